//! One entry to every kind of measured table, and one to every kind of measurement.

use super::measurement::{Counts, Measurement};
use super::{SampleSet, TabulatedBrdf};
use super::{half_angle, mbsdf, merl, multi_angle, nbrdf, rgl};
use crate::error::{Error, Result};
pub(super) use crate::file::open;
use std::io::Read;
use std::path::Path;

/// The formats that [`read_measured`] knows, as told to the user.
const FORMATS: &str =
    "an mbsdf table (\"NVIDIA ARC MBSDF V1\") or a neural BRDF (.f32 or .nbrdf, 675 floats)";

/// Reads a measured BRDF, whatever its format: chosen by the first bytes, else by length and extension.
///
/// # Errors
/// A file that cannot be read, is of no known format, or contradicts its format.
pub fn read_measured(path: &Path) -> Result<TabulatedBrdf> {
    let (mut file, length) = open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(mbsdf::MAGIC.len() as u64).read_to_end(&mut head).map_err(|e| Error::io(path, e))?;
    if head == mbsdf::MAGIC {
        return TabulatedBrdf::read_mbsdf(path);
    }
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("mbsdf") => TabulatedBrdf::read_mbsdf(path),
        Some("f32" | "nbrdf") => neural(path),
        _ if length == nbrdf::BYTES => neural(path),
        _ => {
            let found = format!("{length} bytes beginning {:?}", String::from_utf8_lossy(&head));
            Err(Error::invalid(path.display().to_string(), "format", found, FORMATS))
        }
    }
}

/// The formats that [`read_samples`] knows beyond those.
const SAMPLE_FORMATS: &str = "an RGL material (.bsdf), a MERL file (34992012 bytes), a half-angle table of Guenther et al. \
    (17496084 bytes), readings of a multi-angle instrument (.csv, .tsv or .txt)";

/// Reads a measured BRDF as samples, whatever its format: those of [`read_measured`], and [`rgl`], [`merl`], [`half_angle`] and
/// [`multi_angle`]; chosen by the first bytes, else by length and extension.
///
/// # Errors
/// A file that cannot be read, is of no known format, contradicts its format, or holds no usable sample.
pub fn read_samples(path: &Path) -> Result<Measurement> {
    let (file, length) = open(path)?;
    let mut head = Vec::new();
    file.take(rgl::MAGIC.len() as u64).read_to_end(&mut head).map_err(|e| Error::io(path, e))?;
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match (extension.as_deref(), length) {
        _ if head == rgl::MAGIC => rgl::read_rgl(path),
        (Some("bsdf"), _) => rgl::read_rgl(path),
        (Some("binary"), _) | (_, merl::BYTES) => merl::read_merl(path),
        (_, half_angle::BYTES) => half_angle::read_half_angle(path),
        (Some("csv" | "tsv" | "txt"), _) => multi_angle::read_multi_angle(path),
        _ => tabulated(path),
    }
}

/// The samples of a table, its cells.
fn tabulated(path: &Path) -> Result<Measurement> {
    let table = read_measured(path).map_err(|e| match e {
        Error::Invalid(fault) if fault.what == "format" => {
            Error::invalid(fault.place, fault.what, fault.found, format!("{}, {SAMPLE_FORMATS}", fault.legal))
        }
        other => other,
    })?;
    let samples = SampleSet::from(&table);
    let counts = Counts { found: samples.len(), ..Counts::default() };
    Measurement::new(samples, counts, table.reciprocity()).map_err(|e| e.in_file(path))
}

/// A neural BRDF, tabulated.
fn neural(path: &Path) -> Result<TabulatedBrdf> {
    nbrdf::read_nbrdf(path)?.table().map_err(|e| e.in_file(path))
}
