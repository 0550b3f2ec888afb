//! From a capture to a paint, and how far it is from the paint that was captured, where that is known.

use super::statistics::wasserstein;
use crate::brdf::{ClearCoat, LobeGeometry};
use crate::btf::{FlakeBtf, FlakeSource};
use crate::color::{delta_e_2000, lab_from_rgb, luminance};
use crate::dome::{Dome, Truth};
use crate::error::Result;
use crate::fit::{FitOptions, FitReport, SmoothFit, fit_samples};
use crate::math::half_difference::{directions, spherical};
use crate::measure::calibrate::{Calibration, CalibrationErrors, CalibrationTruth};
use crate::measure::{
    Extraction, ExtractionReport, Homogeneous, Pairs, Rig, SamplingOptions, SliceOptions, SliceReport,
    cut_slices, extract,
};
use crate::parallel::TryMap;
use crate::simulate::{Model, SynthesisOptions, synthesize};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// How a capture becomes a paint.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptureOptions {
    /// Which samples are taken.
    pub sampling: SamplingOptions,
    /// How they are fitted.
    pub fit: FitOptions,
    /// How slices are cut.
    pub slices: SliceOptions,
}

impl CaptureOptions {
    /// As many samples as the default takes, slices with texels as wide as pixels are seen from straight above.
    pub fn new(rig: &Rig, fit: FitOptions) -> Self {
        let distance =
            rig.cameras.iter().map(|c| c.position_mm.length()).sum::<f64>() / rig.cameras.len() as f64;
        let sampling = SamplingOptions { seed: fit.seed, ..SamplingOptions::default() };
        Self { sampling, fit, slices: SliceOptions::new(distance / rig.focal_zoom_px) }
    }
}

/// What was measured of a paint.
pub struct MeasuredPaint {
    /// The smooth part.
    pub smooth: SmoothFit,
    /// The flakes.
    pub btf: FlakeBtf,
    /// What the pictures gave.
    pub extraction: ExtractionReport,
    /// What the fit says of itself.
    pub fit: FitReport,
    /// How the slices were cut.
    pub slices: SliceReport,
}

/// Samples calibrated pictures, fits the smooth part, and cuts the slices; `begin` is told what starts, and how many ticks it takes
/// at most.
///
/// # Errors
/// Those of the stages.
pub fn measure_paint<T: Fn() + Sync>(
    pairs: &dyn Pairs,
    sample_mm: [f64; 2],
    options: &CaptureOptions,
    begin: impl Fn(&str, usize) -> T,
) -> Result<MeasuredPaint> {
    options.sampling.validate()?;
    options.slices.validate(sample_mm)?;
    let count = pairs.cameras() * pairs.cameras();
    let tick = begin("taking samples", count.min(options.sampling.pairs));
    let Extraction { base, gloss, report: extraction } = extract(pairs, sample_mm, &options.sampling, &tick)?;
    drop(tick);
    let tick = begin("fitting lobes", options.fit.ticks());
    let gloss = (!gloss.is_empty()).then_some(&gloss);
    let (smooth, mut fit) = fit_samples(&base, gloss, &options.fit, &tick)?;
    if let Some(coat) = options.fit.coat.filter(|coat| coat.refracts) {
        let straight =
            FitOptions { coat: Some(ClearCoat { refracts: false, ..coat }), ..options.fit.clone() };
        fit.without_refraction = Some(fit_samples(&base, gloss, &straight, &|| ())?.1.errors());
    }
    drop(tick);
    let tick = begin("cutting slices", options.slices.ticks());
    let base = |wi: DVec3, wo: DVec3| seen_base(&smooth, wi, wo);
    let gloss =
        |wi: DVec3, wo: DVec3| smooth.coat.gloss.map_or(0.0, |lobe| lobe.eval(&LobeGeometry::of(wi, wo)));
    let below = Homogeneous { base: &base, gloss: &gloss };
    let (mut btf, slices) =
        cut_slices(pairs, sample_mm, &below, &extraction.blemishes, &options.slices, &tick)?;
    // Angles of slices are outer ones.
    btf.coat = ClearCoat { gloss: None, refracts: false, ..smooth.coat };
    Ok(MeasuredPaint { smooth, btf, extraction, fit, slices })
}

