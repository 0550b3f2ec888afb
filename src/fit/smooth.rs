//! From a table to the smooth part of a paint.

use super::explained::Explained;
use super::lobes::Search;
use super::optimizer::Optimizer;
use super::report::FitReport;
use super::samples::{SampleCounts, Samples, of_sets, of_table};
use super::spectral::SpectralColors;
use crate::brdf::{ClearCoat, ColorTable, Lobe, LobeGeometry, Measured, SampleSet, TabulatedBrdf, base};
use crate::error::{Error, Result};
use crate::math::half_difference::HalfDifference;
use crate::paint::{Flakes, Paint};
use glam::DVec3;
use serde::Serialize;
use serde_json::{Value, json};

/// How to fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitOptions {
    /// Metallic lobes, 1 to 3.
    pub lobes: usize,
    /// Whether fewer lobes are tried, too, and taken if an information criterion says that more say nothing.
    pub choose_lobes: bool,
    /// What lowers the error.
    pub optimizer: Optimizer,
    /// The clear coat, if it is known: its losses (and its refraction, if it refracts) are taken out of the table. If it has a
    /// mirror or a gloss lobe of its own the table holds no gloss, as those of simulated paints: none is sought or taken off.
    /// `None`: a coat without losses, whose gloss lobe is fitted.
    pub coat: Option<ClearCoat>,
    /// Columns (theta_h) and rows (theta_i) of the color table, 2 to 256.
    pub table_size: [usize; 2],
    /// Starts of the solver, 1 to 1000.
    pub starts: usize,
    /// Seed of the starts.
    pub seed: u32,
    /// Whether the table may hold cells filled in by repetition, as measured ones do: such cells are left out. False for a
    /// table computed from a model or a neural BRDF, in which equal neighbors are values: where glitter underflows, a
    /// simulated table is constant in azimuth.
    pub filled: bool,
}

impl Default for FitOptions {
    fn default() -> Self {
        let table_size = ColorTable::DEFAULT_SIZE;
        Self {
            lobes: 3,
            choose_lobes: false,
            optimizer: Optimizer::default(),
            coat: None,
            table_size,
            starts: 8,
            seed: 1,
            filled: true,
        }
    }
}

impl FitOptions {
    /// Largest side of a fitted color table.
    pub const MAX_TABLE_SIDE: usize = 256;

    /// How often [`fit_smooth`] and [`fit_samples`] call their `tick`, at most.
    pub fn ticks(&self) -> usize {
        let races = 1 + if self.choose_lobes { self.lobes } else { 1 };
        races * self.starts + 8
    }

    fn given_coat(&self) -> ClearCoat {
        self.coat.unwrap_or(ClearCoat::NONE)
    }

    fn validate(&self) -> Result<()> {
        if !(1..=3).contains(&self.lobes) {
            return Err(Error::invalid("fit", "lobes", self.lobes, "1 to 3"));
        }
        if !(1..=1000).contains(&self.starts) {
            return Err(Error::invalid("fit", "starts", self.starts, "1 to 1000"));
        }
        if self.table_size.iter().any(|n| !(2..=Self::MAX_TABLE_SIDE).contains(n)) {
            let found = format!("{} x {}", self.table_size[0], self.table_size[1]);
            return Err(Error::invalid("fit", "color table", found, "sides of 2 to 256"));
        }
        self.coat.map_or(Ok(()), |coat| coat.validate())
    }
}

/// The smooth part of a paint: everything but its flakes.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothFit {
    /// The clear coat.
    pub coat: ClearCoat,
    /// Diffuse intensity.
    pub diffuse: f64,
    /// Lobes, widest first.
    pub lobes: Vec<Lobe>,
    /// The color table chi.
    pub colors: ColorTable,
    /// chi by wavelength, if it was fitted to spectra.
    pub spectral: Option<SpectralColors>,
}

impl SmoothFit {
    /// BRDF as seen from outside for unit directions away from the surface, linear Rec.709, 1/sr: gloss lobe included, ideal
    /// mirror not. 0 below the horizon.
    pub fn eval(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return DVec3::ZERO;
        }
        let gloss = self.coat.gloss.map_or(0.0, |lobe| lobe.eval(&LobeGeometry::of(wi, wo)));
        let base = self.base(self.coat.inner(wi), self.coat.inner(wo));
        base * self.coat.transmittance(wi.z, wo.z) + DVec3::splat(gloss)
    }

    /// BRDF under the coat, `chi (a/pi + sum CT)`, for unit directions under the coat.
    pub fn base(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        base(&self.colors, self.diffuse, &self.lobes, wi, wo)
    }

    /// The paint with this smooth part; `source` says what it was fitted to.
    pub fn into_paint(self, flakes: Option<Flakes>, source: Value, report: &FitReport) -> Paint {
        let Self { coat, diffuse, lobes, colors, .. } = self;
        let provenance =
            json!({ "made": "fit", "source": source, "fit": report, "carpaint": env!("CARGO_PKG_VERSION") });
        Paint { coat, diffuse, lobes, colors, flakes, provenance }
    }
}

