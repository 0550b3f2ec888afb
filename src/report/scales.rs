//! Mean and standard deviation of flakes under footprints of all sizes and shapes: drawn against the source, box-filtered.

use super::angular::by_energy;
use crate::btf::AngleGrid;
use crate::color::luminance;
use crate::error::Result;
use crate::math::half_difference::directions;
use crate::math::hash::pcg4d;
use crate::paint::Flakes;
use crate::render::{Random, RenderFlakes, Surface};
use crate::simulate::{Model, Synthesis, SynthesisOptions};
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// The source is simulated so much finer than the paint's texels, an axis: what its own texels blur is then small.
const FINER: usize = 4;
/// Places at which a footprint is tried on the source, and at which it is drawn.
const SOURCE_PLACES: u32 = 8192;
const DRAWN_PLACES: u32 = 60_000;
/// Slices over which variances are averaged, strongest first.
const SLICES: usize = 4;

/// One footprint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scale {
    /// Root of its area, texels.
    pub side_texels: f64,
    /// Long side over short side.
    pub ratio: f64,
    /// Standard deviation over that of the box-filtered source, luminance, root mean square over the slices.
    pub deviation_ratio: f64,
    /// Drawn mean less the mean of the statistics, over the standard deviation of a texel.
    pub mean_error: f64,
    /// Standard error of the last.
    pub mean_noise: f64,
}

/// Mean and standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    pub mean: f64,
    pub deviation: f64,
}

impl Moments {
    pub fn of(values: &[f32]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        let square = values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / n;
        Self { mean, deviation: square.sqrt() }
    }

    /// Correlation of two lists of equal length.
    pub fn correlation(a: &[f32], b: &[f32]) -> f64 {
        let [m, n] = [a, b].map(Self::of);
        let products = a.iter().zip(b).map(|(x, y)| (f64::from(*x) - m.mean) * (f64::from(*y) - n.mean));
        products.sum::<f64>() / (m.deviation * n.deviation * a.len() as f64)
    }
}

/// Luminance of every texel.
pub(super) fn luminances(texels: &[[f32; 3]]) -> Vec<f32> {
    texels.iter().map(|t| luminance(DVec3::from(t.map(f64::from))) as f32).collect()
}

/// The table for footprints of `sides` (root of the area, texels) and `ratios`, long side over short, lying at 0 and 35 degrees.
/// `options` are those of the paint's slices; the source shows the same flakes.
///
/// # Errors
/// Those of the synthesis.
pub fn scales(
    model: &Model,
    options: &SynthesisOptions,
    flakes: &Flakes,
    footprints: &[(f64, f64)],
) -> Result<Vec<Scale>> {
    let strongest: Vec<usize> =
        by_energy(flakes).into_iter().take(40).map(|s| s.0).step_by(40 / SLICES).collect();
    let mut rows = vec![1; flakes.grid.rows().len()];
    for (h, i) in strongest.iter().map(|k| flakes.grid.bins_of(*k)) {
        rows[i] = rows[i].max(h + 1);
    }
    let options = SynthesisOptions {
        grid: AngleGrid::new(flakes.grid.bins(), rows)?,
        size: flakes.size.map(|n| n * FINER),
        texel_mm: Some(flakes.texel_mm / FINER as f64),
        ..options.clone()
    };
    let synthesis = Synthesis::new(model, &options)?;
    let drawn = RenderFlakes::new(flakes)?;
    let sources = strongest.par_iter().filter_map(|k| {
        let (h, i) = flakes.grid.bins_of(*k);
        let texels = luminances(&synthesis.slice(options.grid.slice(h, i)?).fluctuation);
        Some(Source { angles: flakes.grid.angles(*k), texels, size: options.size })
    });
    let sources: Vec<Source> = sources.collect();
    let row = |(side, ratio): &(f64, f64)| {
        let shape = [0.0f32, 35.0].map(|turn| {
            let turn = Vec2::from_angle(turn.to_radians());
            let root = ratio.sqrt();
            [turn * (side * root) as f32, turn.perp() * (side / root) as f32]
        });
        let (mut seen, mut exact, mut texel, mut shift, mut squares) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for footprint in if *ratio == 1.0 { &shape[..1] } else { &shape } {
            for (seed, source) in (1..).zip(&sources) {
                let (theta_h, theta_i) = source.angles;
                let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
                let passed = model.coat().transmittance(wi.z, wo.z);
                let moments =
                    draw(&drawn, footprint.map(|s| s * flakes.texel_mm as f32), source.angles, seed);
                seen += (passed * moments.deviation).powi(2);
                exact += Moments::of(&source.filtered(footprint)).deviation.powi(2);
                texel += Moments::of(&source.texels).deviation.powi(2);
                let mean = drawn.mean(theta_h as f32, theta_i as f32).as_dvec3();
                shift += passed * (moments.mean - luminance(mean));
                squares += (passed * moments.deviation).powi(2) / f64::from(DRAWN_PLACES);
            }
        }
        let count = if *ratio == 1.0 { 1.0 } else { 2.0 } * sources.len() as f64;
        let texel = (texel / count).sqrt();
        Scale {
            side_texels: *side,
            ratio: *ratio,
            deviation_ratio: (seen / exact).sqrt(),
            mean_error: shift / count / texel,
            mean_noise: squares.sqrt() / count / texel,
        }
    };
    Ok(footprints.par_iter().map(row).collect())
}

/// A slice simulated finely.
struct Source {
    angles: (f64, f64),
    texels: Vec<f32>,
    size: [usize; 2],
}

impl Source {
    /// Means over a footprint, in texels of the paint, at many places.
    fn filtered(&self, footprint: &[Vec2; 2]) -> Vec<f32> {
        let sides = footprint.map(|s| s * FINER as f32);
        let count = sides.map(|s| s.length().ceil().max(1.0));
        let at = |place: Vec2| {
            let [x, y] = [(place.x, self.size[0]), (place.y, self.size[1])]
                .map(|(c, n)| (c.floor() as i64).rem_euclid(n as i64) as usize);
            self.texels[y * self.size[0] + x]
        };
        let mean = |k: u32| {
            let [x, y, ..] = pcg4d([k, 5, 6, 7]);
            let corner = Vec2::new((x % self.size[0] as u32) as f32, (y % self.size[1] as u32) as f32);
            let mut sum = 0.0;
            for b in 0..count[1] as u32 {
                for a in 0..count[0] as u32 {
                    let inside = [(a, 0), (b, 1)].map(|(n, axis)| (n as f32 + 0.5) / count[axis]);
                    sum += at(corner + sides[0] * inside[0] + sides[1] * inside[1]);
                }
            }
            sum / (count[0] * count[1])
        };
        (0..SOURCE_PLACES).map(mean).collect()
    }
}

/// Luminance drawn over a footprint, millimetres.
fn draw(flakes: &RenderFlakes, footprint: [Vec2; 2], (theta_h, theta_i): (f64, f64), seed: u32) -> Moments {
    // Places far enough apart to share no cell, and off the lattices.
    let apart = 2.37 * (footprint[0].length() + footprint[1].length()) + 0.1;
    let values = (0..DRAWN_PLACES).map(|k| {
        let uv_mm = Vec2::new((k % 256) as f32, (k / 256) as f32) * apart;
        let surface = Surface { chart: 0, uv_mm, footprint, seed, random: Random::Hash };
        let xi = flakes.xi(&flakes.draws(&surface), theta_h as f32, theta_i as f32, Vec2::ZERO);
        luminance(xi.as_dvec3()) as f32
    });
    Moments::of(&values.collect::<Vec<_>>())
}
