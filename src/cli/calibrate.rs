//! `carpaint calibrate`.

use super::overlay::write_overlay;
use super::{capture, output};
use crate::error::{Error, Result};
use crate::file::{check_output, check_output_apart, check_output_folder, write_text};
use crate::measure::calibrate::Calibration;
use crate::measure::{CaptureFolder, Images};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Calibrate a camera dome: places and lenses from pictures of diodes, response curves and noise from gray fields.
///
/// Rump et al. 2008, sections 4.1 to 4.3. The result lies in the capture folder, where `fit` finds it. Cameras that cannot be
/// calibrated, or that the pictures of the sample contradict, are left out and named; a virtual capture is compared with its truth.
#[derive(clap::Args)]
pub struct Arguments {
    /// The capture folder (see `measure`).
    capture: PathBuf,
    /// Where the calibration goes [default: calibration.json in the capture folder].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Draw the check of figure 7 (PNG): pictures with a mirrored flash, where it should be in red, where it is in green.
    #[arg(long, value_name = "OUT.png")]
    overlay: Option<PathBuf>,
    /// Draw only this camera under the flash of that one.
    #[arg(long, value_name = "CAMERA,LIGHT", value_parser = pair, requires = "overlay")]
    pair: Option<[usize; 2]>,
    /// Write the response curve of every camera into this folder, as `render --tone-map camera:CURVE` reads it.
    #[arg(long, value_name = "DIR")]
    curves: Option<PathBuf>,
    /// Print the calibration as JSON.
    #[arg(long)]
    json: bool,
}

fn pair(text: &str) -> std::result::Result<[usize; 2], String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "two numbers, as 3,5".to_owned())
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        let folder = CaptureFolder::open(&self.capture)?;
        let path = self.output.clone().unwrap_or_else(|| capture::calibration_path(&folder));
        check_output(&path)?;
        if let Some(overlay) = &self.overlay {
            output::require_suffix("--overlay", overlay, ".png")?;
            check_output_apart(overlay, std::slice::from_ref(&path))?;
        }
        self.curves.as_deref().map_or(Ok(()), check_output_folder)?;
        let calibration = capture::calibrate_now(&folder)?;
        if let Some(overlay) = &self.overlay {
            write_overlay(overlay, &folder, &calibration, self.pair)?;
        }
        if let Some(curves) = &self.curves {
            write_curves(curves, &calibration)?;
        }
        write_text(&path, &calibration.to_json())?;
        if self.json {
            output::json(&calibration)?;
        } else {
            print_table(&calibration, folder.rig().cameras.len());
            capture::print_errors(&calibration, &folder)?;
        }
        output::wrote(&path, start)?;
        Ok(ExitCode::SUCCESS)
    }
}

/// One text file a camera.
fn write_curves(folder: &Path, calibration: &Calibration) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    for (camera, response) in calibration.responses.iter().enumerate() {
        if let Some(response) = response {
            write_text(&folder.join(format!("c{camera:03}.txt")), &response.curve()?.to_text())?;
        }
    }
    Ok(())
}

fn print_table(calibration: &Calibration, cameras: usize) {
    output::say!("camera  diodes     rms, pixels    expected error");
    output::say!("        wide zoom  wide   zoom        mm  degrees  focal, pixels");
    for (k, quality) in calibration.geometry.quality.iter().enumerate() {
        if let Some(q) = quality {
            output::say!(
                "{k:6}  {:4} {:4} {:6.3} {:6.3} {:9.4} {:8.5} {:8.3}",
                q.diodes[0],
                q.diodes[1],
                q.rms_px[0],
                q.rms_px[1],
                q.position_error_mm,
                q.rotation_error_deg,
                q.focal_error_px
            );
        }
    }
    let found = calibration.geometry.cameras.iter().flatten().count();
    output::say!("{found} of {cameras} cameras calibrated");
}
