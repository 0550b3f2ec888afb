//! `carpaint measure`.

use super::{model::ModelArguments, output, progress::Bar};
use crate::dome::{Dome, DomeOptions};
use crate::error::Result;
use crate::file::read_text;
use crate::simulate::{Composition, Model};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Longest `DOME.toml`.
const MAX_BYTES: u64 = 1 << 20;

/// Photograph a simulated panel in a virtual camera dome: many cameras, each with its flash.
///
/// Writes a capture folder: `capture.json`, one OpenEXR file a picture (diodes and gray fields for calibration, every pair of
/// camera and flash at every exposure), and `truth.json`, with which a calibration can be compared. An interrupted run goes on
/// where it was when it is started again.
#[derive(clap::Args)]
pub struct Arguments {
    /// The paint's recipe (TOML; see fixtures/compositions).
    composition: PathBuf,
    /// The dome (TOML; see fixtures/domes) [default: 21 cameras, pictures of 256 x 256].
    #[arg(long, value_name = "DOME.toml")]
    dome: Option<PathBuf>,
    /// The capture folder to write, or to go on with.
    #[arg(short, long)]
    output: PathBuf,
    /// Factor on the noise of sensors and flashes, instead of the dome's.
    #[arg(long, allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Seed of all random numbers, instead of the dome's.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    model: ModelArguments,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        let options = self.options()?;
        let composition = Composition::read(&self.composition)?;
        let model =
            Model::new(&composition, self.model.options()).map_err(|e| e.in_file(&self.composition))?;
        let dome = Dome::new(&model, &options)?;
        let bar = Bar::new("taking pictures", dome.ticks());
        let written = dome.write(&self.output, &bar.tick())?;
        drop(bar);
        output::note!(
            "wrote {} pictures to {}, {} were there, in {:.1} s",
            written.pictures,
            self.output.display(),
            written.kept,
            start.elapsed().as_secs_f64()
        );
        Ok(ExitCode::SUCCESS)
    }

    fn options(&self) -> Result<DomeOptions> {
        let mut options = match &self.dome {
            Some(path) => DomeOptions::parse(&read_text(path, MAX_BYTES)?).map_err(|e| e.in_file(path))?,
            None => DomeOptions::default(),
        };
        options.noise = self.noise.unwrap_or(options.noise);
        options.seed = self.seed.unwrap_or(options.seed);
        options.validate()?;
        Ok(options)
    }
}
