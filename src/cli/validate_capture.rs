//! `carpaint validate --capture`: a paint measured from pictures against the paint that was photographed.

use super::capture::{CaptureArguments, calibrated, say_pictures_left_out};
use super::{output, progress::begin};
use crate::dome::{Dome, MadeOf};
use crate::error::{Error, Result};
use crate::fit::FitOptions;
use crate::measure::calibrate::CalibrationErrors;
use crate::measure::{Calibrated, CaptureFolder, HighlightCheck, Images};
use crate::report::{
    AngleError, MeasuredPaint, RadianceError, SliceError, calibration_errors, color_errors, measure_paint,
    radiance_error, slice_errors,
};
use crate::simulate::Model;
use serde::Serialize;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Every so many pairs the light in their pictures is compared.
const STRIDE: usize = 17;

/// All that is compared.
#[derive(Serialize)]
struct Validation {
    calibration: CalibrationErrors,
    radiance: RadianceError,
    highlights: Vec<HighlightCheck>,
    fit: crate::fit::FitReport,
    colors: Vec<AngleError>,
    slices: crate::measure::SliceReport,
    slice_errors: Vec<SliceError>,
}

/// Measures the capture and prints what is found beside the truth.
pub fn validate_capture(
    model: &Model,
    folder: &Path,
    arguments: &CaptureArguments,
    fit: FitOptions,
    json: bool,
) -> Result<ExitCode> {
    let capture = CaptureFolder::open(folder)?;
    let MadeOf { truth, dome: options, composition: photographed } = MadeOf::read(folder)?;
    if photographed != json!(model.composition()) {
        let legal = "the composition that was photographed (truth.json)";
        return Err(Error::invalid(folder.display().to_string(), "composition", "another one", legal));
    }
    let dome = Dome::new(model, &options)?;
    let found = calibrated(&capture)?;
    let pairs = Calibrated::new(&capture, &found);
    let options = arguments.options(&capture, fit);
    let measured = measure_paint(&pairs, capture.rig().sample_mm, &options, begin)?;
    say_pictures_left_out(&measured, &pairs);
    let MeasuredPaint { smooth, btf, extraction, fit, slices } = measured;
    let validation = Validation {
        calibration: calibration_errors(&found, &truth, capture.rig()),
        radiance: radiance_error(&pairs, &dome, STRIDE),
        highlights: extraction.highlights,
        colors: color_errors(&smooth, model),
        slice_errors: slice_errors(&btf, model, &begin("comparing slices", btf.grid.len()))?,
        fit,
        slices,
    };
    if json {
        output::json(&validation)?
    } else {
        validation.print()
    }
    Ok(ExitCode::SUCCESS)
}

impl Validation {
    fn print(&self) {
        let c = &self.calibration;
        output::say!(
            "poses, rms of {} cameras: {:.3} mm, {:.4} degrees; the sample is seen {:.3} pixels off",
            c.cameras.len(),
            c.rms[0],
            c.rms[1],
            c.rms[2]
        );
        let r = &self.radiance;
        output::say!(
            "light in the pictures: single pixels {:.2} % off (rms, of the picture's mean), means {:.2} %; {:.2} % of the \
             pixels are not known",
            100.0 * r.rms,
            100.0 * r.of_means,
            100.0 * r.unknown
        );
        let found = self.highlights.iter().filter_map(|h| Some(h.distance_px? / h.radius_px));
        let (count, sum) = found.fold((0, 0.0), |(n, s), d| (n + 1, s + d));
        output::say!(
            "mirrored flashes: found in {count} of {} pictures that should show one, {:.3} of their radius off; {} too broad to place",
            self.highlights.len(),
            sum / f64::from(count.max(1)),
            self.highlights.iter().filter(|h| h.broad).count()
        );
        super::fit_output::print_report(&self.fit);
        output::say!("color of the smooth part against the model, both directions at theta:");
        output::say!("  theta   Delta-E 2000   worst azimuth");
        for a in &self.colors {
            output::say!("  {:5.0} {:14.2} {:15.2}", a.theta_deg, a.mean, a.worst);
        }
        self.print_slices();
    }

    fn print_slices(&self) {
        let s = &self.slices;
        output::say!(
            "slices: {} ({} cells unreached), {:.2} degrees from their pictures in the mean, {:.2} at most, scaled by {:.2} to {:.2}",
            s.slices,
            s.unreached,
            s.distance_deg[0],
            s.distance_deg[1],
            s.scale[0],
            s.scale[1]
        );
        let weighed = |f: &dyn Fn(&SliceError) -> f64| -> f64 {
            self.slice_errors.iter().map(|e| e.weight * f(e)).sum()
        };
        let flakes = self.slice_errors.iter().any(|e| e.deviation_ratio.is_some());
        let contrast = weighed(&|e| e.deviation_ratio.unwrap_or(0.0));
        output::say!(
            "flakes against those synthesized directly, weighed by their light: W1 {:.2} Delta-E (two syntheses: {:.2}), \
             standard deviation {}",
            weighed(&|e| e.wasserstein),
            weighed(&|e| e.floor),
            if flakes {
                format!("{contrast:.3} of the synthesized")
            } else {
                "of noise alone: no flakes".to_owned()
            }
        );
    }
}
