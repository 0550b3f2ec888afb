//! Phi and its inverse where they decide what is drawn: f32 sums and products and bit patterns only.
//!
//! No quotient, root or library function: every machine computes the same, and a shader, whose built-in exponential and
//! logarithm promise little, is a twin line by line (one that fuses products and sums moves u by a unit in the last place).
//! The polynomials are minimax fits to [`super::normal`]. In the tails the probability is right to 7e-6 of itself down to
//! 2^-24, the smallest that [`super::hash::unit`] gives: brightest flakes keep their number.

use super::floor::floor;
use glam::Vec4;

/// Where the two polynomials of [`probit`] meet, in -ln(4 p (1 - p)).
const TAIL: f32 = 5.0;

/// [`super::normal::probit`] of a multiple of 2^-24 in (0, 1).
#[inline]
pub fn probit(p: f32) -> f32 {
    // Of the tail probability this is a logarithm, about the median a square: smooth on both sides (Giles 2010).
    let w = -ln(4.0 * p * (1.0 - p));
    let slope = if w < TAIL {
        let central = [
            0.000_123_151_5,
            0.000_593_388_05,
            -0.002_436_797_4,
            -0.001_214_450_7,
            0.024_152_359,
            -0.055_406_567,
            -0.073_852_14,
            1.744_013_3,
            4.246_627_3,
        ];
        horner(&central, w * 0.4 - 1.0)
    } else {
        let tail = [
            0.000_909_081_66,
            -0.001_567_127_6,
            2.560_600_3e-5,
            0.003_573_379,
            -0.015_897_404,
            0.063_690_044,
            -0.278_487_7,
            2.289_537_4,
            8.531_282,
        ];
        horner(&tail, (w - 10.129_619) * 0.194_946_26)
    };
    (p - 0.5) * slope
}

/// [`super::normal::cdf`], inside (0, 1): never below 2^-25 nor above 1 - 2^-24.
#[inline]
pub fn cdf(x: f32) -> f32 {
    // Beyond lies less than 2^-25.
    let far = x.abs().min(5.4);
    // log2 of the tail.
    let slope = [
        9.322_112_6e-5,
        -0.000_285_204_06,
        0.000_298_998_17,
        0.000_104_066_69,
        -0.001_540_034,
        0.006_110_202,
        -0.018_419_093,
        0.048_021_674,
        -0.115_488_626,
        -1.803_581,
        -2.765_680_6,
    ];
    let tail = exp2(far * horner(&slope, far * 0.347_826_1 - 1.0) - 1.0);
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// Natural logarithm of a normal positive number.
#[inline]
fn ln(x: f32) -> f32 {
    // x = 2^exponent (1 + t), with 1 + t between the roots of 1/2 and 2.
    let exponent = (x.to_bits() as i32 - 0x3f35_04f3) >> 23;
    let t = f32::from_bits((x.to_bits() as i32 - (exponent << 23)) as u32) - 1.0;
    let quotient = [
        0.089_599_08,
        -0.144_822_7,
        0.149_174_15,
        -0.165_437_3,
        0.199_584_13,
        -0.250_029_47,
        0.333_341_6,
        -0.499_999_8,
        1.0,
    ];
    exponent as f32 * std::f32::consts::LN_2 + t * horner(&quotient, t)
}

/// 2 to a power in (-126, 0].
#[inline]
pub fn exp2(x: f32) -> f32 {
    let whole = floor(x);
    let part = x - whole;
    f32::from_bits(((whole as i32 + 127) as u32) << 23) * (1.0 + part * horner(&EXP2, part))
}

/// The same of four powers, to the bit.
#[inline]
pub fn exp2_each(x: Vec4) -> Vec4 {
    let whole = x.floor();
    let part = x - whole;
    let slope = EXP2.iter().fold(Vec4::ZERO, |sum, c| sum * part + *c);
    let scale = Vec4::from_array(whole.to_array().map(|w| f32::from_bits(((w as i32 + 127) as u32) << 23)));
    scale * (1.0 + part * slope)
}

/// Of `(2^x - 1) / x` in [0, 1].
const EXP2: [f32; 6] =
    [0.000_216_129_19, 0.001_246_784_5, 0.009_675_452, 0.055_485_282, 0.240_229_31, 0.693_147_06];

/// Polynomial with coefficients from the highest power down.
#[inline]
fn horner<const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    coefficients.iter().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::unit;
    use crate::math::normal;

    #[test]
    fn four_powers_are_those_of_each() {
        for k in 0..125_000 {
            let x = Vec4::new(-0.001, -0.000_3, -0.9, -1.0) * k as f32;
            let x = x.max(Vec4::splat(-125.0));
            assert_eq!(exp2_each(x).to_array(), x.to_array().map(exp2), "{x}");
        }
    }

    #[test]
    fn every_number_that_a_hash_can_give() {
        let (mut absolute, mut tails, mut back) = (0.0f64, 0.0f64, 0.0f64);
        let mut before = (f32::NEG_INFINITY, 0.0);
        for k in 0..1u32 << 23 {
            let p = unit(k << 9);
            let (z, u) = (probit(p), cdf(probit(p)));
            assert!(z > before.0 && u >= before.1, "{p}: {z} {u} after {before:?}");
            assert!(u > 0.0 && u < 1.0);
            before = (z, u);
            // The upper half mirrors the lower: the same tail, the same number.
            assert_eq!(probit(1.0 - p), -z);
            let tail = f64::from(p.min(1.0 - p));
            let seen = f64::from(if p < 0.5 { u } else { 1.0 - u });
            // Above the median u itself has steps of 2^-24.
            back = back.max((seen - tail).abs() - if p < 0.5 { 0.0 } else { 2f64.powi(-25) } - 1e-5 * tail);
            // The f64 functions are slow: all of the tail, and each 64th number.
            if p < 1e-3 || k % 64 == 0 {
                absolute = absolute.max((f64::from(z) - normal::probit(p.into())).abs());
                tails = tails.max((normal::cdf(-f64::from(z).abs()) / tail - 1.0).abs());
            }
        }
        // f32 rounds 5.3 by 2.4e-7, a logarithm of 16 by 1e-6, and the tail's logarithmic slope is z.
        assert!(absolute < 2e-6 && tails < 7e-6 && back <= 0.0, "{absolute} {tails} {back}");
    }

    #[test]
    fn tails_of_phi_are_right_to_the_end() {
        let mut before = 0.0;
        for k in -5400..=5400 {
            let x = k as f32 * 1e-3;
            let (seen, exact) = (cdf(x), normal::cdf(x.into()));
            assert!(seen >= before, "{x}");
            before = seen;
            // Exponents of up to 25 are rounded by 1e-6, times ln 2, twice.
            let error = f64::from(seen) - exact;
            assert!(error.abs() < 4e-6 * exact.min(1.0 - exact) + 3e-8, "{x}: {seen} {exact}");
            if x < 0.0 {
                assert!(error.abs() < 4e-6 * exact, "{x}: {seen} {exact}");
            }
        }
        assert_eq!(cdf(0.0), 0.5);
        for far in [6.0, 50.0, f32::INFINITY] {
            assert!(cdf(-far) > 0.0 && cdf(far) < 1.0);
        }
    }
}
