//! The standard normal distribution: distribution function and its inverse, accurate in the tails.

/// Phi(x): probability that a standard normal variable lies below `x`; relative accuracy 1e-15 in the lower tail too.
pub fn cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Inverse of [`cdf`]: the value below which a standard normal variable lies with probability `p`.
///
/// Wichura 1988, AS 241 (PPND16): relative accuracy 1e-16 over the open unit interval; 0 and 1 give the infinities.
// The published coefficients, digit by digit.
#[allow(clippy::excessive_precision)]
pub fn probit(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        let top = [
            2.509_080_928_730_122_6e3,
            3.343_057_558_358_812_8e4,
            6.726_577_092_700_87e4,
            4.592_195_393_154_987e4,
            1.373_169_376_550_946e4,
            1.971_590_950_306_551_3e3,
            1.331_416_678_917_843_8e2,
            3.387_132_872_796_366_5,
        ];
        let bottom = [
            5.226_495_278_852_545e3,
            2.872_908_573_572_194_3e4,
            3.930_789_580_009_271e4,
            2.121_379_430_158_659_7e4,
            5.394_196_021_424_751e3,
            6.871_870_074_920_579e2,
            4.231_333_070_160_091e1,
            1.0,
        ];
        return q * horner(&top, r) / horner(&bottom, r);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    if tail <= 0.0 {
        return if q < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let r = (-tail.ln()).sqrt();
    let value = if r <= 5.0 {
        let r = r - 1.6;
        let top = [
            7.745_450_142_783_414e-4,
            2.272_384_498_926_918_4e-2,
            2.417_807_251_774_506e-1,
            1.270_458_252_452_368_4,
            3.647_848_324_763_204_5,
            5.769_497_221_460_691,
            4.630_337_846_156_546,
            1.423_437_110_749_683_5,
        ];
        let bottom = [
            1.050_750_071_644_416_9e-9,
            5.475_938_084_995_345e-4,
            1.519_866_656_361_645_7e-2,
            1.481_039_764_274_800_8e-1,
            6.897_673_349_851e-1,
            1.676_384_830_183_803_8,
            2.053_191_626_637_759,
            1.0,
        ];
        horner(&top, r) / horner(&bottom, r)
    } else {
        let r = r - 5.0;
        let top = [
            2.010_334_399_292_288_1e-7,
            2.711_555_568_743_487_6e-5,
            1.242_660_947_388_078_4e-3,
            2.653_218_952_657_612_4e-2,
            2.965_605_718_285_048_7e-1,
            1.784_826_539_917_291_3,
            5.463_784_911_164_114,
            6.657_904_643_501_103,
        ];
        let bottom = [
            2.044_263_103_389_939_8e-15,
            1.421_511_758_316_446e-7,
            1.846_318_317_510_054_8e-5,
            7.868_691_311_456_133e-4,
            1.487_536_129_085_061_5e-2,
            1.369_298_809_227_358e-1,
            5.998_322_065_558_88e-1,
            1.0,
        ];
        horner(&top, r) / horner(&bottom, r)
    };
    if q < 0.0 { -value } else { value }
}

/// Polynomial with coefficients from the highest power down.
fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // Mills, tables of the normal integral to 12 digits and more.
        for (x, p) in [
            (0.0, 0.5),
            (-1.0, 0.158_655_253_931_457_05),
            (-3.0, 1.349_898_031_630_094_6e-3),
            (-6.0, 9.865_876_450_376_98e-10),
            (-10.0, 7.619_853_024_160_527e-24),
            (2.0, 0.977_249_868_051_820_8),
        ] {
            // The argument of erfc, rounded, times the logarithmic slope (about x^2) of the tail.
            assert!((cdf(x) / p - 1.0).abs() < 1e-13, "{x}: {} {p}", cdf(x));
        }
    }

    #[test]
    fn probit_inverts_cdf_into_the_tails() {
        for k in 1..400 {
            let x = -6.0 + 0.03 * f64::from(k);
            let p = cdf(x);
            // Above the median 1 - p has lost its digits: the slope of probit is 1 / density.
            let density = (-0.5 * x * x).exp() / 2.506_628_274_631_000_5;
            let tolerance = 1e-12 + 2.0 * f64::EPSILON / density;
            assert!((probit(p) - x).abs() < tolerance, "{x} {}", probit(p));
        }
        assert_eq!(probit(0.0), f64::NEG_INFINITY);
        assert_eq!(probit(1.0), f64::INFINITY);
    }
}
