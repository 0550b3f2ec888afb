//! `carpaint couple`.

use super::{output, progress::Bar};
use crate::error::{Error, Result};
use crate::file::{Container, check_output};
use crate::mix::{self, CoupleOptions, CoupleReport, Mix, Path, add, couple};
use crate::paint::Paint;
use crate::report::{OrderDependence, order_dependence};
use crate::transport::{Cost, Solver};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Couple two to eight paints by optimal transport, so that they can be blended.
///
/// Paints with other angles, texels, levels or color tables are brought to the form of the first, and what that cost is
/// printed. If the first file is a mix, the others are added to it, with its path, cost and threshold.
#[derive(clap::Args)]
pub struct Arguments {
    /// Paints (.paint.exr), in the order of the weights; the first may be a mix.
    #[arg(required = true, num_args = 2..)]
    paints: Vec<PathBuf>,
    /// The mix to write (.paint.exr).
    #[arg(short, long)]
    output: PathBuf,
    /// The path that blends take unless asked otherwise: transport, hybrid or contrast.
    #[arg(long, value_name = "NAME", default_value_t)]
    path: Path,
    /// euclidean, squared or capped:T; by default what suits the path.
    #[arg(long, value_name = "NAME")]
    cost: Option<Cost>,
    /// Distance from which on `hybrid` lets flakes become fewer instead of dimmer, Delta-E.
    #[arg(long, value_name = "DELTA_E", default_value_t = Path::THRESHOLD)]
    threshold: f64,
    #[arg(long, value_name = "NAME", default_value_t, help = Solver::names())]
    solver: Solver,
    /// Also couple three to five paints in every other order, and print how far their blends at equal weights are apart.
    #[arg(long)]
    orders: bool,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output(&self.output)?;
        let (mix, report) = self.couple()?;
        mix.write(&self.output)?;
        if self.json {
            output::json(&report)?;
        } else {
            print(&report);
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }

    fn couple(&self) -> Result<(Mix, CoupleReport)> {
        let first = Container::read(&self.paints[0])?;
        let is_mix = first.meta.get("kind").is_some_and(|kind| kind == mix::KIND);
        let begun =
            is_mix.then(|| Mix::from_container(first)).transpose().map_err(|e| e.in_file(&self.paints[0]))?;
        let files = &self.paints[usize::from(is_mix)..];
        let paints = files.iter().map(|p| Paint::read(p)).collect::<Result<Vec<_>>>()?;
        let named: Vec<_> = files.iter().zip(&paints).map(|(p, q)| (output::stem(p), q)).collect();
        let rows = paints[0].flakes.as_ref().map_or(0, |f| f.levels.len() * f.grid.len());
        let added = if is_mix { paints.len() } else { paints.len() - 1 };
        let bar = Bar::new("coupling", rows * added);
        let Self { path, cost, threshold, solver, .. } = *self;
        let options = CoupleOptions { path, cost, threshold, solver };
        let done = match begun {
            Some(mix) => add(&mix, &named, solver, &bar.tick()),
            None => couple(&named, &options, &bar.tick()),
        };
        drop(bar);
        if self.orders {
            let OrderDependence { orders, mean, largest, from_first } = order_dependence(&named, &options)?;
            output::say!(
                "{orders} other orders: at equal weights {mean:.2} Delta-E apart in the mean, {largest:.2} at most; {from_first:.1} from the first paint"
            );
        }
        done.map_err(|e| in_file(e, &named, files))
    }
}

fn print(report: &CoupleReport) {
    output::say!(
        "{} transport problems, {} arcs, worst gap {:.1e} of max(cost, 1e-3 mean edge), mean cost {:.2}",
        report.problems,
        report.arcs,
        report.worst_relative_gap,
        report.mean_distance
    );
    for form in &report.common_form {
        if form.without_flakes {
            output::say!("{}: has no flakes", form.paint);
        }
        output::say!(
            "{}: brought to the form of the first: angles moved by up to {:.2} degrees, texels {:.3} times the size after {} levels, color table off by up to {:.2} Delta-E",
            form.paint,
            form.angle_moved_deg,
            form.texel_ratio,
            form.levels_shifted,
            form.color_table_error
        );
    }
}

/// The error with the path of the paint that it names.
fn in_file(error: Error, named: &[(String, &Paint)], files: &[PathBuf]) -> Error {
    let (Error::Invalid(fault) | Error::Unsupported(fault) | Error::NotConverged(fault)) = &error else {
        return error;
    };
    let name = fault.place.split(": ").next().unwrap_or_default();
    match named.iter().rposition(|(n, _)| n == name) {
        Some(k) => error.in_file(&files[k]),
        None => error,
    }
}
