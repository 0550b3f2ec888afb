//! How errors fall with what is spent: clusters, steps of the inverse CDF, levels of detail, transport solvers.

use super::solvers::{SolverError, problem, solver_errors};
use super::stage::mean;
use super::statistics::{energetic_slices, wasserstein};
use super::{Chain, ChainOptions};
use crate::btf::{FlakeBtf, half, level_count};
use crate::cluster::{BoxRule, DEFAULT_CLUSTERS, SliceStatistics, cluster_slice};
use crate::error::Result;
use crate::fit::{SliceMean, SmoothFit, residual};
use crate::parallel::TryMap;
use crate::sampler::{ReconstructionError, ReconstructionSamples, Sampler, reconstruction_error};
use crate::simulate::synthesize;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;

const CLUSTERS: [usize; 7] = [16, 25, 50, 100, 200, 400, 1024];
const STEPS: [usize; 6] = [125, 250, 500, 1000, 2000, 4000];
const LEVELS: [usize; 4] = [0, 1, 2, 3];
/// Wasserstein distances of a slice, and colors on either side.
const REPEATS: u32 = 4;
const POINTS: u32 = 500;
/// Bytes of the corners of a box.
const BOX_BYTES: usize = 24;

/// How a slice is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Setting {
    /// Clusters asked for, 1 to 1024.
    pub clusters: usize,
    /// Steps of the inverse CDF; none: the exact sampler.
    pub steps: Option<usize>,
    /// Level of detail, 0 the finest.
    pub level: usize,
}

/// A setting and its errors, means over the slices that hold most energy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurvePoint {
    /// What it cost.
    #[serde(flatten)]
    pub setting: Setting,
    /// Wasserstein-1 above its sampling floor, Delta-E; negative by chance where nothing is left to see.
    pub wasserstein: f64,
    /// Standard error of that, from the scatter of four repeats of 500 colors a slice.
    pub wasserstein_noise: f64,
    /// `|ln|` of the ratio of the luminance's standard deviations, draws over texels.
    pub deviation: f64,
    /// `|ln|` of the ratio of the luminance's 99.9 % quantiles above the mean; of the brightest texels where a level has
    /// fewer than a thousand.
    pub quantile: f64,
    /// Boxes and tables of the sampler, bytes a slice.
    pub bytes: f64,
}

/// What a curve runs along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveAxis {
    /// Number of clusters.
    Clusters,
    /// Steps of the inverse CDF.
    Steps,
    /// Level of detail.
    Level,
}

impl CurveAxis {
    /// Where a setting lies: octaves; the exact sampler one above the most steps.
    pub fn octaves(self, setting: &Setting) -> f64 {
        match self {
            Self::Clusters => (setting.clusters as f64).log2(),
            Self::Steps => (setting.steps.unwrap_or(2 * STEPS[STEPS.len() - 1]) as f64).log2(),
            Self::Level => setting.level as f64,
        }
    }

    /// What is written there.
    pub fn label(self, setting: &Setting) -> String {
        match (self, setting.steps) {
            (Self::Clusters, _) => setting.clusters.to_string(),
            (Self::Steps, Some(steps)) => steps.to_string(),
            (Self::Steps, None) => "exact".to_owned(),
            (Self::Level, _) => setting.level.to_string(),
        }
    }
}

impl fmt::Display for CurveAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Clusters => "clusters",
            Self::Steps => "steps",
            Self::Level => "level",
        })
    }
}

impl Curves {
    /// The curves and what they run along.
    pub fn along(&self) -> [(CurveAxis, &[CurvePoint]); 3] {
        [
            (CurveAxis::Clusters, &self.clusters),
            (CurveAxis::Steps, &self.steps),
            (CurveAxis::Level, &self.levels),
        ]
    }
}

/// Everything measured of one composition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curves {
    /// Against the number of clusters: finest level, exact sampler.
    pub clusters: Vec<CurvePoint>,
    /// Against the steps of the inverse CDF: finest level, 50 clusters; the exact sampler last.
    pub steps: Vec<CurvePoint>,
    /// Against the level: 50 clusters, exact sampler.
    pub levels: Vec<CurvePoint>,
    /// Solvers on the slices and those of the same composition from another seed, 50 clusters each.
    pub solvers: Vec<SolverError>,
}

