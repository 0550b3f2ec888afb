//! Reader of the MERL BRDF database (`.binary`; Matusik, Pfister, Brand & McMillan 2003).
//!
//! Three i32 (90, 90, 180), then little-endian f64, all of red, of green, of blue; index `phi_d + 180 (theta_d + 90 theta_h)`,
//! phi_d over half a turn (the other half is the same by reciprocity), theta_d in equal cells, theta_h finer towards 0: position
//! `90 sqrt(theta_h / 90 degrees)`. Values times 1/1500, 1.15/1500 and 1.66/1500 are the BRDF, linear RGB, 1/sr; below 0: invalid.
//!
//! The look-up published with the database rounds positions down, so value k stands for positions k to k + 1: its sample is put
//! at k + 1/2, and not at the edge k, from which it would be half a degree off in theta_d and phi_d.

use super::half_difference_table::{CELLS, PHI, THETA, measurement};
use super::measured::open;
use super::measurement::Measurement;
use crate::error::{Error, Result};
use crate::file::read_text;
use sha2::{Digest, Sha256};
use std::f64::consts::FRAC_PI_2;
use std::io::{BufReader, Read};
use std::path::Path;

/// Length of a file.
pub(super) const BYTES: u64 = 12 + 3 * 8 * CELLS as u64;
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Largest list of hashes, bytes.
const MAX_LIST: u64 = 1 << 20;

/// Reads a file of the MERL database; invalid cells are left out and counted, phi_d is thinned.
///
/// # Errors
/// A file that cannot be read, another length or other dimensions, no valid cell.
pub fn read_merl(path: &Path) -> Result<Measurement> {
    let (file, length) = open(path)?;
    let refuse =
        |what: &str, found: String, legal: String| Error::invalid("MERL", what, found, legal).in_file(path);
    if length != BYTES {
        return Err(refuse("length", format!("{length} bytes"), format!("{BYTES} bytes")));
    }
    let mut reader = BufReader::new(file);
    let mut bytes = [0; 12];
    reader.read_exact(&mut bytes).map_err(|e| Error::io(path, e))?;
    let dimensions: Vec<i32> = bytes.as_chunks().0.iter().map(|word| i32::from_le_bytes(*word)).collect();
    if dimensions != [THETA as i32, THETA as i32, PHI as i32] {
        return Err(refuse("dimensions", format!("{dimensions:?}"), "90, 90, 180".into()));
    }
    let mut values = Vec::with_capacity(3 * CELLS);
    let mut bytes = [0; 8];
    for _ in 0..3 * CELLS {
        reader.read_exact(&mut bytes).map_err(|e| Error::io(path, e))?;
        values.push(f64::from_le_bytes(bytes));
    }
    let value = |h: usize, d: usize, p: usize| {
        let cell = p + PHI * (d + THETA * h);
        let rgb = [0, 1, 2].map(|c| values[c * CELLS + cell] * SCALES[c]);
        rgb.iter().all(|c| *c >= 0.0).then_some(rgb)
    };
    measurement(theta_h, value).map_err(|e| e.in_file(path))
}

/// Half-vector angle at a position of 0 to 90.
fn theta_h(position: f64) -> f64 {
    FRAC_PI_2 * (position / THETA as f64).powi(2)
}

/// The name under which a list has the file's SHA-256 and length; lines of the list: `hash length name`.
///
/// # Errors
/// A file that cannot be read, a line that is none, a file that is not in the list.
pub fn known_merl(path: &Path, list: &Path) -> Result<String> {
    let text = read_text(list, MAX_LIST)?;
    let (mut file, length) = open(path)?;
    let mut hasher = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        let length = file.read(&mut block).map_err(|e| Error::io(path, e))?;
        if length == 0 {
            break;
        }
        hasher.update(&block[..length]);
    }
    let hash: String = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    for (number, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [known, bytes, name] = words[..] else {
            let place = format!("{}: line {number}", list.display());
            return Err(Error::invalid(place, "entry", format!("{line:?}"), "SHA-256, length and name"));
        };
        if known.eq_ignore_ascii_case(&hash) && bytes == length.to_string() {
            return Ok(name.to_owned());
        }
    }
    Err(Error::invalid(path.display().to_string(), "SHA-256", hash, format!("one of {}", list.display())))
}
