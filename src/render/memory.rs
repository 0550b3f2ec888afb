//! How much a slice fluctuates, and how far the half vector turns until it has forgotten.
//!
//! A draw is Q(Phi(g), i), i the place in the box and g a field over the places of half vectors
//! ([`KnotLattice`](crate::math::knots::KnotLattice)). With Hermite polynomials, orthonormal under the normal law, and Legendre
//! polynomials of i, orthonormal too, it is `sum a_nj He_n(g) L_j(i)`, and draws at two places whose fields correlate by r
//! have the covariance `sum a_nj^2 r^n` less the square of the mean a_00 (Mehler's formula). The terms of order n forget with
//! `E r^n`, over all turns and offsets of the lattice a bell `exp(-d^2 / (2 s_n^2))` of the distance d to within 0.05, the
//! narrower the higher the order: `2 pi s_n^2`, its integral, is 2.41, 1.35, 0.94, 0.72 spacings squared for the first four and
//! 3 / n beyond. The skewer Q, as where few flakes shine, the more it consists of high orders. So kept are: what lasts,
//! j > 0 at n = 0, which hangs on the place in the box alone; and what fades, in four bands of n. The last holds all that is
//! left of the variance, orders without end where Q has steps.

use crate::cluster::{Series, SliceStatistics};
use crate::color::luminance;
use crate::math::normal_f32::probit;
use glam::{DVec3, Vec4};

/// Standard deviations of the luminance of draws, 1/sr, by what becomes of them as the half vector turns. Amplitudes: they
/// are interpolated and summed like the draws themselves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Memory {
    /// What stays, whatever the half vector.
    pub lasting: f32,
    /// What forgets within the four ranges of its bands.
    pub fading: Vec4,
}

/// First orders of the second band and of those after it.
const BANDS: [usize; 3] = [2, 5, 17];

/// Squares of the distances, in spacings of the knots, within which the four bands forget: `s_n^2` for n = 1, and means over 2 to
/// 4, 5 to 16, and 17 and more with weights `n^(-3/2)`, the orders of a step.
pub(super) const RANGES: Vec4 = Vec4::new(0.3841, 0.1775, 0.0625, 0.00965);

/// Orders that are computed.
const ORDERS: usize = BANDS[2];
/// The largest number below 1 that a hash gives.
const MOST: f32 = 1.0 - 1.0 / 16_777_216.0;

impl Memory {
    /// That of a slice; nothing for one that was left out.
    pub fn of(statistics: &SliceStatistics) -> Self {
        let probit = |p: f64| f64::from(probit((p as f32).min(MOST)));
        let Series { coefficients, variance } = Series::<ORDERS>::of(statistics, probit);
        let [mean, lasting @ ..] = coefficients[0];
        let lasting = squares(&lasting);
        let band =
            |from: usize, to: usize| coefficients[from..to].iter().map(|row| squares(row)).sum::<f64>();
        let bands = [band(1, BANDS[0]), band(BANDS[0], BANDS[1]), band(BANDS[1], BANDS[2])];
        // What a slice that hardly scatters is left with is rounding.
        let rest = variance - lasting - bands.iter().sum::<f64>();
        let rest = if rest > 1e-12 * (variance + mean * mean) { rest } else { 0.0 };
        let gain = luminance(DVec3::from(statistics.gain.map(f64::from)));
        let deviation = |variance: f64| (gain * variance.sqrt()) as f32;
        let [first, second, third] = bands;
        Self { lasting: deviation(lasting), fading: Vec4::from([first, second, third, rest].map(deviation)) }
    }

    /// The largest of the deviations.
    pub(super) fn largest(&self) -> f32 {
        self.lasting.max(self.fading.max_element())
    }

    /// `self + other * share`.
    #[must_use]
    pub fn plus(self, other: Self, share: f32) -> Self {
        Self { lasting: self.lasting + other.lasting * share, fading: self.fading + other.fading * share }
    }

