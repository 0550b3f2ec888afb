//! How flakes light up and go out as the half vector turns, and what is drawn between slices: drawn against simulated.

use super::drawn::Drawn;
use super::moments::{Moments, luminances};
use super::slices::{chosen, with_cells};
use crate::btf::AngleGrid;
use crate::color::luminance;
use crate::error::Result;
use crate::math::half_difference::directions;
use crate::paint::Flakes;
use crate::render::FlakeDraws;
use crate::simulate::{Model, Synthesis, SynthesisOptions};
use glam::Vec2;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// Bins of the simulated source: steps of half a degree.
const FINE_BINS: usize = 180;
/// The source is so much wider than the paint's slices: the fewer flakes shine, the more it takes to know their width.
const WIDER: usize = 2;
/// Places at which flakes are drawn.
const PLACES: usize = 30_000;

/// Half-widths of the autocorrelation over theta_h about one slice, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HalfWidth {
    /// Angle between half vector and normal, degrees.
    pub theta_h_deg: f64,
    /// Angle between half vector and light, degrees.
    pub theta_i_deg: f64,
    /// Whether the slice is one of those that hold 80 % of the flakes' energy.
    pub strong: bool,
    /// How many texels of the source share the light evenly: (sum y)^2 / sum y^2 of the flakes' luminances. Where they are few,
    /// single flakes make the half-width.
    pub lit_texels: f64,
    /// Simulated at half-degree steps.
    pub source_deg: f64,
    /// Drawn.
    pub drawn_deg: f64,
}

impl HalfWidth {
    /// Drawn over simulated.
    pub fn ratio(&self) -> f64 {
        self.drawn_deg / self.source_deg
    }
}

/// Standard deviation of the luminance midway between slices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Midway {
    /// Angle between half vector and normal, degrees.
    pub theta_h_deg: f64,
    /// Angle between half vector and light, degrees.
    pub theta_i_deg: f64,
    /// Simulated there.
    pub source: f64,
    /// Interpolated between the slices around.
    pub drawn: f64,
}

/// Random numbers of many places under the smallest footprint, no two in one cell.
fn places(flakes: &Flakes, drawn: &Drawn) -> Vec<FlakeDraws> {
    let side = 1e-3 * flakes.texel_mm as f32;
    let apart = 8.0 * flakes.levels[0].pitch_mm as f32;
    drawn.places(PLACES, apart, [Vec2::X * side, Vec2::Y * side], 1).collect()
}

/// The half-widths about up to twelve slices of a paint that hold 80 % of its flakes' energy, and about as many of the others
/// that hold any. `options` are those of the paint's slices. Slices about which the
/// source's half-width does not fit on the grid are left out.
///
/// # Errors
/// Those of the synthesis.
pub fn half_widths(model: &Model, options: &SynthesisOptions, flakes: &Flakes) -> Result<Vec<HalfWidth>> {
    let chosen = chosen(flakes);
    let fine = |theta_deg: f64| (theta_deg * 2.0).round() as usize;
    let cells: Vec<(usize, usize, bool)> = chosen
        .into_iter()
        .map(|(slice, strong)| {
            let (theta_h, theta_i) = flakes.grid.angles(slice);
            (fine(theta_h.to_degrees()), fine(theta_i.to_degrees()), strong)
        })
        .collect();
    let size = options.size.map(|n| n * WIDER);
    let texel_mm = Some(flakes.texel_mm);
    // All of a row: how far the correlation reaches is not known yet.
    let whole = cells.iter().map(|(_, row, _)| (FINE_BINS - 1 - row, *row));
    let options = SynthesisOptions { size, texel_mm, ..options.clone() };
    let options = with_cells(&options, FINE_BINS, whole)?;
    let synthesis = Synthesis::new(model, &options)?;
    let drawn = Drawn::new(model.coat(), flakes)?;
    let places = places(flakes, &drawn);
    let width = |(theta_h, row, strong): (usize, usize, bool)| {
        let number = |theta_h: usize| options.grid.slice(theta_h, row);
        let angles =
            |theta_h: usize| (options.grid.width() * theta_h as f64, options.grid.width() * row as f64);
        let source = half_width(theta_h, options.grid.rows()[row], |at| {
            number(at).map(|k| luminances(&synthesis.slice(k).fluctuation)).unwrap_or_default()
        })?;
        let drawn = half_width(theta_h, options.grid.rows()[row], |at| drawn.luminances(&places, angles(at)));
        let (wi, wo) = directions(angles(theta_h).0, angles(theta_h).1, FRAC_PI_2);
        let glitter = luminance(model.glitter(wi, wo).linear_rgb());
        let lit_texels = lit_texels(&luminances(&synthesis.slice(number(theta_h)?).fluctuation), glitter);
        let [theta_h_deg, theta_i_deg] = [theta_h, row].map(|k| k as f64 / 2.0);
        let [source_deg, drawn_deg] = [source, drawn.unwrap_or(f64::INFINITY)].map(|w| w / 2.0);
        Some(HalfWidth { theta_h_deg, theta_i_deg, strong, lit_texels, source_deg, drawn_deg })
    };
    Ok(cells.into_par_iter().filter_map(width).collect())
}

