//! Cook-Torrance lobes evaluated from and to JSON, so that they can be checked from outside.

use super::albedo::albedo;
use crate::brdf::cook_torrance::{beckmann, brightness, v_cavity};
use crate::brdf::fresnel::schlick;
use crate::brdf::{Lobe, LobeGeometry};
use crate::error::{Error, Result};
use crate::math::half_difference::spherical;
use serde_json::{Map, Value, json};
use std::f64::consts::FRAC_PI_2;

/// Computes the output fields of one set of lobes.
///
/// Input: `kd` (any number, as in a paint), `lobes` (each `[coefficient, roughness, f0]`, ranges of [`Lobe::validate`]), optionally `albedo`
/// (objects with `theta_i_deg`, 0 to below 90) and `points` (objects with `theta_i`, `theta_o`, 0 to below pi/2, and `dphi`,
/// radians; pi is the mirror side). Other fields pass through. Output: in each
/// of `albedo` `albedo_diffuse`, `albedo_lobes`, `albedo_total`; in each of `points` `f_total`, `f_lobes` (1/sr) and
/// `D`, `F`, `G` of every lobe.
///
/// # Errors
/// A missing field, a value of the wrong kind or outside its range, named.
pub fn eval_cook_torrance_set(set: &Value) -> Result<Value> {
    let kd = number(set, "kd")?;
    let lobes =
        list(set, "lobes")?.iter().enumerate().map(|(k, v)| lobe(v, k)).collect::<Result<Vec<_>>>()?;
    let mut output = object(set, "set")?;
    for (key, row) in [
        ("albedo", albedo_row as fn(f64, &[Lobe], &Value) -> Result<Value>),
        ("points", point_row as fn(f64, &[Lobe], &Value) -> Result<Value>),
    ] {
        if set.get(key).is_some() {
            let rows = list(set, key)?
                .iter()
                .enumerate()
                .map(|(k, v)| row(kd, &lobes, v).map_err(|e| e.within(format!("{key} {k}"))));
            output.insert(key.to_owned(), Value::Array(rows.collect::<Result<_>>()?));
        }
    }
    Ok(Value::Object(output))
}

fn albedo_row(kd: f64, lobes: &[Lobe], row: &Value) -> Result<Value> {
    let degrees = number(row, "theta_i_deg")?;
    if !(0.0..90.0).contains(&degrees) {
        return Err(Error::invalid("theta_i_deg", "value", degrees, "0 to below 90"));
    }
    let each: Vec<f64> = lobes.iter().map(|l| albedo(l, degrees.to_radians())).collect();
    let mut output = object(row, "row")?;
    output.insert("albedo_diffuse".into(), json!(kd));
    output.insert("albedo_total".into(), json!(kd + each.iter().sum::<f64>()));
    output.insert("albedo_lobes".into(), json!(each));
    Ok(Value::Object(output))
}

fn point_row(kd: f64, lobes: &[Lobe], row: &Value) -> Result<Value> {
    let wi = spherical(polar(row, "theta_i")?, 0.0);
    let wo = spherical(polar(row, "theta_o")?, number(row, "dphi")?);
    let g = LobeGeometry::of(wi, wo);
    let each = |f: &dyn Fn(&Lobe) -> f64| json!(lobes.iter().map(f).collect::<Vec<_>>());
    let mut output = object(row, "row")?;
    output.insert("f_total".into(), json!(brightness(kd, lobes, &g)));
    output.insert("f_lobes".into(), each(&|l| l.eval(&g)));
    output.insert("D".into(), each(&|l| beckmann(g.tan2_h, g.cos_h, l.roughness)));
    output.insert("F".into(), each(&|l| schlick(l.f0, g.cos_d)));
    output.insert("G".into(), each(&|_| v_cavity(&g)));
    Ok(Value::Object(output))
}

fn lobe(value: &Value, k: usize) -> Result<Lobe> {
    let numbers: Vec<f64> =
        value.as_array().map(|a| a.iter().filter_map(Value::as_f64).collect()).unwrap_or_default();
    let [coefficient, roughness, f0] = numbers[..] else {
        let legal = "three numbers: coefficient, roughness, f0";
        return Err(Error::invalid(format!("lobes {k}"), "value", value, legal));
    };
    let lobe = Lobe { coefficient, roughness, f0 };
    lobe.validate().map_err(|e| e.within(format!("lobes {k}")))?;
    Ok(lobe)
}

/// A polar angle above the horizon, radians.
fn polar(from: &Value, key: &str) -> Result<f64> {
    let angle = number(from, key)?;
    if !(0.0..FRAC_PI_2).contains(&angle) {
        return Err(Error::invalid(key, "value", angle, "0 to below pi/2"));
    }
    Ok(angle)
}

fn number(from: &Value, key: &str) -> Result<f64> {
    let value = from.get(key).unwrap_or(&Value::Null);
    value.as_f64().ok_or_else(|| Error::invalid(key, "value", value, "a number"))
}

fn list<'a>(from: &'a Value, key: &str) -> Result<&'a [Value]> {
    let value = from.get(key).unwrap_or(&Value::Null);
    value.as_array().map(Vec::as_slice).ok_or_else(|| Error::invalid(key, "value", value, "a list"))
}

fn object(value: &Value, what: &str) -> Result<Map<String, Value>> {
    value.as_object().cloned().ok_or_else(|| Error::invalid(what, "value", value, "an object"))
}
