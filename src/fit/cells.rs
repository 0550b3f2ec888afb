//! The cells of a paint's flakes, and the slices that fill them.
//!
//! Slices of a flake BTF lie at outer angles, cells of a paint at those under its coat, where the directions of both are refracted.
//! Without refraction they are the same. With it a cell takes the slice nearest to where its directions leave the coat: a mean of
//! slices would wash their flakes out. Refraction draws angles together, near the normal by the index; the cells are as much denser.

use crate::brdf::ClearCoat;
use crate::btf::{AngleGrid, FlakeSlice, FlakeSource};
use crate::error::{Error, Result};
use crate::math::half_difference::{HalfDifference, directions};
use glam::DVec3;
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// A flake BTF as it lies under a coat.
pub(super) struct Cells<'a> {
    btf: &'a dyn FlakeSource,
    coat: ClearCoat,
    grid: AngleGrid,
}

impl<'a> Cells<'a> {
    /// # Errors
    /// A coat through which no slice is seen.
    pub fn new(btf: &'a dyn FlakeSource, coat: &ClearCoat) -> Result<Self> {
        let mut cells = Self { btf, coat: *coat, grid: btf.grid().clone() };
        if coat.refracts {
            cells.grid = cells.under_coat()?;
        }
        Ok(cells)
    }

    /// The cells, row by row as far as a slice is near.
    fn under_coat(&self) -> Result<AngleGrid> {
        let bins = (self.btf.grid().bins() as f64 * self.coat.ior).round() as usize;
        let full = AngleGrid::triangle(bins.min(AngleGrid::MAX_BINS))?;
        let filled = |h: usize, i: usize| {
            let (theta_h, theta_i) = (h as f64 * full.width(), i as f64 * full.width());
            self.outer_at(theta_h, theta_i).and_then(|outer| self.nearest(outer)).is_some()
        };
        let length = |i: usize| (0..full.rows()[i]).take_while(|h| filled(*h, i)).count();
        let rows: Vec<usize> = (0..full.rows().len()).map(length).take_while(|n| *n > 0).collect();
        if rows.is_empty() {
            return Err(Error::invalid("clear coat", "slices seen through it", "none", "at least one"));
        }
        AngleGrid::new(full.bins(), rows)
    }

    /// Which cells there are.
    pub fn grid(&self) -> &AngleGrid {
        &self.grid
    }

    /// Unit directions to light and eye of a cell, under the coat.
    pub fn inner(&self, k: usize) -> (DVec3, DVec3) {
        let (theta_h, theta_i) = self.grid.angles(k);
        directions(theta_h, theta_i, FRAC_PI_2)
    }

    /// The same outside.
    pub fn outer(&self, k: usize) -> (DVec3, DVec3) {
        let (theta_h, theta_i) = self.grid.angles(k);
        // Cells without are not in the grid.
        self.outer_at(theta_h, theta_i).unwrap_or((DVec3::Z, DVec3::Z))
    }

    fn outer_at(&self, theta_h: f64, theta_i: f64) -> Option<(DVec3, DVec3)> {
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        Some((self.coat.outer(wi)?, self.coat.outer(wo)?))
    }

    /// The slice nearest to outer directions, if it is within half a bin.
    fn nearest(&self, (wi, wo): (DVec3, DVec3)) -> Option<usize> {
        let angles = HalfDifference::of(wi, wo);
        let bin = |theta: f64| (theta / self.btf.grid().width()).round() as usize;
        self.btf.grid().slice(bin(angles.theta_h), bin(angles.theta_i))
    }

