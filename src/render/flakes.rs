//! The flakes' term Xi(x, theta_h, theta_i), drawn from the statistics (Golla & Klein 2018, section 3.2).
//!
//! Random numbers hang on the cells of a lattice over the surface, one lattice a level of detail, so that a flake stays
//! where it is. One uniform number u per place serves all angles: neighbouring angle slices are interpolated as colors
//! drawn with the same u and the same place in the box. Between levels l and l+1, f of the way,
//! `g = ((1-f) g_l + f g_(l+1)) / sqrt((1-f)^2 + f^2)` with `g = probit(u)`, `u = Phi(g)` stays uniform, and the value is
//! `(1-f) Q_l(u) + f Q_(l+1)(u)`. Long footprints take several taps along their long side.

use super::flake_layout::{Detail, FlakeLayout};
use super::footprint::Surface;
use crate::btf::CellSet;
use crate::cluster::{SliceStatistics, mean_of_boxes};
use crate::error::Result;
use crate::math::hash::{pcg4d, unit};
use crate::math::normal::{cdf, probit};
use crate::paint::Flakes;
use crate::sampler::{self, GuideTable, Sampler};
use glam::{Vec2, Vec3};

/// How far the centers of polygonal cells are moved, in lattice units: up to half of this each way.
const JITTER: f32 = 0.9;
/// Polygons of unequal area raise the integral range by E A^2 / (E A)^2 = 1.0496 (measured on 24,576 cells of this jitter,
/// +- 0.0006); so much denser the lattice must be, an axis its square root, for averages of draws to keep their variance.
const DENSER: f32 = 1.0245;

/// Statistics of the flakes, with their samplers.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderFlakes {
    layout: FlakeLayout,
    levels: Vec<Level>,
    /// Mean of every slice, 1/sr.
    means: Vec<Vec3>,
}

#[derive(Debug, Clone, PartialEq)]
struct Level {
    pitch_mm: f32,
    /// None for a slice that was left out.
    slices: Vec<Option<(SliceStatistics, Sampler)>>,
}

/// The random numbers of one surface point: the same for every light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeDraws {
    taps: [Draw; Self::MAX_TAPS],
    count: usize,
    level: usize,
    fraction: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Draw {
    /// Which cluster, in (0, 1).
    u: f32,
    /// Where in its box, in (0, 1).
    inside: [f32; 3],
}

impl FlakeDraws {
    /// Most taps along a long footprint.
    pub const MAX_TAPS: usize = 8;
}

impl RenderFlakes {
    /// Builds the samplers.
    ///
    /// # Errors
    /// Probabilities that cannot be sampled.
    pub fn new(flakes: &Flakes) -> Result<Self> {
        let slice = |s: &SliceStatistics| {
            if s.is_left_out() {
                return Ok(None);
            }
            let probabilities: Vec<f64> = s.clusters.iter().map(|c| c.probability).collect();
            Ok(Some((s.clone(), Sampler::Exact(GuideTable::new(&probabilities)?))))
        };
        let level = |l: &crate::paint::FlakeLevel| {
            let slices = l.slices.iter().map(slice).collect::<Result<_>>()?;
            Ok(Level { pitch_mm: l.pitch_mm as f32, slices })
        };
        // All levels have the same mean; the coarsest has the fewest boxes.
        let means = flakes.levels.last().map_or_else(Vec::new, |l| l.slices.iter().map(mean).collect());
        Ok(Self {
            layout: FlakeLayout::of(flakes),
            levels: flakes.levels.iter().map(level).collect::<Result<_>>()?,
            means,
        })
    }

    /// How the slices are laid out.
    pub(super) fn layout(&self) -> &FlakeLayout {
        &self.layout
    }

    /// The cells that are there.
    pub(super) fn cells(&self) -> CellSet {
        let mut cells = self.layout.no_cells();
        for (l, level) in self.levels.iter().enumerate() {
            (0..level.slices.len()).filter(|k| level.slices[*k].is_some()).for_each(|k| cells.insert(l, k));
        }
        cells
    }

    /// Whether no slice was left out.
    pub(super) fn is_whole(&self) -> bool {
        self.levels.iter().flat_map(|l| &l.slices).all(Option::is_some)
    }

    /// The random numbers of a surface point.
    pub fn draws(&self, surface: &Surface) -> FlakeDraws {
        let Detail { long, count, level, fraction } = self.layout.detail(surface.footprint);
        let mut taps = [Draw::default(); FlakeDraws::MAX_TAPS];
        for (k, tap) in taps.iter_mut().enumerate().take(count) {
            let along = (k as f32 + 0.5) / count as f32 - 0.5;
            *tap = self.draw(surface, surface.uv_mm + long * along, level, fraction);
        }
        FlakeDraws { taps, count, level, fraction }
    }

