//! Formulas evaluated for one row of a reference file: fields in, fields of the same names out.

use crate::color::{BANDS, wavelength_nm};
use crate::error::{Error, Result};
use crate::simulate::models::substrate_return::mean_inner_reflectance;
use crate::simulate::optics::materials::material;
use crate::simulate::optics::mie::MieSphere;
use crate::simulate::optics::thin_film::{FilmLayer, stack_power};
use nalgebra::Complex;
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;

/// Polar angles, degrees.
const ANGLE_DEG: RangeInclusive<f64> = 0.0..=90.0;

/// A coherent stack. In: `n_list`, outermost media included, each a number, a pair `[n, k]` or a material's name (`AL` and
/// `ALR` are aluminium after McPeak and Rakic); `d_list_nm` of the same length, whose ends are not read; optionally `name`,
/// `angle_deg` inside the first medium, 0 to 90 (0 to 85 by 5), and `wavelength_nm`, above 0 (380 to 780 by 10). Out: `R_s`, `R_p`, `R_unpol`,
/// `T_s`, `T_p`, `T_unpol`, each a list over wavelengths for every angle.
///
/// # Errors
/// A field that is missing, of the wrong kind or length, or outside its range; an unknown material, or one outside 380-780 nm; a first medium
/// that absorbs.
pub fn eval_thin_film(row: &Value) -> Result<Value> {
    let angles = numbers_or(row, "angle_deg", || (0..18).map(|k| 5.0 * f64::from(k)).collect())?;
    let wavelengths = numbers_or(row, "wavelength_nm", || (0..BANDS).map(wavelength_nm).collect())?;
    require(&angles, "angle_deg", ANGLE_DEG, "0 to 90")?;
    require(&wavelengths, "wavelength_nm", f64::MIN_POSITIVE..=f64::MAX, "above 0")?;
    let media = list(row, "n_list")?;
    let thicknesses = list(row, "d_list_nm")?;
    if media.len() < 2 || thicknesses.len() != media.len() {
        let found = format!("{} and {}", media.len(), thicknesses.len());
        return Err(Error::invalid("", "lengths of n_list and d_list_nm", found, "the same, 2 or more"));
    }
    let inner = 1..media.len() - 1;
    let thicknesses =
        inner.clone().map(|k| non_negative(&thicknesses[k], "d_list_nm")).collect::<Result<Vec<_>>>()?;
    let names = ["R_s", "R_p", "R_unpol", "T_s", "T_p", "T_unpol"];
    let mut out = names.map(|_| vec![vec![0.0; wavelengths.len()]; angles.len()]);
    for (j, nm) in wavelengths.iter().enumerate() {
        let indices = media.iter().map(|medium| refractive_index(medium, *nm)).collect::<Result<Vec<_>>>()?;
        if indices[0].im != 0.0 {
            return Err(Error::invalid("n_list", "first medium", &media[0], "one that does not absorb"));
        }
        let layers: Vec<_> = inner
            .clone()
            .map(|k| FilmLayer { index: indices[k], thickness_nm: thicknesses[k - 1] })
            .collect();
        for (i, angle) in angles.iter().enumerate() {
            let cos_alpha = angle.to_radians().cos();
            let power = stack_power(indices[0].re, &layers, indices[media.len() - 1], cos_alpha, *nm);
            let [r, t] = [power.reflectance, power.transmittance];
            let values =
                [r[0], r[1], power.unpolarized_reflectance(), t[0], t[1], power.unpolarized_transmittance()];
            out.iter_mut().zip(values).for_each(|(o, v)| o[i][j] = v);
        }
    }
    let mut row = Map::from_iter([("name".to_owned(), row.get("name").cloned().unwrap_or_default())]);
    row.extend(names.into_iter().zip(out).map(|(name, table)| (name.to_owned(), json!(table))));
    Ok(Value::Object(row))
}

