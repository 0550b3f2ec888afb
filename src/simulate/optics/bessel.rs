//! The modified Bessel function I0, scaled.

/// `exp(-x) I0(x)` for x >= 0, relative accuracy 1e-13 (Abramowitz & Stegun 9.6.10 and 9.7.1).
pub fn i0_scaled(x: f64) -> f64 {
    // The asymptotic series is good to its smallest term, exp(-2 x); the power series has positive terms only.
    if x > 18.0 {
        let (mut term, mut sum) = (1.0, 1.0);
        for k in 1..=30 {
            let odd = f64::from(2 * k - 1);
            let next = term * odd * odd / (8.0 * x * f64::from(k));
            if next >= term || next < 1e-17 {
                break;
            }
            term = next;
            sum += term;
        }
        return sum / (2.0 * std::f64::consts::PI * x).sqrt();
    }
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..=80 {
        term *= quarter / f64::from(k * k);
        sum += term;
        if term < 1e-17 * sum {
            break;
        }
    }
    sum * (-x).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_its_integral() {
        for x in [0.0, 1e-3, 0.5, 1.0, 5.0, 17.99, 18.01, 40.0, 700.0, 1e5] {
            // I0(x) = 1/pi int exp(x cos t) dt; the trapezoid rule converges exponentially once it sees the peak.
            let n = 1 << 13;
            let integral: f64 = (0..n)
                .map(|k| {
                    let half = std::f64::consts::PI * (f64::from(k) + 0.5) / f64::from(n) * 0.5;
                    (-2.0 * x * half.sin().powi(2)).exp()
                })
                .sum::<f64>()
                / f64::from(n);
            // Rounding of exponents near 30 in exp(-x) times the sum.
            assert!((i0_scaled(x) / integral - 1.0).abs() < 1e-13, "{x}: {} {integral}", i0_scaled(x));
        }
    }
}