/// Diffuse and glitter as seen from outside.
fn seen_base(smooth: &SmoothFit, wi: DVec3, wo: DVec3) -> DVec3 {
    smooth.base(smooth.coat.inner(wi), smooth.coat.inner(wo)) * smooth.coat.transmittance(wi.z, wo.z)
}

/// Errors of a calibration against the dome that took the pictures.
pub fn calibration_errors(calibration: &Calibration, truth: &Truth, rig: &Rig) -> CalibrationErrors {
    let response = |camera: usize, c: usize, light: f64| truth.sensors[camera].response[c].respond(light);
    let known = CalibrationTruth {
        wide: truth.wide,
        cameras: &truth.cameras,
        response: &response,
        saturation: &|_, _| 1.0,
    };
    calibration.errors_against(&known, rig)
}

/// Error of the light in calibrated pictures, over the pixels that see the sample away from its edges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RadianceError {
    /// Root mean square of the error of the luminance over the mean luminance of the picture, single pixels.
    pub rms: f64,
    /// Root mean square over the pictures of the error of their mean luminance, relative.
    pub of_means: f64,
    /// Share of the pixels that are not known.
    pub unknown: f64,
}

/// Share of the sample's half side within which pixels count: at its edge they see the wall.
const INNER: f64 = 0.95;

/// Compares the radiance of calibrated pictures with the dome's own, over every `stride`th pair; pictures left out are skipped.
pub fn radiance_error(pairs: &dyn Pairs, dome: &Dome, stride: usize) -> RadianceError {
    let cameras = pairs.cameras();
    let chosen: Vec<usize> = (0..cameras * cameras).step_by(stride.max(1)).collect();
    let errors: Vec<[f64; 3]> =
        chosen.into_par_iter().filter_map(|k| picture_error(pairs, dome, k / cameras, k % cameras)).collect();
    let mean = |of: usize| errors.iter().map(|e| e[of]).sum::<f64>() / errors.len() as f64;
    RadianceError { rms: mean(0).sqrt(), of_means: mean(1).sqrt(), unknown: mean(2) }
}

/// Mean square of the relative error of a pixel, square of that of the mean, share of pixels not known.
fn picture_error(pairs: &dyn Pairs, dome: &Dome, camera: usize, light: usize) -> Option<[f64; 3]> {
    let found = pairs.radiance(camera, light).ok()?;
    let truth = Pairs::radiance(dome, camera, light).ok()?;
    let seen = Pairs::geometry(dome, camera, light)?.camera;
    let half = 0.5 * INNER * DVec2::from(dome.options().sample_mm);
    let columns = Pairs::size(dome)[0];
    let on_sample = |k: &usize| {
        let pixel = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
        seen.on_plane(pixel, 0.0).is_some_and(|p| p.truncate().abs().cmple(half).all())
    };
    let light = |c: [f32; 3]| luminance(DVec3::from(c.map(f64::from)));
    let pixels: Vec<(f64, f64)> =
        (0..truth.len()).filter(on_sample).map(|k| (light(found[k]), light(truth[k]))).collect();
    let known: Vec<&(f64, f64)> = pixels.iter().filter(|(a, _)| a.is_finite()).collect();
    let count = known.len() as f64;
    let (sum, error, squares) = known.iter().fold((0.0, 0.0, 0.0), |(sum, error, squares), (a, b)| {
        (sum + b, error + (a - b), squares + (a - b) * (a - b))
    });
    let mean = sum / count;
    Some([squares / count / (mean * mean), (error / sum).powi(2), 1.0 - count / pixels.len() as f64])
}

/// Measured against true color at one polar angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AngleError {
    /// Polar angle of light and eye, degrees.
    pub theta_deg: f64,
    /// CIEDE2000 of the smooth part: mean over azimuths of the eye from 15 degrees off the mirror direction on.
    pub mean: f64,
    /// The greatest.
    pub worst: f64,
}

