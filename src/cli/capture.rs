//! Captures, opened alike by every command that takes one.

use super::output;
use super::progress::{Bar, begin};
use crate::dome::{MadeOf, truth_path};
use crate::error::{Error, Result};
use crate::file::{read_text, write_text};
use crate::fit::FitOptions;
use crate::measure::calibrate::{Calibration, calibrate};
use crate::measure::highlight::misplaced;
use crate::measure::{Calibrated, CaptureFolder, HighlightCheck, Images, SamplingOptions};
use crate::report::{CaptureOptions, MeasuredPaint, calibration_errors, measure_paint};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// So many pictures that are left out are named.
const NAMED: usize = 20;

/// Longest calibration: a thousand cameras with their curves are some ten megabytes.
const MAX_BYTES: u64 = 1 << 28;

/// How pictures become samples and slices.
#[derive(clap::Args)]
#[command(next_help_heading = "Captures")]
pub struct CaptureArguments {
    /// Samples for diffuse and glitter.
    #[arg(long, default_value_t = SamplingOptions::default().samples)]
    samples: usize,
    /// Sides of the patches whose means are samples, near the mirror direction and far from it, as shares of the sample's width
    /// [default: 0.06,0.1].
    #[arg(long, value_name = "NEAR,FAR", value_parser = patch)]
    patch: Option<[f64; 2]>,
    /// Angle bins per 90 degrees of the slices cut from pictures.
    #[arg(long, default_value_t = 12)]
    slice_bins: usize,
    /// Side of a texel of these slices, micrometers [default: that of a pixel seen from straight above].
    #[arg(long, allow_negative_numbers = true)]
    slice_texel_um: Option<f64>,
}

fn patch(text: &str) -> std::result::Result<[f64; 2], String> {
    let sides: Option<Vec<f64>> = text.split(',').map(|side| side.trim().parse().ok()).collect();
    sides.and_then(|sides| sides.try_into().ok()).ok_or_else(|| "two numbers, as 0.06,0.1".to_owned())
}

impl CaptureArguments {
    /// What the library is asked for.
    pub fn options(&self, images: &dyn Images, fit: FitOptions) -> CaptureOptions {
        let mut options = CaptureOptions::new(images.rig(), fit);
        options.sampling.samples = self.samples;
        options.sampling.patch = self.patch.unwrap_or(options.sampling.patch);
        options.slices.bins = self.slice_bins;
        options.slices.texel_mm = self.slice_texel_um.map_or(options.slices.texel_mm, |um| um * 1e-3);
        options
    }
}

/// Measures the paint of a capture folder, warnings said.
pub fn measure_capture(path: &Path, arguments: &CaptureArguments, fit: FitOptions) -> Result<MeasuredPaint> {
    let capture = CaptureFolder::open(path)?;
    let calibration = calibrated(&capture)?;
    let pairs = Calibrated::new(&capture, &calibration);
    let options = arguments.options(&capture, fit);
    let found = measure_paint(&pairs, capture.rig().sample_mm, &options, begin)?;
    say_pictures_left_out(&found, &pairs);
    check_highlights(&found.extraction.highlights)?;
    Ok(found)
}

/// Says where mirrored flashes are not found in their places, and refuses a calibration that puts most of them elsewhere.
fn check_highlights(checks: &[HighlightCheck]) -> Result<()> {
    let off = misplaced(checks);
    let say = |check: &HighlightCheck| {
        let HighlightCheck { camera, light, radius_px, .. } = check;
        let distance = check.distance_px.unwrap_or_default();
        format!(
            "camera {camera} sees flash {light} mirrored {distance:.1} pixels from its place, it reaches {radius_px:.1}"
        )
    };
    off.iter().for_each(|check| output::note!("warning: left out of the gloss: {}", say(check)));
    let placed = checks.iter().filter(|check| check.distance_px.is_some()).count();
    match off.first() {
        Some(first) if off.len() > 1 && 2 * off.len() > placed => Err(Error::invalid(
            "calibration",
            "mirrored flashes",
            format!("{} of {placed} elsewhere, as {}", off.len(), say(first)),
            "most in their places: are flashes swapped, is their offset_mm (capture.json) right?",
        )),
        _ => Ok(()),
    }
}

