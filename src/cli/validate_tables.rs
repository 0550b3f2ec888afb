//! The tables that `carpaint validate` prints instead of its stages.

use super::drawing;
use super::{output, progress::begin};
use crate::error::Result;
use crate::file::{check_output, write_text};
use crate::fit::SmoothFit;
use crate::report::{
    Chain, ChainOptions, CurvePoint, Curves, Interpolation, LobeError, PhysicalChange, SolverError,
    coherence, curve_ticks, curves, energetic_slices, interpolation_table, reconstruction_table, run_chain,
};
use crate::simulate::Composition;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// What is measured, and how it is printed.
pub struct Tables<'a> {
    pub composition: &'a Composition,
    pub options: ChainOptions,
    pub json: bool,
}

impl Tables<'_> {
    fn chain(&self) -> Result<Chain> {
        run_chain("paint", self.composition, &self.options, begin)
    }

    pub fn reconstruction(&self) -> Result<ExitCode> {
        let Chain { btf, paint, .. } = self.chain()?;
        let tick = begin("comparing", 4 * energetic_slices(&btf).len());
        let table = reconstruction_table(&btf, &SmoothFit::from(&paint), &tick)?;
        drop(tick);
        if self.json {
            output::json(&table)?;
            return Ok(ExitCode::SUCCESS);
        }
        output::say!(
            "slice  theta_h theta_i  boxes           sampler       W1 (floor), Delta-E  mean error  std ratio  q99.9 ratio"
        );
        for row in &table {
            let e = &row.error;
            output::say!(
                "{:>5}  {:7.1} {:7.1}  {:<14}  {:<11}  {:7.2} ({:6.2})      {:10.2e}  {:9.4}  {:11.4}",
                row.slice,
                row.theta_h_deg,
                row.theta_i_deg,
                format!("{:?}", row.boxes),
                format!("{:?}", row.sampler),
                e.wasserstein,
                e.wasserstein_floor,
                e.mean_error(),
                e.std_ratio(),
                e.quantile_ratio()
            );
        }
        Ok(ExitCode::SUCCESS)
    }

    pub fn coherence(&self) -> Result<ExitCode> {
        match coherence(&self.chain()?, &self.options, &begin("comparing", 4))? {
            found if self.json => output::json(&found)?,
            Some(found) => output::print(format_args!("{found}")),
            None => output::say!("no flakes"),
        }
        Ok(ExitCode::SUCCESS)
    }

    pub fn interpolation(&self) -> Result<ExitCode> {
        let tick = begin("comparing", PhysicalChange::ALL.len());
        let table = interpolation_table(self.composition, &self.options, &tick)?;
        drop(tick);
        if self.json {
            output::json(&table)?;
            return Ok(ExitCode::SUCCESS);
        }
        output::say!(
            "change             method               W1, Delta-E  |ln std|  |ln q99.9|  coherence  smooth, Delta-E"
        );
        for row in &table.methods {
            let Interpolation { change, method, wasserstein, deviation, quantile, coherence, smooth } = row;
            output::say!(
                "{change:<18} {method:<20} {wasserstein:11.2} {deviation:9.3} {quantile:11.3} {coherence:10.3} {smooth:16.2}"
            );
        }
        output::say!("\nchange             weight  lobes    smooth, Delta-E");
        for LobeError { change, way, lobes, smooth } in &table.lobes {
            output::say!("{change:<18} {way:6.2}  {lobes:<8} {smooth:15.2}");
        }
        Ok(ExitCode::SUCCESS)
    }

    /// `svg`: where the curves are drawn, if anywhere. Nothing is drawn of a paint without flakes.
    pub fn curves(&self, svg: Option<&Path>) -> Result<ExitCode> {
        if let Some(path) = svg {
            output::require_suffix("--svg", path, ".svg")?;
            check_output(path)?;
        }
        let start = Instant::now();
        let found = curves(&self.chain()?, &self.options, &begin("comparing", curve_ticks()))?;
        if let (Some(path), Some(found)) = (svg, &found) {
            write_text(path, &drawing::curves(&self.composition.title, found))?;
            output::wrote(path, start)?;
        }
        match found {
            found if self.json => output::json(&found)?,
            Some(found) => print_curves(&found),
            None => output::say!("no flakes"),
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn print_curves(curves: &Curves) {
    for (axis, points) in curves.along() {
        output::say!("{axis:<8}  W1, Delta-E   +-   |ln std|  |ln q99.9|  bytes a slice");
        for point in points {
            let CurvePoint { setting, wasserstein, wasserstein_noise, deviation, quantile, bytes } = point;
            let place = axis.label(setting);
            output::say!(
                "{place:>8}  {wasserstein:11.3} {wasserstein_noise:6.3} {deviation:8.4}  {quantile:10.4}  {bytes:13.0}"
            );
        }
        output::say!("");
    }
    output::say!("solver                     cost error  marginal error  ms a pair");
    for SolverError { solver, cost_error, marginal_error, milliseconds } in &curves.solvers {
        output::say!("{solver:<25}  {cost_error:10.1e}  {marginal_error:14.1e}  {milliseconds:9.3}");
    }
}
