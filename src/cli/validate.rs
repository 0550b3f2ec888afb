//! `carpaint validate`.

use super::{output, progress::Bar};
use crate::error::Result;
use crate::fit::SmoothFit;
use crate::mix::{CoupleOptions, couple};
use crate::report::{
    Chain, ChainOptions, Interpolation, LobeError, PhysicalChange, Stage, blend_checks, coherence,
    energetic_slices, interpolation_table, picture_checks, reconstruction_table, run_chain, transport_checks,
};
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
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let composition = Composition::read(&self.composition)?;
        if self.reconstruction {
            return self.print_reconstruction(&composition);
        }
        if self.coherence {
            return self.print_coherence(&composition);
        }
        if self.interpolation {
            return self.print_interpolation(&composition);
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

    fn print_reconstruction(&self, composition: &Composition) -> Result<ExitCode> {
        let options = ChainOptions { bins: self.bins, size: self.size, texel_mm: None, seed: self.seed };
        let Chain { btf, paint, .. } = run_chain("paint", composition, &options, begin)?;
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

    fn print_coherence(&self, composition: &Composition) -> Result<ExitCode> {
        let options = ChainOptions { bins: self.bins, size: self.size, texel_mm: None, seed: self.seed };
        let chain = run_chain("paint", composition, &options, begin)?;
        let found = coherence(&chain, &options, &begin("comparing", 4))?;
        match found {
            found if self.json => output::json(&found)?,
            Some(found) => output::print(format_args!("{found}")),
            None => output::say!("no flakes"),
        }
        Ok(ExitCode::SUCCESS)
    }

    fn print_interpolation(&self, composition: &Composition) -> Result<ExitCode> {
        let options = ChainOptions { bins: self.bins, size: self.size, texel_mm: None, seed: self.seed };
        let tick = begin("comparing", PhysicalChange::ALL.len());
        let table = interpolation_table(composition, &options, &tick)?;
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

    fn stages(&self, composition: &Composition) -> Result<Vec<Stage>> {
        let options = ChainOptions { bins: self.bins, size: self.size, texel_mm: None, seed: self.seed };
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

/// A bar for what begins.
fn begin(what: &str, ticks: usize) -> impl Fn() + Sync + use<> {
    Bar::new(what, ticks).into_tick()
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
