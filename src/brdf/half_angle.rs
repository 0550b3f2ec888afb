//! Reader of the half-angle tables of car paints by Guenther, Chen, Goesele, Wald & Seidel 2005 (Efficient acquisition and
//! realistic rendering of car paint; the data are for research only).
//!
//! Known from the authors' description: 84 bytes of header, then f32 red, green, blue; phi_d (180 bins) outermost, theta_h (90),
//! theta_d (90) innermost; -1 is invalid; raw values, neither normalized nor color-calibrated. Inferred: little-endian; equal bins;
//! phi_d over half a turn, the rest by reciprocity; values for the middles of the bins.

use super::half_difference_table::{CELLS, THETA, measurement};
use super::measured::open;
use super::measurement::Measurement;
use crate::error::{Error, Result};
use std::f64::consts::FRAC_PI_2;
use std::io::{BufReader, Read};
use std::path::Path;

const HEADER: u64 = 84;
/// Length of a file.
pub(super) const BYTES: u64 = HEADER + 12 * CELLS as u64;

/// Reads a half-angle table; invalid cells are left out and counted, phi_d is thinned.
///
/// # Errors
/// A file that cannot be read, another length, no valid cell.
pub fn read_half_angle(path: &Path) -> Result<Measurement> {
    let (file, length) = open(path)?;
    if length != BYTES {
        let legal = format!("{BYTES} bytes");
        return Err(
            Error::invalid("half-angle table", "length", format!("{length} bytes"), legal).in_file(path)
        );
    }
    let mut reader = BufReader::new(file);
    let mut values = Vec::with_capacity(3 * CELLS);
    reader.read_exact(&mut [0; HEADER as usize]).map_err(|e| Error::io(path, e))?;
    let mut bytes = [0; 4];
    for _ in 0..3 * CELLS {
        reader.read_exact(&mut bytes).map_err(|e| Error::io(path, e))?;
        values.push(f32::from_le_bytes(bytes));
    }
    let value = |h: usize, d: usize, p: usize| {
        let cell = d + THETA * (h + THETA * p);
        let rgb = [0, 1, 2].map(|c| f64::from(values[3 * cell + c]));
        rgb.iter().all(|c| *c >= 0.0).then_some(rgb)
    };
    measurement(|position| FRAC_PI_2 * position / THETA as f64, value).map_err(|e| e.in_file(path))
}