/// Measures a composition; none if it has no flakes. `tick` is called once a setting, [`curve_ticks`] times.
///
/// # Errors
/// Those of synthesis, clustering, samplers and transport.
pub fn curves(chain: &Chain, options: &ChainOptions, tick: &(dyn Fn() + Sync)) -> Result<Option<Curves>> {
    let slices = energetic_slices(&chain.btf);
    if slices.is_empty() {
        return Ok(None);
    }
    let smooth = SmoothFit::from(&chain.paint);
    let pyramids = slices
        .iter()
        .map(|k| Ok(pyramid(residual(&chain.btf, &smooth, SliceMean::Residual, *k)?, chain.btf.size)))
        .collect::<Result<Vec<_>>>()?;
    let [clusters, steps, levels] = settings().map(|settings| {
        let there = settings.into_iter().filter(|s| s.level < level_count(chain.btf.size));
        there.map(|s| point(&pyramids, s, options.seed).inspect(|_| tick())).collect::<Result<Vec<_>>>()
    });
    let seed = options.seed.wrapping_add(1);
    let texel_mm = Some(chain.btf.texel_mm);
    let other = synthesize(&chain.model, &ChainOptions { seed, texel_mm, ..*options }.synthesis()?, &|| ())?;
    let pairs = slices
        .iter()
        .map(|k| problem(&statistics(&chain.btf, &smooth, *k)?, &statistics(&other, &smooth, *k)?))
        .collect::<Result<Vec<_>>>()?;
    Ok(Some(Curves { clusters: clusters?, steps: steps?, levels: levels?, solvers: solver_errors(&pairs)? }))
}

/// How often [`curves`] ticks at most.
pub fn curve_ticks() -> usize {
    settings().iter().map(Vec::len).sum()
}

/// The settings of the three curves.
fn settings() -> [Vec<Setting>; 3] {
    let usual = Setting { clusters: DEFAULT_CLUSTERS, steps: None, level: 0 };
    [
        CLUSTERS.map(|clusters| Setting { clusters, ..usual }).to_vec(),
        STEPS.map(Some).into_iter().chain([None]).map(|steps| Setting { steps, ..usual }).collect(),
        LEVELS.map(|level| Setting { level, ..usual }).to_vec(),
    ]
}

/// Texels of the levels that are looked at, finest first.
fn pyramid(texels: Vec<[f32; 3]>, size: [usize; 2]) -> Vec<Vec<[f32; 3]>> {
    let finer = std::iter::successors(Some((texels, size)), |(texels, size)| Some(half(texels, *size)));
    finer.take(LEVELS.len().min(level_count(size))).map(|(texels, _)| texels).collect()
}

/// One setting over all slices.
fn point(pyramids: &[Vec<Vec<[f32; 3]>>], setting: Setting, seed: u32) -> Result<CurvePoint> {
    let errors = |(k, levels): (usize, &Vec<Vec<[f32; 3]>>)| {
        let texels = &levels[setting.level];
        let statistics = cluster_slice(texels, setting.clusters, BoxRule::MomentMatched)?;
        let sampler = match setting.steps {
            Some(steps) => Sampler::inverse_cdf(&statistics, steps)?,
            None => Sampler::exact(&statistics)?,
        };
        // Other seeds for every slice, and the same for every setting: chance averages out, and cancels between settings.
        let run = |repeat: u32| {
            let seed = seed.wrapping_add(REPEATS * k as u32 + repeat);
            let draws = if repeat == 0 { 1_000_000 } else { 1 };
            let samples = ReconstructionSamples { draws, points: POINTS, repeats: 1, seed };
            reconstruction_error(texels, &statistics, &sampler, samples, wasserstein)
        };
        let runs = (0..REPEATS).map(run).collect::<Result<Vec<_>>>()?;
        let excess = mean(runs.iter().map(ReconstructionError::excess));
        let scatter = mean(runs.iter().map(|error| (error.excess() - excess).powi(2)));
        let [deviation, quantile] =
            [runs[0].std_ratio(), runs[0].quantile_ratio()].map(|ratio| ratio.ln().abs());
        let bytes = BOX_BYTES * statistics.clusters.len() + sampler.bytes();
        Ok([excess, scatter / f64::from(REPEATS - 1), deviation, quantile, bytes as f64])
    };
    let by_slice = pyramids.par_iter().enumerate().try_map(errors)?;
    let [wasserstein, variance, deviation, quantile, bytes] =
        [0, 1, 2, 3, 4].map(|column| mean(by_slice.iter().map(|errors| errors[column])));
    let wasserstein_noise = (variance / by_slice.len() as f64).sqrt();
    Ok(CurvePoint { setting, wasserstein, wasserstein_noise, deviation, quantile, bytes })
}

/// Slice `k` of the finest level, as it is kept usually.
fn statistics(btf: &FlakeBtf, smooth: &SmoothFit, k: usize) -> Result<SliceStatistics> {
    cluster_slice(&residual(btf, smooth, SliceMean::Residual, k)?, DEFAULT_CLUSTERS, BoxRule::MomentMatched)
}
