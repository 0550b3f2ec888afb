//! `carpaint fit`.

use super::budget::{BudgetArguments, picked};
use super::capture::{CaptureArguments, measure_capture};
use super::drawing::fit_plot;
use super::fit_ink::{self, InkArguments, ink_of_spectra, paint_of_ink, print_ink};
use super::fit_output::print_report;
use super::{output, progress::Bar, synthesis::SynthesisArguments};
use crate::brdf::merl::known_merl;
use crate::brdf::{ClearCoat, Ink, Measured};
use crate::btf::{AxfFolder, BtfReader, FlakeBtf, FlakeSource};
use crate::cluster::BoxRule;
use crate::error::{Error, Result};
use crate::file::{check_output_apart, write_text};
use crate::fit::{
    FitOptions, FitReport, FlakeOptions, Lifetime, Optimizer, SliceMean, SmoothFit, compare, compare_samples,
    fit_btf, fit_flakes, fit_measured, fit_smooth,
};
use crate::paint::Paint;
use crate::simulate::{Composition, Model, ModelOptions, synthesize};
use crate::tradeoff::{pick_clusters, pick_starts};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Spacing of the knots of usual flakes: the presets have 0.08 to 0.1.
const USUAL_SPACING: f64 = 0.09;
/// Most cells of a table that are drawn.
const DRAWN: usize = 3000;
/// Random starts, and their seed, unless others are asked for.
const STARTS: usize = 8;
const SEED: u32 = 1;

/// Fit a paint to a measurement, to a flake BTF (.btf.exr) or to a capture folder; or an ink to spectra.
///
/// Measurements: tables (.mbsdf, .f32), MERL (.binary) and RGL (.bsdf) files, half-angle tables of Guenther et al. 2005, readings of
/// multi-angle instruments (.csv). Diffuse and Cook-Torrance lobes are fitted to the intensity, the scaled colors become the color
/// table (Rump et al. 2008). A flake BTF, a folder of EXR slices with a JSON of AxF's properties, and a capture also give the paint
/// its flakes; a measurement can be given those of a composition. A capture (see `measure`) is calibrated first, unless it was.
///
/// With an output NAME.ink.json spectra (.csv) become a goniochromatic ink (Pranovich et al. 2024): roughness, and reflectance and
/// growth with the angle at each wavelength. Such an ink as the input becomes a paint.
#[derive(clap::Args)]
#[command(mut_arg("bins", |a| a.requires("flakes")), mut_arg("size", |a| a.requires("flakes")))]
#[command(mut_arg("texel_um", |a| a.requires("flakes")))]
#[command(mut_arg("error", |a| a.conflicts_with_all(["starts", "clusters"])))]
#[command(mut_arg("time", |a| a.conflicts_with_all(["starts", "clusters"])))]
pub struct Arguments {
    /// A measurement, a flake BTF, a capture folder or an ink (.ink.json).
    input: PathBuf,
    /// The paint (.paint.exr) or the ink (.ink.json) to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Refuse a MERL file whose SHA-256 is not in this list (lines `hash length name`).
    #[arg(long, value_name = "LIST")]
    sha256: Option<PathBuf>,
    /// Give a measured table the flakes of this composition (TOML); the table's mean is kept.
    #[arg(long, value_name = "COMPOSITION")]
    flakes: Option<PathBuf>,
    /// Metallic lobes: 1 to 3, or `auto`: as many as an information criterion finds worth their parameters.
    #[arg(long, value_parser = lobes, default_value = Lobes::DEFAULT)]
    lobes: Lobes,
    /// What lowers the error.
    #[arg(long, value_enum, default_value_t)]
    optimizer: OptimizerName,
    /// A table lies under an ideal clear coat of this index (and holds no gloss peak); without it the gloss is fitted. A capture
    /// lies under a coat of this index, whose gloss is fitted in any case.
    #[arg(long, allow_negative_numbers = true)]
    ior: Option<f64>,
    /// Let the coat refract, flakes of a capture beneath it, too; needs --ior, and of a table no --flakes. The errors without
    /// refraction are printed, too.
    #[arg(long, requires = "ior", conflicts_with = "flakes")]
    refract: bool,
    #[command(flatten)]
    statistics: StatisticsArguments,
    #[command(flatten)]
    budget: BudgetArguments,
    /// Random starts of the optimizer.
    #[arg(long, default_value_t = STARTS)]
    starts: usize,
    /// Seed of the starts and of synthesized flakes.
    #[arg(long, default_value_t = SEED, allow_negative_numbers = true)]
    seed: u32,
    /// Draw a table and its fit over the angle of the half vector, too.
    #[arg(long, value_name = "OUT.svg")]
    svg: Option<PathBuf>,
    /// Keep the flake slices of a capture, too (.btf.exr).
    #[arg(long, value_name = "OUT.btf.exr")]
    btf: Option<PathBuf>,
    #[command(flatten)]
    capture: CaptureArguments,
    #[command(flatten, next_help_heading = "Inks (with an output .ink.json)")]
    ink: InkArguments,
    /// Print the report as JSON.
    #[arg(long, help_heading = None)]
    json: bool,
    #[command(flatten, next_help_heading = "Flakes of a composition (with --flakes)")]
    synthesis: SynthesisArguments,
}

