//! Raw flake slices with what is needed to use them: angle grid, physical size, the smooth part they fluctuate about.

use super::AngleGrid;
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::error::{Error, Result};
use serde_json::Value;

/// A flake BTF: per angle pair a signed texture.
///
/// Values are BRDF, 1/sr, linear Rec.709, no cosine, as seen from outside the coat (Fresnel losses included, gloss left
/// out). **Who carries the mean**: a slice is a fluctuation of zero mean about an expectation, and the expectation is the
/// smooth BRDF of the same angles, glitter included; so nothing is counted twice.
#[derive(Debug, Clone, PartialEq)]
pub struct FlakeBtf {
    /// Which angle pairs have a slice. Angles are the outer ones.
    pub grid: AngleGrid,
    /// Columns and rows of every slice, texels; the texture repeats.
    pub size: [usize; 2],
    /// Side of a texel, millimetres, 1e-6 to 1e4; typically 0.01-0.1.
    pub texel_mm: f64,
    /// One slice a grid point, in grid order.
    pub slices: Vec<FlakeSlice>,
    /// The smooth part (glitter mean + shade, no gloss), from outside the coat.
    pub smooth: TabulatedBrdf,
    /// The coat over the flakes.
    pub coat: ClearCoat,
    /// Where it came from: free-form JSON (composition, seed, tool version, statistics checks).
    pub provenance: Value,
}

/// One texture of a flake BTF.
#[derive(Debug, Clone, PartialEq)]
pub struct FlakeSlice {
    /// Texels minus expectation, row-major, zero mean up to the sampling of the flakes.
    pub fluctuation: Vec<[f32; 3]>,
    /// The smooth BRDF at this slice's angles and phi_d = 90 degrees, as the model gives it.
    pub expectation: [f64; 3],
}

impl FlakeBtf {
    /// Largest side of a slice, texels.
    pub const MAX_SIDE: usize = 4096;
    /// Most texels in all slices together.
    pub const MAX_TEXELS: usize = 1 << 28;

    /// Checks that everything fits together.
    ///
    /// # Errors
    /// Sides outside 1-4096, more than [`Self::MAX_TEXELS`] in all, a texel size outside its range, slices that do not fit
    /// grid or size, a value that is not finite (slice and texel named), an illegal coat.
    pub fn validate(&self) -> Result<()> {
        Self::check_size(&self.grid, self.size, self.texel_mm)?;
        if self.slices.len() != self.grid.len() {
            let legal = format!("{} (the grid)", self.grid.len());
            return Err(Error::invalid("flake BTF", "slices", self.slices.len(), legal));
        }
        for (k, slice) in self.slices.iter().enumerate() {
            slice.validate(self.size).map_err(|e| e.within(format!("slice {k}")))?;
        }
        self.coat.validate()
    }

    /// Checks the size of everything, before any of it is there.
    pub(super) fn check_size(grid: &AngleGrid, size: [usize; 2], texel_mm: f64) -> Result<()> {
        Self::check_texels(size, texel_mm).map_err(|e| e.within("flake BTF"))?;
        let texels = grid.len() * size[0] * size[1];
        if texels > Self::MAX_TEXELS {
            let legal = format!("up to {}", Self::MAX_TEXELS);
            return Err(Error::invalid("flake BTF", "texels in all slices", texels, legal));
        }
        Ok(())
    }

    /// Checks columns and rows of a slice, and the side of a texel.
    pub(crate) fn check_texels(size: [usize; 2], texel_mm: f64) -> Result<()> {
        if size.iter().any(|n| !(1..=Self::MAX_SIDE).contains(n)) {
            return Err(Error::invalid("", "slice size", format!("{size:?}"), "1 to 4096"));
        }
        if !(1e-6..=1e4).contains(&texel_mm) {
            return Err(Error::invalid("", "texel_mm", texel_mm, "1e-6 to 1e4"));
        }
        Ok(())
    }
}

impl FlakeSlice {
    pub(super) fn validate(&self, size: [usize; 2]) -> Result<()> {
        if self.fluctuation.len() != size[0] * size[1] {
            let legal = format!("{} ({} x {})", size[0] * size[1], size[0], size[1]);
            return Err(Error::invalid("", "texels", self.fluctuation.len(), legal));
        }
        if let Some(k) = self.fluctuation.iter().position(|t| t.iter().any(|c| !c.is_finite())) {
            let place = format!("texel ({}, {})", k % size[0], k / size[0]);
            let found = format!("{:?}", self.fluctuation[k]);
            return Err(Error::invalid(place, "value", found, "finite numbers"));
        }
        if self.expectation.iter().any(|c| !c.is_finite()) {
            let found = format!("{:?}", self.expectation);
            return Err(Error::invalid("", "expectation", found, "finite numbers"));
        }
        Ok(())
    }
}