/// Color of the smooth part, gloss left out, against the model, at 5, 10 ... 80 degrees.
pub fn color_errors(smooth: &SmoothFit, model: &Model) -> Vec<AngleError> {
    let lab = |f: DVec3| lab_from_rgb(f * PI);
    let at = |degrees: u32| {
        let theta = f64::from(degrees).to_radians();
        let wi = spherical(theta, 0.0);
        let errors: Vec<f64> = (0..=11)
            .map(|k| {
                let wo = spherical(theta, PI - (15.0 * f64::from(k)).to_radians());
                delta_e_2000(lab(seen_base(smooth, wi, wo)), lab(model.brdf_rgb(wi, wo)))
            })
            .collect();
        AngleError {
            theta_deg: f64::from(degrees),
            mean: errors.iter().sum::<f64>() / errors.len() as f64,
            worst: errors.iter().copied().fold(0.0, f64::max),
        }
    };
    (1..=16).map(|k| at(5 * k)).collect()
}

/// Measured against synthesized flakes of one slice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SliceError {
    /// Half-vector angle, degrees.
    pub theta_h_deg: f64,
    /// Angle between half vector and light, degrees.
    pub theta_i_deg: f64,
    /// Wasserstein-1 distance of the colors of the texels, CIE 1976.
    pub wasserstein: f64,
    /// The same between two synthesized slices of other seeds: what no measurement can be below.
    pub floor: f64,
    /// Standard deviation of the luminance over the synthesized one's; of a paint without flakes none.
    pub deviation_ratio: Option<f64>,
    /// Share of the light of all flakes that this slice holds, by the synthesized one's deviation; without flakes all slices alike.
    pub weight: f64,
}

/// Texels of a slice that are compared.
const COMPARED: usize = 600;

/// Compares every slice with one that is synthesized directly, at the same angles, texels and size.
///
/// # Errors
/// Those of the synthesis.
pub fn slice_errors(btf: &FlakeBtf, model: &Model, tick: &(dyn Fn() + Sync)) -> Result<Vec<SliceError>> {
    let truth = |seed: u64| {
        let options = SynthesisOptions {
            size: btf.size,
            texel_mm: Some(btf.texel_mm),
            seed,
            ..SynthesisOptions::new(btf.grid.clone())
        };
        synthesize(model, &options, &|| ())
    };
    let (one, two) = (truth(11)?, truth(12)?);
    let deviations: Vec<f64> = (0..btf.grid.len()).map(|k| deviation(&one, k)).collect::<Result<_>>()?;
    let total: f64 = deviations.iter().sum();
    (0..btf.grid.len()).into_par_iter().try_map(|k| {
        let colors = |source: &FlakeBtf| total_colors(source, model, k);
        let (found, one_colors, two_colors) = (colors(btf)?, colors(&one)?, colors(&two)?);
        let (theta_h, theta_i) = btf.grid.angles(k);
        let error = SliceError {
            theta_h_deg: theta_h.to_degrees(),
            theta_i_deg: theta_i.to_degrees(),
            wasserstein: wasserstein(&found, &one_colors),
            floor: wasserstein(&two_colors, &one_colors),
            deviation_ratio: (deviations[k] > 0.0).then_some(deviation(btf, k)? / deviations[k]),
            weight: if total > 0.0 { deviations[k] / total } else { 1.0 / deviations.len() as f64 },
        };
        tick();
        Ok(error)
    })
}

fn deviation(btf: &FlakeBtf, k: usize) -> Result<f64> {
    let slice = btf.slice(k)?;
    let count = slice.fluctuation.len() as f64;
    let light: Vec<f64> =
        slice.fluctuation.iter().map(|t| luminance(DVec3::from(t.map(f64::from)))).collect();
    let mean = light.iter().sum::<f64>() / count;
    Ok((light.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// Lab of the texels of a slice about the expectation of the model, evenly thinned.
fn total_colors(btf: &FlakeBtf, model: &Model, k: usize) -> Result<Vec<DVec3>> {
    let (theta_h, theta_i) = btf.grid.angles(k);
    let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
    let mean = model.brdf_rgb(wi, wo);
    let slice = btf.slice(k)?;
    let stride = slice.fluctuation.len().div_ceil(COMPARED).max(1);
    let texels = slice.fluctuation.iter().step_by(stride);
    Ok(texels.map(|t| lab_from_rgb((mean + DVec3::from(t.map(f64::from))) * PI)).collect())
}
