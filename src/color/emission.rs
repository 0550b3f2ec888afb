//! Spectra of lamps, as text.

use super::spectrum::{Illuminant, Spectrum};
use super::wavelengths::Wavelengths;
use crate::error::{Error, Result};
use crate::file::read_text;
use std::path::Path;

/// Largest file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Most lines of a table.
const MAX_LINES: usize = 10_000;

impl Illuminant {
    /// The illuminant of this name, letter case aside.
    ///
    /// # Errors
    /// There is none.
    pub fn named(name: &str) -> Result<Self> {
        match name.to_ascii_lowercase().as_str() {
            "d65" => Ok(Self::D65),
            "a" => Ok(Self::A),
            _ => Err(Error::invalid("illuminant", "name", format!("{name:?}"), "D65 or A")),
        }
    }
}

/// Reads a measured emission.
///
/// # Errors
/// Those of the file system and of [`parse_emission`].
pub fn read_emission(path: &Path) -> Result<Spectrum> {
    parse_emission(&read_text(path, MAX_BYTES)?).map_err(|e| e.in_file(path))
}

/// A measured emission: a line a wavelength, nanometres and power in any unit, separated by comma, semicolon or white space;
/// `#` begins a comment, and a first line of words is a header.
///
/// # Errors
/// Other lines; wavelengths that [`Wavelengths::new`] refuses or that do not cover 400 to 700 nm; power below 0; darkness.
pub fn parse_emission(text: &str) -> Result<Spectrum> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines =
        (1..).zip(text.lines()).map(|(k, line)| (k, line.split('#').next().unwrap_or_default().trim()));
    let lines: Vec<(usize, &str)> = lines.filter(|(_, line)| !line.is_empty()).take(MAX_LINES + 1).collect();
    if lines.len() > MAX_LINES {
        return Err(Error::invalid("", "lines", format!("over {MAX_LINES}"), format!("up to {MAX_LINES}")));
    }
    let is_header = lines.first().is_some_and(|(_, line)| line.starts_with(|c: char| c.is_alphabetic()));
    let rows = lines
        .iter()
        .skip(usize::from(is_header))
        .map(|(k, line)| row(line).map_err(|e| e.within(format!("line {k}"))));
    let rows = rows.collect::<Result<Vec<[f64; 2]>>>()?;
    let wavelengths = Wavelengths::new(rows.iter().map(|row| row[0]).collect())?;
    let (first, last) = (rows[0][0], rows[rows.len() - 1][0]);
    if first > 400.0 || last < 700.0 {
        return Err(Error::invalid(
            "",
            "wavelengths",
            format!("{first} to {last}"),
            "some that cover 400 to 700 nm",
        ));
    }
    let power: Vec<f64> = rows.iter().map(|row| row[1]).collect();
    let spectrum = wavelengths.spectrum_of_means(&power);
    if !spectrum.0.iter().any(|power| *power > 0.0) {
        return Err(Error::invalid("", "power", "0 everywhere", "above 0 between 380 and 780 nm"));
    }
    Ok(spectrum)
}

fn row(line: &str) -> Result<[f64; 2]> {
    let numbers = line.split([',', ';', ' ', '\t']).filter(|cell| !cell.is_empty()).map(str::parse::<f64>);
    let numbers: Vec<f64> = numbers.collect::<std::result::Result<_, _>>().unwrap_or_default();
    match numbers[..] {
        [nm, power] if power >= 0.0 && power.is_finite() => Ok([nm, power]),
        [_, power] => Err(Error::invalid("", "power", power, "0 or more")),
        _ => Err(Error::invalid("", "line", format!("{line:?}"), "a wavelength in nanometres and a power")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_however_they_are_separated() {
        let d65 = Illuminant::D65.spectrum();
        for separator in [",", ";", "\t", " , "] {
            let line = |(k, power): (usize, &f64)| format!("{}{separator}{power}\n", 380 + 10 * k);
            let text: String = d65.0.iter().enumerate().map(line).collect();
            let found = parse_emission(&format!("# lamp\nnm{separator}power\n{text}")).unwrap();
            let off = found.0.iter().zip(&d65.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{off}");
        }
    }

    #[test]
    fn bad_tables_are_named() {
        for (text, words) in [
            ("", "wavelengths: found 0"),
            ("nm,power\n", "wavelengths: found 0"),
            ("400 1\n700", "line 2: line: found \"700\""),
            ("400 1\nx 1", "line 2"),
            ("400 1\n700 -1", "line 2: power: found -1, expected 0 or more"),
            ("400 1\n700 nan", "power: found NaN"),
            ("700 1\n400 1", "700 before 400"),
            ("0.4 1\n0.7 1", "in micrometres?"),
            ("450 1\n700 1", "450 to 700, expected some that cover"),
            ("300 0\n500 0\n900 0", "0 everywhere"),
        ] {
            let message = parse_emission(text).unwrap_err().to_string();
            assert!(message.contains(words), "{text:?}: {message}");
        }
        assert!(Illuminant::named("d65").is_ok() && Illuminant::named("F11").is_err());
    }
}