    /// What is seen of a cell from outside: flakes of the nearest slice about the expectation there.
    ///
    /// # Errors
    /// Those of the source.
    pub fn slice(&self, k: usize) -> Result<Cow<'a, FlakeSlice>> {
        if !self.coat.refracts {
            return self.btf.slice(k);
        }
        let (wi, wo) = self.outer(k);
        let nearest = self.nearest((wi, wo)).unwrap_or(0);
        let mut slice = self.btf.slice(nearest)?.into_owned();
        let (theta_h, theta_i) = self.btf.grid().angles(nearest);
        let (own_i, own_o) = directions(theta_h, theta_i, FRAC_PI_2);
        let smooth = self.btf.smooth();
        let moved = smooth.eval(wi, wo) - smooth.eval(own_i, own_o);
        slice.expectation = (DVec3::from(slice.expectation) + moved).to_array();
        Ok(Cow::Owned(slice))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::TabulatedBrdf;
    use crate::btf::FlakeBtf;
    use serde_json::Value;

    fn btf(bins: usize) -> FlakeBtf {
        let grid = AngleGrid::triangle(bins).unwrap();
        let smooth = |wi: DVec3, wo: DVec3| DVec3::splat(0.1 + 0.2 * (wi.z + wo.z));
        let slice = |k: usize| {
            let (h, i) = grid.angles(k);
            let (wi, wo) = directions(h, i, FRAC_PI_2);
            // A tenth more than the smooth part has.
            let expectation = (1.1 * smooth(wi, wo)).to_array();
            FlakeSlice { fluctuation: vec![[k as f32; 3], [-(k as f32); 3]], expectation }
        };
        FlakeBtf {
            slices: (0..grid.len()).map(slice).collect(),
            size: [2, 1],
            texel_mm: 0.1,
            smooth: TabulatedBrdf::from_fn(45, 90, smooth).unwrap(),
            coat: ClearCoat::NONE,
            provenance: Value::Null,
            grid,
        }
    }

    #[test]
    fn without_refraction_cells_are_slices() {
        let btf = btf(6);
        let cells = Cells::new(&btf, &ClearCoat::ideal(1.5, false)).unwrap();
        assert_eq!(cells.grid(), &btf.grid);
        for k in 0..btf.grid.len() {
            assert_eq!(*cells.slice(k).unwrap(), btf.slices[k]);
            assert!((cells.inner(k).0 - cells.outer(k).0).length() < 1e-15);
        }
    }

    #[test]
    fn refracted_cells_take_the_slices_that_are_seen_there() {
        let btf = btf(12);
        let coat = ClearCoat::ideal(1.5, true);
        let cells = Cells::new(&btf, &coat).unwrap();
        assert_eq!(cells.grid().bins(), 18);
        // 41.8 degrees of 90 are reached, less what lies beyond the last slices.
        assert!((6..=9).contains(&cells.grid().rows().len()), "{:?}", cells.grid().rows());
        for k in 0..cells.grid().len() {
            let ((inner_i, inner_o), (wi, wo)) = (cells.inner(k), cells.outer(k));
            assert!(
                (coat.inner(wi) - inner_i).length() < 1e-14 && (coat.inner(wo) - inner_o).length() < 1e-14
            );
            let slice = cells.slice(k).unwrap();
            let nearest = slice.fluctuation[0][0] as usize;
            let (h, i) = btf.grid.angles(nearest);
            let angles = HalfDifference::of(wi, wo);
            let half = 0.5 * btf.grid.width() + 1e-12;
            assert!((angles.theta_h - h).abs() < half && (angles.theta_i - i).abs() < half);
            // The tenth is that of the slice, not of the place: the smooth part changes by less than .4 over half a bin.
            let smooth = 0.1 + 0.2 * (wi.z + wo.z);
            assert!((slice.expectation[0] - 1.1 * smooth).abs() < 0.1 * 0.4 * half + 1e-3, "{k}");
        }
    }

    #[test]
    fn a_strange_index_is_survived() {
        let btf = btf(180);
        assert_eq!(Cells::new(&btf, &ClearCoat::ideal(4.0, true)).unwrap().grid().bins(), 180);
        let one = self::btf(1);
        assert!(!Cells::new(&one, &ClearCoat::ideal(1.5, true)).unwrap().grid().rows().is_empty());
    }
}
