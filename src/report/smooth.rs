//! The smooth part of a paint against the analytic model.

use super::Check;
use super::stage::{largest, mean};
use crate::brdf::ClearCoat;
use crate::color::{delta_e_2000, lab_from_rgb};
use crate::fit::{ASPECULAR_DEG, SmoothFit};
use crate::math::half_difference::spherical;
use crate::simulate::Model;
use glam::DVec3;
use std::f64::consts::PI;

/// Delta-E 2000 of the reflectance factor between a BRDF and that of the model, for given directions.
fn difference(brdf: DVec3, model: &Model, wi: DVec3, wo: DVec3) -> f64 {
    delta_e_2000(lab_from_rgb(PI * model.brdf_rgb(wi, wo)), lab_from_rgb(PI * brdf))
}

/// The fit without its gloss, as the model leaves it out.
pub(super) fn matt(fit: &SmoothFit) -> SmoothFit {
    SmoothFit { coat: ClearCoat { gloss: None, ..fit.coat }, ..fit.clone() }
}

/// Differences at the aspecular angles of the trade, 45 degrees incidence.
fn aspecular(fit: &SmoothFit, model: &Model) -> Vec<f64> {
    let wi = spherical(PI / 4.0, 0.0);
    let at = |a: f64| spherical((a - 45.0).to_radians(), 0.0);
    ASPECULAR_DEG.iter().map(|a| difference(fit.eval(wi, at(*a)), model, wi, at(*a))).collect()
}

/// Mean difference on a grid of both polar angles, 5 to 75 degrees, and the azimuth between them.
pub(super) fn mean_difference(brdf: impl Fn(DVec3, DVec3) -> DVec3, model: &Model) -> f64 {
    let angle = |k: usize| (5.0 + 10.0 * k as f64).to_radians();
    mean((0..8 * 8 * 5).map(|k| {
        let wi = spherical(angle(k % 8), 0.0);
        let wo = spherical(angle(k / 8 % 8), PI * (k / 64) as f64 / 4.0);
        difference(brdf(wi, wo), model, wi, wo)
    }))
}

/// Mean and largest color difference, gloss left out as the model leaves it; `bars` for the largest at the aspecular angles and the mean of the grid.
pub fn checks(fit: &SmoothFit, model: &Model, bars: [f64; 2]) -> Vec<Check> {
    let matt = matt(fit);
    vec![
        Check::new(
            "smooth part, largest Delta-E 2000 of 5 aspecular angles",
            largest(aspecular(&matt, model)),
            bars[0],
        ),
        Check::new(
            "smooth part, mean Delta-E 2000 over 320 directions",
            mean_difference(|wi, wo| matt.eval(wi, wo), model),
            bars[1],
        ),
    ]
}
