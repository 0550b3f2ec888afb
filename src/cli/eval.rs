//! `carpaint eval`.

use super::{MAX_JSON_BYTES, eval_gonio, eval_paint, output, transport};
use crate::color::{self, BANDS, Illuminant, Spectrum};
use crate::error::{Error, Result};
use crate::file::read_text;
use crate::fit::eval_cook_torrance_set;
use crate::simulate::eval::rows::{eval_fresnel, eval_mie, eval_thin_film};
use crate::simulate::{eval_flake_layer, eval_slab};
use glam::{DMat3, DVec3};
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;
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
    /// The fast two-layer paint: params {sigma_deg, DSh, rp, tp, eta, rs, kh}, points.
    Fast,
    /// Sparkle probabilities and statistics: sigma_deg, eta, directions, and Delta_deg or D_per_cm3, S_cm2, H_cm and so on.
    Sparkle,
    /// Plane slabs of particles: albedo, b, g, n, collimated (fluxes); case (angular kernels).
    Slab,
    /// A layer of mirror flakes: config, theta_i_deg, points.
    FlakeLayer,
    /// Spectra (reflectance, 41 values) to XYZ, RGB, Lab; color differences of lab1, lab2.
    Color,
    /// Stacks of thin layers: n_list, d_list_nm (angle_deg, wavelength_nm).
    ThinFilm,
    /// Mie spheres: x, m_re, m_im_absorbing_positive (angle_deg).
    Mie,
    /// Smooth boundaries: eta, angle_deg.
    Fresnel,
    /// Goniochromatic reflection: theta_i, theta_o, dphi (radians), alpha, rho, c.
    Gonio,
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

    /// Whether an object has some of a row's inputs: then it is one, though others may be missing.
    fn is_row(self, map: &Map<String, Value>) -> bool {
        let keys: &[&str] = match self {
            Self::Transport => &["source_centres", "target_centres", "p", "q"],
            Self::Lobes => &["kd", "lobes", "albedo", "points"],
            Self::Fast => &["params", "points"],
            Self::Sparkle => {
                &["sigma_deg", "eta", "theta_i_deg", "theta_o_deg", "phi_deg", "Delta_deg", "D_per_cm3"]
            }
            Self::Slab => &["albedo", "b", "g", "n", "collimated", "case", "layers"],
            Self::FlakeLayer => &["config", "theta_i_deg", "points"],
            Self::Color => &["reflectance", "lab1", "lab2"],
            Self::ThinFilm => &["n_list", "d_list_nm"],
            Self::Mie => &["x", "m_re", "m_im_absorbing_positive"],
            Self::Fresnel => &["eta", "angle_deg"],
            Self::Gonio => &["theta_i", "theta_o", "dphi", "alpha", "rho", "c"],
        };
        keys.iter().any(|k| map.contains_key(*k))
    }

    fn inputs(self) -> &'static str {
        match self {
            Self::Transport => "source_centres, target_centres, p, q",
            Self::Lobes => "kd, lobes, albedo, points",
            Self::Fast => "params, points",
            Self::Sparkle => "sigma_deg, eta, theta_i_deg, theta_o_deg, phi_deg, and Delta_deg or D_per_cm3",
            Self::Slab => "albedo, b, g, n, collimated, or case",
            Self::FlakeLayer => "config, theta_i_deg, points",
            Self::Color => "reflectance, or lab1 and lab2",
            Self::ThinFilm => "n_list, d_list_nm",
            Self::Mie => "x, m_re, m_im_absorbing_positive",
            Self::Fresnel => "eta, or angle_deg",
            Self::Gonio => "theta_i, theta_o, dphi, alpha, rho, c",
        }
    }

    fn row(self, row: &Value) -> Result<Value> {
        match self {
            Self::Transport => transport::eval_row(row),
            Self::Lobes => eval_cook_torrance_set(row),
            Self::Fast => eval_paint::fast(row),
            Self::Sparkle => eval_paint::sparkle(row),
            Self::Slab => eval_slab(row),
            Self::FlakeLayer => eval_flake_layer(row),
            Self::Color if row.get("reflectance").is_some() => spectrum(row),
            Self::Color => difference(row),
            Self::ThinFilm => eval_thin_film(row),
            Self::Mie => eval_mie(row),
            Self::Fresnel => eval_fresnel(row),
            Self::Gonio => eval_gonio::gonio(row),
        }
    }
}

/// A number of a row.
pub fn number(row: &Value, key: &str, legal: RangeInclusive<f64>) -> Result<f64> {
    let value = row.get(key).unwrap_or(&Value::Null);
    let found = value.as_f64().filter(|x| legal.contains(x));
    found.ok_or_else(|| Error::invalid(key, "field", value, format!("{} to {}", legal.start(), legal.end())))
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
    let [d65, a] = [Illuminant::D65, Illuminant::A].map(|light| reflectance.xyz(&light.spectrum()));
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