/// A sphere. In: `x`, `m_re`, `m_im_absorbing_positive` (0), optionally `angle_deg` (0 to 180 by 10). Out: those, and
/// `Qext`, `Qsca`, `Qabs`, `g`, and over angles `phase_per_sr` and the amplitudes `S1`, `S2` as pairs.
///
/// # Errors
/// A field that is missing or of the wrong kind; [`MieSphere::new`].
pub fn eval_mie(row: &Value) -> Result<Value> {
    let angles = numbers_or(row, "angle_deg", || (0..19).map(|k| 10.0 * f64::from(k)).collect())?;
    let (x, re) = (number(row, "x")?, number(row, "m_re")?);
    let im = if row.get("m_im_absorbing_positive").is_some() {
        number(row, "m_im_absorbing_positive")?
    } else {
        0.0
    };
    let sphere = MieSphere::new(x, Complex::new(re, im))?;
    let cosines: Vec<f64> = angles.iter().map(|a| a.to_radians().cos()).collect();
    let amplitudes: Vec<_> = cosines.iter().map(|c| sphere.amplitudes(*c).map(|s| [s.re, s.im])).collect();
    Ok(json!({
        "x": x,
        "m_re": re,
        "m_im_absorbing_positive": im,
        "Qext": sphere.extinction(),
        "Qsca": sphere.scattering(),
        "Qabs": sphere.extinction() - sphere.scattering(),
        "g": sphere.asymmetry(),
        "phase_per_sr": cosines.iter().map(|c| sphere.phase(*c)).collect::<Vec<_>>(),
        "S1": amplitudes.iter().map(|s| s[0]).collect::<Vec<_>>(),
        "S2": amplitudes.iter().map(|s| s[1]).collect::<Vec<_>>(),
    }))
}

/// A smooth boundary. In: `eta` (index beyond over index before, 1 to 4 unless only angles are asked for) and optionally
/// `angle_deg` on the near side, 0 to 90. Out: with angles `R_s`, `R_p`, `R_unpol`; for eta >= 1 the means over Lambertian light from
/// the thin side, `F_external`, and from the dense side, `F_internal` (Ershov 2001, eq. 31), by quadrature, and both by
/// Walsh's closed form.
///
/// Or a table: `angle_deg` without `eta`, with keys `air_to_binder_eta1.5`, `binder_to_air_eta1over1.5` (any index; these
/// two if there are none) and a list `diffuse` of rows. Out: the same keys.
///
/// # Errors
/// A field that is missing or of the wrong kind; an index or angle outside its range.
pub fn eval_fresnel(row: &Value) -> Result<Value> {
    let angles = numbers_or(row, "angle_deg", Vec::new)?;
    require(&angles, "angle_deg", ANGLE_DEG, "0 to 90")?;
    if row.get("eta").is_none() {
        return fresnel_tables(row, &angles);
    }
    let eta = number(row, "eta")?;
    if !(0.25..=4.0).contains(&eta) || (eta < 1.0 && angles.is_empty()) {
        return Err(Error::invalid("", "eta", eta, "1 to 4, or with angle_deg 0.25 to 4"));
    }
    let mut out = boundary(eta, &angles);
    out.insert("eta".into(), json!(eta));
    if eta >= 1.0 {
        let external = |internal: f64| 1.0 - eta * eta * (1.0 - internal);
        let internal = |external: f64| 1.0 - (1.0 - external) / (eta * eta);
        let (numeric, closed) = (mean_inner_reflectance(eta), walsh(eta));
        for (key, value) in [
            ("F_internal", numeric),
            ("F_external", external(numeric)),
            ("walsh_internal", internal(closed)),
            ("walsh_external", closed),
        ] {
            out.insert(key.into(), json!(value));
        }
    }
    Ok(Value::Object(out))
}

fn fresnel_tables(row: &Value, angles: &[f64]) -> Result<Value> {
    let mut out = Map::new();
    let usual = ["air_to_binder_eta1.5", "binder_to_air_eta1over1.5"];
    let given: Vec<&str> =
        row.as_object().into_iter().flat_map(|map| map.keys().map(String::as_str)).collect();
    let named = |keys: &[&str]| -> Vec<(String, f64)> {
        let ratio = |key: &str| {
            let inverse = key.strip_prefix("binder_to_air_eta1over").and_then(|eta| eta.parse::<f64>().ok());
            let eta = key.strip_prefix("air_to_binder_eta").and_then(|eta| eta.parse::<f64>().ok());
            eta.or(inverse.map(f64::recip)).filter(|eta| (0.25..=4.0).contains(eta))
        };
        keys.iter().filter_map(|key| Some(((*key).to_owned(), ratio(key)?))).collect()
    };
    let mut tables = named(&given);
    if tables.is_empty() {
        tables = named(&usual);
    }
    for (key, eta) in tables {
        out.insert(key, Value::Object(boundary(eta, angles)));
    }
    if let Some(rows) = row.get("diffuse").and_then(Value::as_array) {
        out.insert("diffuse".into(), rows.iter().map(eval_fresnel).collect::<Result<_>>()?);
    }
    Ok(Value::Object(out))
}

