//! A mix as one EXR file: part `arcs` (probabilities, one row a slice and level), `clusters_K`, `mean_K` and
//! `color_table_K` for paint K; the rest as JSON.

use super::{Arc, Constituent, Mix, MixFlakes, MixLevel, MixSlice};
use crate::brdf::{ClearCoat, Lobe};
use crate::error::{Error, Result};
use crate::file::{Channel, Container, Part, check_kind};
use crate::paint::{FlakesMeta, color_table_part, read_color_table, rows};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// `kind` of a mix file.
pub const KIND: &str = "mix";
const VERSION: u64 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Meta {
    kind: String,
    version: u64,
    constituents: Vec<ConstituentMeta>,
    flakes: Option<FlakesMeta>,
    /// Means of each paint in each row (levels outer), linear Rec.709; f64, since an offset is a small difference of them.
    means: Vec<Vec<[f64; 3]>>,
    /// Duality gap of each row, Lab units.
    gaps: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConstituentMeta {
    name: String,
    coat: ClearCoat,
    diffuse: f64,
    lobes: Vec<Lobe>,
    provenance: Value,
}

impl Mix {
    /// Writes the mix, whole or not at all.
    ///
    /// # Errors
    /// As [`Mix::validate`], and those of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.validate().map_err(|e| e.in_file(path))?;
        let mut parts = BTreeMap::new();
        for (k, c) in self.constituents.iter().enumerate() {
            parts.insert(format!("color_table_{k}"), color_table_part(&c.colors));
        }
        let rows: Vec<&MixSlice> =
            self.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices).collect();
        if !rows.is_empty() {
            insert_arcs(&rows, self.constituents.len(), &mut parts);
        }
        let constituents = self
            .constituents
            .iter()
            .map(|c| ConstituentMeta {
                name: c.name.clone(),
                coat: c.coat,
                diffuse: c.diffuse,
                lobes: c.lobes.clone(),
                provenance: c.provenance.clone(),
            })
            .collect();
        let meta = Meta {
            kind: KIND.into(),
            version: VERSION,
            constituents,
            flakes: self.flakes.as_ref().map(MixFlakes::meta),
            means: rows.iter().map(|r| r.means.iter().map(|m| m.to_array()).collect()).collect(),
            gaps: rows.iter().map(|r| r.gap).collect(),
        };
        let meta = serde_json::to_value(meta)
            .map_err(|e| Error::invalid(path.display().to_string(), "metadata", e, "JSON"))?;
        Container { meta, parts }.write(path)
    }

    /// Reads a mix.
    ///
    /// # Errors
    /// As [`Container::read`]; another kind of file, a newer version, unknown keys, parts that do not fit.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_container(Container::read(path)?).map_err(|e| e.in_file(path))
    }

    /// A mix from a container already read.
    ///
    /// # Errors
    /// As [`Mix::read`], the file not named.
    pub fn from_container(mut container: Container) -> Result<Self> {
        check_kind(&container.meta, KIND, VERSION)?;
        let meta: Meta = serde_json::from_value(std::mem::take(&mut container.meta))
            .map_err(|e| Error::invalid("attribute carpaint", "mix", e, "the keys of this version"))?;
        let paints = meta.constituents.len();
        let mut constituents = Vec::with_capacity(paints);
        for (k, c) in meta.constituents.into_iter().enumerate() {
            let colors = read_color_table(&container, &format!("color_table_{k}"))?;
            let ConstituentMeta { name, coat, diffuse, lobes, provenance } = c;
            constituents.push(Constituent { name, coat, diffuse, lobes, colors, provenance });
        }
        let flakes = match meta.flakes {
            Some(f) => Some(MixFlakes::from_rows(f, read_arcs(&container, paints, meta.means, meta.gaps)?)?),
            None => None,
        };
        let mix = Self { constituents, flakes };
        mix.validate()?;
        Ok(mix)
    }
}

fn insert_arcs(rows: &[&MixSlice], paints: usize, parts: &mut BTreeMap<String, Part>) {
    let probabilities: Vec<Vec<f64>> =
        rows.iter().map(|r| r.arcs.iter().map(|a| a.probability).collect()).collect();
    let probabilities: Vec<&[f64]> = probabilities.iter().map(Vec::as_slice).collect();
    let channels: Vec<Channel> = rows::probability_channels(&probabilities);
    parts.insert("arcs".into(), rows::part(&probabilities, channels));
    for k in 0..paints {
        let corners: Vec<Vec<_>> = rows.iter().map(|r| r.arcs.iter().map(|a| a.boxes[k]).collect()).collect();
        let corners: Vec<&[_]> = corners.iter().map(Vec::as_slice).collect();
        parts.insert(format!("clusters_{k}"), rows::part(&corners, rows::corner_channels(&corners)));
    }
}

fn read_arcs(
    container: &Container,
    paints: usize,
    means: Vec<Vec<[f64; 3]>>,
    gaps: Vec<f64>,
) -> Result<Vec<MixSlice>> {
    let probabilities =
        rows::read_probabilities(container.part("arcs")?).map_err(|e| e.within("part arcs"))?;
    let lengths: Vec<usize> = probabilities.iter().map(Vec::len).collect();
    if means.len() != lengths.len() || gaps.len() != lengths.len() {
        let found = format!("{} means, {} gaps", means.len(), gaps.len());
        return Err(Error::invalid("attribute carpaint", "rows", found, lengths.len().to_string()));
    }
    let mut corners = Vec::with_capacity(paints);
    for k in 0..paints {
        let name = format!("clusters_{k}");
        let read = rows::read_corners(container.part(&name)?, &lengths);
        corners.push(read.map_err(|e| e.within(format!("part {name}")))?);
    }
    let slices = probabilities.into_iter().zip(means).zip(gaps).enumerate();
    Ok(slices
        .map(|(row, ((probabilities, means), gap))| {
            let arcs = probabilities
                .into_iter()
                .enumerate()
                .map(|(a, probability)| Arc {
                    probability,
                    boxes: corners.iter().map(|c| c[row][a]).collect(),
                })
                .collect();
            MixSlice { arcs, means: means.into_iter().map(DVec3::from).collect(), gap }
        })
        .collect())
}

impl MixFlakes {
    fn meta(&self) -> FlakesMeta {
        FlakesMeta {
            grid: self.grid.clone(),
            missing: self.missing,
            size: self.size,
            texel_mm: self.texel_mm,
            pitch_mm: self.levels.iter().map(|l| l.pitch_mm).collect(),
            inverse_cdf_steps: self.inverse_cdf_steps,
            knot_spacing: self.knot_spacing,
        }
    }

    fn from_rows(meta: FlakesMeta, rows: Vec<MixSlice>) -> Result<Self> {
        let expected = meta.grid.len() * meta.pitch_mm.len();
        if rows.len() != expected {
            return Err(Error::invalid(
                "part arcs",
                "rows",
                rows.len(),
                format!("{expected} (slices times levels)"),
            ));
        }
        let mut rows = rows.into_iter();
        let levels = meta
            .pitch_mm
            .iter()
            .map(|pitch_mm| MixLevel {
                pitch_mm: *pitch_mm,
                slices: rows.by_ref().take(meta.grid.len()).collect(),
            })
            .collect();
        Ok(Self {
            grid: meta.grid,
            missing: meta.missing,
            size: meta.size,
            texel_mm: meta.texel_mm,
            inverse_cdf_steps: meta.inverse_cdf_steps,
            knot_spacing: meta.knot_spacing,
            levels,
        })
    }
}