/// A number of lobes, or the choice of it.
#[derive(Clone, Copy)]
enum Lobes {
    Fixed(usize),
    Auto,
}

impl Lobes {
    const DEFAULT: &str = "3";
}

fn lobes(text: &str) -> std::result::Result<Lobes, String> {
    match text {
        "auto" => Ok(Lobes::Auto),
        _ => text.parse().map(Lobes::Fixed).map_err(|_| "1 to 3, or auto".to_owned()),
    }
}

#[derive(Clone, Copy, PartialEq, Default, clap::ValueEnum)]
enum OptimizerName {
    /// Quasi-Newton, symmetric updates of rank one.
    Sr1,
    /// Least squares in a box.
    #[default]
    LevenbergMarquardt,
    /// Least squares with reflections at the bounds.
    TrustRegionReflective,
}

/// How flake slices become statistics.
#[derive(clap::Args)]
pub struct StatisticsArguments {
    /// Clusters a slice.
    #[arg(long, default_value_t = 50)]
    clusters: usize,
    /// Boxes around clusters.
    #[arg(long, value_enum, default_value = "moment-matched")]
    boxes: Boxes,
    /// Steps of the inverse CDF table written for engines.
    #[arg(long, default_value_t = 500)]
    steps: usize,
    /// How flakes go out as the half vector turns: `solve` as the source's do, `endless` not at all, or the spacing of the
    /// knots of their random numbers, about a lobe's width in radians (1e-4 to 10) [default: solve; for captures 0.09].
    #[arg(long, value_parser = lifetime)]
    lifetime: Option<Lifetime>,
}

