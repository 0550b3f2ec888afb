//! Blends against paints simulated between the ends, and against what else one could do with two textures.

use super::physical_change::PhysicalChange;
use super::stage::mean;
use super::statistics::{energetic_slices, wasserstein};
use super::{ChainOptions, LobeError, lobes, smooth};
use crate::btf::FlakeBtf;
use crate::cluster::SliceStatistics;
use crate::color::{lab_from_rgb, luminance};
use crate::error::Result;
use crate::fit::{FitOptions, FlakeOptions, SliceMean, SmoothFit, fit_flakes, fit_smooth, residual};
use crate::math::hash::{pcg4d, unit};
use crate::mix::{BlendOptions, CoupleOptions, Mix, Path, couple};
use crate::paint::{Flakes, Paint};
use crate::parallel::TryMap;
use crate::sampler::{Sampler, color};
use crate::simulate::{Composition, Model, ModelOptions, synthesize};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt;

/// Colors on either side of a Wasserstein distance.
const POINTS: u32 = 500;
/// Where between the ends.
const WAYS: [f64; 3] = [0.25, 0.5, 0.75];

/// How the paint between two others is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A blend, coupled with the cost that suits its path.
    Blend(Path),
    /// Independent textures of the ends, `(1-w) a + w b` texel by texel.
    CrossFade,
    /// The same, its fluctuation over `sqrt((1-w)^2 + w^2)`.
    VariancePreserving,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Blend(Path::Transport),
        Self::Blend(Path::Hybrid),
        Self::Blend(Path::Contrast),
        Self::CrossFade,
        Self::VariancePreserving,
    ];
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blend(path) => path.fmt(f),
            Self::CrossFade => f.pad("cross-fade"),
            Self::VariancePreserving => f.pad("variance-preserving"),
        }
    }
}

/// Errors of one method for one change: means over the ways between the ends and over the slices that hold most energy.
/// The means of slices are taken out: they are the smooth part's matter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interpolation {
    /// What changes from end to end.
    pub change: PhysicalChange,
    /// How the paint between is made.
    pub method: Method,
    /// Wasserstein-1 above its sampling floor, Delta-E.
    pub wasserstein: f64,
    /// `|ln|` of the ratio of the luminance's standard deviations.
    pub deviation: f64,
    /// `|ln|` of the ratio of the luminance's 99.9 % quantiles above the mean.
    pub quantile: f64,
    /// Standard deviation of the luminance of colors half way between neighbouring slices, drawn with the same numbers, over
    /// the mean of the slices' own: 1 if flakes keep their place in u from angle to angle. For the ends' textures, which
    /// the rivals fade, that of the start's own statistics.
    pub coherence: f64,
    /// Mean Delta-E 2000 of the smooth part over 320 pairs of directions.
    pub smooth: f64,
}

/// All comparisons of a composition.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Interpolations {
    /// A row a change and method.
    pub methods: Vec<Interpolation>,
    /// Ways to blend lobes.
    pub lobes: Vec<LobeError>,
}

/// An end of an interpolation.
struct End {
    paint: Paint,
    btf: FlakeBtf,
}

impl End {
    fn new(composition: &Composition, options: &ChainOptions) -> Result<Self> {
        let model = Model::new(composition, ModelOptions::default())?;
        let btf = synthesize(&model, &options.synthesis()?, &|| ())?;
        let fit_options =
            FitOptions { coat: Some(btf.coat), filled: false, seed: options.seed, ..FitOptions::default() };
        let (smooth, report) = fit_smooth(&btf.smooth, &fit_options, &|| ())?;
        let flakes = fit_flakes(&btf, &smooth, SliceMean::Residual, &FlakeOptions::default(), &|| ())?;
        Ok(Self { paint: smooth.into_paint(Some(flakes), btf.provenance.clone(), &report), btf })
    }
}

