//! `carpaint simulate`.

use super::{output, progress::Bar, synthesis::SynthesisArguments};
use crate::error::{Error, Result};
use crate::file::check_output;
use crate::simulate::{Composition, synthesize};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Synthesize a flake BTF and its smooth BRDF from a paint composition.
///
/// To couple two paints later, simulate both with the same --texel-um, --bins and --size: left to itself, the texel follows
/// the flakes, and differs from paint to paint.
#[derive(clap::Args)]
pub struct Arguments {
    /// The paint's recipe (TOML; see fixtures/compositions).
    composition: PathBuf,
    /// The flake BTF to write, NAME.btf.exr.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    synthesis: SynthesisArguments,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    seed: u32,
    /// Print the summary as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output(&self.output)?;
        let composition = Composition::read(&self.composition)?;
        let options = self.synthesis.options(self.seed)?;
        let bar = Bar::new("flakes", options.grid.len());
        let btf = synthesize(&composition, &options, &bar.tick())?;
        drop(bar);
        btf.write(&self.output)?;
        let bytes = std::fs::metadata(&self.output).map_err(|e| Error::io(&self.output, e))?.len();
        let summary = serde_json::json!({
            "output": self.output,
            "slices": btf.grid.len(),
            "size": btf.size,
            "texel_um": btf.texel_mm * 1e3,
            "flakes": btf.provenance["flakes"],
            "check": btf.provenance["check"],
            "bytes": bytes,
            "seconds": start.elapsed().as_secs_f64(),
        });
        if self.json {
            output::say!("{summary:#}");
        } else {
            print_summary(&summary);
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn print_summary(summary: &serde_json::Value) {
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or(f64::NAN);
    let [columns, rows] = [0, 1].map(|k| number(&summary["size"][k]));
    output::say!(
        "{}: {} slices of {columns} x {rows} texels of {:.2} um, {:.1} MB, {:.2} s",
        summary["output"].as_str().unwrap_or_default(),
        summary["slices"],
        number(&summary["texel_um"]),
        number(&summary["bytes"]) * 1e-6,
        number(&summary["seconds"]),
    );
    output::say!("flakes of each kind: {}", summary["flakes"]);
    let check = &summary["check"];
    output::say!(
        "slice means against the model: rms z {:.2}, largest {:.2}, over {} slices",
        number(&check["rms_z"]),
        number(&check["max_abs_z"]),
        check["slices"],
    );
}
