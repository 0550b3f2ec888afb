//! The flakes' term Xi(x, theta_h, theta_i), drawn from the statistics (Golla & Klein 2018, section 3.2).
//!
//! Random numbers hang on the cells of a lattice over the surface, one lattice a level of detail, so that a flake stays
//! where it is. One uniform number u per place and half vector serves all slices: neighbouring angle slices are interpolated
//! as colors drawn with the same u and the same place in the box. As the half vector turns, u follows a Gaussian field with
//! the lifetime of the paint's flakes ([`KnotLattice`](crate::math::knots::KnotLattice)). Between levels l and l+1, f of the way,
//! `g = ((1-f) g_l + f g_(l+1)) / sqrt((1-f)^2 + f^2)` with `g = probit(u)`, `u = Phi(g)` stays uniform, and the value is
//! `(1-f) Q_l(u) + f Q_(l+1)(u)`. Long footprints take several taps along their long side.

use super::cells::cell;
use super::draws::{Draw, FlakeDraws, Number};
use super::flake_layout::{Detail, FlakeLayout};
use super::footprint::Surface;
use super::light_patches::{LightPatch, variance_of};
use super::memory::Memory;
use super::packed::{pack_ramp, rounded, unpack_ramp};
use super::shade::Geometry;
use crate::btf::CellSet;
use crate::cluster::SliceStatistics;
use crate::error::Result;
use crate::math::knots::KnotMap;
use crate::paint::Flakes;
use crate::sampler::{self, Sampler};
use glam::{Vec2, Vec3};

/// Statistics of the flakes, with their samplers.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderFlakes {
    layout: FlakeLayout,
    levels: Vec<Level>,
    /// Mean of every slice, 1/sr.
    means: Vec<Vec3>,
    /// From projected half vectors to places of the lattices of u; none: u depends on the place alone.
    knots: Option<KnotMap>,
}

#[derive(Debug, Clone, PartialEq)]
struct Level {
    /// Not the pitch: a product is the same on every machine, a quotient is not, and it decides which cell holds a point.
    cells_per_mm: f32,
    /// None for a slice that was left out.
    slices: Vec<Option<DrawnSlice>>,
}