/// Says which pictures and exposures were left out, each once.
pub fn say_pictures_left_out(found: &MeasuredPaint, pairs: &Calibrated<'_>) {
    let pictures = found.extraction.left_out.iter().chain(&found.slices.left_out).cloned();
    let all: BTreeSet<String> = pictures.chain(pairs.warnings()).collect();
    all.iter().take(NAMED).for_each(|why| output::note!("warning: left out: {why}"));
    if all.len() > NAMED {
        output::note!("warning: left out: {} more pictures", all.len() - NAMED);
    }
    let blemishes = &found.extraction.blemishes;
    if !blemishes.places_mm.is_empty() {
        output::note!(
            "warning: the panel differs from itself in {} cells of {:.1} mm, as at {:.1?} mm (a scratch?): {} samples left out",
            blemishes.places_mm.len(),
            2.0 * blemishes.half_mm,
            blemishes.places_mm[0],
            found.extraction.blemished
        );
    }
}

/// Where the calibration of a capture is kept.
pub fn calibration_path(capture: &CaptureFolder) -> PathBuf {
    capture.path().join("calibration.json")
}

/// The calibration of a capture: the one it holds, or a new one, which it then holds. What is left out is said.
pub fn calibrated(capture: &CaptureFolder) -> Result<Calibration> {
    let path = calibration_path(capture);
    if path.exists() {
        let text = read_text(&path, MAX_BYTES)?;
        let found = Calibration::from_json(&text).map_err(|e| e.in_file(&path))?;
        found.check_rig(capture.rig()).map_err(|e| e.in_file(&path))?;
        say_left_out(&found);
        return Ok(found);
    }
    let found = calibrate_now(capture)?;
    write_text(&path, &found.to_json())?;
    Ok(found)
}

/// A new calibration.
pub fn calibrate_now(capture: &CaptureFolder) -> Result<Calibration> {
    let bar = Bar::new("calibrating", Calibration::ticks(capture.rig()));
    let mut found = calibrate(capture, &bar.tick())?;
    drop(bar);
    let bar = Bar::new("comparing pictures", Calibration::looks(capture.rig()));
    found.leave_out_exchanged(capture, &bar.tick())?;
    drop(bar);
    say_left_out(&found);
    Ok(found)
}

fn say_left_out(calibration: &Calibration) {
    for left in &calibration.geometry.left_out {
        output::note!("warning: camera {} is left out: {}", left.camera, left.reason);
    }
    for (camera, response) in calibration.responses.iter().enumerate() {
        if let Some((response, first)) = response.as_ref().and_then(|r| r.unread.first().map(|why| (r, why)))
        {
            let count = response.unread.len();
            output::note!("warning: camera {camera}: gray fields left out: {count}, as {first}");
        }
    }
}

/// Prints how far a calibration is from the truth, if the capture is a virtual one.
pub fn print_errors(calibration: &Calibration, capture: &CaptureFolder) -> Result<()> {
    if !truth_path(capture.path()).exists() {
        return Ok(());
    }
    let MadeOf { truth, .. } = MadeOf::read(capture.path())?;
    let errors = calibration_errors(calibration, &truth, capture.rig());
    output::say!(
        "against the truth (rms of {} cameras): position {:.3} mm, orientation {:.4} degrees, sample {:.3} pixels; focal \
         length without zoom {:+.3} %",
        errors.cameras.len(),
        errors.rms[0],
        errors.rms[1],
        errors.rms[2],
        100.0 * errors.wide_focal
    );
    Ok(())
}
