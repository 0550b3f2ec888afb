//! `carpaint calibrate`.

use super::{capture, output};
use crate::error::Result;
use crate::file::{check_output, write_text};
use crate::measure::calibrate::Calibration;
use crate::measure::{CaptureFolder, Images};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Calibrate a camera dome: places and lenses from pictures of diodes, response curves and noise from gray fields.
///
/// Rump et al. 2008, sections 4.1 to 4.3. The result lies in the capture folder, where `fit` finds it. Cameras that cannot be
/// calibrated are left out and named; a virtual capture is compared with its truth.
#[derive(clap::Args)]
pub struct Arguments {
    /// The capture folder (see `measure`).
    capture: PathBuf,
    /// Where the calibration goes [default: calibration.json in the capture folder].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Print the calibration as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        let folder = CaptureFolder::open(&self.capture)?;
        let path = self.output.clone().unwrap_or_else(|| capture::calibration_path(&folder));
        check_output(&path)?;
        let calibration = capture::calibrate_now(&folder)?;
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