    /// From this to `other`.
    #[must_use]
    pub fn lerp(self, other: Self, fraction: f32) -> Self {
        Self::default().plus(self, 1.0 - fraction).plus(other, fraction)
    }
}

fn squares(row: &[f64]) -> f64 {
    row.iter().map(|c| c * c).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::Cluster;
    use crate::math::hash::{pcg4d, unit};
    use crate::math::knots::KnotLattice;
    use crate::math::normal_f32::cdf;
    use crate::sampler::{Sampler, color};
    use glam::Vec2;

    /// One texel in `1 / bright` shines.
    fn slice(bright: f64) -> SliceStatistics {
        let cluster = |probability, l: f32, half: f32| Cluster {
            probability,
            min: [l - half, -3.0, 0.0],
            max: [l + half, 5.0, 1.0],
        };
        let clusters =
            vec![cluster(0.7, 5.0, 4.0), cluster(0.3 - bright, 30.0, 6.0), cluster(bright, 140.0, 25.0)];
        SliceStatistics { gain: [1.5; 3], ..SliceStatistics::new(clusters, [0.1, 0.2, 0.3]) }
    }

    #[test]
    fn covariances_of_draws_are_those_of_the_bands() {
        let n = 400_000;
        for bright in [0.1, 0.01] {
            let slice = slice(bright);
            let (sampler, memory) = (Sampler::exact(&slice).unwrap(), Memory::of(&slice));
            let drawn = |k: u32, place: Vec2| {
                let lattice = KnotLattice::new(pcg4d([k, 1, 2, 3]));
                let inside = pcg4d([k, 4, 5, 6]).map(unit);
                let rgb =
                    color(&slice, &sampler, cdf(lattice.value(place)), [inside[0], inside[1], inside[2]]);
                luminance(DVec3::from(rgb.map(f64::from)))
            };
            let mean = luminance(slice.mean_rgb());
            let variance = f64::from(memory.lasting.powi(2) + memory.fading.length_squared());
            for distance in [0.0f32, 0.1, 0.25, 0.5, 1.0, 3.0] {
                let (one, two) = (Vec2::new(0.3, -0.2), Vec2::new(0.3 + distance, -0.2));
                let products = (0..n).map(|k| (drawn(k, one) - mean) * (drawn(k, two) - mean));
                let (sum, square) = products.fold((0.0, 0.0), |(s, q), p| (s + p, q + p * p));
                let seen = sum / f64::from(n);
                let error = (square / f64::from(n) - seen * seen).sqrt() / f64::from(n).sqrt();
                let bells = (-0.5 * distance * distance / RANGES).exp();
                let exact = memory.lasting.powi(2) + (memory.fading * memory.fading).dot(bells);
                // A bell is off by up to 0.05, a band of them by as much again; four standard errors.
                let off = seen - f64::from(exact);
                let limit = if distance == 0.0 { 0.002 } else { 0.06 };
                assert!(off.abs() < limit * variance + 4.0 * error, "{bright}, {distance}: {seen} {exact}");
            }
        }
    }

    #[test]
    fn even_slices_and_missing_ones_do_not_fluctuate() {
        let point = [40.0, 1.0, 2.0];
        let even = |p: f64| Cluster { probability: p, min: point, max: point };
        let statistics = SliceStatistics::new(vec![even(0.3), even(0.7)], [0.5; 3]);
        for statistics in [statistics, SliceStatistics::left_out()] {
            let memory = Memory::of(&statistics);
            // The rounding of a sum of squares.
            assert!(memory.lasting + memory.fading.element_sum() < 1e-7, "{memory:?}");
        }
    }

    #[test]
    fn a_box_alone_lasts() {
        let cluster = Cluster { probability: 1.0, min: [20.0, 0.0, 0.0], max: [90.0, 0.0, 0.0] };
        let memory = Memory::of(&SliceStatistics::new(vec![cluster], [0.0; 3]));
        assert!(memory.lasting > 0.05);
        assert!(memory.fading.length() < 1e-6 * memory.lasting, "{memory:?}");
    }
}
