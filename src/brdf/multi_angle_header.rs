//! The columns of a table of multi-angle readings ([`super::multi_angle`]), and its rows by them.

use super::instrument::Reading;
use super::sample_set::{Bands, BrdfSample};
use crate::color::rgb_from_lab;
use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

/// Most columns.
const MAX_COLUMNS: usize = 2048;
/// Largest reflectance factor: no measurement is near.
const MAX_FACTOR: f64 = 1e9;

/// What the columns are.
pub(super) struct Header {
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
    ThetaI,
    ThetaO,
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
            "theta_i" => Self::ThetaI,
            "theta_o" => Self::ThetaO,
            "weight" => Self::Weight,
            "name" => Self::Name,
            "l*" | "l" => Self::Lab(0),
            "a*" | "a" => Self::Lab(1),
            "b*" => Self::Lab(2),
            "r" => Self::Rgb(0),
            "g" => Self::Rgb(1),
            // Of Lab or of RGB: the other columns tell.
            "b" => Self::Rgb(2),
            _ => Self::Wavelength(wavelength(name, &bare)?),
        })
    }
}

/// The wavelength that a column is named after, nanometres; `bare` is the name in lower case.
fn wavelength(name: &str, bare: &str) -> Result<f64> {
    let micrometres = ["um", "\u{b5}m", "\u{3bc}m"].into_iter().find_map(|unit| bare.strip_suffix(unit));
    let number = micrometres.or_else(|| bare.strip_suffix("nm")).unwrap_or(bare).trim().parse::<f64>().ok();
    match number {
        Some(nm) if micrometres.is_none() && (100.0..=10_000.0).contains(&nm) => Ok(nm),
        // No instrument sees 0.1 to 10 nm.
        Some(um) if (0.1..=10.0).contains(&um) => {
            let legal = format!("nanometres, as {} for {um} um", (um * 1e6).round() / 1e3);
            Err(Error::invalid("", "wavelength", format!("{name:?}, micrometres"), legal))
        }
        _ => {
            let legal = "geometry, incidence, aspecular, theta_i, theta_o, weight, name, a wavelength of 100 to 10000 nm, L*, a*, b*, \
                R, G or B";
            Err(Error::invalid("", "column", format!("{name:?}"), legal))
        }
    }
}

impl Header {
    /// The header of a table.
    ///
    /// # Errors
    /// A column that is none, or is there twice; no columns of directions, or two ways to say them; no values, or two kinds of them.
    pub(super) fn parse(line: &str) -> Result<Self> {
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
        let pairs = [(Column::Incidence, Column::Aspecular), (Column::ThetaI, Column::ThetaO)];
        let whole = pairs.iter().filter(|(a, b)| has(a) && has(b)).count();
        let any = pairs.iter().filter(|(a, b)| has(a) || has(b)).count();
        if whole != any || usize::from(has(&Column::Geometry)) + any != 1 {
            let legal = "either a column geometry, or columns incidence and aspecular, or columns theta_i and theta_o";
            return Err(Error::invalid("", "columns of directions", format!("{:?}", line.trim()), legal));
        }
        let values = Values::of(&columns)?;
        Ok(Self { separator, columns, values })
    }

    /// What the values are.
    pub(super) fn bands(&self) -> Bands {
        match &self.values {
            Values::Lab | Values::Rgb => Bands::Rgb,
            Values::Spectral(nm) => Bands::Wavelengths(nm.clone()),
        }
    }

    /// Refuses values that are no spectra, and wavelengths that do not ascend from column to column.
    pub(super) fn require_ascending(&self) -> Result<()> {
        if !matches!(self.values, Values::Spectral(_)) {
            return Err(Error::invalid("", "columns of values", "colors", "spectra: wavelengths in nm"));
        }
        let mut last = 0.0;
        for (k, column) in self.columns.iter().enumerate() {
            let Column::Wavelength(nm) = *column else { continue };
            if nm <= last {
                let found = format!("{nm} nm after {last} nm");
                return Err(Error::invalid(format!("column {}", k + 1), "wavelengths", found, "ascending"));
            }
            last = nm;
        }
        Ok(())
    }

    /// Sample and BRDF values of a line.
    pub(super) fn row(&self, line: &str) -> Result<(BrdfSample, Vec<f64>)> {
        let cells: Vec<&str> =
            line.split(self.separator).map(|c| c.trim().trim_matches('"').trim()).collect();
        if cells.len() != self.columns.len() {
            let legal = format!("{} (the header)", self.columns.len());
            return Err(Error::invalid("", "columns", cells.len(), legal));
        }
        let at = |k: usize| move |e: Error| e.within(format!("column {}", k + 1));
        let (mut incidence, mut aspecular, mut exit, mut weight) = (0.0, 0.0, None, 1.0);
        let mut values = Vec::new();
        let mut directions_at = 0;
        for (k, (column, cell)) in self.columns.iter().zip(&cells).enumerate() {
            match column {
                Column::Geometry => {
                    ((incidence, aspecular), directions_at) = (self.geometry(cell).map_err(at(k))?, k)
                }
                Column::Incidence | Column::ThetaI => incidence = self.number(cell).map_err(at(k))?,
                Column::Aspecular => (aspecular, directions_at) = (self.number(cell).map_err(at(k))?, k),
                Column::ThetaO => (exit, directions_at) = (Some(self.number(cell).map_err(at(k))?), k),
                Column::Weight => weight = self.number(cell).map_err(at(k))?,
                Column::Name => (),
                Column::Wavelength(nm) => values.push((*nm, self.factor(cell).map_err(at(k))?)),
                Column::Rgb(c) => values.push((*c as f64, self.factor(cell).map_err(at(k))?)),
                Column::Lab(c) => values.push((*c as f64, self.number(cell).map_err(at(k))?)),
            }
        }
        let reading = match exit {
            Some(exit) => Reading::between(incidence, exit),
            None => Reading::new(incidence, aspecular),
        };
        let (wi, wo) = reading.map_err(at(directions_at))?.directions();
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
