//! Mixes of which only some cells are there: what a scene needs.

use super::{MixFlakes, MixSlice};
use crate::btf::CellSet;

impl MixFlakes {
    /// Leaves out all but these cells.
    pub fn keep(&mut self, cells: &CellSet) {
        for (l, level) in self.levels.iter_mut().enumerate() {
            for (k, slice) in level.slices.iter_mut().enumerate() {
                if !cells.contains(l, k) {
                    *slice = MixSlice::left_out(slice.boxes.len());
                }
            }
        }
    }
}
