//! A flake BTF as one EXR file: one RGB part a slice, the smooth table, the rest as JSON.

use super::{AngleGrid, FlakeBtf, FlakeSlice};
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::error::{Error, Result};
use crate::file::{Container, Part};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// `kind` of a flake BTF file.
pub const KIND: &str = "flake-btf";
const VERSION: u64 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Meta {
    kind: String,
    version: u64,
    grid: AngleGrid,
    size: [usize; 2],
    texel_mm: f64,
    coat: ClearCoat,
    expectation: Vec<[f64; 3]>,
    smooth_resolution: [usize; 2],
    provenance: Value,
}

impl FlakeBtf {
    /// Writes the BTF as one EXR file: parts `slice_0000`, ... (linear Rec.709, the fluctuation) and `smooth` (the
    /// table, a row a pair of polar angles), whole or not at all.
    ///
    /// # Errors
    /// As [`FlakeBtf::validate`], and those of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.validate().map_err(|e| e.in_file(path))?;
        let [theta, phi] = self.smooth.resolution();
        let meta = Meta {
            kind: KIND.into(),
            version: VERSION,
            grid: self.grid.clone(),
            size: self.size,
            texel_mm: self.texel_mm,
            coat: self.coat,
            expectation: self.slices.iter().map(|s| s.expectation).collect(),
            smooth_resolution: [theta, phi],
            provenance: self.provenance.clone(),
        };
        let mut parts: std::collections::BTreeMap<_, _> = self
            .slices
            .iter()
            .enumerate()
            .map(|(k, s)| (slice_name(k), Part::rgb(self.size, &s.fluctuation)))
            .collect();
        parts.insert("smooth".into(), Part::rgb([phi, theta * theta], self.smooth.values()));
        let meta = serde_json::to_value(meta)
            .map_err(|e| Error::invalid(path.display().to_string(), "metadata", e, "JSON"))?;
        Container { meta, parts }.write(path)
    }

    /// Reads a flake BTF.
    ///
    /// # Errors
    /// As [`Container::read`]; another kind of file, a newer version, unknown keys, parts that do not fit.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_container(Container::read(path)?).map_err(|e| e.in_file(path))
    }

    /// A flake BTF from a container already read.
    ///
    /// # Errors
    /// As [`FlakeBtf::read`], the file not named.
    pub fn from_container(mut container: Container) -> Result<Self> {
        crate::file::check_kind(&container.meta, KIND, VERSION)?;
        let meta: Meta = serde_json::from_value(std::mem::take(&mut container.meta))
            .map_err(|e| Error::invalid("attribute carpaint", "flake BTF", e, "the keys of this version"))?;
        if meta.expectation.len() != meta.grid.len() {
            let legal = format!("{} (the grid)", meta.grid.len());
            return Err(Error::invalid("expectation", "length", meta.expectation.len(), legal));
        }
        Self::check_size(&meta.grid, meta.size, meta.texel_mm)?;
        let mut slices = Vec::with_capacity(meta.grid.len());
        for (k, expectation) in meta.expectation.into_iter().enumerate() {
            let name = slice_name(k);
            let fluctuation = texels(&container, &name, meta.size)?;
            container.parts.remove(&name);
            slices.push(FlakeSlice { fluctuation, expectation });
        }
        let [theta, phi] = meta.smooth_resolution;
        let smooth = texels(&container, "smooth", [phi, theta.saturating_mul(theta)])?;
        let btf = Self {
            grid: meta.grid,
            size: meta.size,
            texel_mm: meta.texel_mm,
            slices,
            smooth: TabulatedBrdf::new(theta, phi, smooth).map_err(|e| e.within("part smooth"))?,
            coat: meta.coat,
            provenance: meta.provenance,
        };
        btf.validate()?;
        Ok(btf)
    }
}

/// The colors of a part of this size.
fn texels(container: &Container, name: &str, size: [usize; 2]) -> Result<Vec<[f32; 3]>> {
    let part = container.part(name)?;
    if part.size != size {
        let (found, legal) = (format!("{:?}", part.size), format!("{size:?}"));
        return Err(Error::invalid(format!("part {name}"), "size", found, legal));
    }
    part.rgb_texels().map_err(|e| e.within(format!("part {name}")))
}

fn slice_name(k: usize) -> String {
    format!("slice_{k:04}")
}
