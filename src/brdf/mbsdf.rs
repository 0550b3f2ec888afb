//! Reader and writer of NVIDIA's measured-BSDF tables (`.mbsdf`, reflection part).
//!
//! Two lines of text, three u32 (type 0 scalar or 1 RGB, polar cells, azimuthal cells), then little-endian f32 in the
//! order and with the meaning of [`TabulatedBrdf`]: 1/sr, no cosine, last azimuth the mirror side.

use super::TabulatedBrdf;
use super::measured::open;
use crate::error::{Error, Result};
use std::io::{BufReader, Read};
use std::path::Path;

/// First line of the file.
pub(super) const MAGIC: &[u8] = b"NVIDIA ARC MBSDF V1\n";
/// Second line: which data follow.
const SECTION: &[u8] = b"MBSDF_DATA_REFLECTION=\n";
/// Bytes before the values.
const HEADER: usize = MAGIC.len() + SECTION.len() + 12;

impl TabulatedBrdf {
    /// Reads an mbsdf table; a scalar one gets three equal channels.
    ///
    /// # Errors
    /// A file that cannot be read, another format, a resolution outside 2-720, a length that does not fit the resolution
    /// (checked before anything is allocated), a value that is not finite (its cell named).
    pub fn read_mbsdf(path: &Path) -> Result<Self> {
        let (file, length) = open(path)?;
        parse(BufReader::new(file), length).map_err(|fault| match fault {
            ReadFault::Io(e) => Error::io(path, e),
            ReadFault::Content(e) => e.in_file(path),
        })
    }
}

#[cfg(feature = "files")]
impl TabulatedBrdf {
    /// Writes an mbsdf table of three channels, whole or not at all; reading it gives the same bits.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write_mbsdf(&self, path: &Path) -> Result<()> {
        crate::file::write_atomically(path, |w| self.write_to(w).map_err(|e| Error::io(path, e)))
    }

    fn write_to(&self, w: &mut impl std::io::Write) -> std::io::Result<()> {
        w.write_all(MAGIC)?;
        w.write_all(SECTION)?;
        let [theta, phi] = self.resolution();
        for word in [1, theta as u32, phi as u32] {
            w.write_all(&word.to_le_bytes())?;
        }
        self.values().as_flattened().iter().try_for_each(|value| w.write_all(&value.to_le_bytes()))
    }
}

/// What can go wrong while reading: the system's refusal needs the path, the rest its place.
enum ReadFault {
    Io(std::io::Error),
    Content(Error),
}

impl From<std::io::Error> for ReadFault {
    fn from(e: std::io::Error) -> Self {
        Self::Io(e)
    }
}

impl From<Error> for ReadFault {
    fn from(e: Error) -> Self {
        Self::Content(e)
    }
}

fn parse(mut reader: impl Read, length: u64) -> std::result::Result<TabulatedBrdf, ReadFault> {
    if length < HEADER as u64 {
        return Err(Error::invalid("mbsdf", "length", length, format!("at least {HEADER} bytes")).into());
    }
    let mut header = [0; HEADER];
    reader.read_exact(&mut header)?;
    for (name, expected, at) in [("first line", MAGIC, 0), ("second line", SECTION, MAGIC.len())] {
        let found = &header[at..at + expected.len()];
        if found != expected {
            let found = format!("{:?}", String::from_utf8_lossy(found));
            let legal = format!("{:?}", String::from_utf8_lossy(expected));
            return Err(Error::invalid("mbsdf", name, found, legal).into());
        }
    }
    let word = |k: usize| {
        let at = HEADER - 12 + 4 * k;
        u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
    };
    let channels: usize = match word(0) {
        0 => 1,
        1 => 3,
        other => return Err(Error::invalid("mbsdf", "type", other, "0 (scalar) or 1 (RGB)").into()),
    };
    let (theta, phi) = (word(1) as usize, word(2) as usize);
    if [theta, phi].iter().any(|n| !(2..=TabulatedBrdf::MAX_RESOLUTION).contains(n)) {
        let found = format!("{theta} x {phi}");
        return Err(Error::invalid("mbsdf", "resolution", found, "sides of 2 to 720").into());
    }
    let cells = theta * theta * phi;
    let expected = (HEADER + cells * channels * 4) as u64;
    if length != expected {
        let legal = format!("{expected} bytes for {theta} x {theta} x {phi} cells of {channels} values");
        return Err(Error::invalid("mbsdf", "length", format!("{length} bytes"), legal).into());
    }
    let mut values = Vec::with_capacity(cells);
    let mut cell = [0; 12];
    for _ in 0..cells {
        let bytes = &mut cell[..4 * channels];
        reader.read_exact(bytes)?;
        let value = |k: usize| f32::from_le_bytes([bytes[k], bytes[k + 1], bytes[k + 2], bytes[k + 3]]);
        values.push(if channels == 1 { [value(0); 3] } else { [value(0), value(4), value(8)] });
    }
    Ok(TabulatedBrdf::new(theta, phi, values)?)
}
