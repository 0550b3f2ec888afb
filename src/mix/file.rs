//! A mix as one EXR file: part `arcs` (probabilities and groups, one row a slice and level), `clusters_K` and `color_table_K`
//! for paint K; the rest as JSON.

use super::{Constituent, Groups, Mix, MixFlakes, MixLevel, MixSlice, Path};
use crate::brdf::{ClearCoat, Lobe};
use crate::error::{Error, Result};
use crate::file::{Channel, Container, Part, check_kind};
use crate::paint::{FlakesMeta, color_table_part, read_color_table, rows};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// `kind` of a mix file.
pub const KIND: &str = "mix";
/// 1 had neither groups nor deviations.
const VERSION: u64 = 2;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Meta {
    kind: String,
    version: u64,
    constituents: Vec<ConstituentMeta>,
    flakes: Option<FlakesMeta>,
    path: Path,
    /// As on the command line.
    cost: String,
    threshold: f64,
    /// One a slice and level (levels outer).
    rows: Vec<RowMeta>,
}

/// What a row holds of each paint besides its boxes; f64, since an offset is a small difference of means.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RowMeta {
    /// Linear Rec.709, 1/sr.
    means: Vec<[f64; 3]>,
    deviations: Vec<[f64; 3]>,
    gains: Vec<[f32; 3]>,
    /// Duality gap.
    gap: f64,
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
    pub fn write(&self, path: &std::path::Path) -> Result<()> {
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
            path: self.path,
            cost: self.cost.to_string(),
            threshold: self.threshold,
            rows: rows.iter().map(|r| RowMeta::of(r)).collect(),
        };
        let meta = serde_json::to_value(meta)
            .map_err(|e| Error::invalid(path.display().to_string(), "metadata", e, "JSON"))?;
        Container { meta, parts }.write(path)
    }

    /// Reads a mix.
    ///
    /// # Errors
    /// As [`Container::read`]; another kind of file, a newer version, unknown keys, parts that do not fit.
    pub fn read(path: &std::path::Path) -> Result<Self> {
        Self::from_container(Container::read(path)?).map_err(|e| e.in_file(path))
    }

    /// A mix from a container already read.
    ///
    /// # Errors
    /// As [`Mix::read`], the file not named.
    pub fn from_container(mut container: Container) -> Result<Self> {
        check_kind(&container.meta, KIND, VERSION)?;
        if container.meta.get("version").and_then(Value::as_u64) == Some(1) {
            let legal = format!("{VERSION}: couple the paints again");
            return Err(Error::unsupported("attribute carpaint", "version of a mix", 1, legal));
        }
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
            Some(f) => Some(MixFlakes::from_rows(f, read_arcs(&container, paints, meta.rows)?)?),
            None => None,
        };
        let (path, threshold) = (meta.path, meta.threshold);
        let cost = meta.cost.parse().map_err(|e: Error| e.within("attribute carpaint"))?;
        let mix = Self { constituents, flakes, path, cost, threshold };
        mix.validate()?;
        Ok(mix)
    }
}

impl RowMeta {
    fn of(row: &MixSlice) -> Self {
        let arrays = |values: &[DVec3]| values.iter().map(|v| v.to_array()).collect();
        Self {
            means: arrays(&row.means),
            deviations: arrays(&row.deviations),
            gains: row.gains.clone(),
            gap: row.gap,
        }
    }

    fn into_slice(
        self,
        probabilities: Vec<f64>,
        groups: Vec<Groups>,
        boxes: Vec<Vec<[[f32; 3]; 2]>>,
    ) -> MixSlice {
        let vectors = |values: Vec<[f64; 3]>| values.into_iter().map(DVec3::from).collect();
        MixSlice {
            probabilities,
            boxes,
            groups,
            means: vectors(self.means),
            deviations: vectors(self.deviations),
            gains: self.gains,
            gap: self.gap,
        }
    }
}

fn insert_arcs(rows: &[&MixSlice], paints: usize, parts: &mut BTreeMap<String, Part>) {
    let probabilities: Vec<&[f64]> = rows.iter().map(|r| r.probabilities.as_slice()).collect();
    let mut channels: Vec<Channel> = rows::probability_channels(&probabilities);
    let groups: Vec<&[Groups]> = rows.iter().map(|r| r.groups.as_slice()).collect();
    channels.push(Channel::u32("groups", rows::rectangle(&groups, |g| g.0)));
    parts.insert("arcs".into(), rows::part(&probabilities, channels));
    for k in 0..paints {
        let corners: Vec<&[_]> = rows.iter().map(|r| r.boxes[k].as_slice()).collect();
        parts.insert(format!("clusters_{k}"), rows::part(&corners, rows::corner_channels(&corners)));
    }
}

fn read_arcs(container: &Container, paints: usize, meta: Vec<RowMeta>) -> Result<Vec<MixSlice>> {
    let part = container.part("arcs")?;
    let probabilities = rows::read_probabilities(part).map_err(|e| e.within("part arcs"))?;
    let groups = part.u32("groups").map_err(|e| e.within("part arcs"))?;
    let lengths: Vec<usize> = probabilities.iter().map(Vec::len).collect();
    if meta.len() != lengths.len() {
        return Err(Error::invalid("attribute carpaint", "rows", meta.len(), lengths.len().to_string()));
    }
    let mut corners = Vec::with_capacity(paints);
    for k in 0..paints {
        let name = format!("clusters_{k}");
        let read = rows::read_corners(container.part(&name)?, &lengths);
        corners.push(read.map_err(|e| e.within(format!("part {name}")))?.into_iter());
    }
    let rows = probabilities.into_iter().zip(meta).enumerate().map(|(row, (probabilities, meta))| {
        let groups = groups[row * part.size[0]..].iter().take(probabilities.len()).map(|g| Groups(*g));
        let boxes = corners.iter_mut().map(|c| c.next().unwrap_or_default()).collect();
        let groups = groups.collect();
        meta.into_slice(probabilities, groups, boxes)
    });
    Ok(rows.collect())
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
            knot_spacing: self.knots.map(|k| k.spacing),
            knot_compression: self.knots.map(|k| k.compression),
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
        let knots = meta.knots();
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
            knots,
            levels,
        })
    }
}
