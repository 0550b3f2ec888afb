//! What a composition looks like without its sparkle: the model, its colors, and the smooth paint that shows them.

use crate::paints::composition;
use carpaint::brdf::{ClearCoat, TabulatedBrdf};
use carpaint::color::lab_from_rgb;
use carpaint::error::Result;
use carpaint::fit::{FitOptions, fit_smooth};
use carpaint::paint::Paint;
use carpaint::simulate::{Model, ModelOptions, Reading};
use glam::DVec3;
use std::f64::consts::PI;

/// The model of a preset.
pub fn model(preset: &str) -> Result<Model> {
    Model::new(&composition(preset)?, ModelOptions::default())
}

/// The paint of a model, all of its light but the sparkle.
pub fn paint(model: &Model) -> Result<Paint> {
    fitted(model.coat(), |wi, wo| model.brdf_rgb(wi, wo))
}

/// A paint whose light under the coat is that of a function, seen from outside, gloss left out.
pub fn fitted(coat: ClearCoat, light: impl Fn(DVec3, DVec3) -> DVec3 + Sync) -> Result<Paint> {
    let table = TabulatedBrdf::from_fn(45, 90, light)?;
    let options = FitOptions { coat: Some(coat), filled: false, ..FitOptions::default() };
    let (smooth, report) = fit_smooth(&table, &options, &|| ())?;
    Ok(smooth.into_paint(None, serde_json::Value::Null, &report))
}

/// L*a*b* of the reflectance factor for light at `incidence` seen at `aspecular`, degrees, without gloss.
pub fn lab(model: &Model, incidence: f64, aspecular: f64) -> Result<DVec3> {
    let (wi, wo) = Reading::new(incidence, aspecular)?.directions();
    Ok(lab_from_rgb(PI * model.brdf_rgb(wi, wo)))
}

/// Hue of L*a*b*, degrees.
pub fn hue(lab: DVec3) -> f64 {
    lab.z.atan2(lab.y).to_degrees()
}

/// Chroma of L*a*b*.
pub fn chroma(lab: DVec3) -> f64 {
    lab.y.hypot(lab.z)
}

/// Angle between two hues, 0 to 180 degrees.
pub fn turn(a: f64, b: f64) -> f64 {
    180.0 - ((a - b).rem_euclid(360.0) - 180.0).abs()
}
