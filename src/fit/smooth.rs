//! From a table to the smooth part of a paint.

use super::colors::{self, ColorSample};
use super::lobes::{self, LobeFit};
use super::report::{FitReport, Start, aspecular, difference, spread};
use super::samples::{Sample, SampleCounts, collect};
use crate::brdf::cook_torrance::brightness;
use crate::brdf::{ClearCoat, ColorTable, Lobe, LobeGeometry, TabulatedBrdf};
use crate::error::{Error, Result};
use crate::math::half_difference::HalfDifference;
use crate::paint::{Flakes, Paint};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};

/// How to fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitOptions {
    /// Metallic lobes, 1 to 3.
    pub lobes: usize,
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
        Self { lobes: 3, coat: None, table_size, starts: 8, seed: 1, filled: true }
    }
}

impl FitOptions {
    /// Largest side of a fitted color table.
    pub const MAX_TABLE_SIDE: usize = 256;

    /// How often [`fit_smooth`] calls its `tick`, at most.
    pub fn ticks(&self) -> usize {
        2 * self.starts + 8
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
        let angles = HalfDifference::of(wi, wo);
        let chi = self.colors.sample(angles.theta_h as f32, angles.theta_i as f32).map(f64::from);
        DVec3::from(chi) * brightness(self.diffuse, &self.lobes, &LobeGeometry::of(wi, wo))
    }

    /// The paint with this smooth part; `source` says what it was fitted to.
    pub fn into_paint(self, flakes: Option<Flakes>, source: Value, report: &FitReport) -> Paint {
        let Self { coat, diffuse, lobes, colors } = self;
        let provenance =
            json!({ "made": "fit", "source": source, "fit": report, "carpaint": env!("CARGO_PKG_VERSION") });
        Paint { coat, diffuse, lobes, colors, flakes, provenance }
    }
}

/// The smooth part of any paint, fitted or blended.
impl From<&Paint> for SmoothFit {
    fn from(paint: &Paint) -> Self {
        let Paint { coat, diffuse, lobes, colors, .. } = paint;
        Self { coat: *coat, diffuse: *diffuse, lobes: lobes.clone(), colors: colors.clone() }
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
    let given = options.coat.unwrap_or(ClearCoat::NONE);
    let (samples, mut counts) = collect(table, &given, options.seed, options.filled);
    if samples.iter().all(|s| s.intensity() <= 0.0) {
        return Err(Error::invalid("fit", "table", "no positive intensity", "light in at least one cell"));
    }
    let fitted = lobes::fit(&samples, &given, options.lobes, options.starts, options.seed, tick)?;
    let terms = Terms { samples: &samples, fitted: &fitted };
    let colors = colors::fit(&terms.color_samples(), options.table_size, fitted.epsilon)?;
    tick();
    counts.gloss = samples.len() - terms.base().count();
    // Until the report is made the coat has the gloss that the table holds.
    let coat = ClearCoat { gloss: fitted.gloss, ..given };
    let mut fit = SmoothFit { coat, diffuse: fitted.diffuse, lobes: fitted.lobes.clone(), colors };
    let mut report = terms.report(table, &fit, options, counts);
    fit.coat.gloss = given.gloss.or(fitted.gloss);
    report.coat = fit.coat;
    tick();
    Ok((fit, report))
}

/// The samples and what was fitted to them.
struct Terms<'a> {
    samples: &'a [Sample],
    fitted: &'a LobeFit,
}

impl Terms<'_> {
    fn base(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter().filter(|s| !self.in_gloss(s))
    }

    fn in_gloss(&self, sample: &Sample) -> bool {
        sample.outer_theta_h() < self.fitted.gloss_end
    }

    fn brightness(&self, sample: &Sample) -> f64 {
        sample.transmittance * brightness(self.fitted.diffuse, &self.fitted.lobes, &sample.geometry)
    }

    fn gloss(&self, sample: &Sample) -> f64 {
        self.fitted.gloss.map_or(0.0, |lobe| lobe.eval(&sample.outer))
    }

    fn color_samples(&self) -> Vec<ColorSample<'_>> {
        self.base()
            .map(|sample| ColorSample {
                sample,
                brightness: self.brightness(sample),
                color: sample.color - DVec3::splat(self.gloss(sample)),
            })
            .collect()
    }

    /// The fit at a sample, color table in.
    fn colored(&self, sample: &Sample, colors: &ColorTable) -> DVec3 {
        let chi = colors.sample(sample.angles.theta_h as f32, sample.angles.theta_i as f32).map(f64::from);
        DVec3::from(chi) * self.brightness(sample) + DVec3::splat(self.gloss(sample))
    }

    /// Eq. 7 over the samples in or outside the gloss peak, for a model of the intensity.
    fn error(&self, gloss: bool, model: impl Fn(&Sample) -> f64) -> f64 {
        let epsilon = self.fitted.epsilon;
        let (mut sum, mut count) = (0.0, 0usize);
        for s in self.samples.iter().filter(|s| self.in_gloss(s) == gloss) {
            sum += ((s.intensity().max(0.0) + epsilon) / (model(s).max(0.0) + epsilon)).ln().abs();
            count += 1;
        }
        sum / count.max(1) as f64
    }

    /// Fitted over measured light of the gloss peak, what lies below it taken off both.
    fn gloss_energy(&self, colors: &ColorTable) -> f64 {
        let (mut fitted, mut measured) = (0.0, 0.0);
        for s in self.samples.iter().filter(|s| self.in_gloss(s)) {
            let weight = s.solid_angle * s.outer.cos_i * s.outer.cos_o;
            let gloss = self.gloss(s);
            let below = self.colored(s, colors).element_sum() / 3.0 - gloss;
            fitted += weight * gloss;
            measured += weight * (s.intensity() - below);
        }
        fitted / measured
    }

    fn report(
        &self,
        table: &TabulatedBrdf,
        fit: &SmoothFit,
        options: &FitOptions,
        samples: SampleCounts,
    ) -> FitReport {
        let plain = |s: &Sample| self.brightness(s) + self.gloss(s);
        let colored = |s: &Sample| self.colored(s, &fit.colors).element_sum() / 3.0;
        let differences: Vec<f64> =
            self.samples.par_iter().map(|s| difference(s.color, self.colored(s, &fit.colors))).collect();
        let outside = self.samples.iter().zip(&differences).filter(|(s, _)| !self.in_gloss(s));
        let measured = fit.colors.measured();
        FitReport {
            options: options.clone(),
            coat: fit.coat,
            diffuse: fit.diffuse,
            lobes: fit.lobes.clone(),
            samples,
            epsilon: self.fitted.epsilon,
            error: self.error(false, plain),
            colored_error: self.error(false, colored),
            gloss_error: self.fitted.gloss.map(|_| self.error(true, colored)),
            gloss_energy: self.fitted.gloss.map(|_| self.gloss_energy(&fit.colors)),
            gloss_end_deg: self.fitted.gloss_end.to_degrees(),
            starts: self.fitted.starts.iter().map(|s| Start { error: s.error, steps: s.steps }).collect(),
            aspecular: aspecular(table, fit),
            delta_e_2000: spread(outside.map(|(_, d)| *d).collect()),
            texels_measured: measured.iter().filter(|m| **m).count() as f64 / measured.len() as f64,
            delta_e_2000_with_gloss: spread(differences),
        }
    }
}
