//! Masses as whole numbers, so that flows are added and subtracted without rounding.
//!
//! Every f64 is a whole multiple of a power of two. In units of the smallest such power among the masses of a problem
//! all masses are integers, and so are all flows of a spanning tree: a supply of 1e-300 that leaves through the same
//! arc as one of 0.5 is not lost. Below the unit lie `guard` bits for the perturbation that excludes degeneracy.

use std::ops::{Add, Sub};

/// A nonnegative integer that holds masses and flows.
pub(super) trait Mass: Copy + Ord + Add<Output = Self> + Sub<Output = Self> {
    /// Number of bits.
    const BITS: u32;
    /// `value * 2^shift`.
    fn shifted(value: u64, shift: u32) -> Self;
    /// The floor of `self / 2^shift`, `shift` being below 64.
    fn shifted_down(self, shift: u32) -> Self;
    /// The number nearest to `self * 2^exponent`.
    fn to_f64(self, exponent: i32) -> f64;
}

/// Masses that are counts over a power of two, as of the texels of a slice.
impl Mass for u64 {
    const BITS: u32 = 64;

    fn shifted(value: u64, shift: u32) -> Self {
        value << shift
    }

    fn shifted_down(self, shift: u32) -> Self {
        self >> shift
    }

    fn to_f64(self, exponent: i32) -> f64 {
        libm::ldexp(self as f64, exponent)
    }
}

/// Ordinary problems: masses down to about 1e-19 of the total.
impl Mass for u128 {
    const BITS: u32 = 128;

    fn shifted(value: u64, shift: u32) -> Self {
        Self::from(value) << shift
    }

    fn shifted_down(self, shift: u32) -> Self {
        self >> shift
    }

    fn to_f64(self, exponent: i32) -> f64 {
        libm::ldexp(self as f64, exponent)
    }
}

/// Room for the whole range of f64, 2^-1074 to 2^1024, and the guard bits; most significant limb first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Wide([u64; Wide::LIMBS]);

impl Wide {
    const LIMBS: usize = 34;
    /// Place of the least significant limb.
    const LAST: usize = Self::LIMBS - 1;
}

impl Add for Wide {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        let mut carry = false;
        for (a, b) in self.0.iter_mut().zip(other.0).rev() {
            (*a, carry) = a.carrying_add(b, carry);
        }
        self
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(mut self, other: Self) -> Self {
        let mut borrow = false;
        for (a, b) in self.0.iter_mut().zip(other.0).rev() {
            (*a, borrow) = a.borrowing_sub(b, borrow);
        }
        self
    }
}

impl Mass for Wide {
    const BITS: u32 = 64 * Self::LIMBS as u32;

    fn shifted(value: u64, shift: u32) -> Self {
        let mut limbs = [0; Self::LIMBS];
        let (place, bits) = (Self::LAST - (shift / 64) as usize, shift % 64);
        limbs[place] = value << bits;
        if bits > 0 && place > 0 {
            limbs[place - 1] = value >> (64 - bits);
        }
        Self(limbs)
    }

    fn shifted_down(mut self, shift: u32) -> Self {
        let mut above = 0;
        for limb in &mut self.0 {
            let pair = (u128::from(above) << 64) | u128::from(*limb);
            above = *limb;
            *limb = (pair >> shift) as u64;
        }
        self
    }

    fn to_f64(self, exponent: i32) -> f64 {
        let top = self.0.iter().position(|&limb| limb != 0).unwrap_or(Self::LAST).min(Self::LAST - 1);
        let pair = (u128::from(self.0[top]) << 64) | u128::from(self.0[top + 1]);
        // A bit that stands for all lower limbs makes the rounding of the upper ones right.
        let below = self.0[top + 2..].iter().any(|&limb| limb != 0);
        let place = 64 * (Self::LAST - 1 - top) as i32;
        libm::ldexp((pair | u128::from(below)) as f64, exponent + place)
    }
}

/// How the masses of one problem are written as integers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// The unit is 2^unit.
    unit: i32,
    /// Bits below the unit.
    guard: u32,
    /// Bits that the total needs.
    pub bits: u32,
}

impl Scale {
    /// For positive masses with this total, on a tree of `nodes` nodes.
    pub fn new(masses: impl Iterator<Item = f64>, total: f64, nodes: usize) -> Self {
        let unit = masses.map(|mass| decompose(mass).1).min().unwrap_or(0);
        // Perturbations add up to `nodes` at most, which must stay below half a unit.
        let guard = nodes.ilog2() + 2;
        // One bit for what rounding may have taken from the total, one for the perturbation.
        let bits = (libm::frexp(total).1 - unit) as u32 + guard + 2;
        Self { unit, guard, bits }
    }

    /// An exact multiple of the unit.
    pub fn encode<M: Mass>(self, mass: f64) -> M {
        let (mantissa, exponent) = decompose(mass);
        M::shifted(mantissa, (exponent - self.unit) as u32 + self.guard)
    }

    /// The number nearest to a flow, its perturbation removed.
    pub fn decode<M: Mass>(self, flow: M) -> f64 {
        let half_a_unit = M::shifted(1, self.guard - 1);
        (flow + half_a_unit).shifted_down(self.guard).to_f64(self.unit)
    }
}

/// Odd mantissa and exponent of a positive number.
fn decompose(x: f64) -> (u64, i32) {
    let fraction = x.to_bits() & ((1 << 52) - 1);
    let biased = (x.to_bits() >> 52) as i32;
    let (mantissa, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
    let zeros = mantissa.trailing_zeros();
    (mantissa >> zeros, exponent + zeros as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smallest, subnormal, ordinary and largest numbers, odd mantissas among them.
    const NUMBERS: [f64; 8] = [5e-324, 3e-310, 1e-300, 1.0 / 3.0, 0.5, 1.0 + f64::EPSILON, 1e300, f64::MAX];

    #[test]
    fn numbers_come_back() {
        let scale = Scale::new(NUMBERS.into_iter(), f64::MAX, 1 << 17);
        assert!(scale.bits <= Wide::BITS);
        for x in NUMBERS {
            assert_eq!(scale.decode(scale.encode::<Wide>(x)), x);
            let own = Scale::new(std::iter::once(x), x, 100);
            assert_eq!(own.decode(own.encode::<u128>(x)), x);
        }
    }

    #[test]
    fn wide_integers_agree_with_narrow_ones() {
        let samples =
            [1_u128, u128::from(u64::MAX), 1 << 64, (1 << 100) + 12_345, (1 << 120) - 1, (1 << 117) + 1];
        let wide = |x: u128| Wide::shifted((x >> 64) as u64, 64) + Wide::shifted(x as u64, 0);
        for a in samples {
            assert_eq!(wide(a).to_f64(-60), a.to_f64(-60));
            assert_eq!(wide(a).shifted_down(13), wide(a >> 13));
            for b in samples {
                assert_eq!(wide(a) + wide(b), wide(a + b));
                assert_eq!(wide(a).cmp(&wide(b)), a.cmp(&b));
                if a >= b {
                    assert_eq!(wide(a) - wide(b), wide(a - b));
                }
            }
        }
    }

    #[test]
    fn a_lower_limb_decides_a_tie() {
        let tie = Wide::shifted((1 << 53) + 1, 200);
        assert_eq!(tie.to_f64(-200), (1_u64 << 53) as f64);
        assert_eq!((tie + Wide::shifted(1, 0)).to_f64(-200), ((1_u64 << 53) + 2) as f64);
    }
}
