//! The angle grid of a flake BTF.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Which (theta_h, theta_i) pairs have a slice: bins of equal width on both axes, rows (theta_i) of their own length.
///
/// Slice (i, j) sits at `theta_h = i * width`, `theta_i = j * width` (bin offset 0). Slices are numbered row by row, theta_i
/// outer, as in the slice table of AxF-style paints. Rows are consecutive from theta_h = 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "GridFile", into = "GridFile")]
pub struct AngleGrid {
    bins: usize,
    rows: Vec<usize>,
    starts: Vec<usize>,
}

/// The grid as written to a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GridFile {
    /// Bins per 90 degrees.
    bins: usize,
    /// Slices of each theta_i row.
    rows: Vec<usize>,
}

impl TryFrom<GridFile> for AngleGrid {
    type Error = Error;
    fn try_from(file: GridFile) -> Result<Self> {
        Self::new(file.bins, file.rows)
    }
}

impl From<AngleGrid> for GridFile {
    fn from(grid: AngleGrid) -> Self {
        Self { bins: grid.bins, rows: grid.rows }
    }
}

impl AngleGrid {
    /// Most bins per 90 degrees.
    pub const MAX_BINS: usize = 180;

    /// A grid of `bins` per 90 degrees whose row j (theta_i) holds `rows[j]` slices.
    ///
    /// # Errors
    /// Bins outside 1-180; no rows or more rows than bins; a row that is empty or longer than the bins.
    pub fn new(bins: usize, rows: Vec<usize>) -> Result<Self> {
        if !(1..=Self::MAX_BINS).contains(&bins) {
            return Err(Error::invalid("angle grid", "bins per 90 degrees", bins, "1 to 180"));
        }
        if rows.is_empty() || rows.len() > bins {
            return Err(Error::invalid("angle grid", "rows (theta_i)", rows.len(), format!("1 to {bins}")));
        }
        if let Some(j) = rows.iter().position(|n| !(1..=bins).contains(n)) {
            let place = format!("angle grid: row {j}");
            return Err(Error::invalid(place, "slices", rows[j], format!("1 to {bins}")));
        }
        let starts = rows
            .iter()
            .scan(0, |sum, n| {
                *sum += n;
                Some(*sum - n)
            })
            .collect();
        Ok(Self { bins, rows, starts })
    }

    /// The triangle `theta_h + theta_i < 90 degrees`: row j holds `bins - j` slices; 30 bins make 465 slices.
    ///
    /// # Errors
    /// Bins outside 1-180.
    pub fn triangle(bins: usize) -> Result<Self> {
        Self::new(bins, (0..bins).map(|j| bins - j).collect())
    }

    /// Bins per 90 degrees.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Angle between neighbouring slices, radians.
    pub fn width(&self) -> f64 {
        FRAC_PI_2 / self.bins as f64
    }

    /// Number of slices.
    pub fn len(&self) -> usize {
        self.rows.iter().sum()
    }

    /// Never: a grid has at least one slice.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Slices of each theta_i row.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Number of the slice at bins (theta_h, theta_i), if the grid has it.
    pub fn slice(&self, theta_h: usize, theta_i: usize) -> Option<usize> {
        (theta_h < *self.rows.get(theta_i)?).then(|| self.starts[theta_i] + theta_h)
    }

    /// Bins (theta_h, theta_i) of a slice, for `slice < len()`.
    pub fn bins_of(&self, slice: usize) -> (usize, usize) {
        let row = self.starts.partition_point(|start| *start <= slice) - 1;
        (slice - self.starts[row], row)
    }

    /// Angles (theta_h, theta_i) of a slice, radians.
    pub fn angles(&self, slice: usize) -> (f64, f64) {
        let (h, i) = self.bins_of(slice);
        (h as f64 * self.width(), i as f64 * self.width())
    }

    /// The four grid points around (theta_h, theta_i), radians, with bilinear weights; `None` where the grid has no slice.
    /// Bench and shader use the same four numbers.
    pub fn taps(&self, theta_h: f32, theta_i: f32) -> [(Option<usize>, f32); 4] {
        let scale = self.bins as f32 * std::f32::consts::FRAC_2_PI;
        let split = |theta: f32| {
            let x = (theta * scale).max(0.0);
            (x as usize, x.fract())
        };
        let ((h, fh), (i, fi)) = (split(theta_h), split(theta_i));
        [
            (self.slice(h, i), (1.0 - fh) * (1.0 - fi)),
            (self.slice(h + 1, i), fh * (1.0 - fi)),
            (self.slice(h, i + 1), (1.0 - fh) * fi),
            (self.slice(h + 1, i + 1), fh * fi),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_and_bins_agree() {
        // The layout of AxF files seen: 12 bins, rows of min(8, 12 - j).
        let grid = AngleGrid::new(12, (0..12).map(|j| 8.min(12 - j)).collect()).unwrap();
        assert_eq!(grid.len(), 68);
        assert_eq!(AngleGrid::triangle(30).unwrap().len(), 465);
        for slice in 0..grid.len() {
            let (h, i) = grid.bins_of(slice);
            assert_eq!(grid.slice(h, i), Some(slice));
        }
        assert_eq!(grid.slice(8, 0), None);
        assert_eq!(grid.slice(0, 12), None);
    }

    #[test]
    fn taps_sum_to_one_and_hit_slices() {
        let grid = AngleGrid::triangle(24).unwrap();
        for slice in 0..grid.len() {
            let (h, i) = grid.angles(slice);
            let taps = grid.taps(h as f32, i as f32);
            let total: f32 = taps.iter().map(|t| t.1).sum();
            assert!((total - 1.0).abs() < 1e-6);
            let here: f32 = taps.iter().filter(|t| t.0 == Some(slice)).map(|t| t.1).sum();
            // The angle rounded to f32 is off by up to half a unit in the last place of 24.
            assert!(here > 1.0 - 1e-5, "slice {slice}: {taps:?}");
        }
    }

    #[test]
    fn bad_grids_are_refused() {
        assert!(AngleGrid::new(0, vec![1]).is_err());
        assert!(AngleGrid::new(3, vec![]).is_err());
        assert!(AngleGrid::new(3, vec![1, 4]).is_err());
        assert!(AngleGrid::new(3, vec![1, 0]).is_err());
        assert!(AngleGrid::new(3, vec![1; 4]).is_err());
    }
}