    fn draw(&self, surface: &Surface, uv_mm: Vec2, level: usize, fraction: f32) -> Draw {
        let fine = self.cell(surface, uv_mm, level);
        if fraction == 0.0 {
            return fine;
        }
        fine.blend(self.cell(surface, uv_mm, level + 1), fraction)
    }

    /// The numbers of the lattice cell that holds a point. Only the finest level can be magnified: its cells are polygons,
    /// those of the others are squares that no sample resolves.
    fn cell(&self, surface: &Surface, uv_mm: Vec2, level: usize) -> Draw {
        let place = uv_mm / self.levels[level].pitch_mm;
        let chart = surface.chart << 8 | level as u32;
        let cell =
            if level == 0 { nearest_center(place * DENSER, chart, surface.seed) } else { place.floor() };
        let [u, l, a, b] = pcg4d(words(cell, chart, surface.seed)).map(unit);
        Draw { u, inside: [l, a, b] }
    }

    /// Xi, linear Rec.709, 1/sr, at angles under the coat, radians.
    pub fn xi(&self, draws: &FlakeDraws, theta_h: f32, theta_i: f32) -> Vec3 {
        let slices = self.layout.slices(theta_h, theta_i);
        let taps = &draws.taps[..draws.count];
        let sum = taps.iter().fold(Vec3::ZERO, |sum, draw| {
            let fine = self.quantile(draws.level, &slices, draw);
            if draws.fraction == 0.0 {
                return sum + fine;
            }
            sum + fine.lerp(self.quantile(draws.level + 1, &slices, draw), draws.fraction)
        });
        sum / draws.count as f32
    }

    /// Mean of Xi over the surface.
    pub fn mean(&self, theta_h: f32, theta_i: f32) -> Vec3 {
        let slices = self.layout.slices(theta_h, theta_i);
        slices.iter().fold(Vec3::ZERO, |sum, (slice, weight)| {
            sum + slice.map_or(Vec3::ZERO, |k| self.means[k] * *weight)
        })
    }

    fn quantile(&self, level: usize, slices: &[(Option<usize>, f32); 4], draw: &Draw) -> Vec3 {
        slices.iter().filter(|(_, weight)| *weight > 0.0).fold(Vec3::ZERO, |sum, (slice, weight)| {
            // Slices that were left out are never asked for: pictures check that they are not needed.
            match slice.and_then(|k| self.levels[level].slices[k].as_ref()) {
                Some((statistics, sampler)) => {
                    sum + Vec3::from(sampler::color(statistics, sampler, draw.u, draw.inside)) * *weight
                }
                None => sum,
            }
        })
    }
}

impl Draw {
    /// From this level's numbers to the next one's, each staying uniform.
    fn blend(self, coarse: Self, fraction: f32) -> Self {
        let (near, far) = (f64::from(1.0 - fraction), f64::from(fraction));
        let mixed = near * probit(self.u.into()) + far * probit(coarse.u.into());
        let u = cdf(mixed / near.hypot(far)) as f32;
        // Rounding must not reach the ends, which belong to no cluster.
        let u = u.clamp(f32::MIN_POSITIVE, 1.0 - f32::EPSILON / 2.0);
        let inside = [0, 1, 2].map(|k| uniform_blend(self.inside[k], coarse.inside[k], fraction));
        Self { u, inside }
    }
}

/// A uniform number from two independent ones: the distribution function of `(1-f) a + f b`, a trapezoid, at that value.
/// Cheaper than the normal one; inside a box only the marginal matters.
fn uniform_blend(a: f32, b: f32, f: f32) -> f32 {
    let (narrow, wide) = (f.min(1.0 - f), f.max(1.0 - f));
    let x = (1.0 - f) * a + f * b;
    let rising = |x: f32| if x < narrow { x * x / (2.0 * narrow * wide) } else { (x - narrow / 2.0) / wide };
    if x <= 0.5 { rising(x) } else { 1.0 - rising(1.0 - x) }
}

/// The cell whose jittered center is nearest to a place in lattice units (Worley 1996): the cells are irregular polygons, as
/// flakes are.
fn nearest_center(place: Vec2, chart: u32, seed: u32) -> Vec2 {
    let home = place.floor();
    let mut nearest = (f32::INFINITY, home);
    for k in 0..9 {
        let cell = home + Vec2::new((k % 3) as f32 - 1.0, (k / 3) as f32 - 1.0);
        let [x, y, ..] = pcg4d(words(cell, chart, !seed)).map(unit);
        let center = cell + 0.5 + JITTER * (Vec2::new(x, y) - 0.5);
        let distance = center.distance_squared(place);
        if distance < nearest.0 {
            nearest = (distance, cell);
        }
    }
    nearest.1
}

