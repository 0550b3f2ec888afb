//! How large the flakes of a kind are: discs of log-normal diameter.

use crate::simulate::composition::FlakeKind;
use rand_distr::{Distribution, StandardNormal};

/// Areas of the flakes of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeAreas {
    /// Mean area, `<S>` of the papers, square micrometres.
    pub mean_um2: f64,
    /// Standard deviation of the diameter over its mean, 0 to 1.
    pub diameter_spread: f64,
}

impl FlakeAreas {
    /// Those of a kind of flakes.
    pub fn of(kind: &FlakeKind) -> Self {
        Self { mean_um2: kind.mean_area_um2(), diameter_spread: kind.diameter_spread }
    }

    /// `<S^2> / <S>^2 = (1 + spread^2)^4`, from the fourth moment of a log-normal diameter.
    pub fn mean_square(&self) -> f64 {
        (1.0 + self.diameter_spread.powi(2)).powi(4)
    }

    /// The area of a random flake over the mean area.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> f64 {
        let normal: f64 = StandardNormal.sample(rng);
        let variance = self.diameter_spread.powi(2).ln_1p();
        (2.0 * (variance.sqrt() * normal - variance)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn areas_have_their_moments() {
        for spread in [0.0, 0.3, 0.6] {
            let areas = FlakeAreas { mean_um2: 100.0, diameter_spread: spread };
            let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
            let n = 400_000;
            let draws: Vec<f64> = (0..n).map(|_| areas.sample(&mut rng)).collect();
            let moment = |k: i32| draws.iter().map(|s| s.powi(k)).sum::<f64>() / f64::from(n);
            for (power, expected) in [(1, 1.0), (2, areas.mean_square())] {
                let error = ((moment(2 * power) - moment(power).powi(2)) / f64::from(n)).sqrt();
                // Four standard errors.
                let off = (moment(power) - expected).abs();
                assert!(off <= 4.0 * error, "{spread} {power}: {off} {error}");
            }
        }
    }
}
