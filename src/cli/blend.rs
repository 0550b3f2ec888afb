//! `carpaint blend`.

use super::output;
use crate::error::Result;
use crate::file::check_output;
use crate::mix::Mix;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// The paint that coupled paints give at these weights; weights outside [0, 1] extrapolate.
#[derive(clap::Args)]
pub struct Arguments {
    /// The mix (.paint.exr, from `couple`).
    mix: PathBuf,
    /// One weight a paint, separated by commas, summing to 1.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, required = true)]
    weights: Vec<f64>,
    /// The paint to write (.paint.exr).
    #[arg(short, long)]
    output: PathBuf,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output(&self.output)?;
        let mix = Mix::read(&self.mix)?;
        mix.blend(&self.weights)?.write(&self.output)?;
        if self.weights.iter().any(|w| !(0.0..=1.0).contains(w)) {
            let mass = 100.0 * mix.inverted_mass(&self.weights)?;
            output::say!("extrapolated: boxes of {mass:.1} % of the flakes are kept from turning inside out");
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }
}
