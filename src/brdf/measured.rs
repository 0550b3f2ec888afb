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

/// A measurement in the form that suits it: a table keeps its cells, of which a fit tells filled ones by their neighbors.
#[derive(Debug, Clone, PartialEq)]
pub enum Measured {
    /// A table over both directions.
    Table(TabulatedBrdf),
    /// Anything else.
    Scattered(Measurement),
}

impl Measured {
    /// Reads a measured BRDF of any format of [`read_samples`].
    ///
    /// # Errors
    /// Those of [`read_samples`].
    pub fn read(path: &Path) -> Result<Self> {
        match format(path)? {
            Format::Table => table(path).map(Self::Table),
            scattered => scattered.read(path).map(Self::Scattered),
        }
    }

    /// What the user should know, a sentence each; none if all is well.
    pub fn warnings(&self) -> Vec<String> {
        let table = match self {
            Self::Table(table) => table,
            Self::Scattered(measurement) => return measurement.warnings(),
        };
        let cells = table.values();
        let count = |is: fn(&[f32; 3]) -> bool| cells.iter().filter(|cell| is(cell)).count();
        let negative = count(|cell| cell.iter().any(|band| *band < 0.0));
        let zero = count(|cell| *cell == [0.0; 3]);
        let counts = Counts { found: cells.len(), negative, zero, ..Counts::default() };
        counts.warnings(cells.len(), table.reciprocity())
    }
}

/// Which reader a file is for.
#[derive(Clone, Copy)]
enum Format {
    Rgl,
    Merl,
    HalfAngle,
    MultiAngle,
    Table,
}

/// The format of a file, by its first bytes, else by length and extension.
fn format(path: &Path) -> Result<Format> {
    let (file, length) = open(path)?;
    let mut head = Vec::new();
    file.take(rgl::MAGIC.len() as u64).read_to_end(&mut head).map_err(|e| Error::io(path, e))?;
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    Ok(match (extension.as_deref(), length) {
        _ if head == rgl::MAGIC => Format::Rgl,
        (Some("bsdf"), _) => Format::Rgl,
        (Some("binary"), _) | (_, merl::BYTES) => Format::Merl,
        (_, half_angle::BYTES) => Format::HalfAngle,
        (Some("csv" | "tsv" | "txt"), _) => Format::MultiAngle,
        _ => Format::Table,
    })
}

impl Format {
    fn read(self, path: &Path) -> Result<Measurement> {
        match self {
            Self::Rgl => rgl::read_rgl(path),
            Self::Merl => merl::read_merl(path),
            Self::HalfAngle => half_angle::read_half_angle(path),
            Self::MultiAngle => multi_angle::read_multi_angle(path),
            Self::Table => tabulated(path),
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
    format(path)?.read(path)
}

/// A table; what is none may be any other format.
fn table(path: &Path) -> Result<TabulatedBrdf> {
    read_measured(path).map_err(|e| match e {
        Error::Invalid(fault) if fault.what == "format" => {
            Error::invalid(fault.place, fault.what, fault.found, format!("{}, {SAMPLE_FORMATS}", fault.legal))
        }
        other => other,
    })
}

/// The samples of a table, its cells.
fn tabulated(path: &Path) -> Result<Measurement> {
    let table = table(path)?;
    let samples = SampleSet::from(&table);
    let counts = Counts { found: samples.len(), ..Counts::default() };
    Measurement::new(samples, counts, table.reciprocity()).map_err(|e| e.in_file(path))
}

/// A neural BRDF, tabulated.
fn neural(path: &Path) -> Result<TabulatedBrdf> {
    nbrdf::read_nbrdf(path)?.table().map_err(|e| e.in_file(path))
}
