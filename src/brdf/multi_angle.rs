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
//! columns `incidence` and `aspecular`, degrees; angles as in [`super::instrument`]. A column `weight` is what a row counts (1), a
//! column `name` is for people. Columns are separated by commas, tabs or semicolons; with semicolons or tabs a comma in a number is
//! its decimal point. The BRDF is the reflectance factor over pi.

use super::instrument::Reading;
use super::measurement::{Counts, Measurement};
use super::sample_set::{Bands, BrdfSample, SampleSet};
use crate::color::rgb_from_lab;
use crate::error::{Error, Result};
use crate::file::read_text;
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

/// Largest file, bytes.
const MAX_BYTES: u64 = 1 << 24;
/// Most columns.
const MAX_COLUMNS: usize = 2048;
/// Most rows.
const MAX_ROWS: usize = 1 << 16;
/// Largest reflectance factor: no measurement is near.
const MAX_FACTOR: f64 = 1e9;

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
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines =
        (1..).zip(text.lines()).map(|(number, line)| (number, line.split('#').next().unwrap_or_default()));
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let legal = "a header: geometry, then wavelengths, or L*, a*, b*, or R, G, B";
    let (number, header) = lines.next().ok_or_else(|| Error::invalid("", "text", "nothing", legal))?;
    let header = Header::parse(header).map_err(|e| e.within(format!("line {number}")))?;
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

/// What the columns are.
struct Header {
    separator: char,
    columns: Vec<Column>,
    values: Values,
}

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    Geometry,
    Incidence,
    Aspecular,
    Weight,
    Name,
    Wavelength(f64),
    /// L*, a*, b*: 0 to 2.
    Lab(usize),
    /// Red, green, blue: 0 to 2.
    Rgb(usize),
}

/// What the values are.
enum Values {
    Lab,
    Rgb,
    /// Wavelengths, ascending.
    Spectral(Vec<f64>),
}

impl Column {
    fn parse(name: &str) -> Result<Self> {
        let bare = name.trim().trim_matches('"').trim().to_ascii_lowercase();
        Ok(match bare.as_str() {
            "geometry" => Self::Geometry,
            "incidence" => Self::Incidence,
            "aspecular" => Self::Aspecular,
            "weight" => Self::Weight,
            "name" => Self::Name,
            "l*" | "l" => Self::Lab(0),
            "a*" | "a" => Self::Lab(1),
            "b*" => Self::Lab(2),
            "r" => Self::Rgb(0),
            "g" => Self::Rgb(1),
            // Of Lab or of RGB: the other columns tell.
            "b" => Self::Rgb(2),
            _ => {
                let nm = bare.strip_suffix("nm").unwrap_or(&bare).trim();
                let legal = "geometry, incidence, aspecular, weight, name, a wavelength of 100 to 10000 nm, L*, a*, b*, R, G or B";
                let is_wavelength = |nm: &f64| (100.0..=10_000.0).contains(nm);
                let nm = nm.parse().ok().filter(is_wavelength);
                Self::Wavelength(nm.ok_or_else(|| Error::invalid("", "column", format!("{name:?}"), legal))?)
            }
        })
    }
}

impl Header {
    fn parse(line: &str) -> Result<Self> {
        let separator = ['\t', ';'].into_iter().find(|c| line.contains(*c)).unwrap_or(',');
        let names: Vec<&str> = line.split(separator).collect();
        if names.len() > MAX_COLUMNS {
            return Err(Error::invalid("", "columns", names.len(), format!("up to {MAX_COLUMNS}")));
        }
        let place = |k: usize| format!("column {}", k + 1);
        let mut columns = (names.iter().enumerate())
            .map(|(k, name)| Column::parse(name).map_err(|e| e.within(place(k))))
            .collect::<Result<Vec<_>>>()?;
        if columns.contains(&Column::Lab(0)) {
            columns.iter_mut().filter(|c| **c == Column::Rgb(2)).for_each(|c| *c = Column::Lab(2));
        }
        if let Some(k) = (1..columns.len()).find(|k| columns[..*k].contains(&columns[*k])) {
            return Err(Error::invalid(
                place(k),
                "column",
                format!("{:?} twice", names[k].trim()),
                "each once",
            ));
        }
        let has = |column: &Column| columns.contains(column);
        let is_pair = has(&Column::Incidence) && has(&Column::Aspecular);
        let is_any = has(&Column::Incidence) || has(&Column::Aspecular);
        if has(&Column::Geometry) == is_any || is_any != is_pair {
            let legal = "either a column geometry or columns incidence and aspecular";
            return Err(Error::invalid("", "columns of directions", format!("{:?}", line.trim()), legal));
        }
        let values = Values::of(&columns)?;
        Ok(Self { separator, columns, values })
    }

