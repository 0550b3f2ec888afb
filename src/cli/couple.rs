//! `carpaint couple`.

use super::{output, progress::Bar};
use crate::error::{Error, Result};
use crate::file::check_output;
use crate::mix::couple;
use crate::paint::Paint;
use crate::transport::Solver;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Couple two to eight paints by optimal transport, so that they can be blended.
#[derive(clap::Args)]
pub struct Arguments {
    /// Paints (.paint.exr), in the order of the weights.
    #[arg(required = true, num_args = 2..)]
    paints: Vec<PathBuf>,
    /// The mix to write (.paint.exr).
    #[arg(short, long)]
    output: PathBuf,
    /// network-simplex, good-lp:microlp or good-lp:minilp (its old name).
    #[arg(long, value_name = "NAME", default_value_t)]
    solver: Solver,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output(&self.output)?;
        let paints = self.paints.iter().map(|p| Paint::read(p)).collect::<Result<Vec<_>>>()?;
        let named: Vec<_> = self.paints.iter().zip(&paints).map(|(p, q)| (output::stem(p), q)).collect();
        let rows = paints[0].flakes.as_ref().map_or(0, |f| f.levels.len() * f.grid.len());
        let bar = Bar::new("coupling", rows);
        let (mix, report) = couple(&named, self.solver, &bar.tick()).map_err(|e| self.in_file(e, &named))?;
        drop(bar);
        mix.write(&self.output)?;
        if self.json {
            output::json(&report)?;
        } else {
            output::say!(
                "{} transport problems, {} arcs, worst gap {:.1e} of max(cost, 1e-3 mean edge), mean distance {:.2} Delta-E",
                report.problems,
                report.arcs,
                report.worst_relative_gap,
                report.mean_distance
            );
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }
    /// The error with the path of the paint that it names.
    fn in_file(&self, error: Error, named: &[(String, &Paint)]) -> Error {
        let (Error::Invalid(fault) | Error::Unsupported(fault) | Error::NotConverged(fault)) = &error else {
            return error;
        };
        let name = fault.place.split(": ").next().unwrap_or_default();
        match named.iter().rposition(|(n, _)| n == name) {
            Some(k) => error.in_file(&self.paints[k]),
            None => error,
        }
    }
}
