//! Flakes from the raw slices of a flake BTF: what the statistics stand for, repeated over the surface.
//!
//! A box-filtered pyramid of every slice (Rump et al. 2008, section 6), linear between levels and between angles, several taps
//! along a long footprint; exact where a pixel has so many samples that each is smaller than a texel. Memory is what the
//! statistics save.

use super::flake_layout::{Detail, FlakeLayout};
use super::footprint::Surface;
use crate::btf::{FlakeBtf, half, level_count};
use crate::paint::MissingSlice;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;

/// The slices of a flake BTF, ready to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderSlices {
    layout: FlakeLayout,
    /// Finest first.
    levels: Vec<Level>,
}

#[derive(Debug, Clone, PartialEq)]
struct Level {
    size: [usize; 2],
    texel_mm: f32,
    /// Row-major texels of every slice, linear Rec.709, 1/sr.
    slices: Vec<Vec<[f32; 3]>>,
}

impl RenderSlices {
    /// The pyramids of all slices: four thirds of the slices themselves. Angle pairs without a slice take the nearest.
    pub fn new(btf: &FlakeBtf) -> Self {
        let count = level_count(btf.size);
        let layout = FlakeLayout::of_slices(&btf.grid, MissingSlice::Nearest, btf.texel_mm as f32, count);
        let mut levels = vec![Level {
            size: btf.size,
            texel_mm: btf.texel_mm as f32,
            slices: btf.slices.iter().map(|slice| centered(&slice.fluctuation)).collect(),
        }];
        while levels.len() < count {
            let finer = &levels[levels.len() - 1];
            let halves: Vec<_> = finer.slices.par_iter().map(|slice| half(slice, finer.size)).collect();
            let size = halves[0].1;
            let texel_mm = 2.0 * finer.texel_mm;
            levels.push(Level { size, texel_mm, slices: halves.into_iter().map(|half| half.0).collect() });
        }
        Self { layout, levels }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let texels = |level: &Level| level.slices.iter().map(Vec::len).sum::<usize>();
        self.levels.iter().map(texels).sum::<usize>() * size_of::<[f32; 3]>()
    }

    /// Xi of a patch of surface at angles in radians: the mean of taps along its long side.
    pub fn xi(&self, surface: &Surface, theta_h: f32, theta_i: f32) -> Vec3 {
        let Detail { long, count, level, fraction } = self.layout.detail(surface.footprint);
        let slices = self.layout.slices(theta_h, theta_i);
        let mut sum = Vec3::ZERO;
        for k in 0..count {
            let along = (k as f32 + 0.5) / count as f32 - 0.5;
            let place = surface.uv_mm + long * along;
            for (slice, weight) in slices.iter().filter(|(_, weight)| *weight > 0.0) {
                let Some(slice) = *slice else { continue };
                let fine = self.levels[level].texel(slice, place);
                let coarser = (fraction > 0.0).then(|| self.levels[level + 1].texel(slice, place));
                sum += coarser.map_or(fine, |coarse| fine.lerp(coarse, fraction)) * *weight;
            }
        }
        sum / count as f32
    }
}

/// Texels less their mean, which is off zero by the chance of where flakes fell.
fn centered(texels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let sum: DVec3 = texels.iter().map(|t| DVec3::from(t.map(f64::from))).sum();
    let mean = (sum / texels.len().max(1) as f64).as_vec3();
    texels.iter().map(|t| (Vec3::from(*t) - mean).to_array()).collect()
}

impl Level {
    /// The texel at a place; the slice repeats. Not blended with its neighbours: a texel is the mean over its square, and a
    /// blend would take contrast from it.
    fn texel(&self, slice: usize, uv_mm: Vec2) -> Vec3 {
        let at = (uv_mm / self.texel_mm).floor();
        let [x, y] = [0, 1].map(|axis| (at[axis] as i64).rem_euclid(self.size[axis] as i64) as usize);
        self.slices[slice][y * self.size[0] + x].into()
    }
}