fn lifetime(text: &str) -> std::result::Result<Lifetime, String> {
    match text {
        "solve" => Ok(Lifetime::Solve),
        "endless" => Ok(Lifetime::Endless),
        _ => text.parse().map(Lifetime::Fixed).map_err(|_| "solve, endless or a number".to_owned()),
    }
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Boxes {
    /// Mean and variance of the cluster's members.
    MomentMatched,
    /// The members' bounding box (Golla & Klein).
    Bounding,
}

impl StatisticsArguments {
    /// As the library takes them, with this lifetime unless one is asked for.
    pub fn options(&self, lifetime: Lifetime) -> FlakeOptions {
        FlakeOptions {
            clusters: self.clusters,
            boxes: match self.boxes {
                Boxes::MomentMatched => BoxRule::MomentMatched,
                Boxes::Bounding => BoxRule::Bounding,
            },
            inverse_cdf_steps: self.steps,
            lifetime: self.lifetime.unwrap_or(lifetime),
            ..FlakeOptions::default()
        }
    }
}

impl StatisticsArguments {
    /// The same, with as many clusters as the budget asks for, if there is one.
    pub fn picked(
        &self,
        source: &dyn FlakeSource,
        lifetime: Lifetime,
        budget: &BudgetArguments,
    ) -> Result<FlakeOptions> {
        let mut options = self.options(lifetime);
        if let Some(budget) = budget.budget()? {
            options.clusters = picked("statistics", pick_clusters(source, options.boxes, budget)?);
        }
        Ok(options)
    }
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output_apart(&self.output, std::slice::from_ref(&self.input))?;
        self.budget.budget()?;
        if fit_ink::is_ink(&self.output) {
            return self.run_ink(start);
        }
        self.check_ink_options()?;
        if let Some(path) = &self.svg {
            output::require_suffix("--svg", path, ".svg")?;
            check_output_apart(path, &[self.input.clone(), self.output.clone()])?;
        }
        if let Some(path) = &self.btf {
            output::require_suffix("--btf", path, ".btf.exr")?;
            check_output_apart(path, &[self.input.clone(), self.output.clone()])?;
            if !self.input.is_dir() {
                return Err(Error::invalid("--btf", "input", self.input.display(), "a capture folder"));
            }
        }
        let (paint, report) = self.fit()?;
        paint.write(&self.output)?;
        if self.json {
            output::json(&report)?;
        } else {
            print_report(&report);
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }

    /// An ink of spectra.
    fn run_ink(&self, start: Instant) -> Result<ExitCode> {
        self.check_arguments("an ink is fitted to spectra", true)?;
        self.check_paint_options()?;
        let (ink, report) = ink_of_spectra(&self.input, &self.ink)?;
        ink.write(&self.output)?;
        if self.json {
            output::json(&report)?;
        } else {
            print_ink(&report);
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Refuses options of inks where none is fitted.
    fn check_ink_options(&self) -> Result<()> {
        if self.ink.is_given() {
            let legal = "one that ends in .ink.json with --white, --leave-out, --weights, --growth or --published-alpha";
            return Err(Error::invalid("fit", "output", self.output.display(), legal));
        }
        Ok(())
    }

    /// Refuses options of paints where an ink is fitted.
    fn check_paint_options(&self) -> Result<()> {
        let is_default = |lobes| matches!(lobes, Lobes::Fixed(n) if n.to_string() == Lobes::DEFAULT);
        let of_paints = [
            ("--lobes", !is_default(self.lobes)),
            ("--optimizer", self.optimizer != OptimizerName::default()),
            ("--starts", self.starts != STARTS),
            ("--seed", self.seed != SEED),
            ("--btf", self.btf.is_some()),
            ("--lifetime", self.statistics.lifetime.is_some()),
            ("--error or --time", self.budget.is_given()),
        ];
        match of_paints.iter().find(|(_, is_given)| *is_given) {
            Some((name, _)) => {
                let legal = "only with a paint as the output (.paint.exr): an ink has no lobes and no flakes";
                Err(Error::invalid("fit", "option", name, legal))
            }
            None => Ok(()),
        }
    }

    /// A paint of an ink.
    fn fit_of_ink(&self) -> Result<(Paint, FitReport)> {
        let ink = Ink::read(&self.input)?;
        let (paint, report, error) = paint_of_ink(&ink, &self.options(Some(ClearCoat::NONE)))?;
        output::note!(
            "three numbers for spectra: exact under D65, under illuminant A off by {:.2} Delta-E 2000 (largest {:.2})",
            error.mean,
            error.largest
        );
        Ok((paint, report))
    }

    fn fit(&self) -> Result<(Paint, FitReport)> {
        if fit_ink::is_ink(&self.input) {
            self.check_arguments("an ink has no coat", true)?;
            return self.fit_of_ink();
        }
        if self.input.is_dir() {
            if AxfFolder::json_path(&self.input).is_file() {
                self.check_arguments("a folder of slices brings its flakes and its coat", true)?;
                return self.fit_slices(&AxfFolder::open(&self.input)?);
            }
            self.check_arguments("a capture brings its flakes", false)?;
            return self.fit_capture();
        }
        if self.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
            self.check_arguments("a flake BTF brings its flakes and its coat", true)?;
            return self.fit_slices(&BtfReader::open(&self.input)?);
        }
        self.fit_measured()
    }

    /// A paint of slices with a smooth part.
    fn fit_slices(&self, btf: &impl FlakeSource) -> Result<(Paint, FitReport)> {
        // Slices lie at outer angles, where a coat refracts nothing.
        let mut options = self.options(Some(ClearCoat { refracts: false, ..btf.coat() }));
        self.pick_starts(&mut options, |options| fit_smooth(btf.smooth(), options, &|| ()))?;
        let statistics = self.statistics.picked(btf, Lifetime::Solve, &self.budget)?;
        let bar = Bar::new("fitting", options.ticks() + btf.grid().len());
        fit_btf(btf, &options, &statistics, &bar.tick())
    }

    /// A paint of a capture folder.
    fn fit_capture(&self) -> Result<(Paint, FitReport)> {
        // Pictures show the gloss of the surface: it is fitted, too.
        let coat = self.ior.map(|ior| ClearCoat { ior, refracts: self.refract, ..ClearCoat::NONE });
        let measured = measure_capture(&self.input, &self.capture, self.options(coat))?;
        // Pictures of half vectors at any azimuth show other flakes in every slice: lifetimes cannot be read from them.
        let options = self.statistics.picked(&measured.btf, Lifetime::Fixed(USUAL_SPACING), &self.budget)?;
        let bar = Bar::new("statistics", measured.btf.grid.len());
        let flakes = fit_flakes(&measured.btf, &measured.smooth, SliceMean::Residual, &options, &bar.tick())?;
        if let Some(path) = &self.btf {
            measured.btf.write(path)?;
        }
        let source = json!({ "capture": output::stem(&self.input), "slices": measured.slices });
        let paint = measured.smooth.into_paint(Some(flakes), source, &measured.fit);
        Ok((paint, measured.fit))
    }

    /// A paint of a measured table or of scattered measurements, with the flakes of a composition if they are asked for.
    fn fit_measured(&self) -> Result<(Paint, FitReport)> {
        let source = output::stem(&self.input);
        if let Some(list) = &self.sha256 {
            output::note!("the list knows the file as {}", known_merl(&self.input, list)?);
        }
        let input = Measured::read(&self.input)?;
        input.warnings().iter().for_each(|warning| output::note!("warning: {warning}"));
        let mut options = self.options(self.ior.map(|ior| ClearCoat::ideal(ior, self.refract)));
        self.pick_starts(&mut options, |options| fit_measured(&input, options, &|| ()))?;
        let (smooth, mut report) = fit_input(&input, &options)?;
        if self.refract {
            let straight = self.options(self.ior.map(|ior| ClearCoat::ideal(ior, false)));
            report.without_refraction = Some(fit_input(&input, &straight)?.1.errors());
        }
        if let Some(path) = &self.svg {
            let points = match &input {
                Measured::Table(table) => compare(table, &smooth, &options, DRAWN),
                Measured::Scattered(measurement) => compare_samples(&measurement.samples, &smooth, DRAWN),
            };
            write_text(path, &fit_plot(&source, &report, &points))?;
        }
        let flakes = match &self.flakes {
            Some(path) => {
                let btf = self.synthesize(path)?;
                let options = self.statistics.picked(&btf, Lifetime::Solve, &self.budget)?;
                let bar = Bar::new("statistics", btf.grid.len());
                Some(fit_flakes(&btf, &smooth, SliceMean::Zero, &options, &bar.tick())?)
            }
            None => None,
        };
        let from = self.flakes.as_deref().map(output::stem);
        let paint = smooth.into_paint(flakes, json!({ "table": source, "flakes": from }), &report);
        Ok((paint, report))
    }

    /// Refuses what only a measured table can be told, and of a coat what is known already.
    fn check_arguments(&self, why: &str, coat_known: bool) -> Result<()> {
        let all = [
            ("--flakes", self.flakes.is_some(), false),
            ("--ior", self.ior.is_some(), true),
            ("--refract", self.refract, true),
            ("--svg", self.svg.is_some(), false),
            ("--sha256", self.sha256.is_some(), false),
        ];
        let illegal: Vec<_> = all.into_iter().filter(|(_, _, of_coat)| coat_known || !of_coat).collect();
        let names: Vec<&str> = illegal.iter().map(|(name, ..)| *name).collect();
        let found: Vec<&str> =
            illegal.iter().filter(|(_, given, _)| *given).map(|(name, ..)| *name).collect();
        if found.is_empty() {
            return Ok(());
        }
        let legal = format!("none of {}: {why}", names.join(", "));
        Err(Error::invalid(self.input.display().to_string(), "options for a table", found.join(", "), legal))
    }

    fn options(&self, coat: Option<ClearCoat>) -> FitOptions {
        let (lobes, choose_lobes) = match self.lobes {
            Lobes::Fixed(lobes) => (lobes, false),
            Lobes::Auto => (3, true),
        };
        let optimizer = match self.optimizer {
            OptimizerName::Sr1 => Optimizer::Sr1,
            OptimizerName::LevenbergMarquardt => Optimizer::LevenbergMarquardt,
            OptimizerName::TrustRegionReflective => Optimizer::TrustRegionReflective,
        };
        let (starts, seed) = (self.starts, self.seed);
        FitOptions { lobes, choose_lobes, optimizer, coat, starts, seed, ..FitOptions::default() }
    }

    /// Sets the starts by the budget, if there is one.
    fn pick_starts(
        &self,
        options: &mut FitOptions,
        fit: impl Fn(&FitOptions) -> Result<(SmoothFit, FitReport)>,
    ) -> Result<()> {
        if let Some(budget) = self.budget.budget()? {
            let smooth = |options: &FitOptions| Ok(fit(options)?.0);
            options.starts = picked("fit", pick_starts(options, budget, smooth)?);
        }
        Ok(())
    }

    fn synthesize(&self, path: &std::path::Path) -> Result<FlakeBtf> {
        let model = Model::new(&Composition::read(path)?, ModelOptions::default())?;
        let options = self.synthesis.options(self.seed)?;
        let bar = Bar::new("synthesizing flakes", options.grid.len());
        synthesize(&model, &options, &bar.tick())
    }
}

/// Fits the smooth part of a measurement, with a bar over the starts.
fn fit_input(input: &Measured, options: &FitOptions) -> Result<(SmoothFit, FitReport)> {
    let bar = Bar::new("fitting lobes", options.ticks());
    fit_measured(input, options, &bar.tick())
}