/// Every change that does something to the composition, every method. `tick` is called once a change.
///
/// # Errors
/// Those of simulation, fit and coupling.
pub fn interpolation_table(
    composition: &Composition,
    options: &ChainOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<Interpolations> {
    let start = End::new(composition, options)?;
    let options = ChainOptions { texel_mm: Some(start.btf.texel_mm), ..*options };
    let mut all = Interpolations::default();
    for change in PhysicalChange::ALL {
        if change.at(composition, 1.0)? != *composition {
            let (methods, lobes) = compare(change, composition, &start, &options)?;
            all.methods.extend(methods);
            all.lobes.extend(lobes);
        }
        tick();
    }
    Ok(all)
}

fn compare(
    change: PhysicalChange,
    composition: &Composition,
    start: &End,
    options: &ChainOptions,
) -> Result<(Vec<Interpolation>, Vec<LobeError>)> {
    let seeded = |k: u32| ChainOptions { seed: options.seed.wrapping_add(k), ..*options };
    let end = End::new(&change.at(composition, 1.0)?, &seeded(1))?;
    let pair = [("start".to_owned(), &start.paint), ("end".to_owned(), &end.paint)];
    let mixes = Path::ALL
        .iter()
        .map(|path| Ok(couple(&pair, &CoupleOptions { path: *path, ..CoupleOptions::default() }, &|| ())?.0))
        .collect::<Result<Vec<_>>>()?;
    let mut errors = vec![Vec::new(); Method::ALL.len()];
    for (k, way) in WAYS.into_iter().enumerate() {
        let model = Model::new(&change.at(composition, way)?, ModelOptions::default())?;
        let truth = synthesize(&model, &seeded(2 + k as u32).synthesis()?, &|| ())?;
        let between = Between { start, end: &end, mixes: &mixes, truth: &truth, model: &model, way };
        for (all, new) in errors.iter_mut().zip(between.errors()?) {
            all.push(new);
        }
    }
    let summary = |(method, errors): (Method, Vec<[f64; 5]>)| {
        let [wasserstein, deviation, quantile, coherence, smooth] =
            [0, 1, 2, 3, 4].map(|m| mean(errors.iter().map(|e| e[m])));
        Interpolation { change, method, wasserstein, deviation, quantile, coherence, smooth }
    };
    let lobes = lobes::errors(change, composition, &mixes[0])?;
    Ok((Method::ALL.into_iter().zip(errors).map(summary).collect(), lobes))
}

/// One way between the ends.
struct Between<'a> {
    start: &'a End,
    end: &'a End,
    /// One a path.
    mixes: &'a [Mix],
    truth: &'a FlakeBtf,
    model: &'a Model,
    way: f64,
}

impl Between<'_> {
    /// Wasserstein-1, deviation, quantile, coherence and smooth part, for every method.
    fn errors(&self) -> Result<Vec<[f64; 5]>> {
        let weights = [1.0 - self.way, self.way];
        let blends = self
            .mixes
            .iter()
            .zip(Path::ALL)
            .map(|(mix, path)| {
                mix.blend_with(&weights, &BlendOptions { path: Some(path), ..BlendOptions::default() })
            })
            .collect::<Result<Vec<_>>>()?;
        let slices = energetic_slices(self.truth);
        let by_slice = slices.par_iter().try_map(|k| self.slice_errors(&blends, *k))?;
        let blended = SmoothFit::from(&blends[0]);
        let smooth = [
            smooth::mean_difference(|wi, wo| smooth::matt(&blended).eval(wi, wo), self.model),
            smooth::mean_difference(self.faded_smooth(), self.model),
        ];
        let method = |m: usize| {
            let [w, d, q, c] = [0, 1, 2, 3].map(|c| mean(by_slice.iter().map(|errors| errors[m][c])));
            [w, d, q, c, smooth[usize::from(m >= Path::ALL.len())]]
        };
        Ok((0..Method::ALL.len()).map(method).collect())
    }

    /// The smooth part of a plain cross-fade.
    fn faded_smooth(&self) -> impl Fn(DVec3, DVec3) -> DVec3 {
        let [a, b] = [self.start, self.end].map(|end| smooth::matt(&SmoothFit::from(&end.paint)));
        let way = self.way;
        move |wi, wo| a.eval(wi, wo).lerp(b.eval(wi, wo), way)
    }

    fn slice_errors(&self, blends: &[Paint], k: usize) -> Result<Vec<[f64; 4]>> {
        // Any smooth part does: means are taken out.
        let texels = |btf: &FlakeBtf, paint: &Paint| {
            residual(btf, &SmoothFit::from(paint), SliceMean::Residual, k).map(|texels| centered(&texels))
        };
        let truth = texels(self.truth, &self.start.paint)?;
        let (a, b) = (texels(&self.start.btf, &self.start.paint)?, texels(&self.end.btf, &self.end.paint)?);
        let (wa, wb) = (1.0 - self.way, self.way);
        let faded: Vec<DVec3> = a.iter().zip(&b).map(|(a, b)| wa * *a + wb * *b).collect();
        let kept: Vec<DVec3> = faded.iter().map(|c| *c / wa.hypot(wb)).collect();
        let mut sides = blends
            .iter()
            .map(|paint| draws(&paint.flakes, k, 4 * truth.len() as u32))
            .collect::<Result<Vec<_>>>()?;
        let mut coherence =
            blends.iter().map(|paint| coherence(&paint.flakes, k)).collect::<Result<Vec<_>>>()?;
        sides.extend([faded, kept]);
        coherence.resize(sides.len(), self::coherence(&self.start.paint.flakes, k)?);
        let source = cloud(&truth, 0, k as u32);
        let floor = wasserstein(&source, &cloud(&truth, 1, k as u32));
        let (deviation, quantile) = spread(&truth);
        let errors = |(side, coherence): (&Vec<DVec3>, f64)| {
            let (d, q) = spread(side);
            let excess = wasserstein(&cloud(side, 2, k as u32), &source) - floor;
            [excess, (d / deviation).ln().abs(), (q / quantile).ln().abs(), coherence]
        };
        Ok(sides.iter().zip(coherence).map(errors).collect())
    }
}