/// The smooth part of any paint, fitted or blended.
impl From<&Paint> for SmoothFit {
    fn from(paint: &Paint) -> Self {
        let Paint { coat, diffuse, lobes, colors, .. } = paint;
        Self { coat: *coat, diffuse: *diffuse, lobes: lobes.clone(), colors: colors.clone(), spectral: None }
    }
}

/// Fits diffuse, lobes, gloss and color table to a measured or simulated BRDF.
///
/// The same bits for any number of threads. `tick` is called after every start and stage, at most
/// [`FitOptions::ticks`] times.
///
/// # Errors
/// An option outside its range; a table without usable cells or without light.
pub fn fit_smooth(
    table: &TabulatedBrdf,
    options: &FitOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<(SmoothFit, FitReport)> {
    options.validate()?;
    let (samples, counts) = of_table(table, &options.given_coat(), options.seed, options.filled);
    fit(&samples, counts, options, &|wi, wo| Some(table.eval(wi, wo)), tick)
}

/// Fits diffuse, lobes, gloss and color table to scattered samples of any bands, each under its own light.
///
/// Samples taken for the gloss (Rump et al. 2008, section 5.1.1) may come as a set of their own, `gloss`, which serves the gloss lobe
/// alone; the other samples around the mirror direction serve it in any case. A coat of known index has a gloss of that index. The same bits for any number of threads. `tick` is
/// called after every start and stage, at most [`FitOptions::ticks`] times.
///
/// # Errors
/// An option outside its range; no sample, or none that has light; sets of different bands; a light whose shares do not sum to 1.
pub fn fit_samples(
    base: &SampleSet,
    gloss: Option<&SampleSet>,
    options: &FitOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<(SmoothFit, FitReport)> {
    options.validate()?;
    let (samples, counts) = of_sets(base, gloss, &options.given_coat(), options.seed)?;
    fit(&samples, counts, options, &|wi, wo| samples.near(wi, wo), tick)
}

/// Fits whatever was measured: [`fit_smooth`] to tables, [`fit_samples`] to the rest.
///
/// # Errors
/// Those of either.
pub fn fit_measured(
    measured: &Measured,
    options: &FitOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<(SmoothFit, FitReport)> {
    match measured {
        Measured::Table(table) => fit_smooth(table, options, tick),
        Measured::Scattered(measurement) => fit_samples(&measurement.samples, None, options, tick),
    }
}

/// A measured intensity and what a fit says there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Compared {
    /// Angle of half vector and normal, radians.
    pub theta_h: f64,
    /// Mean of the bands, 1/sr.
    pub measured: f64,
    /// The same of the fit, gloss included.
    pub fitted: f64,
}

/// Up to `count` cells of a table, of all that a fit with `options` takes, against the fit.
pub fn compare(table: &TabulatedBrdf, fit: &SmoothFit, options: &FitOptions, count: usize) -> Vec<Compared> {
    let (samples, _) = of_table(table, &options.given_coat(), options.seed, options.filled);
    let list = &samples.list;
    let at = |k: usize| compared(list[k].wi, list[k].wo, list[k].intensity, fit);
    evenly(list.len(), count).map(at).collect()
}

/// Up to `count` samples against the fit.
pub fn compare_samples(set: &SampleSet, fit: &SmoothFit, count: usize) -> Vec<Compared> {
    let bands = set.bands().len() as f64;
    let at = |k: usize| {
        let s = &set.samples()[k];
        compared(s.wi, s.wo, set.values(k).iter().sum::<f64>() / bands, fit)
    };
    evenly(set.len(), count).map(at).collect()
}

/// Up to `count` of `all`, evenly spread.
fn evenly(all: usize, count: usize) -> impl Iterator<Item = usize> {
    let n = all.min(count);
    (0..n).map(move |k| k * all / n)
}

fn compared(wi: DVec3, wo: DVec3, measured: f64, fit: &SmoothFit) -> Compared {
    let theta_h = HalfDifference::of(wi, wo).theta_h;
    Compared { theta_h, measured, fitted: fit.eval(wi, wo).element_sum() / 3.0 }
}

/// The one way of both. `measured` is the measurement in two directions, if it was taken there.
fn fit(
    samples: &Samples,
    counts: SampleCounts,
    options: &FitOptions,
    measured: &dyn Fn(DVec3, DVec3) -> Option<DVec3>,
    tick: &(dyn Fn() + Sync),
) -> Result<(SmoothFit, FitReport)> {
    if samples.list.iter().all(|s| s.intensity <= 0.0) {
        return Err(Error::invalid("fit", "samples", "no positive intensity", "light in at least one"));
    }
    let search = Search::new(samples, options.optimizer, options.starts, options.seed, tick);
    let fitted = search.fit(options.lobes, options.choose_lobes)?;
    let explained = Explained::new(samples, &fitted);
    let (colors, spectral) = explained.colors(options.table_size)?;
    tick();
    // Until the report is made the coat has the gloss that the samples hold.
    let coat = ClearCoat { gloss: fitted.gloss, ..samples.coat };
    let lobes = fitted.lobes.clone();
    let mut fit = SmoothFit { coat, diffuse: fitted.diffuse, lobes, colors, spectral };
    let mut report = explained.report(&fit, measured, options, counts);
    fit.coat.gloss = samples.coat.gloss.or(fitted.gloss);
    report.coat = fit.coat;
    tick();
    Ok((fit, report))
}