/// One slice at one level, ready to be drawn from.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnSlice {
    /// What is drawn, its boxes rounded to what a GPU keeps: corners within 0.004 Lab units up to L* 128.
    pub statistics: SliceStatistics,
    /// The exact one of these statistics.
    pub sampler: Sampler,
    /// How much draws fluctuate, and how far they remember the half vector.
    pub memory: Memory,
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
            let (sampler, memory) = (Sampler::exact(s)?, Memory::of(s));
            Ok(Some(DrawnSlice { statistics: rounded(s), sampler: with_rounded_bands(sampler), memory }))
        };
        let level = |l: &crate::paint::FlakeLevel| {
            let slices = l.slices.iter().map(slice).collect::<Result<_>>()?;
            Ok(Level { cells_per_mm: (1.0 / l.pitch_mm) as f32, slices })
        };
        // All levels have the same mean; the coarsest has the fewest boxes.
        let means = flakes.levels.last().map_or_else(Vec::new, |l| l.slices.iter().map(mean).collect());
        Ok(Self {
            layout: FlakeLayout::of(flakes),
            levels: flakes.levels.iter().map(level).collect::<Result<_>>()?,
            means,
            knots: flakes.knots.map(|k| k.map()),
        })
    }

    /// How the slices are laid out.
    pub fn layout(&self) -> &FlakeLayout {
        &self.layout
    }

    /// Cells of the lattice a millimetre, and slices, of every level, finest first; `None` for a slice that was left out.
    pub fn levels(&self) -> impl Iterator<Item = (f32, &[Option<DrawnSlice>])> {
        self.levels.iter().map(|level| (level.cells_per_mm, &level.slices[..]))
    }

    /// From projected half vectors to places of the lattices of u; none: u depends on the place alone.
    pub fn knots(&self) -> Option<KnotMap> {
        self.knots
    }

    /// Mean of every slice, linear Rec.709, 1/sr.
    pub fn means(&self) -> &[Vec3] {
        &self.means
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

    /// Random numbers that are given, not drawn: `u` and `inside` in (0, 1), the same for all half vectors, of one
    /// tap of a side of 1 texel or more.
    pub fn given_draws(&self, u: f32, inside: [f32; 3], side: f32) -> FlakeDraws {
        let (level, fraction) = self.layout.levels_about(side);
        let mut taps = [Draw::default(); FlakeDraws::MAX_TAPS];
        taps[0] = Draw { cluster: Number::Fixed(u), inside };
        FlakeDraws { taps, count: 1, level, fraction }
    }

    fn draw(&self, surface: &Surface, uv_mm: Vec2, level: usize, fraction: f32) -> Draw {
        let words = |level: usize| cell(surface, uv_mm, level, self.levels[level].cells_per_mm);
        let coarse = (fraction > 0.0).then(|| (words(level + 1), fraction));
        Draw::new(words(level), coarse, self.knots.is_some())
    }

    /// Xi, linear Rec.709, 1/sr, at angles under the coat, radians, and the projected half vector in a frame fixed to the
    /// surface ([`projected_half`](crate::brdf::projected_half())).
    pub fn xi(&self, draws: &FlakeDraws, theta_h: f32, theta_i: f32, half: Vec2) -> Vec3 {
        let slices = self.layout.slices(theta_h, theta_i);
        let place = self.knots.map_or(Vec2::ZERO, |knots| knots.place(half));
        let taps = &draws.taps[..draws.count];
        let sum = taps.iter().fold(Vec3::ZERO, |sum, draw| {
            let u = draw.u(place);
            let fine = self.quantile(draws.level, &slices, u, draw.inside);
            if draws.fraction == 0.0 {
                return sum + fine;
            }
            sum + fine.lerp(self.quantile(draws.level + 1, &slices, u, draw.inside), draws.fraction)
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

    /// What a patch of light adds to the fluctuation at a pair of directions: of the projected half vector `half`, over an area of
    /// `area` of them, counted `weight` times.
    pub(super) fn patch(
        &self,
        draws: &FlakeDraws,
        g: &Geometry,
        half: Vec2,
        area: f32,
        weight: f32,
    ) -> LightPatch {
        // Without knots all half vectors draw alike: nothing is forgotten.
        let Some(knots) = &self.knots else { return LightPatch::default() };
        let slices = self.layout.slices(g.theta_h, g.theta_i);
        let mut memory = self.memory(draws.level, &slices);
        if draws.fraction > 0.0 {
            memory = memory.lerp(self.memory(draws.level + 1, &slices), draws.fraction);
        }
        LightPatch {
            place: knots.place(half),
            variance: variance_of(area * knots.stretch(half)),
            memory: Memory::default().plus(memory, weight),
            ..LightPatch::default()
        }
    }

    /// How much draws fluctuate, interpolated between slices like the draws: they go up and down together.
    fn memory(&self, level: usize, slices: &[(Option<usize>, f32); 4]) -> Memory {
        slices.iter().fold(Memory::default(), |sum, (slice, weight)| {
            match slice.and_then(|k| self.levels[level].slices[k].as_ref()) {
                Some(slice) => sum.plus(slice.memory, *weight),
                None => sum,
            }
        })
    }

    /// The color drawn by `u` and `inside`, interpolated between slices.
    fn quantile(&self, level: usize, slices: &[(Option<usize>, f32); 4], u: f32, inside: [f32; 3]) -> Vec3 {
        slices.iter().filter(|(_, weight)| *weight > 0.0).fold(Vec3::ZERO, |sum, (slice, weight)| {
            // Slices that were left out are never asked for: pictures check that they are not needed.
            match slice.and_then(|k| self.levels[level].slices[k].as_ref()) {
                Some(slice) => {
                    let color = sampler::color(&slice.statistics, &slice.sampler, u, inside);
                    sum + Vec3::from(color) * *weight
                }
                None => sum,
            }
        })
    }
}

/// With the bands that a GPU keeps, see [`super::packed`].
fn with_rounded_bands(sampler: Sampler) -> Sampler {
    match sampler {
        Sampler::Exact(table, ramps) => {
            Sampler::Exact(table, ramps.into_iter().map(|ramp| unpack_ramp(pack_ramp(ramp))).collect())
        }
        other => other,
    }
}

fn mean(statistics: &SliceStatistics) -> Vec3 {
    statistics.mean_rgb().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::btf::AngleGrid;
    use crate::paint::MissingSlice;

    #[test]
    fn means_are_those_of_the_statistics() {
        let cluster =
            crate::cluster::Cluster { probability: 1.0, min: [50.0, 0.0, 0.0], max: [60.0, 5.0, 0.0] };
        let slice =
            SliceStatistics { gain: [1.5, 0.5, 2.0], ..SliceStatistics::new(vec![cluster], [0.1; 3]) };
        let flakes = Flakes {
            grid: AngleGrid::triangle(1).unwrap(),
            missing: MissingSlice::Nearest,
            size: [1, 1],
            texel_mm: 0.02,
            levels: vec![crate::paint::FlakeLevel { pitch_mm: 0.02, slices: vec![slice.clone()] }],
            inverse_cdf_steps: 500,
            knots: None,
        };
        let mean = RenderFlakes::new(&flakes).unwrap().mean(0.0, 0.0);
        assert!((mean - slice.mean_rgb().as_vec3()).length() < 1e-6, "{mean}");
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
            knots: None,
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