fn boundary(eta: f64, angles: &[f64]) -> Map<String, Value> {
    let power =
        |degrees: &f64| stack_power(1.0, &[], Complex::new(eta, 0.0), degrees.to_radians().cos(), 1.0);
    let all: Vec<_> = angles.iter().map(power).collect();
    let mut out = Map::new();
    if !all.is_empty() {
        out.insert("R_s".into(), all.iter().map(|p| p.reflectance[0]).collect());
        out.insert("R_p".into(), all.iter().map(|p| p.reflectance[1]).collect());
        out.insert("R_unpol".into(), all.iter().map(|p| p.unpolarized_reflectance()).collect());
    }
    out
}

/// Mean reflectance for Lambertian light from the thin side (Walsh 1926; Duntley 1942), `n` >= 1.
fn walsh(n: f64) -> f64 {
    if n == 1.0 {
        return 0.0;
    }
    let (n2, n4) = (n * n, n.powi(4));
    0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
        + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
        - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
        + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln()
}

/// Index of a medium of `n_list` at a wavelength.
fn refractive_index(medium: &Value, nm: f64) -> Result<Complex<f64>> {
    if let Some(name) = medium.as_str() {
        let material = material(match name {
            "AL" => "Al",
            "ALR" => "Al-Rakic",
            other => other,
        })?;
        let position = (nm - wavelength_nm(0)) / (wavelength_nm(1) - wavelength_nm(0));
        if !(0.0..=(BANDS - 1) as f64).contains(&position) {
            return Err(Error::invalid("wavelength_nm", name, nm, "380 to 780 for materials by name"));
        }
        let left = (position as usize).min(BANDS - 2);
        let t = position - left as f64;
        let at = |values: &[f64; BANDS]| values[left] * (1.0 - t) + values[left + 1] * t;
        return Ok(Complex::new(at(&material.n.0), at(&material.k.0)));
    }
    let pair = medium.as_array().map(|pair| pair.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
    let (n, k) = match (medium.as_f64(), pair.as_deref()) {
        (Some(n), _) => (n, 0.0),
        (None, Some([n, k])) => (*n, *k),
        _ => {
            return Err(Error::invalid(
                "n_list",
                "medium",
                medium,
                "a number, a pair [n, k], or a material's name",
            ));
        }
    };
    if !(1e-3..=1e3).contains(&n) || !(0.0..=1e3).contains(&k) {
        return Err(Error::invalid("n_list", "index", medium, "n 0.001 to 1000, k 0 to 1000"));
    }
    Ok(Complex::new(n, k))
}

fn number(row: &Value, key: &str) -> Result<f64> {
    let value = row.get(key).unwrap_or(&Value::Null);
    value.as_f64().ok_or_else(|| Error::invalid("", key, value, "a number"))
}

fn non_negative(value: &Value, key: &str) -> Result<f64> {
    let found = value.as_f64().filter(|v| *v >= 0.0);
    found.ok_or_else(|| Error::invalid("", key, value, "0 or more between the outer media"))
}

/// Refuses the first of the values outside `legal`.
fn require(values: &[f64], key: &str, legal: RangeInclusive<f64>, words: &str) -> Result<()> {
    match values.iter().find(|value| !legal.contains(value)) {
        None => Ok(()),
        Some(value) => Err(Error::invalid("", key, value, words)),
    }
}

fn list<'a>(row: &'a Value, key: &str) -> Result<&'a Vec<Value>> {
    let value = row.get(key).unwrap_or(&Value::Null);
    value.as_array().ok_or_else(|| Error::invalid("", key, value, "a list"))
}

fn numbers_or(row: &Value, key: &str, usual: impl FnOnce() -> Vec<f64>) -> Result<Vec<f64>> {
    if row.get(key).is_none() {
        return Ok(usual());
    }
    list(row, key)?.iter().map(|v| v.as_f64().ok_or_else(|| Error::invalid("", key, v, "numbers"))).collect()
}
