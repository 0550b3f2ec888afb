//! Reader of multi-angle instruments' readings as a table of text (`.csv`, `.tsv`, `.txt`).
//!
//! ```text
//! # silver, BYK-mac style            comments and empty lines anywhere
//! geometry, 400, 410, ... 700        wavelengths in nm (also `400nm`): spectral reflectance factors,
//! 45as-15,  0.81, 0.82, ...          1 = perfect diffuser; a cell may be in percent: `81 %`
//! 45as15,   2.31, 2.33, ...
//! ```
//!
//! In place of wavelengths the columns may be `L*, a*, b*` (or `L, a, b`; D65, 2 degree observer, not converted from others) or
//! `R, G, B` (linear Rec.709 reflectance factors), in any order. In place of `geometry` (`45as15` or `45:15`) there may be two
//! columns `incidence` and `aspecular`, degrees, angles as in [`super::instrument`]; or two columns `theta_i` and `theta_o`, degrees from
//! the normal in the plane of incidence, theta_o positive on the mirror side: aspecular = theta_i - theta_o. A column `weight` is what a row counts (1),
//! a column `name` is for people. Columns are separated by commas, tabs or semicolons; with semicolons or tabs a comma in a number is
//! its decimal point. The BRDF is the reflectance factor over pi.

use super::measurement::{Counts, Measurement};
use super::multi_angle_header::Header;
use super::sample_set::SampleSet;
use crate::error::{Error, Result};
use crate::file::read_text;
use std::path::Path;

/// Largest file, bytes.
const MAX_BYTES: u64 = 1 << 24;
/// Most rows.
pub(super) const MAX_ROWS: usize = 1 << 16;

/// Reads the readings of a multi-angle instrument.
///
/// # Errors
/// A file that cannot be read; with line and column: a header that says neither geometry nor values, or says them twice, a row of
/// another length, what is no number, a direction not above the horizon; no row.
pub fn read_multi_angle(path: &Path) -> Result<Measurement> {
    parse(&read_text(path, MAX_BYTES)?).map_err(|e| e.in_file(path))
}

/// The readings of a text.
///
/// # Errors
/// As [`read_multi_angle`].
pub fn parse(text: &str) -> Result<Measurement> {
    parse_if(text, |_| Ok(()))
}

/// [`read_multi_angle`] for spectra whose wavelengths ascend from column to column.
///
/// # Errors
/// As [`read_multi_angle`]; colors, wavelengths out of order.
pub(super) fn read_ascending(path: &Path) -> Result<Measurement> {
    parse_if(&read_text(path, MAX_BYTES)?, Header::require_ascending).map_err(|e| e.in_file(path))
}

