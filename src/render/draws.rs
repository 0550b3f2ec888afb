//! The random numbers of a surface point, and how those of two levels of detail become one.

use crate::math::hash::{pcg4d, unit};
use crate::math::knots::KnotLattice;
use crate::math::normal_f32::{cdf, probit};
use glam::Vec2;

/// The random numbers of one surface point: the same for every light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeDraws {
    pub(super) taps: [Draw; Self::MAX_TAPS],
    pub(super) count: usize,
    pub(super) level: usize,
    pub(super) fraction: f32,
}

impl FlakeDraws {
    /// Most taps along a long footprint.
    pub const MAX_TAPS: usize = 16;
}

/// The numbers of one tap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Draw {
    /// Which cluster.
    pub cluster: Number,
    /// Where in its box, in (0, 1).
    pub inside: [f32; 3],
}

/// A uniform number, given or still to be asked for a half vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Number {
    /// The same for all half vectors, in (0, 1).
    Fixed(f32),
    /// Phi of a Gaussian field over projected half vectors, of one level or blended from two.
    Turning { fine: KnotLattice, coarse: Option<(KnotLattice, f32)> },
}

impl Default for Draw {
    fn default() -> Self {
        Self { cluster: Number::Fixed(0.5), inside: [0.5; 3] }
    }
}

impl Draw {
    /// What the words of a cell, and of that of the next level with its share, draw. `turning`: whether u depends on the half
    /// vector.
    pub fn new(fine: [u32; 4], coarse: Option<([u32; 4], f32)>, turning: bool) -> Self {
        let cluster = if turning {
            let lattice = |words| KnotLattice::new(pcg4d(words));
            Number::Turning { fine: lattice(fine), coarse: coarse.map(|(words, f)| (lattice(words), f)) }
        } else {
            let u = unit(fine[0]);
            Number::Fixed(coarse.map_or(u, |(words, f)| cdf(blend(probit(u), probit(unit(words[0])), f))))
        };
        let inside = |words: [u32; 4], axis: usize| unit(words[axis + 1]);
        let inside = [0, 1, 2].map(|axis| {
            let near = inside(fine, axis);
            coarse.map_or(near, |(words, f)| uniform_blend(near, inside(words, axis), f))
        });
        Self { cluster, inside }
    }

    /// Which cluster, in (0, 1), at a projected half vector in units of the knots' spacing.
    #[inline]
    pub fn u(&self, place: Vec2) -> f32 {
        match &self.cluster {
            Number::Fixed(u) => *u,
            Number::Turning { fine, coarse } => {
                let g = fine.value(place);
                cdf(coarse.as_ref().map_or(g, |(coarse, f)| blend(g, coarse.value(place), *f)))
            }
        }
    }
}

/// A standard normal number from two independent ones, `fraction` of the way from the first.
fn blend(near: f32, far: f32, fraction: f32) -> f32 {
    let (a, b) = (1.0 - fraction, fraction);
    (a * near + b * far) / (a * a + b * b).sqrt()
}

/// A uniform number from two independent ones: the distribution function of `(1-f) a + f b`, a trapezoid, at that value.
/// Cheaper than the normal one; inside a box only the marginal matters.
fn uniform_blend(a: f32, b: f32, f: f32) -> f32 {
    let (narrow, wide) = (f.min(1.0 - f), f.max(1.0 - f));
    let x = (1.0 - f) * a + f * b;
    let rising = |x: f32| if x < narrow { x * x / (2.0 * narrow * wide) } else { (x - narrow / 2.0) / wide };
    if x <= 0.5 { rising(x) } else { 1.0 - rising(1.0 - x) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest distance between the distribution function of samples in (0, 1) and the uniform one.
    fn kolmogorov_smirnov(mut samples: Vec<f32>) -> f64 {
        samples.sort_by(f32::total_cmp);
        let n = samples.len() as f64;
        let distance = |(k, x): (usize, &f32)| {
            (f64::from(*x) - k as f64 / n).abs().max(((k + 1) as f64 / n - f64::from(*x)).abs())
        };
        samples.iter().enumerate().map(distance).fold(0.0, f64::max)
    }

    /// Exceeded by one fair sample in ten thousand.
    fn limit(n: u32) -> f64 {
        2.23 / f64::from(n).sqrt()
    }

    fn words(k: u32, salt: u32) -> [u32; 4] {
        pcg4d([k, salt, 3, 4])
    }

    #[test]
    fn blends_between_levels_stay_uniform() {
        let n = 40_000;
        for fraction in [0.0, 0.01, 0.3, 0.5, 0.9, 0.999] {
            for turning in [false, true] {
                let coarse = |k| (fraction > 0.0).then(|| (words(k, 2), fraction));
                let draws: Vec<Draw> = (0..n).map(|k| Draw::new(words(k, 1), coarse(k), turning)).collect();
                for place in [Vec2::ZERO, Vec2::new(-0.7, 5.2)] {
                    let distance = kolmogorov_smirnov(draws.iter().map(|d| d.u(place)).collect());
                    assert!(distance < limit(n), "u at {fraction}, {turning}, {place}: {distance}");
                }
                for axis in 0..3 {
                    let samples: Vec<f32> = draws.iter().map(|d| d.inside[axis]).collect();
                    assert!(kolmogorov_smirnov(samples) < limit(n), "axis {axis} at {fraction}");
                }
            }
        }
    }

    #[test]
    fn one_place_sees_all_numbers_as_the_half_vector_turns() {
        let draw = Draw::new(words(5, 1), Some((words(5, 2), 0.4)), true);
        // Half vectors farther apart than the field remembers, about three spacings.
        let samples = (0..40_000u32).map(|k| draw.u(Vec2::new((k % 200) as f32, (k / 200) as f32) * 3.1));
        assert!(kolmogorov_smirnov(samples.collect()) < limit(40_000));
    }

    #[test]
    fn a_blend_begins_at_one_level_and_ends_at_the_next() {
        for turning in [false, true] {
            let place = Vec2::new(0.3, 0.4);
            let alone = |salt| Draw::new(words(9, salt), None, turning);
            for (fraction, end) in [(1e-6, alone(1)), (1.0 - 1e-6, alone(2))] {
                let blend = Draw::new(words(9, 1), Some((words(9, 2), fraction)), turning);
                // The slope of every step with the fraction is below 10.
                assert!((blend.u(place) - end.u(place)).abs() < 1e-5);
                assert!(blend.inside.iter().zip(end.inside).all(|(a, b)| (a - b).abs() < 1e-5), "{blend:?}");
            }
        }
    }
}
