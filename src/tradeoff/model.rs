//! Simulation: models and error targets against the full model at 1e-5; wavelengths.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve, curve_of_bytes};
use crate::brdf::instrument::MULTI_ANGLE;
use crate::color::{BANDS, Illuminant, Spectrum, delta_e_2000, lab_from_rgb, lab_from_xyz, wavelength_nm};
use crate::error::Result;
use crate::fit::SmoothFit;
use crate::simulate::{Model, ModelKind, ModelOptions};
use glam::DVec3;
use std::f64::consts::PI;

/// Error target of the truth.
const TRUTH: f64 = 1e-5;
/// Every so many wavelengths.
const STEPS: [usize; 6] = [10, 8, 5, 4, 2, 1];

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
    let judge = |found: &Vec<DVec3>| Ok((apart(found, &truth), None));
    let spectra = wavelengths(&Model::new(composition, usual)?, effort)?;
    Ok(vec![curve(head, &trials, *effort, judge)?, spectra])
}

/// Spectra at every n-th wavelength, straight in between: what all of a model's tables, and its time, grow with.
fn wavelengths(model: &Model, effort: &Effort) -> Result<Curve> {
    let colors = |step: usize| -> Result<Vec<DVec3>> {
        spectra(model).iter().map(|spectrum| Ok(color(&thinned(spectrum, step)?))).collect()
    };
    let truth = colors(1)?;
    let [half, quarter] = [apart(&colors(2)?, &truth), apart(&colors(4)?, &truth)];
    let trials = STEPS.map(|step| {
        let setting = (BANDS - 1) / step + 1;
        Trial::new(setting, step == 1, move || Ok((step, colors(step)?)))
    });
    let head = Head {
        stage: "Simulation",
        knob: "wavelengths of a spectrum (always 41)",
        error: "largest Delta-E 2000 at the eight geometries, against 41; that of 41 itself goes on from 11 to 21 as a series does",
        why: "Color is computed from 41 wavelengths in the tables of colorimetry. Flakes with interference colors lose 0.3 to 0.6 at 21, and an \
              estimated 0.06 to 0.2 at 41; gray metal would do with 21.",
    };
    let judge = |(step, found): &(usize, Vec<DVec3>)| {
        let error = if *step == 1 { half * half / quarter.max(half) } else { apart(found, &truth) };
        Ok((error, Some((size_of::<f64>() * ((BANDS - 1) / step + 1)) as f64)))
    };
    curve_of_bytes(head, &trials, *effort, judge)
}

/// A spectrum of which every so many bands are known.
fn thinned(spectrum: &Spectrum, step: usize) -> Result<Spectrum> {
    let knots: Vec<(f64, f64)> =
        (0..BANDS).step_by(step).map(|k| (wavelength_nm(k), spectrum.0[k])).collect();
    Spectrum::from_knots(&knots)
}

/// Largest Delta-E 2000.
fn apart(found: &[DVec3], truth: &[DVec3]) -> f64 {
    found.iter().zip(truth).map(|(a, b)| delta_e_2000(*a, *b)).fold(0.0, f64::max)
}

/// Reflectance factors at the instrument's geometries.
fn spectra(model: &Model) -> Vec<Spectrum> {
    read(|wi, wo| Spectrum(model.brdf(wi, wo).0.map(|f| PI * f)))
}

/// Colors at the instrument's geometries under D65.
pub(super) fn lab(model: &Model) -> Vec<DVec3> {
    spectra(model).iter().map(color).collect()
}

/// Color of reflectance factors under D65.
fn color(factors: &Spectrum) -> DVec3 {
    lab_from_xyz(factors.xyz(&Illuminant::D65.spectrum()), Illuminant::D65.white())
}

/// The same of a fit.
pub(super) fn lab_of_fit(fit: &SmoothFit) -> Vec<DVec3> {
    read(|wi, wo| lab_from_rgb(PI * fit.eval(wi, wo)))
}

fn read<T>(value: impl Fn(DVec3, DVec3) -> T) -> Vec<T> {
    MULTI_ANGLE.iter().map(|reading| reading.directions()).map(|(wi, wo)| value(wi, wo)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinned_spectra_keep_what_is_straight_and_lose_what_is_not() {
        let ramp = Spectrum(std::array::from_fn(|k| 0.1 + 0.02 * k as f64));
        let teeth = Spectrum(std::array::from_fn(|k| (k % 2) as f64));
        for step in STEPS {
            let kept = thinned(&ramp, step).unwrap();
            assert!(kept.0.iter().zip(ramp.0).all(|(a, b)| (a - b).abs() < 1e-15), "{step}");
            assert_eq!(thinned(&teeth, step).unwrap() == teeth, step == 1, "{step}");
        }
    }
}
