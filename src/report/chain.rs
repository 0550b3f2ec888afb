//! From a composition to a paint, measured.

use super::{Check, Stage, smooth, statistics, synthesis};
use crate::btf::{AngleGrid, FlakeBtf};
use crate::error::Result;
use crate::fit::{FitOptions, FitReport, FlakeOptions, SliceMean, fit_flakes, fit_smooth};
use crate::paint::Paint;
use crate::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};

/// Sizes of a chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainOptions {
    /// Angle bins per 90 degrees.
    pub bins: usize,
    /// Columns and rows of a slice, texels.
    pub size: usize,
    /// Side of a texel, millimetres; none: a mean flake is 1.5 texels wide.
    pub texel_mm: Option<f64>,
    /// Seed of everything random.
    pub seed: u32,
}

impl ChainOptions {
    /// How these sizes are asked of the synthesis.
    ///
    /// # Errors
    /// Bins out of range.
    pub fn synthesis(&self) -> Result<SynthesisOptions> {
        Ok(SynthesisOptions {
            size: [self.size; 2],
            texel_mm: self.texel_mm,
            seed: u64::from(self.seed),
            ..SynthesisOptions::new(AngleGrid::triangle(self.bins)?)
        })
    }
}

/// A composition on its way to a paint.
pub struct Chain {
    /// The analytic model: the truth.
    pub model: Model,
    /// The synthesized slices.
    pub btf: FlakeBtf,
    /// The paint.
    pub paint: Paint,
    /// What the fit says of itself.
    pub fit: FitReport,
    /// Synthesis, fit and statistics, measured.
    pub stages: Vec<Stage>,
}

/// Simulates, fits and reduces a composition, checking every stage; `begin` is told what starts, and how many ticks it takes.
///
/// # Errors
/// Those of the stages.
pub fn run_chain<T: Fn() + Sync>(
    name: &str,
    composition: &Composition,
    options: &ChainOptions,
    begin: impl Fn(&str, usize) -> T,
) -> Result<Chain> {
    let model = Model::new(composition, ModelOptions::default())?;
    let synthesis_options = options.synthesis()?;
    let tick = begin("simulating", synthesis_options.grid.len());
    let (stage, btf) =
        Stage::run(format!("{name}: simulate"), || synthesize(&model, &synthesis_options, &tick))?;
    let simulated = stage.with(synthesis::checks(&btf));

    let fit_options =
        FitOptions { coat: Some(btf.coat), filled: false, seed: options.seed, ..FitOptions::default() };
    let tick = begin("fitting", fit_options.ticks());
    let (stage, (smooth, fit)) =
        Stage::run(format!("{name}: fit"), || fit_smooth(&btf.smooth, &fit_options, &tick))?;
    // The presets show 0.04 to 0.05, then 0.25 and 0.42 at most: half as much again, still no visible difference.
    let mut checks =
        vec![Check::new("logarithmic error with color table (Rump, eq. 7)", fit.colored_error, 0.08)];
    checks.extend(smooth::checks(&smooth, &model, [0.5, 0.7]));
    let fitted = stage.with(checks);

    let tick = begin("reducing slices", btf.grid.len());
    let (stage, flakes) = Stage::run(format!("{name}: statistics"), || {
        fit_flakes(&btf, &smooth, SliceMean::Residual, &FlakeOptions::default(), &tick)
    })?;
    let reduced = stage.with(statistics::checks(&btf, &smooth, &flakes)?);
    let paint = smooth.into_paint(Some(flakes), btf.provenance.clone(), &fit);
    Ok(Chain { model, btf, paint, fit, stages: vec![simulated, fitted, reduced] })
}
