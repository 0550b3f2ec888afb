//! Which statistics a footprint and a pair of angles draw from: slices and levels of detail.

use super::draws::FlakeDraws;
use crate::btf::{AngleGrid, CellSet};
use crate::mix::MixFlakes;
use crate::paint::{Flakes, MissingSlice};
use glam::Vec2;
use std::f32::consts::{FRAC_2_PI, SQRT_2};

/// How the flakes of a paint are laid out over angles and scales.
#[derive(Debug, Clone, PartialEq)]
pub struct FlakeLayout {
    grid: AngleGrid,
    missing: MissingSlice,
    texel_mm: f32,
    levels: usize,
}

/// How a footprint is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Detail {
    /// Long side of the footprint, millimetres on the surface, along which the taps lie.
    pub long: Vec2,
    /// Number of taps.
    pub count: usize,
    /// The finer of two levels.
    pub level: usize,
    /// How far on the way to the next level, 0 to 1: linear in the root of 1 / side, the side of a tap.
    pub fraction: f32,
}

impl FlakeLayout {
    /// The layout of these flakes.
    pub fn of(flakes: &Flakes) -> Self {
        Self {
            grid: flakes.grid.clone(),
            missing: flakes.missing,
            texel_mm: flakes.texel_mm as f32,
            levels: flakes.levels.len(),
        }
    }

    /// The layout of raw slices: a grid, what angle pairs without a slice give, texel and number of levels.
    pub(super) fn of_slices(grid: &AngleGrid, missing: MissingSlice, texel_mm: f32, levels: usize) -> Self {
        Self { grid: grid.clone(), missing, texel_mm, levels }
    }

    /// The layout of these coupled flakes, and so of all their blends.
    pub fn of_mix(flakes: &MixFlakes) -> Self {
        Self {
            grid: flakes.grid.clone(),
            missing: flakes.missing,
            texel_mm: flakes.texel_mm as f32,
            levels: flakes.levels.len(),
        }
    }

    /// Which angle pairs have a slice.
    pub fn grid(&self) -> &AngleGrid {
        &self.grid
    }

    /// What an angle pair without a slice gives.
    pub fn missing(&self) -> MissingSlice {
        self.missing
    }

    /// Side of a texel of the finest level, millimetres.
    pub fn texel_mm(&self) -> f32 {
        self.texel_mm
    }

    /// The empty set of cells of this layout.
    pub(super) fn no_cells(&self) -> CellSet {
        CellSet::none(self.grid.len(), self.levels)
    }

    /// Taps and levels for a footprint, given by its two sides, millimetres on the surface.
    pub(super) fn detail(&self, footprint: [Vec2; 2]) -> Detail {
        let (long, ratio) = long_side(footprint);
        // A texel is as narrow as a tap can be: more of them would blur what they share.
        let count =
            (ratio.round().min(long.length() / self.texel_mm) as usize).clamp(1, FlakeDraws::MAX_TAPS);
        let area = footprint[0].perp_dot(footprint[1]).abs() / count as f32;
        let (level, fraction) = self.levels_about((area.sqrt() / self.texel_mm).max(1.0));
        Detail { long, count, level, fraction }
    }

    /// The finer of the two levels about a tap of this side, texels, 1 or more, and how far it is on the way to the next.
    pub(super) fn levels_about(&self, side: f32) -> (usize, f32) {
        let last = self.levels - 1;
        let level = (side.log2() as usize).min(last);
        // Between linear in the level, which keeps up to 4 % too much contrast of dense flakes half way, and in 1 / side, which
        // leaves up to 5 % too little of sparse ones.
        let left = ((1u32 << level) as f32 / side).sqrt();
        let fraction = if level == last { 0.0 } else { ((1.0 - left) * (2.0 + SQRT_2)).clamp(0.0, 1.0) };
        (level, fraction)
    }

    /// Adds the cells that a footprint at a pair of angles, radians, draws from.
    pub(super) fn insert_cells(&self, cells: &mut CellSet, detail: &Detail, theta_h: f32, theta_i: f32) {
        for slice in
            self.slices(theta_h, theta_i).into_iter().filter(|tap| tap.1 > 0.0).filter_map(|tap| tap.0)
        {
            cells.insert(detail.level, slice);
            if detail.fraction > 0.0 {
                cells.insert(detail.level + 1, slice);
            }
        }
    }

    /// The four slices around a pair of angles and their weights, missing ones as the paint wants them.
    pub fn slices(&self, theta_h: f32, theta_i: f32) -> [(Option<usize>, f32); 4] {
        let mut taps = self.grid.taps(theta_h, theta_i);
        if self.missing == MissingSlice::Nearest {
            let scale = self.grid.bins() as f32 * FRAC_2_PI;
            let [h, i] = [theta_h, theta_i].map(|theta| (theta * scale).max(0.0) as usize);
            for (corner, tap) in taps.iter_mut().enumerate().filter(|(_, tap)| tap.0.is_none()) {
                tap.0 = self.nearest(h + corner % 2, i + corner / 2);
            }
        }
        taps
    }

    /// The nearest slice of the same theta_i row, or of the last row.
    fn nearest(&self, theta_h: usize, theta_i: usize) -> Option<usize> {
        let rows = self.grid.rows();
        let row = theta_i.min(rows.len() - 1);
        self.grid.slice(theta_h.min(rows[row] - 1), row)
    }
}

/// Long side of the ellipse that a parallelogram's sides span (twice the major half axis of its image of a unit disc),
/// and how many times longer it is than the short one.
fn long_side([a, b]: [Vec2; 2]) -> (Vec2, f32) {
    let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
    let mean = 0.5 * (aa + bb);
    let spread = (0.5 * (aa - bb)).hypot(ab);
    let (long, short) = ((mean + spread).sqrt(), (mean - spread).max(0.0).sqrt());
    // The right singular vector turns by half the angle; its image is the long side.
    let (sin, cos) = (0.5 * (2.0 * ab).atan2(aa - bb)).sin_cos();
    let ratio = long / short.max(long * 1e-3);
    (a * cos + b * sin, if ratio.is_finite() { ratio } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_sides_of_parallelograms() {
        // A rectangle 3 x 1, as it is and sheared by half a turn of its sides: the same ellipse.
        let (long, ratio) = long_side([Vec2::new(3.0, 0.0), Vec2::new(0.0, 1.0)]);
        assert!((long.abs() - Vec2::new(3.0, 0.0)).length() < 1e-6 && (ratio - 3.0).abs() < 1e-5);
        let turn = std::f32::consts::FRAC_1_SQRT_2;
        let (long, ratio) = long_side([Vec2::new(3.0, 1.0) * turn, Vec2::new(-3.0, 1.0) * turn]);
        assert!((long.abs() - Vec2::new(3.0, 0.0)).length() < 1e-5 && (ratio - 3.0).abs() < 1e-5);
        // No area, no extent: one tap where the point is.
        assert_eq!(long_side([Vec2::ZERO; 2]), (Vec2::ZERO, 1.0));
        let (_, ratio) = long_side([Vec2::X, Vec2::X * 2.0]);
        assert!(ratio > 100.0 && ratio.is_finite());
    }
}
