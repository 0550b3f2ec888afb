//! Simulation: models and error targets against the full model at 1e-5.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::brdf::instrument::MULTI_ANGLE;
use crate::color::{Illuminant, Spectrum, delta_e_2000, lab_from_rgb, lab_from_xyz};
use crate::error::Result;
use crate::fit::SmoothFit;
use crate::simulate::{Model, ModelKind, ModelOptions};
use glam::DVec3;
use std::f64::consts::PI;

/// Error target of the truth.
const TRUTH: f64 = 1e-5;

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let composition = subject.chain.model.composition();
    let colors = |kind: ModelKind, error: f64| -> Result<Vec<DVec3>> {
        Ok(lab(&Model::new(composition, ModelOptions { kind, error })?))
    };
    let truth = colors(ModelKind::Full, TRUTH)?;
    let usual = ModelOptions::default();
    let settings = [
        ("fast", ModelKind::Fast, usual.error),
        ("fast-corrected", ModelKind::FastCorrected, usual.error),
        ("auto, 0.01", usual.kind, usual.error),
        ("full, 0.1", ModelKind::Full, 0.1),
        ("full, 0.01", ModelKind::Full, 0.01),
        ("full, 0.001", ModelKind::Full, 1e-3),
        ("full, 0.0001", ModelKind::Full, 1e-4),
    ];
    // The fast model has no pigments and one film.
    let known = settings.into_iter().filter(|(_, kind, error)| {
        Model::new(composition, ModelOptions { kind: *kind, error: *error }).is_ok()
    });
    let trials: Vec<Trial<Vec<DVec3>>> = known
        .map(|(name, kind, error)| {
            let is_default = (kind, error) == (usual.kind, usual.error);
            Trial::new(name, is_default, move || colors(kind, error))
        })
        .collect();
    let head = Head {
        stage: "Simulation",
        knob: "model and its error target (--model, --tolerance)",
        error: "largest Delta-E 2000 at the eight geometries of ASTM E2194 and E2539, against the full model at 1e-5",
        why: "auto takes the cheapest model that is known to stay within 1 %, which no eye sees; a tighter target costs in \
              proportion to what it adds in directions, and pays only where another tool is compared with.",
    };
    let judge = |found: &Vec<DVec3>| {
        let errors = found.iter().zip(&truth).map(|(a, b)| delta_e_2000(*a, *b));
        Ok((errors.fold(0.0, f64::max), None))
    };
    Ok(vec![curve(head, &trials, *effort, judge)?])
}

/// Colors at the instrument's geometries under D65.
pub(super) fn lab(model: &Model) -> Vec<DVec3> {
    let (light, white) = (Illuminant::D65.spectrum(), Illuminant::D65.white());
    read(|wi, wo| {
        let factors = Spectrum(model.brdf(wi, wo).0.map(|f| PI * f));
        lab_from_xyz(factors.xyz(&light), white)
    })
}

/// The same of a fit.
pub(super) fn lab_of_fit(fit: &SmoothFit) -> Vec<DVec3> {
    read(|wi, wo| lab_from_rgb(PI * fit.eval(wi, wo)))
}

fn read(color: impl Fn(DVec3, DVec3) -> DVec3) -> Vec<DVec3> {
    MULTI_ANGLE.iter().map(|reading| reading.directions()).map(|(wi, wo)| color(wi, wo)).collect()
}
