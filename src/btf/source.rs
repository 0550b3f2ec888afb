//! Where the slices of a flake BTF come from.

use super::{AngleGrid, FlakeBtf, FlakeSlice};
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::error::{Error, Result};
use serde_json::Value;
use std::borrow::Cow;

/// A flake BTF whose slices are asked for one at a time, so that they need not all be in memory. Fields: see [`FlakeBtf`].
pub trait FlakeSource: Sync {
    /// Which angle pairs have a slice.
    fn grid(&self) -> &AngleGrid;
    /// Columns and rows of every slice, texels.
    fn size(&self) -> [usize; 2];
    /// Side of a texel, millimetres.
    fn texel_mm(&self) -> f64;
    /// The smooth part.
    fn smooth(&self) -> &TabulatedBrdf;
    /// The coat over the flakes.
    fn coat(&self) -> ClearCoat;
    /// Where it came from.
    fn provenance(&self) -> &Value;
    /// Slice `k`, below the length of the grid.
    ///
    /// # Errors
    /// Those of the file, if it comes from one.
    fn slice(&self, k: usize) -> Result<Cow<'_, FlakeSlice>>;
}

impl FlakeSource for FlakeBtf {
    fn grid(&self) -> &AngleGrid {
        &self.grid
    }
    fn size(&self) -> [usize; 2] {
        self.size
    }
    fn texel_mm(&self) -> f64 {
        self.texel_mm
    }
    fn smooth(&self) -> &TabulatedBrdf {
        &self.smooth
    }
    fn coat(&self) -> ClearCoat {
        self.coat
    }
    fn provenance(&self) -> &Value {
        &self.provenance
    }
    fn slice(&self, k: usize) -> Result<Cow<'_, FlakeSlice>> {
        let missing = || Error::invalid("slice", "number", k, format!("below {}", self.slices.len()));
        self.slices.get(k).map(Cow::Borrowed).ok_or_else(missing)
    }
}
