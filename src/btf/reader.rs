//! A flake BTF read from its file slice by slice.

use super::file::{KIND, Meta, VERSION, slice_name};
use super::{AngleGrid, FlakeBtf, FlakeSlice, FlakeSource};
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::error::{Error, Result};
use crate::file::{ContainerReader, Part, check_kind};
use crate::parallel::TryMap;
use rayon::prelude::*;
use serde_json::Value;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// An open flake BTF: everything but the slices is read, and these come from the file when they are asked for, from any
/// thread.
pub struct BtfReader {
    container: ContainerReader,
    path: PathBuf,
    grid: AngleGrid,
    size: [usize; 2],
    texel_mm: f64,
    smooth: TabulatedBrdf,
    coat: ClearCoat,
    expectation: Vec<[f64; 3]>,
    provenance: Value,
}

impl BtfReader {
    /// Opens a flake BTF.
    ///
    /// # Errors
    /// As [`ContainerReader::open`]; another kind of file, a newer version, unknown keys, parts that do not fit or are missing,
    /// sizes that [`FlakeBtf::validate`] refuses.
    pub fn open(path: &Path) -> Result<Self> {
        let container = ContainerReader::open(path)?;
        let meta = Self::meta(&container).map_err(|e| e.in_file(path))?;
        let [theta, phi] = meta.smooth_resolution;
        let smooth = texels(&container.part("smooth")?, [phi, theta.saturating_mul(theta)])
            .and_then(|values| TabulatedBrdf::new(theta, phi, values));
        Ok(Self {
            container,
            path: path.to_owned(),
            grid: meta.grid,
            size: meta.size,
            texel_mm: meta.texel_mm,
            smooth: smooth.map_err(|e| e.within("part smooth").in_file(path))?,
            coat: meta.coat,
            expectation: meta.expectation,
            provenance: meta.provenance,
        })
    }

    fn meta(container: &ContainerReader) -> Result<Meta> {
        check_kind(&container.meta, KIND, VERSION)?;
        let meta: Meta = serde_json::from_value(container.meta.clone())
            .map_err(|e| Error::invalid("attribute carpaint", "flake BTF", e, "the keys of this version"))?;
        if meta.expectation.len() != meta.grid.len() {
            let legal = format!("{} (the grid)", meta.grid.len());
            return Err(Error::invalid("expectation", "length", meta.expectation.len(), legal));
        }
        FlakeBtf::check_size(&meta.grid, meta.size, meta.texel_mm)?;
        meta.coat.validate()?;
        Ok(meta)
    }
}

impl FlakeSource for BtfReader {
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
        let name = slice_name(k);
        let part = self.container.part(&name)?;
        let read = || {
            let fluctuation = texels(&part, self.size)?;
            let slice = FlakeSlice { fluctuation, expectation: self.expectation[k] };
            slice.validate(self.size)?;
            Ok(Cow::Owned(slice))
        };
        read().map_err(|e: Error| e.within(format!("part {name}")).in_file(&self.path))
    }
}

impl FlakeBtf {
    /// Reads a flake BTF.
    ///
    /// # Errors
    /// As [`BtfReader::open`]; a slice that does not fit or is damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let reader = BtfReader::open(path)?;
        let slice = |k: usize| reader.slice(k).map(Cow::into_owned);
        let slices = (0..reader.grid.len()).into_par_iter().try_map(slice)?;
        let BtfReader { grid, size, texel_mm, smooth, coat, provenance, .. } = reader;
        Ok(Self { grid, size, texel_mm, slices, smooth, coat, provenance })
    }
}

/// The colors of a part of this size.
fn texels(part: &Part, size: [usize; 2]) -> Result<Vec<[f32; 3]>> {
    if part.size != size {
        return Err(Error::invalid("", "size", format!("{:?}", part.size), format!("{size:?}")));
    }
    part.rgb_texels()
}
