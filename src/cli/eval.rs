//! `carpaint eval`.

use super::{MAX_JSON_BYTES, output, transport};
use crate::color::{self, BANDS, Illuminant, Spectrum};
use crate::error::{Error, Result};
use crate::file::read_text;
use crate::fit::eval_cook_torrance_set;
use glam::{DMat3, DVec3};
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Evaluate one formula for the inputs of a file of reference rows, and print the rows with its outputs.
///
/// The file holds one row, a list of rows, or an object whose lists are rows; other fields are ignored.
#[derive(clap::Args)]
pub struct Arguments {
    /// Which formula.
    kind: Kind,
    /// Rows as JSON.
    file: PathBuf,
    /// Print JSON (the only form there is; accepted for symmetry with the other commands).
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Kind {
    /// Optimal transport: source_centres, target_centres, p, q.
    Transport,
    /// Cook-Torrance lobes: kd, lobes, albedo angles, points.
    Lobes,
    /// Spectra (reflectance, 41 values) to XYZ, RGB, Lab; color differences of lab1, lab2.
    Color,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let text = read_text(&self.file, MAX_JSON_BYTES)?;
        let input: Value = serde_json::from_str(&text)
            .map_err(|e| Error::invalid(self.file.display().to_string(), "not JSON", e, "JSON"))?;
        output::json(&self.kind.rows(&input).map_err(|e| e.in_file(&self.file))?)?;
        Ok(ExitCode::SUCCESS)
    }
}

impl Kind {
    /// Evaluates a row, or every row of a list, or every list of an object.
    fn rows(self, input: &Value) -> Result<Value> {
        match input {
            Value::Array(rows) => {
                let rows = rows.iter().enumerate();
                rows.map(|(k, r)| self.row(r).map_err(|e| e.within(format!("row {k}")))).collect()
            }
            Value::Object(map) if !self.is_row(map) => {
                let mut out = Map::new();
                for (key, value) in map.iter().filter(|(_, v)| v.is_array()) {
                    out.insert(key.clone(), self.rows(value).map_err(|e| e.within(key))?);
                }
                if out.is_empty() {
                    return Err(Error::invalid("", "rows", "none", format!("fields {}", self.inputs())));
                }
                Ok(Value::Object(out))
            }
            row => self.row(row),
        }
    }

    fn is_row(self, map: &Map<String, Value>) -> bool {
        let keys: &[&str] = match self {
            Self::Transport => &["source_centres"],
            Self::Lobes => &["lobes"],
            Self::Color => &["reflectance", "lab1"],
        };
        keys.iter().any(|k| map.contains_key(*k))
    }

    fn inputs(self) -> &'static str {
        match self {
            Self::Transport => "source_centres, target_centres, p, q",
            Self::Lobes => "kd, lobes, albedo, points",
            Self::Color => "reflectance, or lab1 and lab2",
        }
    }

    fn row(self, row: &Value) -> Result<Value> {
        match self {
            Self::Transport => transport::eval_row(row),
            Self::Lobes => eval_cook_torrance_set(row),
            Self::Color if row.get("reflectance").is_some() => spectrum(row),
            Self::Color => difference(row),
        }
    }
}

/// The numbers of a list of a given length.
fn numbers<const N: usize>(row: &Value, key: &str) -> Result<[f64; N]> {
    let legal = || format!("{N} numbers");
    let list = row.get(key).and_then(Value::as_array);
    let list =
        list.ok_or_else(|| Error::invalid(key, "field", row.get(key).unwrap_or(&Value::Null), legal()))?;
    let values: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
    values.try_into().map_err(|_| Error::invalid(key, "length", list.len(), legal()))
}

/// XYZ by straight 10 nm sums; Lab relative to the white of the same sums, and to x = 0.3127, y = 0.3290.
fn spectrum(row: &Value) -> Result<Value> {
    let reflectance = Spectrum(numbers::<BANDS>(row, "reflectance")?);
    let (d65, a) = (reflectance.xyz(Illuminant::D65), reflectance.xyz(Illuminant::A));
    let linear = color::rgb_from_xyz(d65);
    // IEC 61966-2-1 prints the inverse matrix with four digits.
    let four_digits = DMat3::from_cols(
        DVec3::new(3.2406, -0.9689, 0.0557),
        DVec3::new(-1.5372, 1.8758, -0.204),
        DVec3::new(-0.4986, 0.0415, 1.057),
    );
    // The linear toe of the curve, continued below zero.
    let encoded = linear.to_array().map(|c| if c < 0.0 { 12.92 * c } else { color::srgb_encode(c) });
    let adapted = color::bradford(Illuminant::A.white(), Illuminant::D65.white()) * a;
    let list = |v: DVec3| json!(v.to_array());
    Ok(json!({
        "name": row.get("name"),
        "XYZ_D65": list(d65),
        "Lab_D65_tablewhite": list(color::lab_from_xyz(d65, Illuminant::D65.white())),
        "XYZ_A": list(a),
        "Lab_A_tablewhite": list(color::lab_from_xyz(a, Illuminant::A.white())),
        "Lab_D65_white_xy.3127_.3290": list(color::lab_from_xyz(d65, color::WHITE_XYZ)),
        "sRGB_linear_IEC4digit": list(four_digits * d65),
        "sRGB_linear_derived": list(linear),
        "sRGB_encoded_derived_unclipped_clipneg": encoded,
        "XYZ_A_bradford_to_D65": list(adapted),
        "linear_rgb": list(reflectance.linear_rgb()),
    }))
}

fn difference(row: &Value) -> Result<Value> {
    let (a, b) = (DVec3::from(numbers::<3>(row, "lab1")?), DVec3::from(numbers::<3>(row, "lab2")?));
    Ok(json!({
        "lab1": a.to_array(),
        "lab2": b.to_array(),
        "dE76": color::delta_e_76(a, b),
        "dE94_graphic": color::delta_e_94(a, b),
        "dE2000": color::delta_e_2000(a, b),
    }))
}
