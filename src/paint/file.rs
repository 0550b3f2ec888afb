//! A paint as one EXR file: parts `clusters` and `offset` (one row a slice and level, levels outer), `inverse_cdf`,
//! `color_table`; the rest as JSON.

use super::{FlakeLevel, Flakes, Knots, MissingSlice, Paint, rows};
use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::btf::AngleGrid;
use crate::cluster::SliceStatistics;
use crate::error::{Error, Result};
use crate::file::{Channel, Container, Part, check_kind};
use crate::sampler::InverseCdf;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// `kind` of a paint file.
pub const KIND: &str = "paint";
const VERSION: u64 = 1;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Meta {
    kind: String,
    version: u64,
    coat: ClearCoat,
    diffuse: f64,
    lobes: Vec<Lobe>,
    flakes: Option<FlakesMeta>,
    provenance: Value,
}

/// What a file says of flakes besides the arrays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FlakesMeta {
    pub grid: AngleGrid,
    pub missing: MissingSlice,
    pub size: [usize; 2],
    pub texel_mm: f64,
    pub pitch_mm: Vec<f64>,
    pub inverse_cdf_steps: usize,
    #[serde(default)]
    pub knot_spacing: Option<f64>,
    /// A file of before paints had their own has none, which is the usual.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub knot_compression: Option<f64>,
}

impl FlakesMeta {
    pub fn knots(&self) -> Option<Knots> {
        let compression = self.knot_compression.unwrap_or(Knots::USUAL_COMPRESSION);
        self.knot_spacing.map(|spacing| Knots { spacing, compression })
    }
}

impl Paint {
    /// Writes the paint, whole or not at all.
    ///
    /// # Errors
    /// As [`Paint::validate`], and those of the file system.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.validate().map_err(|e| e.in_file(path))?;
        let mut parts = BTreeMap::from([("color_table".to_owned(), color_table_part(&self.colors))]);
        if let Some(flakes) = &self.flakes {
            flakes.insert_parts(&mut parts).map_err(|e| e.in_file(path))?;
        }
        let meta = Meta {
            kind: KIND.into(),
            version: VERSION,
            coat: self.coat,
            diffuse: self.diffuse,
            lobes: self.lobes.clone(),
            flakes: self.flakes.as_ref().map(Flakes::meta),
            provenance: self.provenance.clone(),
        };
        let meta = serde_json::to_value(meta)
            .map_err(|e| Error::invalid(path.display().to_string(), "metadata", e, "JSON"))?;
        Container { meta, parts }.write(path)
    }

    /// Reads a paint.
    ///
    /// # Errors
    /// As [`Container::read`]; another kind of file, a newer version, unknown keys, parts that do not fit.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_container(Container::read(path)?).map_err(|e| e.in_file(path))
    }

    /// A paint from a container already read.
    ///
    /// # Errors
    /// As [`Paint::read`], the file not named.
    pub fn from_container(mut container: Container) -> Result<Self> {
        check_kind(&container.meta, KIND, VERSION)?;
        let meta: Meta = serde_json::from_value(std::mem::take(&mut container.meta))
            .map_err(|e| Error::invalid("attribute carpaint", "paint", e, "the keys of this version"))?;
        let paint = Self {
            coat: meta.coat,
            diffuse: meta.diffuse,
            lobes: meta.lobes,
            colors: read_color_table(&container, "color_table")?,
            flakes: meta.flakes.map(|m| Flakes::from_parts(m, &container)).transpose()?,
            provenance: meta.provenance,
        };
        paint.validate()?;
        Ok(paint)
    }
}

impl Flakes {
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

    fn insert_parts(&self, parts: &mut BTreeMap<String, Part>) -> Result<()> {
        let all: Vec<&SliceStatistics> = self.levels.iter().flat_map(|l| &l.slices).collect();
        let probabilities: Vec<Vec<f64>> =
            all.iter().map(|s| s.clusters.iter().map(|c| c.probability).collect()).collect();
        let corners: Vec<Vec<_>> =
            all.iter().map(|s| s.clusters.iter().map(|c| [c.min, c.max]).collect()).collect();
        let steps = probabilities
            .iter()
            .map(|p| inverse_cdf_row(p, self.inverse_cdf_steps))
            .collect::<Result<Vec<_>>>()?;
        let probabilities: Vec<&[f64]> = probabilities.iter().map(Vec::as_slice).collect();
        let corners: Vec<&[_]> = corners.iter().map(Vec::as_slice).collect();
        let mut channels = rows::probability_channels(&probabilities);
        channels.extend(rows::corner_channels(&corners));
        let fades: Vec<&[f32]> = all.iter().map(|s| s.fades.as_slice()).collect();
        if fades.iter().any(|f| !f.is_empty()) {
            channels.push(rows::fade_channel(&fades, &probabilities));
        }
        parts.insert("clusters".into(), rows::part(&probabilities, channels));
        let offsets: Vec<[f32; 3]> = all.iter().map(|s| s.offset).collect();
        let mut part = Part::rgb([1, all.len()], &offsets);
        part.channels.extend((0..3).map(|c| Channel::f32(GAINS[c], all.iter().map(|s| s.gain[c]).collect())));
        parts.insert("offset".into(), part);
        let steps = steps.concat();
        let size = [self.inverse_cdf_steps, all.len()];
        parts.insert("inverse_cdf".into(), Part { size, channels: vec![Channel::u32("index", steps)] });
        Ok(())
    }