/// What the hash of a cell is made of. Through i32: a negative coordinate has its own cells, and an infinite one saturates.
fn words(cell: Vec2, chart: u32, seed: u32) -> [u32; 4] {
    [cell.x as i32 as u32, cell.y as i32 as u32, chart, seed]
}

fn mean(statistics: &SliceStatistics) -> Vec3 {
    mean_of_boxes(&statistics.clusters).as_vec3() + Vec3::from(statistics.offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::AngleGrid;
    use crate::paint::MissingSlice;

    /// Largest distance between the distribution function of samples in (0, 1) and the uniform one.
    fn kolmogorov_smirnov(mut samples: Vec<f32>) -> f64 {
        samples.sort_by(f32::total_cmp);
        let n = samples.len() as f64;
        let distance = |(k, x): (usize, &f32)| {
            (f64::from(*x) - k as f64 / n).abs().max(((k + 1) as f64 / n - f64::from(*x)).abs())
        };
        samples.iter().enumerate().map(distance).fold(0.0, f64::max)
    }

    #[test]
    fn blends_between_levels_stay_uniform() {
        let n = 40_000u32;
        let draw = |k: u32, salt: u32| {
            let [u, l, a, b] = pcg4d([k, salt, 3, 4]).map(unit);
            Draw { u, inside: [l, a, b] }
        };
        for fraction in [0.01, 0.3, 0.5, 0.9, 0.999] {
            let blends: Vec<Draw> = (0..n).map(|k| draw(k, 1).blend(draw(k, 2), fraction)).collect();
            // Exceeded by one fair sample in ten thousand: 2.23 / sqrt(n).
            let limit = 2.23 / f64::from(n).sqrt();
            assert!(kolmogorov_smirnov(blends.iter().map(|d| d.u).collect()) < limit, "u at {fraction}");
            for axis in 0..3 {
                let samples: Vec<f32> = blends.iter().map(|d| d.inside[axis]).collect();
                assert!(kolmogorov_smirnov(samples) < limit, "axis {axis} at {fraction}");
            }
        }
    }

    #[test]
    fn a_blend_begins_at_one_level_and_ends_at_the_next() {
        let fine = Draw { u: 0.25, inside: [0.1, 0.5, 0.9] };
        let coarse = Draw { u: 0.999, inside: [0.7, 0.2, 0.3] };
        for (fraction, end) in [(1e-6, fine), (1.0 - 1e-6, coarse)] {
            let blend = fine.blend(coarse, fraction);
            // The slope of every step with the fraction is below 10.
            assert!((blend.u - end.u).abs() < 1e-5);
            assert!(blend.inside.iter().zip(end.inside).all(|(a, b)| (a - b).abs() < 1e-5), "{blend:?}");
        }
    }

    #[test]
    fn missing_slices_are_nothing_or_the_nearest() {
        let slice = |lightness: f32| {
            let point = [lightness, 0.0, 0.0];
            let cluster = crate::cluster::Cluster { probability: 1.0, min: point, max: point };
            SliceStatistics::new(vec![cluster], [0.0; 3])
        };
        // Three bins of 30 degrees, rows of two and one.
        let mut flakes = Flakes {
            grid: AngleGrid::new(3, vec![2, 1]).unwrap(),
            missing: MissingSlice::Zero,
            size: [1, 1],
            texel_mm: 0.02,
            levels: vec![crate::paint::FlakeLevel {
                pitch_mm: 0.02,
                slices: vec![slice(10.0), slice(20.0), slice(30.0)],
            }],
            inverse_cdf_steps: 500,
            knot_spacing: None,
        };
        let at = |flakes: &Flakes, h: f32, i: f32| {
            RenderFlakes::new(flakes).unwrap().mean(h.to_radians(), i.to_radians()).x
        };
        let value = |lightness: f32| {
            let statistics = slice(lightness);
            mean(&statistics).x
        };
        assert!((at(&flakes, 30.0, 0.0) - value(20.0)).abs() < 1e-5);
        assert!((at(&flakes, 45.0, 0.0) - 0.5 * value(20.0)).abs() < 1e-5);
        assert_eq!(at(&flakes, 60.0, 60.0), 0.0);
        flakes.missing = MissingSlice::Nearest;
        assert!((at(&flakes, 80.0, 0.0) - value(20.0)).abs() < 1e-5);
        assert!((at(&flakes, 80.0, 30.0) - value(30.0)).abs() < 1e-5);
        assert!((at(&flakes, 80.0, 85.0) - value(30.0)).abs() < 1e-5);
    }
}
