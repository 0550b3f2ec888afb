//! How well colors drawn from statistics stand for the texels they were made of.

use super::{Sampler, color};
use crate::cluster::{Cluster, SliceStatistics};
use crate::color::{lab_from_rgb, luminance};
use crate::error::{Error, Result};
use crate::math::hash::{pcg4d, unit};
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::PI;

/// Sizes of the samples behind a [`ReconstructionError`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ReconstructionSamples {
    /// Draws for mean, standard deviation and quantile, 1 or more. Their u are equally spaced: every cluster gets its share,
    /// and chance is left only in where in its box a color lies.
    pub draws: u32,
    /// Colors on either side of a Wasserstein distance, 1 or more.
    pub points: u32,
    /// Independent distances to average, 1 or more.
    pub repeats: u32,
    /// Seed of all draws.
    pub seed: u32,
}

impl Default for ReconstructionSamples {
    fn default() -> Self {
        Self { draws: 1_000_000, points: 2_500, repeats: 4, seed: 1 }
    }
}

/// Errors of the statistics of one slice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReconstructionError {
    /// Wasserstein-1 distance between drawn colors and texels, Delta-E (Euclidean in signed Lab of `pi f`); mean of the
    /// repeats.
    pub wasserstein: f64,
    /// The same between two independent samples of the texels, of equal size: what a perfect model would show.
    pub wasserstein_floor: f64,
    /// The texels.
    pub source: Spread,
    /// The draws.
    pub drawn: Spread,
}

/// Mean, spread and tail of a set of colors, linear Rec.709, 1/sr.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Mean color.
    pub mean_rgb: [f64; 3],
    /// Standard deviation per component.
    pub std_rgb: [f64; 3],
    /// Mean luminance.
    pub mean_luminance: f64,
    /// Standard deviation of the luminance.
    pub std_luminance: f64,
    /// Luminance that one color in a thousand exceeds.
    pub quantile_999_luminance: f64,
}

impl ReconstructionError {
    /// Wasserstein-1 above its sampling floor, Delta-E; slightly negative by chance where the model is perfect.
    pub fn excess(&self) -> f64 {
        self.wasserstein - self.wasserstein_floor
    }

    /// Distance of the mean colors over the largest standard deviation of the source; 0 where they are equal.
    pub fn mean_error(&self) -> f64 {
        let difference =
            DVec3::from_array(self.drawn.mean_rgb).distance(DVec3::from_array(self.source.mean_rgb));
        let spread = DVec3::from_array(self.source.std_rgb).max_element();
        if difference == 0.0 { 0.0 } else { difference / spread }
    }

    /// Standard deviation of the luminance, draws over source; 1 where neither has any.
    pub fn std_ratio(&self) -> f64 {
        ratio(self.drawn.std_luminance, self.source.std_luminance)
    }

    /// 99.9 % quantile of the luminance above its mean, draws over source; 1 where both are 0.
    pub fn quantile_ratio(&self) -> f64 {
        let above = |s: &Spread| s.quantile_999_luminance - s.mean_luminance;
        ratio(above(&self.drawn), above(&self.source))
    }
}

fn ratio(drawn: f64, source: f64) -> f64 {
    if drawn == source { 1.0 } else { drawn / source }
}

/// Compares draws with the texels (linear Rec.709, 1/sr) the statistics were made of.
///
/// `sampler` is one of these statistics. `wasserstein` gives the exact Wasserstein-1 distance of two clouds of equally
/// many, equally weighted points, with Euclidean cost.
///
/// # Errors
/// No texels; a sample size of 0.
pub fn reconstruction_error(
    texels: &[[f32; 3]],
    statistics: &SliceStatistics,
    sampler: &Sampler,
    samples: ReconstructionSamples,
    wasserstein: impl Fn(&[DVec3], &[DVec3]) -> f64,
) -> Result<ReconstructionError> {
    let draw = |u: f32, random: [f32; 3]| color(statistics, sampler, u, random);
    reconstruction_error_of(texels, statistics, draw, samples, wasserstein)
}