    fn from_parts(meta: FlakesMeta, container: &Container) -> Result<Self> {
        let part = container.part("clusters")?;
        let in_clusters = |e: Error| e.within("part clusters");
        let probabilities = rows::read_probabilities(part).map_err(in_clusters)?;
        let lengths: Vec<usize> = probabilities.iter().map(Vec::len).collect();
        let corners = rows::read_corners(part, &lengths).map_err(in_clusters)?;
        let fades = rows::read_fades(part, &lengths).map_err(in_clusters)?;
        let [offsets, gains] =
            read_offsets(container.part("offset")?).map_err(|e| e.within("part offset"))?;
        let expected = meta.grid.len() * meta.pitch_mm.len();
        if probabilities.len() != expected || offsets.len() != expected {
            let found = format!("{} and {}", probabilities.len(), offsets.len());
            let legal = format!("{expected} (slices times levels)");
            return Err(Error::invalid("parts clusters, offset", "rows", found, legal));
        }
        check_inverse_cdf(container.part("inverse_cdf")?, &probabilities, meta.inverse_cdf_steps)
            .map_err(|e| e.within("part inverse_cdf"))?;
        let mut slices =
            probabilities.into_iter().zip(corners).zip(fades).zip(offsets.into_iter().zip(gains)).map(
                |(((p, c), fades), (offset, gain))| SliceStatistics {
                    clusters: rows::zip(p, c),
                    fades,
                    gain,
                    offset,
                },
            );
        let knots = meta.knots();
        let levels = meta
            .pitch_mm
            .iter()
            .map(|pitch_mm| FlakeLevel {
                pitch_mm: *pitch_mm,
                slices: slices.by_ref().take(meta.grid.len()).collect(),
            })
            .collect();
        Ok(Self {
            grid: meta.grid,
            missing: meta.missing,
            size: meta.size,
            texel_mm: meta.texel_mm,
            levels,
            inverse_cdf_steps: meta.inverse_cdf_steps,
            knots,
        })
    }
}

/// Channels of the gain in part `offset`.
const GAINS: [&str; 3] = ["gain.R", "gain.G", "gain.B"];

/// Offsets and gains; a file of before there were gains has none, which is 1.
fn read_offsets(part: &Part) -> Result<[Vec<[f32; 3]>; 2]> {
    let offsets = part.rgb_texels()?;
    if part.channels.iter().all(|c| c.name != GAINS[0]) {
        let gains = vec![[1.0; 3]; offsets.len()];
        return Ok([offsets, gains]);
    }
    let [r, g, b] = [part.f32(GAINS[0])?, part.f32(GAINS[1])?, part.f32(GAINS[2])?];
    let gains = r.into_iter().zip(g).zip(b).map(|((r, g), b)| [r, g, b]).collect();
    Ok([offsets, gains])
}

/// The row of a slice; zeros for one that was left out.
fn inverse_cdf_row(probabilities: &[f64], steps: usize) -> Result<Vec<u32>> {
    if probabilities.is_empty() {
        return Ok(vec![0; steps]);
    }
    Ok(InverseCdf::new(probabilities, steps)?.steps().iter().map(|s| u32::from(*s)).collect())
}

/// The table is for engines; carpaint draws from the exact probabilities, and checks that engines would draw the same.
fn check_inverse_cdf(part: &Part, probabilities: &[Vec<f64>], steps: usize) -> Result<()> {
    if part.size != [steps, probabilities.len()] {
        let legal = format!("{steps} x {}", probabilities.len());
        return Err(Error::invalid("", "size", format!("{} x {}", part.size[0], part.size[1]), legal));
    }
    let found = part.u32("index")?;
    for (row, p) in probabilities.iter().enumerate() {
        let expected = inverse_cdf_row(p, steps).map_err(|e| e.within(format!("row {row}")))?;
        for (k, (found, expected)) in found[row * steps..].iter().zip(expected).enumerate() {
            if *found != expected {
                let place = format!("pixel ({k}, {row})");
                let legal = format!("{expected} (by the probabilities)");
                return Err(Error::invalid(place, "cluster", found, legal));
            }
        }
    }
    Ok(())
}

/// The color table as a part: R, G, B and which texels were measured.
pub(crate) fn color_table_part(table: &ColorTable) -> Part {
    let mut part = Part::rgb(table.size(), table.texels());
    let measured = table.measured().iter().map(|m| f32::from(u8::from(*m))).collect();
    part.channels.push(Channel::f32("measured", measured));
    part
}

/// Inverse of [`color_table_part`].
pub(crate) fn read_color_table(container: &Container, name: &str) -> Result<ColorTable> {
    let read = || {
        let part = container.part(name)?;
        let measured = part.f32("measured")?.into_iter().map(|m| m > 0.5).collect();
        ColorTable::new(part.size, part.rgb_texels()?, measured)
    };
    read().map_err(|e| e.within(format!("part {name}")))
}
