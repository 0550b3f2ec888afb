//! `carpaint validate`.

use super::capture::CaptureArguments;
use super::validate_capture::validate_capture;
use super::validate_tables::Tables;
use super::{output, progress::begin};
use crate::brdf::ClearCoat;
use crate::error::Result;
use crate::fit::FitOptions;
use crate::mix::{CoupleOptions, couple};
use crate::report::{Chain, ChainOptions, Stage, blend_checks, picture_checks, run_chain, transport_checks};
use crate::simulate::{Composition, Model, ModelOptions, synthesize};
use std::path::PathBuf;
use std::process::ExitCode;

/// Check every stage of the chain against the analytic model of a composition; exit code 1 past a bar.
///
/// Synthesis, fit, statistics and picture are compared with the model of the composition itself. For transport and blend the
/// composition is coupled with itself at another flake density, and the blend half way is compared with the paint
/// simulated half way.
#[derive(clap::Args)]
pub struct Arguments {
    /// The composition (TOML).
    composition: PathBuf,
    /// Angle bins per 90 degrees.
    #[arg(long, default_value_t = 12)]
    bins: usize,
    /// Columns and rows of a flake slice, texels.
    #[arg(long, default_value_t = 128)]
    size: usize,
    /// Flake density of the second paint, relative to the first.
    #[arg(long, default_value_t = 0.5)]
    density: f64,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Instead of the stages, the reconstruction errors of the statistics, slice by slice, for both box rules and both samplers.
    #[arg(long)]
    reconstruction: bool,
    /// Instead of the stages, how what is drawn hangs together: angular autocorrelation, contrast between slices, at all scales
    /// and under long footprints, against the simulated source.
    #[arg(long, conflicts_with = "reconstruction")]
    coherence: bool,
    /// Instead of the stages, blends of the composition with itself after a change of one physical quantity, in each path,
    /// against paints simulated in between and against cross-fades of the textures.
    #[arg(long, conflicts_with_all = ["reconstruction", "coherence"])]
    interpolation: bool,
    /// Instead of the stages, how the errors of the statistics fall with clusters, steps of the inverse CDF and levels, and those
    /// of transport with the solver.
    #[arg(long, conflicts_with_all = ["reconstruction", "coherence", "interpolation"])]
    curves: bool,
    /// Draw the curves, too.
    #[arg(long, value_name = "OUT.svg", requires = "curves")]
    svg: Option<PathBuf>,
    /// Instead of the stages, the paint measured from a virtual capture of this composition (see `measure`) against the
    /// composition itself: poses, light, lobes, colors, flakes.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["reconstruction", "coherence", "interpolation", "curves"])]
    capture: Option<PathBuf>,
    /// Fit the capture beneath a coat that refracts with the composition's own index, instead of with light going straight on.
    #[arg(long, requires = "capture")]
    refract: bool,
    #[command(flatten)]
    measuring: CaptureArguments,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let composition = Composition::read(&self.composition)?;
        if let Some(folder) = &self.capture {
            let model = Model::new(&composition, ModelOptions::default())?;
            let ior = model.optics().top().index;
            let coat = self.refract.then_some(ClearCoat { ior, refracts: true, ..ClearCoat::NONE });
            let fit = FitOptions { seed: self.seed, coat, ..FitOptions::default() };
            return validate_capture(&model, folder, &self.measuring, fit, self.json);
        }
        let tables = Tables { composition: &composition, options: self.options(), json: self.json };
        if self.reconstruction {
            return tables.reconstruction();
        }
        if self.coherence {
            return tables.coherence();
        }
        if self.interpolation {
            return tables.interpolation();
        }
        if self.curves {
            return tables.curves(self.svg.as_deref());
        }
        let stages = self.stages(&composition)?;
        if self.json {
            output::json(&stages)?;
        } else {
            for stage in &stages {
                output::print(format_args!("{stage}"));
            }
        }
        Ok(if stages.iter().all(Stage::passes) { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn options(&self) -> ChainOptions {
        ChainOptions { bins: self.bins, size: self.size, texel_mm: None, seed: self.seed }
    }

    fn stages(&self, composition: &Composition) -> Result<Vec<Stage>> {
        let options = self.options();
        let Chain { model, btf, paint, stages, .. } = run_chain("paint", composition, &options, begin)?;
        let mut all = stages;

        let other = scaled(composition, self.density)?;
        let options =
            ChainOptions { texel_mm: Some(btf.texel_mm), seed: self.seed.wrapping_add(1), ..options };
        let Chain { paint: partner, stages, .. } = run_chain("partner", &other, &options, begin)?;
        all.extend(stages);

        let pair = [("paint".to_owned(), &paint), ("partner".to_owned(), &partner)];
        let (stage, (mix, report)) =
            Stage::run("transport", || couple(&pair, &CoupleOptions::default(), &|| ()))?;
        all.push(match (&paint.flakes, &partner.flakes) {
            (Some(a), Some(b)) => stage.with(transport_checks(&report, a, b)?),
            _ => stage,
        });

        let half = scaled(composition, 0.5 * (1.0 + self.density))?;
        let options = ChainOptions { seed: self.seed.wrapping_add(2), ..options };
        let half_way = Model::new(&half, ModelOptions::default())?;
        let truth =
            synthesize(&half_way, &options.synthesis()?, &begin("simulating half way", btf.grid.len()))?;
        let (stage, blend) = Stage::run("blend", || mix.blend(&[0.5, 0.5]))?;
        all.push(stage.with(blend_checks(&blend, &truth, &half_way)?));

        let (stage, checks) = Stage::run("picture", || picture_checks(&paint, &model))?;
        all.push(stage.with(checks));
        Ok(all)
    }
}

/// The composition with all flake densities scaled.
fn scaled(composition: &Composition, factor: f64) -> Result<Composition> {
    let mut other = composition.clone();
    for kind in other.films.iter_mut().flat_map(|film| &mut film.flakes) {
        kind.area_density *= factor;
    }
    other.validate().map_err(|e| e.within("--density"))?;
    Ok(other)
}
