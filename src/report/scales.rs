//! Mean and standard deviation of flakes under footprints of all sizes and shapes: drawn against the source, box-filtered.

use super::drawn::Drawn;
use super::moments::{Moments, luminances};
use super::slices::{by_energy, with_cells};
use crate::error::Result;
use crate::paint::Flakes;
use crate::simulate::{Model, Synthesis, SynthesisOptions};
use glam::{DVec2, Vec2};
use rayon::prelude::*;
use serde::Serialize;

/// The source is simulated so much finer than the paint's texels, an axis: what its own texels blur is then small.
const FINER: usize = 4;
/// Places at which a footprint is tried on the source: so many that each texel is seen 16 times, but no more than this.
const SOURCE_PLACES: f32 = 65_536.0;
const OVERLAP: f32 = 16.0;
/// Places at which a footprint is drawn.
const DRAWN_PLACES: usize = 60_000;
/// Steps of Roberts' sequence: one over the plastic ratio, and over its square.
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
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
    let options = SynthesisOptions {
        size: flakes.size.map(|n| n * FINER),
        texel_mm: Some(flakes.texel_mm / FINER as f64),
        ..options.clone()
    };
    let cells = strongest.iter().map(|k| flakes.grid.bins_of(*k));
    let options = with_cells(&options, flakes.grid.bins(), cells)?;
    let synthesis = Synthesis::new(model, &options)?;
    let drawn = Drawn::new(model.coat(), flakes)?;
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
                let footprint_mm = footprint.map(|s| s * flakes.texel_mm as f32);
                // Far enough apart to share no cell, and off the lattices.
                let apart = 2.37 * (footprint_mm[0].length() + footprint_mm[1].length()) + 0.1;
                let places = drawn.places(DRAWN_PLACES, apart, footprint_mm, seed);
                let moments = Moments::of(&drawn.luminances(places, source.angles));
                seen += moments.deviation.powi(2);
                exact += Moments::of(&source.filtered(footprint)).deviation.powi(2);
                texel += Moments::of(&source.texels).deviation.powi(2);
                shift += moments.mean - drawn.mean(source.angles);
                squares += moments.deviation.powi(2) / DRAWN_PLACES as f64;
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
    /// Means over a footprint, in texels of the paint, at places spread evenly (Roberts' sequence): few flakes make the contrast,
    /// and each must count alike.
    fn filtered(&self, footprint: &[Vec2; 2]) -> Vec<f32> {
        let sides = footprint.map(|s| s * FINER as f32);
        let count = sides.map(|s| s.length().ceil().max(1.0));
        let at = |place: Vec2| {
            let [x, y] = [(place.x, self.size[0]), (place.y, self.size[1])]
                .map(|(c, n)| (c.floor() as i64).rem_euclid(n as i64) as usize);
            self.texels[y * self.size[0] + x]
        };
        let [width, height] = self.size.map(|n| n as f64);
        let windows = (width * height) as f32 / sides[0].perp_dot(sides[1]).abs();
        let places = (OVERLAP * windows).min(SOURCE_PLACES) as u32;
        let mean = |k: u32| {
            let [x, y] = PLASTIC.map(|step| (f64::from(k) * step).fract());
            let corner = DVec2::new(x * width, y * height).floor().as_vec2();
            let mut sum = 0.0;
            for b in 0..count[1] as u32 {
                for a in 0..count[0] as u32 {
                    let inside = [(a, 0), (b, 1)].map(|(n, axis)| (n as f32 + 0.5) / count[axis]);
                    sum += at(corner + sides[0] * inside[0] + sides[1] * inside[1]);
                }
            }
            sum / (count[0] * count[1])
        };
        (0..places).map(mean).collect()
    }
}
