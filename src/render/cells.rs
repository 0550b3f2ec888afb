//! Which random words belong to a place: those of the cell of a lattice over the surface that holds it.

use super::footprint::Surface;
use crate::error::{Error, Result};
use crate::math::hash::{pcg4d, unit};
use glam::Vec2;

/// How far the centers of polygonal cells are moved, in lattice units: up to half of this each way.
const JITTER: f32 = 0.9;
/// Polygons of unequal area raise the integral range by E A^2 / (E A)^2 = 1.0496 (measured on 24,576 cells of this jitter,
/// +- 0.0006); so much denser the lattice must be, an axis its square root, for averages of draws to keep their variance.
const DENSER: f32 = 1.0245;

/// Where random numbers come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Random {
    /// From a hash of the cell: the surface has no tile.
    #[default]
    Hash,
    /// From a square texture of so many cells a side, repeated over the surface (Golla & Klein 2018), 1 to 65536.
    Texture(u32),
}

impl Random {
    pub(super) fn validate(self) -> Result<()> {
        match self {
            Self::Texture(side) if !(1..=1 << 16).contains(&side) => {
                Err(Error::invalid("render", "side of the random texture", side, "1 to 65536"))
            }
            _ => Ok(()),
        }
    }

    /// Number of a cell along an axis. Through i32: a negative coordinate has its own cells, and an infinite one saturates.
    fn index(self, coordinate: f32) -> u32 {
        let index = coordinate as i32;
        match self {
            Self::Hash => index as u32,
            Self::Texture(side) => index.rem_euclid(side as i32) as u32,
        }
    }
}

/// The random words of the cell of `level` that holds a point; of a lattice of so many cells a millimetre. Only the finest level can be
/// magnified: its cells are polygons, those of the others are squares that no sample resolves.
pub(super) fn cell(surface: &Surface, uv_mm: Vec2, level: usize, cells_per_mm: f32) -> [u32; 4] {
    let place = uv_mm * cells_per_mm;
    let chart = surface.chart << 8 | level as u32;
    let cell = if level == 0 { nearest_center(place * DENSER, chart, surface) } else { place.floor() };
    words(cell, chart, surface, surface.seed)
}

/// The cell whose jittered center is nearest to a place in lattice units (Worley 1996): the cells are irregular polygons, as
/// flakes are.
fn nearest_center(place: Vec2, chart: u32, surface: &Surface) -> Vec2 {
    let home = place.floor();
    let mut nearest = (f32::INFINITY, home);
    for k in 0..9 {
        let cell = home + Vec2::new((k % 3) as f32 - 1.0, (k / 3) as f32 - 1.0);
        let [x, y, ..] = words(cell, chart, surface, !surface.seed).map(unit);
        let center = cell + 0.5 + JITTER * (Vec2::new(x, y) - 0.5);
        let distance = center.distance_squared(place);
        if distance < nearest.0 {
            nearest = (distance, cell);
        }
    }
    nearest.1
}

fn words(cell: Vec2, chart: u32, surface: &Surface, seed: u32) -> [u32; 4] {
    pcg4d([surface.random.index(cell.x), surface.random.index(cell.y), chart, seed])
}