    fn bands(&self) -> Bands {
        match &self.values {
            Values::Lab | Values::Rgb => Bands::Rgb,
            Values::Spectral(nm) => Bands::Wavelengths(nm.clone()),
        }
    }

    /// Sample and BRDF values of a line.
    fn row(&self, line: &str) -> Result<(BrdfSample, Vec<f64>)> {
        let cells: Vec<&str> =
            line.split(self.separator).map(|c| c.trim().trim_matches('"').trim()).collect();
        if cells.len() != self.columns.len() {
            let legal = format!("{} (the header)", self.columns.len());
            return Err(Error::invalid("", "columns", cells.len(), legal));
        }
        let at = |k: usize| move |e: Error| e.within(format!("column {}", k + 1));
        let (mut incidence, mut aspecular, mut weight) = (0.0, 0.0, 1.0);
        let mut values = Vec::new();
        let mut directions_at = 0;
        for (k, (column, cell)) in self.columns.iter().zip(&cells).enumerate() {
            match column {
                Column::Geometry => {
                    ((incidence, aspecular), directions_at) = (self.geometry(cell).map_err(at(k))?, k)
                }
                Column::Incidence => incidence = self.number(cell).map_err(at(k))?,
                Column::Aspecular => (aspecular, directions_at) = (self.number(cell).map_err(at(k))?, k),
                Column::Weight => weight = self.number(cell).map_err(at(k))?,
                Column::Name => (),
                Column::Wavelength(nm) => values.push((*nm, self.factor(cell).map_err(at(k))?)),
                Column::Rgb(c) => values.push((*c as f64, self.factor(cell).map_err(at(k))?)),
                Column::Lab(c) => values.push((*c as f64, self.number(cell).map_err(at(k))?)),
            }
        }
        let (wi, wo) = Reading::new(incidence, aspecular).map_err(at(directions_at))?.directions();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let values: Vec<f64> = values.into_iter().map(|v| v.1).collect();
        let factors = match self.values {
            Values::Lab => rgb_from_lab(DVec3::new(values[0], values[1], values[2])).to_array().to_vec(),
            _ => values,
        };
        Ok((BrdfSample::new(wi, wo, weight), factors.into_iter().map(|r| r / PI).collect()))
    }

    /// Incidence and aspecular angle of `45as15` or `45:15`.
    fn geometry(&self, cell: &str) -> Result<(f64, f64)> {
        let bare = cell.to_ascii_lowercase();
        let (incidence, aspecular) =
            bare.split_once("as").or_else(|| bare.split_once(':')).ok_or_else(|| {
                Error::invalid(
                    "",
                    "geometry",
                    format!("{cell:?}"),
                    "incidence and aspecular angle, as in 45as15",
                )
            })?;
        Ok((self.number(incidence)?, self.number(aspecular)?))
    }

    /// A reflectance factor, also in percent.
    fn factor(&self, cell: &str) -> Result<f64> {
        let factor = match cell.strip_suffix('%') {
            Some(percent) => self.number(percent)? / 100.0,
            None => self.number(cell)?,
        };
        if factor.abs() > MAX_FACTOR {
            return Err(Error::invalid("", "reflectance factor", factor, "within +-1e9"));
        }
        Ok(factor)
    }

    fn number(&self, cell: &str) -> Result<f64> {
        let text = if self.separator == ',' { cell.to_owned() } else { cell.replace(',', ".") };
        let number = text.trim().parse().ok().filter(|x: &f64| x.abs() <= 1e12);
        number.ok_or_else(|| Error::invalid("", "number", format!("{cell:?}"), "a decimal number"))
    }
}

impl Values {
    fn of(columns: &[Column]) -> Result<Self> {
        let count = |is: &dyn Fn(&Column) -> bool| columns.iter().filter(|c| is(c)).count();
        let lab = count(&|c| matches!(c, Column::Lab(_)));
        let rgb = count(&|c| matches!(c, Column::Rgb(_)));
        let mut nm: Vec<f64> = columns
            .iter()
            .filter_map(|c| if let Column::Wavelength(nm) = c { Some(*nm) } else { None })
            .collect();
        match (lab, rgb, nm.len()) {
            (3, 0, 0) => Ok(Self::Lab),
            (0, 3, 0) => Ok(Self::Rgb),
            (0, 0, 1..) => {
                nm.sort_by(f64::total_cmp);
                Ok(Self::Spectral(nm))
            }
            _ => {
                let found = format!("{lab} of L*, a*, b*, {rgb} of R, G, B, {} wavelengths", nm.len());
                let legal = "all of one kind: wavelengths, or L*, a*, b*, or R, G, B";
                Err(Error::invalid("", "columns of values", found, legal))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }

    #[test]
    fn bad_tables_are_refused_with_line_and_column() {
        for (text, words) in [
            ("", "text: found nothing"),
            ("geometry,400\n", "usable samples"),
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