/// See [`Interpolation::coherence`]: from slice `k` to the next theta_h of its row, or back from the last one.
fn coherence(flakes: &Option<Flakes>, k: usize) -> Result<f64> {
    let Some(flakes) = flakes else { return Ok(f64::NAN) };
    let (h, i) = flakes.grid.bins_of(k);
    let Some(next) = flakes.grid.slice(h + 1, i).or_else(|| flakes.grid.slice(h.wrapping_sub(1), i)) else {
        return Ok(1.0);
    };
    let draw = |k: usize| draws_of(&flakes.levels[0].slices[k], 40_000, 0);
    let (here, there) = (draw(k)?, draw(next)?);
    let between: Vec<DVec3> = here.iter().zip(&there).map(|(a, b)| 0.5 * (*a + *b)).collect();
    Ok(2.0 * spread(&between).0 / (spread(&here).0 + spread(&there).0))
}

/// Colors without their mean.
fn centered(texels: &[[f32; 3]]) -> Vec<DVec3> {
    let wide = |t: &[f32; 3]| DVec3::from(t.map(f64::from));
    let mean = texels.iter().map(wide).sum::<DVec3>() / texels.len() as f64;
    texels.iter().map(|t| wide(t) - mean).collect()
}

/// Draws from slice `k` of the finest level.
fn draws(flakes: &Option<Flakes>, k: usize, count: u32) -> Result<Vec<DVec3>> {
    flakes.as_ref().map_or(Ok(Vec::new()), |f| draws_of(&f.levels[0].slices[k], count, k as u32))
}

fn draws_of(statistics: &SliceStatistics, count: u32, seed: u32) -> Result<Vec<DVec3>> {
    let sampler = Sampler::exact(statistics)?;
    let draw = |n: u32| {
        let [u, r0, r1, r2] = pcg4d([n, seed, 2, 1]).map(unit);
        color(statistics, &sampler, u, [r0, r1, r2])
    };
    Ok(centered(&(0..count).map(draw).collect::<Vec<_>>()))
}

/// Some of the colors, in Lab of `pi f`.
fn cloud(colors: &[DVec3], stream: u32, slice: u32) -> Vec<DVec3> {
    let pick = |n: u32| {
        let bits = u64::from(pcg4d([n, stream, slice, 3])[0]);
        lab_from_rgb(PI * colors[((bits * colors.len() as u64) >> 32) as usize])
    };
    (0..POINTS).map(pick).collect()
}

/// Standard deviation and 99.9 % quantile of the luminance of colors of mean 0.
fn spread(colors: &[DVec3]) -> (f64, f64) {
    let mut values: Vec<f64> = colors.iter().map(|c| luminance(*c)).collect();
    let deviation = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let place = (values.len() * 999 / 1000).min(values.len() - 1);
    let (_, quantile, _) = values.select_nth_unstable_by(place, f64::total_cmp);
    (deviation, *quantile)
}
