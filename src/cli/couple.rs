//! `carpaint couple`.

use super::budget::BudgetArguments;
use super::fit::StatisticsArguments;
use super::scene::SceneArguments;
use super::{output, progress::Bar};
use crate::btf::{self, BtfReader, FlakeSource};
use crate::error::{Error, Result};
use crate::file::{ContainerReader, check_output_apart};
use crate::fit::{FitOptions, Lifetime, fit_btf};
use crate::mix::{self, BlendOptions, CoupleOptions, CoupleReport, Mix, Path, add, couple};
use crate::paint::Paint;
use crate::render::{needed_of_blend, needed_of_paint};
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
#[command(mut_arg("error", |a| a.conflicts_with_all(["clusters", "solver"])))]
#[command(mut_arg("time", |a| a.conflicts_with_all(["clusters", "solver"])))]
#[command(mut_arg("shape", |a| a.requires("scene")), mut_arg("size", |a| a.requires("scene")))]
pub struct Arguments {
    /// Paints (.paint.exr) or flake BTFs (.btf.exr), in the order of the weights; the first may be a mix.
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
    #[command(flatten)]
    budget: BudgetArguments,
    #[command(flatten, next_help_heading = "Statistics of flake BTFs")]
    statistics: StatisticsArguments,
    #[command(flatten, next_help_heading = "Only what a picture of a scene needs")]
    scene: SceneArguments,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output_apart(&self.output, &self.paints)?;
        if self.budget.budget()?.is_some() {
            output::note!(
                "picked: couple --solver {}: exact, and the fastest; the rest is up to the clusters of the paints (fit --clusters)",
                Solver::default()
            );
        }
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
        let is_mix = ContainerReader::open(&self.paints[0])?.kind() == mix::KIND;
        if is_mix && self.orders {
            let place = self.paints[0].display().to_string();
            return Err(Error::invalid(place, "first file of --orders", "a mix", "a paint or flake BTF"));
        }
        let mut begun = is_mix.then(|| Mix::read(&self.paints[0])).transpose()?;
        let paints = self.paints[usize::from(is_mix)..].iter().map(|path| self.paint(path));
        let mut paints = paints.collect::<Result<Vec<_>>>()?;
        self.keep_needed(begun.as_mut(), &mut paints)?;
        let files = &self.paints[usize::from(is_mix)..];
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
        let done = done.map_err(|e| in_file(e, &named, files))?;
        if self.orders {
            let OrderDependence { orders, mean, largest, from_first } = order_dependence(&named, &options)?;
            output::note!(
                "{orders} other orders: at equal weights {mean:.2} Delta-E apart in the mean, {largest:.2} at most; {from_first:.1} from the first paint"
            );
        }
        Ok(done)
    }
}

impl Arguments {
    /// A paint, or that of a flake BTF, whose slices come from the file one at a time.
    fn paint(&self, path: &std::path::Path) -> Result<Paint> {
        if ContainerReader::open(path)?.kind() != btf::KIND {
            return Paint::read(path);
        }
        let source = BtfReader::open(path)?;
        let options = FitOptions { coat: Some(source.coat()), ..FitOptions::default() };
        let statistics = self.statistics.picked(&source, Lifetime::Solve, &self.budget)?;
        let bar = Bar::new("fitting", options.ticks() + source.grid().len());
        let (paint, _) = fit_btf(&source, &options, &statistics, &bar.tick())?;
        Ok(paint)
    }

    /// Leaves out what a picture of the scene does not need, if one is named: the first with flakes has the form of the mix.
    fn keep_needed(&self, begun: Option<&mut Mix>, paints: &mut [Paint]) -> Result<()> {
        let Some(scene) = self.scene.named()? else { return Ok(()) };
        let coats = begun.iter().flat_map(|m| m.constituents.iter().map(|c| c.coat));
        let coats: Vec<_> = coats.chain(paints.iter().map(|p| p.coat)).collect();
        if let Some(other) = coats.iter().find(|c| coats[0].refracts && c.ior != coats[0].ior) {
            let legal = format!("{}, that of the first: blends refract to angles of their own", coats[0].ior);
            return Err(Error::unsupported("--scene", "index of a refracting coat", other.ior, legal));
        }
        let options = self.scene.options();
        let cells = match begun {
            Some(mix) => {
                let weights: Vec<f64> =
                    (0..mix.constituents.len()).map(|k| f64::from(u8::from(k == 0))).collect();
                let cells = needed_of_blend(&scene, &options, mix, &weights, &BlendOptions::default())?;
                mix.flakes.iter_mut().zip(&cells).for_each(|(flakes, cells)| flakes.keep(cells));
                cells
            }
            None => match paints.iter_mut().find(|p| p.flakes.is_some()) {
                Some(paint) => {
                    let cells = needed_of_paint(&scene, &options, paint, None)?;
                    paint.flakes.iter_mut().zip(&cells).for_each(|(flakes, cells)| flakes.keep(cells));
                    cells
                }
                None => None,
            },
        };
        if let Some(cells) = cells {
            output::note!("for the scene {} of {} cells", cells.len(), cells.total());
        }
        Ok(())
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
