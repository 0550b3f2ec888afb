//! How many sparkles a pixel holds: a Poisson law, since flakes lie independent of each other.

use rand::RngExt;
use rand_distr::{Distribution, Poisson};

/// Law of the number of sparkles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CountRule {
    /// Poisson.
    #[default]
    Poisson,
    /// 1999: for means below 0.1 one sparkle or none, Poisson otherwise. The mean is kept, the variance is low by the mean: by
    /// up to a tenth. It holds for all kinds of flakes together: a pixel shows one sparkle of one light, of whatever kind.
    Shortcut,
}

/// Means below this take the shortcut (1999, section 5.3.5).
pub const SMALL_MEAN: f64 = 0.1;

/// Number of sparkles about its mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountLaw {
    /// Mean number, 0 or more, finite.
    pub mean: f64,
    /// How it is drawn.
    pub rule: CountRule,
}

impl CountLaw {
    /// Probability of `n` sparkles.
    pub fn probability(&self, n: u32) -> f64 {
        match (self.takes_shortcut(), n) {
            (true, 0) => 1.0 - self.mean,
            (true, 1) => self.mean,
            (true, _) => 0.0,
            (false, 0) => (-self.mean).exp(),
            (false, _) => {
                let n = f64::from(n);
                // In logarithms: neither power nor factorial overflows.
                (n * self.mean.ln() - self.mean - libm::lgamma(n + 1.0)).exp()
            }
        }
    }

    /// Least n with at least `share` of all pixels at n sparkles or fewer; `share` in [0, 1).
    pub fn quantile(&self, share: f64) -> u32 {
        // Above the mean the terms fall off: what is left out beyond this many is far below rounding.
        let end = self.mean + 40.0 * self.mean.sqrt() + 40.0;
        let mut below = 0.0;
        for n in 0..=end as u32 {
            below += self.probability(n);
            if below >= share {
                return n;
            }
        }
        end as u32
    }

    /// A number of sparkles.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> u64 {
        if self.takes_shortcut() {
            return u64::from(rng.random::<f64>() < self.mean);
        }
        // No sparkles need no draw: a Poisson law has a positive mean.
        Poisson::new(self.mean).map_or(0, |law| law.sample(rng) as u64)
    }

    /// Whether there is one sparkle at most.
    pub fn takes_shortcut(&self) -> bool {
        self.rule == CountRule::Shortcut && self.mean < SMALL_MEAN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn draws_follow_the_law() {
        for rule in [CountRule::Poisson, CountRule::Shortcut] {
            for mean in [0.0, 0.02, 0.09, 0.11, 3.0, 50.0] {
                let law = CountLaw { mean, rule };
                let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
                let n = 200_000;
                let draws: Vec<f64> = (0..n).map(|_| law.sample(&mut rng) as f64).collect();
                let average =
                    |f: &dyn Fn(f64) -> f64| draws.iter().map(|d| f(*d)).sum::<f64>() / f64::from(n);
                let variance = if law.takes_shortcut() { mean * (1.0 - mean) } else { mean };
                let found = average(&|d| (d - mean).powi(2));
                let error = (average(&|d| (d - mean).powi(4)) / f64::from(n)).sqrt();
                // Four standard errors each.
                assert!((average(&|d| d) - mean).abs() <= 4.0 * (variance / f64::from(n)).sqrt(), "{mean}");
                assert!((found - variance).abs() <= 4.0 * error, "{rule:?} {mean}: {found} {variance}");
                let (total, moment) = (0..200).fold((0.0, 0.0), |(t, m), k| {
                    let p = law.probability(k);
                    (t + p, m + p * f64::from(k))
                });
                assert!((total - 1.0).abs() < 1e-12 && (moment - mean).abs() < 1e-11, "{mean}");
            }
        }
    }

    #[test]
    fn quantiles_invert_the_law() {
        let law = |mean| CountLaw { mean, rule: CountRule::Poisson };
        assert_eq!(law(0.0).quantile(0.999), 0);
        // exp(-0.05) = 0.9512.
        assert_eq!((law(0.05).quantile(0.95), law(0.05).quantile(0.952)), (0, 1));
        // Median of a large mean: within 1 of it.
        assert!((f64::from(law(1e5).quantile(0.5)) - 1e5).abs() <= 1.0);
    }
}
