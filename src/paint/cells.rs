//! Flakes of which only some cells are there: what a scene needs.

use super::Flakes;
use crate::btf::CellSet;
use crate::cluster::SliceStatistics;

impl Flakes {
    /// The cells that are there, all of them unless the flakes were made for a scene.
    pub fn cells(&self) -> CellSet {
        let mut cells = CellSet::none(self.grid.len(), self.levels.len());
        for (l, level) in self.levels.iter().enumerate() {
            let there = level.slices.iter().enumerate().filter(|(_, s)| !s.is_left_out());
            there.for_each(|(k, _)| cells.insert(l, k));
        }
        cells
    }

    /// Leaves out all but these cells.
    pub fn keep(&mut self, cells: &CellSet) {
        for (l, level) in self.levels.iter_mut().enumerate() {
            for (k, slice) in level.slices.iter_mut().enumerate() {
                if !cells.contains(l, k) {
                    *slice = SliceStatistics::left_out();
                }
            }
        }
    }

    /// Bytes of the clusters of these cells as a renderer holds them: a probability and two corners in f32.
    pub fn cluster_bytes(&self, cells: &CellSet) -> usize {
        cells.iter().map(|(l, k)| self.levels[l].slices[k].clusters.len() * 28).sum()
    }
}
