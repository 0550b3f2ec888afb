//! A set of cells: slices at levels of detail.

/// Which slices (angle pairs, in grid order) at which levels of detail are wanted, out of all that a flake BTF or its
/// statistics have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellSet {
    slices: usize,
    /// Level by level.
    cells: Vec<bool>,
}

impl CellSet {
    /// The empty set out of `slices` at each of `levels`.
    pub fn none(slices: usize, levels: usize) -> Self {
        Self { slices, cells: vec![false; slices * levels] }
    }

    /// All cells.
    pub fn all(slices: usize, levels: usize) -> Self {
        Self { slices, cells: vec![true; slices * levels] }
    }

    /// Adds a cell; one that is not there to be had is ignored.
    pub fn insert(&mut self, level: usize, slice: usize) {
        if slice < self.slices
            && let Some(cell) = self.cells.get_mut(level * self.slices + slice)
        {
            *cell = true;
        }
    }

    /// Adds all slices of a level.
    pub fn insert_level(&mut self, level: usize) {
        (0..self.slices).for_each(|slice| self.insert(level, slice));
    }

    /// Whether a cell is in the set.
    pub fn contains(&self, level: usize, slice: usize) -> bool {
        slice < self.slices && self.cells.get(level * self.slices + slice) == Some(&true)
    }

    /// Adds all cells of a set out of the same cells.
    pub fn extend(&mut self, other: &Self) {
        self.cells.iter_mut().zip(&other.cells).for_each(|(a, b)| *a |= b);
    }

    /// The first cell (level, slice) of this set that the other one lacks.
    pub fn first_beyond(&self, other: &Self) -> Option<(usize, usize)> {
        self.iter().find(|(level, slice)| !other.contains(*level, *slice))
    }

    /// The cells (level, slice), level by level.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize)> {
        let place = |(k, _)| (k / self.slices, k % self.slices);
        self.cells.iter().enumerate().filter(|(_, wanted)| **wanted).map(place)
    }

    /// Number of cells in the set.
    pub fn len(&self) -> usize {
        self.cells.iter().filter(|wanted| **wanted).count()
    }

    /// Whether no cell is in the set.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of cells that there are.
    pub fn total(&self) -> usize {
        self.cells.len()
    }

    /// Number of slices that are wanted at a level.
    pub fn len_of_level(&self, level: usize) -> usize {
        self.iter().filter(|cell| cell.0 == level).count()
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.cells.len().checked_div(self.slices).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_in_is_there() {
        let mut set = CellSet::none(5, 3);
        assert!(set.is_empty() && set.total() == 15 && set.levels() == 3);
        set.insert(1, 4);
        set.insert_level(2);
        // Beyond the last slice lies no cell, not the first of the next level.
        set.insert(0, 5);
        set.insert(3, 0);
        assert_eq!((set.len(), set.len_of_level(0), set.len_of_level(1), set.len_of_level(2)), (6, 0, 1, 5));
        assert!(set.contains(1, 4) && !set.contains(1, 3) && !set.contains(0, 9) && !set.contains(3, 0));
        let mut other = CellSet::none(5, 3);
        other.insert(0, 2);
        assert_eq!(other.first_beyond(&set), Some((0, 2)));
        set.extend(&other);
        assert_eq!((set.len(), other.first_beyond(&set)), (7, None));
        assert_eq!(set.first_beyond(&CellSet::all(5, 3)), None);
        assert_eq!(CellSet::all(5, 3).len(), 15);
    }
}
