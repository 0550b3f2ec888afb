//! A flake BTF as one EXR file: one RGB part a slice, the smooth table, the rest as JSON.

use super::{AngleGrid, FlakeBtf, FlakeSlice};
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::error::{Error, Result};
use crate::file::{ContainerWriter, Part};
use crate::parallel::TryMap;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// `kind` of a flake BTF file.
pub const KIND: &str = "flake-btf";
pub(super) const VERSION: u64 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Meta {
    pub kind: String,
    pub version: u64,
    pub grid: AngleGrid,
    pub size: [usize; 2],
    pub texel_mm: f64,
    pub coat: ClearCoat,
    pub expectation: Vec<[f64; 3]>,
    pub smooth_resolution: [usize; 2],
    pub provenance: Value,
}

/// A flake BTF on its way to a file, slice by slice, in any order and from any thread: memory does not grow with the number
/// of slices.
pub struct BtfWriter {
    container: ContainerWriter,
    grid: AngleGrid,
    size: [usize; 2],
    texel_mm: f64,
    path: PathBuf,
    expectation: Mutex<Vec<Option<[f64; 3]>>>,
}

impl BtfWriter {
    /// A BTF without slices that [`BtfWriter::finish`] will write to `path`.
    ///
    /// # Errors
    /// Sizes that [`FlakeBtf::validate`] refuses.
    pub fn new(path: &Path, grid: &AngleGrid, size: [usize; 2], texel_mm: f64) -> Result<Self> {
        FlakeBtf::check_size(grid, size, texel_mm).map_err(|e| e.in_file(path))?;
        Ok(Self {
            container: ContainerWriter::new(path),
            grid: grid.clone(),
            size,
            texel_mm,
            path: path.to_owned(),
            expectation: Mutex::new(vec![None; grid.len()]),
        })
    }

    /// Adds slice `k` of the grid.
    ///
    /// # Errors
    /// A slice that does not fit, holds a value that is not finite, or was there before; those of the file system.
    pub fn slice(&self, k: usize, slice: &FlakeSlice) -> Result<()> {
        let fault = |e: Error| e.within(format!("slice {k}")).in_file(&self.path);
        slice.validate(self.size).map_err(fault)?;
        match self.expectation.lock().unwrap_or_else(PoisonError::into_inner).get_mut(k) {
            Some(place) => *place = Some(slice.expectation),
            None => return Err(fault(Error::invalid("", "number", k, format!("below {}", self.grid.len())))),
        }
        self.container.part(&slice_name(k), &Part::rgb(self.size, &slice.fluctuation))
    }

    /// Writes the file, whole or not at all; the rest is as in [`FlakeBtf`].
    ///
    /// # Errors
    /// A slice is missing; an illegal coat; those of the file system.
    pub fn finish(self, smooth: &TabulatedBrdf, coat: ClearCoat, provenance: &Value) -> Result<()> {
        let path = self.path.display().to_string();
        coat.validate().map_err(|e| e.within(&path))?;
        let expectation = self.expectation.into_inner().unwrap_or_else(PoisonError::into_inner);
        let there: Vec<[f64; 3]> = expectation.into_iter().flatten().collect();
        if there.len() != self.grid.len() {
            let legal = format!("{} (the grid)", self.grid.len());
            return Err(Error::invalid(path, "slices", there.len(), legal));
        }
        let [theta, phi] = smooth.resolution();
        self.container.part("smooth", &Part::rgb([phi, theta * theta], smooth.values()))?;
        let meta = Meta {
            kind: KIND.into(),
            version: VERSION,
            grid: self.grid,
            size: self.size,
            texel_mm: self.texel_mm,
            coat,
            expectation: there,
            smooth_resolution: [theta, phi],
            provenance: provenance.clone(),
        };
        let meta = serde_json::to_value(meta).map_err(|e| Error::invalid(path, "metadata", e, "JSON"))?;
        self.container.finish(&meta)
    }
}

impl FlakeBtf {
    /// Writes the BTF as one EXR file: parts `slice_0000`, ... (linear Rec.709, the fluctuation) and `smooth` (the
    /// table, a row a pair of polar angles), whole or not at all. [`BtfWriter`] writes the same bytes slice by slice.
    ///
    /// # Errors
    /// As [`FlakeBtf::validate`], and those of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.validate().map_err(|e| e.in_file(path))?;
        let writer = BtfWriter::new(path, &self.grid, self.size, self.texel_mm)?;
        self.slices.par_iter().enumerate().try_map(|(k, slice)| writer.slice(k, slice))?;
        writer.finish(&self.smooth, self.coat, &self.provenance)
    }
}

pub(super) fn slice_name(k: usize) -> String {
    format!("slice_{k:04}")
}
