//! `carpaint eval gonio`: the goniochromatic model at directions given by angles.

use super::eval::number;
use crate::brdf::LobeGeometry;
use crate::brdf::goniochromatic::Goniochromatic;
use crate::error::Result;
use crate::math::half_difference::spherical;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A row's BRDF; where light is mirrored also by eq. 7. Angles in radians.
pub fn gonio(row: &Value) -> Result<Value> {
    let [theta_i, theta_o] = ["theta_i", "theta_o"].map(|key| number(row, key, 0.0..=FRAC_PI_2));
    let (theta_i, theta_o, turn) = (theta_i?, theta_o?, number(row, "dphi", -TAU..=TAU)?);
    let model = Goniochromatic {
        roughness: number(row, "alpha", Goniochromatic::MIN_ROUGHNESS..=1.0)?,
        reflectance: number(row, "rho", 0.0..=Goniochromatic::MAX_REFLECTANCE)?,
        growth: number(row, "c", -Goniochromatic::MAX_GROWTH..=Goniochromatic::MAX_GROWTH)?,
    };
    let g = LobeGeometry::of(spherical(theta_i, 0.0), spherical(theta_o, turn));
    let mirrored = theta_i == theta_o && turn.abs() == PI;
    Ok(json!({
        "theta_i": theta_i,
        "theta_o": theta_o,
        "dphi": turn,
        "cos_theta_h": g.cos_h,
        "f": model.eval(&g),
        "f_eq7": mirrored.then(|| model.mirrored(theta_i.cos())),
    }))
}
