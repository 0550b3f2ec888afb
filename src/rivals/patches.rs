//! Texture of any size from random patches of a small piece (Rump et al. 2008, section 6).
//!
//! The surface is a mosaic of square patches, each a copy of a random one of the stored piece. Which of which is stored, and the
//! same for every slice: flakes stay where they are from frame to frame. Borders are hard, as in the paper.

use crate::error::{Error, Result};
use crate::math::hash::pcg4d;

/// Where each patch of a surface comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patches {
    /// Columns and rows of the stored piece.
    source: [usize; 2],
    /// Columns and rows of the surface.
    size: [usize; 2],
    /// Side of a patch.
    side: usize,
    /// First column and row in the piece, patch by patch, row-major.
    from: Vec<[u16; 2]>,
}

impl Patches {
    /// The usual side of a patch, texels.
    pub const SIDE: usize = 16;

    /// A surface of `size` from a piece of `source` texels in patches of `side`.
    ///
    /// # Errors
    /// Sides outside 1 to 4096; patches larger than the piece.
    pub fn new(source: [usize; 2], size: [usize; 2], side: usize, seed: u32) -> Result<Self> {
        for (name, sides) in [("piece", source), ("surface", size), ("patch", [side; 2])] {
            if sides.iter().any(|n| !(1..=4096).contains(n)) {
                return Err(Error::invalid("patches", name, format!("{sides:?}"), "sides of 1 to 4096"));
            }
        }
        if source.iter().any(|n| *n < side) {
            return Err(Error::invalid("patches", "patch", side, format!("up to the piece, {source:?}")));
        }
        let count = size[0].div_ceil(side) * size[1].div_ceil(side);
        let from = (0..count).map(|k| {
            let random = pcg4d([k as u32, 0, 0, seed]);
            [0, 1].map(|axis| ((u64::from(random[axis]) * (source[axis] - side + 1) as u64) >> 32) as u16)
        });
        Ok(Self { source, size, side, from: from.collect() })
    }

    /// Bytes of the map: four a patch.
    pub fn bytes(&self) -> usize {
        4 * self.from.len()
    }

    /// The surface from a piece of that size, row-major; None for a piece of another size.
    pub fn surface(&self, piece: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
        if piece.len() != self.source[0] * self.source[1] {
            return None;
        }
        let across = self.size[0].div_ceil(self.side);
        let texel = |k: usize| {
            let (x, y) = (k % self.size[0], k / self.size[0]);
            let [left, top] = self.from[y / self.side * across + x / self.side].map(usize::from);
            piece[(top + y % self.side) * self.source[0] + left + x % self.side]
        };
        Some((0..self.size[0] * self.size[1]).map(texel).collect())
    }
}
