//! One entry to every kind of measured table.

use super::TabulatedBrdf;
use super::{mbsdf, nbrdf};
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

/// A neural BRDF, tabulated.
fn neural(path: &Path) -> Result<TabulatedBrdf> {
    nbrdf::read_nbrdf(path)?.table().map_err(|e| e.in_file(path))
}