/// [`reconstruction_error`] of any way to draw: `draw_at` makes a color of u and three more numbers, all in (0, 1).
///
/// # Errors
/// No texels; a sample size of 0.
pub fn reconstruction_error_of(
    texels: &[[f32; 3]],
    statistics: &SliceStatistics,
    draw_at: impl Fn(f32, [f32; 3]) -> [f32; 3],
    samples: ReconstructionSamples,
    wasserstein: impl Fn(&[DVec3], &[DVec3]) -> f64,
) -> Result<ReconstructionError> {
    if texels.is_empty() {
        return Err(Error::invalid("slice", "texels", 0, "1 or more"));
    }
    let ReconstructionSamples { draws, points, repeats, seed } = samples;
    for (name, n) in [("draws", draws), ("points", points), ("repeats", repeats)] {
        if n == 0 {
            return Err(Error::invalid("reconstruction error", name, n, "1 or more"));
        }
    }
    let random = |k: u32, stream: u32| pcg4d([k, stream, 0, seed]);
    let draw = |k: u32, stream: u32| {
        let [u, r0, r1, r2] = random(k, stream).map(unit);
        draw_at(u, [r0, r1, r2])
    };
    let texel = |bits: u32| ((u64::from(bits) * texels.len() as u64) >> 32) as usize;
    // The floor's second sample follows the same u as the draws, so that both hold as many sparkles; the chance of how many
    // these are, by far the largest, cancels in the difference.
    let order = order_along_u(texels, statistics);
    let (mut distance, mut floor) = (0.0, 0.0);
    for repeat in 1..=repeats {
        let drawn: Vec<DVec3> = (0..points).map(|k| lab(draw(k, repeat))).collect();
        let source: Vec<DVec3> =
            (0..points).map(|k| lab(texels[texel(pcg4d([k, repeat, 1, seed])[0])])).collect();
        let other: Vec<DVec3> =
            (0..points).map(|k| lab(texels[order[texel(random(k, repeat)[0])]])).collect();
        distance += wasserstein(&drawn, &source) / f64::from(repeats);
        floor += wasserstein(&other, &source) / f64::from(repeats);
    }
    let evenly = |k: u32| {
        let [_, r0, r1, r2] = random(k, 0).map(unit);
        draw_at(((f64::from(k) + 0.5) / f64::from(draws)) as f32, [r0, r1, r2])
    };
    let drawn: Vec<[f32; 3]> = (0..draws).map(evenly).collect();
    Ok(ReconstructionError {
        wasserstein: distance,
        wasserstein_floor: floor,
        source: Spread::of(texels),
        drawn: Spread::of(&drawn),
    })
}

/// Numbers of the texels by nearest cluster, in no order of their own within one.
fn order_along_u(texels: &[[f32; 3]], statistics: &SliceStatistics) -> Vec<usize> {
    let centers: Vec<DVec3> = statistics.clusters.iter().map(Cluster::center).collect();
    let nearest = |texel: [f32; 3]| {
        let color = lab(texel);
        let distances = centers.iter().map(|center| center.distance_squared(color)).enumerate();
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k)
    };
    let mut order: Vec<(usize, u32, usize)> =
        texels.iter().enumerate().map(|(k, t)| (nearest(*t), pcg4d([k as u32, 0, 2, 0])[0], k)).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, _, k)| k).collect()
}

fn wide(rgb: [f32; 3]) -> DVec3 {
    DVec3::from_array(rgb.map(f64::from))
}

fn lab(f: [f32; 3]) -> DVec3 {
    lab_from_rgb(PI * wide(f))
}

impl Spread {
    /// Of at least one color.
    fn of(colors: &[[f32; 3]]) -> Self {
        let n = colors.len() as f64;
        let mean = colors.iter().map(|c| wide(*c)).sum::<DVec3>() / n;
        let squares = |c: &[f32; 3]| (wide(*c) - mean) * (wide(*c) - mean);
        let variance = colors.iter().map(squares).sum::<DVec3>() / n;
        let mut luminances: Vec<f64> = colors.iter().map(|c| luminance(wide(*c))).collect();
        let mean_luminance = luminance(mean);
        let variance_luminance = luminances.iter().map(|y| (y - mean_luminance).powi(2)).sum::<f64>() / n;
        let rank = colors.len() - 1 - colors.len() / 1000;
        Self {
            mean_rgb: mean.to_array(),
            std_rgb: variance.map(f64::sqrt).to_array(),
            mean_luminance,
            std_luminance: variance_luminance.sqrt(),
            quantile_999_luminance: *luminances.select_nth_unstable_by(rank, f64::total_cmp).1,
        }
    }
}