/// How many of the texels share the light, given their fluctuations about `mean`.
fn lit_texels(fluctuations: &[f32], mean: f64) -> f64 {
    let light = |f: &f32| f64::from(*f) + mean;
    let (sum, squares) = fluctuations.iter().map(light).fold((0.0, 0.0), |(s, q), y| (s + y, q + y * y));
    sum * sum / squares
}

/// Lag at which the correlation with `values(from)` falls to one half, in steps: the mean of both sides while both are there.
fn half_width(from: usize, end: usize, values: impl Fn(usize) -> Vec<f32>) -> Option<f64> {
    let here = values(from);
    let with = |at: usize| Moments::correlation(&here, &values(at));
    let mut before = 1.0;
    for lag in 1.. {
        let sides = [from.checked_sub(lag), Some(from + lag).filter(|at| *at < end)];
        let sides: Vec<f64> = sides.into_iter().flatten().map(with).collect();
        if sides.is_empty() {
            return None;
        }
        let correlation = sides.iter().sum::<f64>() / sides.len() as f64;
        if correlation <= 0.5 {
            return Some(lag as f64 - (0.5 - correlation) / (before - correlation));
        }
        before = correlation;
    }
    None
}

/// The standard deviation between slices, at all middles of cells of the grid that hold 95 % of the energy, thinned: along
/// either axis and both.
///
/// # Errors
/// Those of the synthesis.
pub fn midway(model: &Model, options: &SynthesisOptions, flakes: &Flakes) -> Result<Vec<Midway>> {
    let grid = AngleGrid::triangle(2 * flakes.grid.bins())?;
    let cells: Vec<usize> = chosen(flakes)
        .into_iter()
        .filter(|c| c.1)
        .flat_map(|(slice, _)| {
            let (h, i) = flakes.grid.bins_of(slice);
            [(1, 0), (0, 1), (1, 1)].map(|(dh, di)| (2 * h + dh, 2 * i + di))
        })
        // All slices around must be there.
        .filter(|(h, i)| flakes.grid.slice(h.div_ceil(2), i.div_ceil(2)).is_some())
        .filter_map(|(h, i)| grid.slice(h, i))
        .collect();
    let options = with_cells(options, grid.bins(), cells.iter().map(|k| grid.bins_of(*k)))?;
    let synthesis = Synthesis::new(model, &options)?;
    let drawn = Drawn::new(model.coat(), flakes)?;
    let places = places(flakes, &drawn);
    let row = |k: usize| {
        let ((h, i), (theta_h, theta_i)) = (grid.bins_of(k), grid.angles(k));
        let source = synthesis.slice(options.grid.slice(h, i)?);
        Some(Midway {
            theta_h_deg: theta_h.to_degrees(),
            theta_i_deg: theta_i.to_degrees(),
            source: Moments::of(&luminances(&source.fluctuation)).deviation,
            drawn: Moments::of(&drawn.luminances(&places, (theta_h, theta_i))).deviation,
        })
    };
    Ok(cells.into_par_iter().filter_map(row).collect())
}