/// The readings of a text whose header is as wished.
fn parse_if(text: &str, check: impl Fn(&Header) -> Result<()>) -> Result<Measurement> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines =
        (1..).zip(text.lines()).map(|(number, line)| (number, line.split('#').next().unwrap_or_default()));
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let legal = "a header: geometry, then wavelengths, or L*, a*, b*, or R, G, B";
    let (number, header) = lines.next().ok_or_else(|| Error::invalid("", "text", "nothing", legal))?;
    let in_line = |e: Error| e.within(format!("line {number}"));
    let header = Header::parse(header).map_err(in_line)?;
    check(&header).map_err(in_line)?;
    let mut samples = SampleSet::new(header.bands())?;
    let mut rows = 0;
    for (number, line) in lines {
        rows += 1;
        if rows > MAX_ROWS {
            return Err(Error::invalid("", "rows", format!("over {MAX_ROWS}"), format!("up to {MAX_ROWS}")));
        }
        let (sample, values) = header.row(line).map_err(|e| e.within(format!("line {number}")))?;
        samples.push(sample, &values).map_err(|e| e.within(format!("line {number}")))?;
    }
    let reciprocity = samples.reciprocity();
    Measurement::new(samples, Counts { found: rows, ..Counts::default() }, reciprocity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::Bands;
    use crate::brdf::instrument::Reading;
    use crate::color::rgb_from_lab;
    use glam::DVec3;
    use std::f64::consts::PI;

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn spectra_are_read_in_any_order_of_columns() {
        let text = "\u{feff}# of a panel\n\n410nm, Geometry ,400,name\n50 %, 45as15, 1.5,a # near the mirror\n0.2,45:110,0.1,b\r\n";
        let read = parse(text).unwrap();
        let set = &read.samples;
        assert_eq!(set.bands(), &Bands::Wavelengths(vec![400.0, 410.0]));
        assert_eq!(set.values(0), [1.5 / PI, 0.5 / PI]);
        assert_eq!(set.values(1), [0.1 / PI, 0.2 / PI]);
        let reading = Reading { incidence_deg: 45.0, aspecular_deg: 110.0 };
        assert_eq!((set.samples()[1].wi, set.samples()[1].wo), reading.directions());
        assert_eq!((read.counts.found, read.warnings()), (2, vec![]));
    }

    #[test]
    fn lab_and_rgb_are_told_apart_and_decimal_commas_read() {
        let lab = parse("geometry;L*;a*;b*;weight\n45as45;50,5;1,25;-3;2\n").unwrap().samples;
        let expected = rgb_from_lab(DVec3::new(50.5, 1.25, -3.0)) / PI;
        assert_eq!((lab.values(0), lab.samples()[0].weight), (&expected.to_array()[..], 2.0));
        let short = parse("incidence\taspecular\tb\ta\tL\n45\t45\t-3\t1.25\t50.5\n").unwrap().samples;
        assert_eq!(short.values(0), lab.values(0));
        let rgb = parse("incidence,aspecular,B,G,R\n15,-15,30%,0.2,0.1\n").unwrap().samples;
        assert_eq!(rgb.values(0), [0.1 / PI, 0.2 / PI, 0.3 / PI]);
        assert!((rgb.samples()[0].wo.z - 30f64.to_radians().cos()).abs() < 1e-15);
        let signed = parse("theta_o,theta_i,R,G,B\n30,15,0.1,0.2,0.3\n").unwrap().samples;
        assert_eq!((signed.samples(), signed.values(0)), (rgb.samples(), rgb.values(0)));
    }

    #[test]
    fn bad_tables_are_refused_with_line_and_column() {
        for (text, words) in [
            ("", "text: found nothing"),
            ("geometry,400\n", "usable samples"),
            (
                "geometry,0.38 um\n",
                "line 1: column 2: wavelength: found \"0.38 um\", micrometres, expected nanometres, as 380",
            ),
            ("theta_i,400\n", "columns of directions"),
            ("theta_i,theta_o,incidence,aspecular,400\n", "columns of directions"),
            ("theta_i,theta_o,400\n20,90,1\n", "line 2: column 2: theta_o"),
            ("geometry,foo\n", "line 1: column 2: column: found \"foo\""),
            ("geometry,50\n", "line 1: column 2"),
            ("geometry,400,400nm\n", "line 1: column 3: column: found \"400nm\" twice"),
            ("400,410\n", "columns of directions"),
            ("geometry,incidence,400\n", "columns of directions"),
            ("incidence,400\n", "columns of directions"),
            ("geometry\n", "columns of values"),
            ("geometry,L*,a*\n", "columns of values: found 2 of L*"),
            ("geometry,400,R,G,B\n", "columns of values"),
            ("# c\ngeometry,400\n45as15\n", "line 3: columns: found 1, expected 2"),
            ("geometry,400\n45as15,x\n", "line 2: column 2: number: found \"x\""),
            ("geometry,400\n45as15,\n", "line 2: column 2: number: found \"\""),
            ("geometry,400\n45as15,nan\n", "line 2: column 2: number"),
            ("geometry,400\n45as15,1e300\n", "line 2: column 2: number"),
            ("geometry,400\n45as15,1e11\n", "line 2: column 2: reflectance factor"),
            ("geometry,400\n45,0.5\n", "line 2: column 1: geometry: found \"45\""),
            ("geometry,400\n45as-45,0.5\n", "line 2: column 1: aspecular"),
            ("geometry,400\n95as15,0.5\n", "line 2: column 1: incidence"),
            ("geometry,400,weight\n45as15,0.5,-1\n", "line 2: sample 0: weight"),
        ] {
            assert!(message(text).contains(words), "{text:?}: {}", message(text));
        }
    }

    #[test]
    fn every_truncation_is_read_or_refused() {
        let text = "geometry;L*;a*;b*\n45as15;90,5;1;-3\n45as110;20;1e3;0 # end\n";
        for length in 0..text.len() {
            let _ = parse(&text[..length]);
        }
    }
}
