//! The flakes of the pictures: what the homogeneous BRDF leaves, resampled to slices over (theta_h, theta_i) (Rump et al. 2008,
//! section 5.2).
//!
//! The fitted BRDF, gloss and all, is taken off every texel with the directions of its own place, and so is the quadratic surface
//! through what is left: flakes change from texel to texel, and what varies slowly over a square is misfit of the smooth part (the
//! wings of a gloss, above all) and no flake. Pairs lie scattered over the angles. A slice is a
//! square of texels of one picture, whole, since a mean of pictures would wash its flakes out: of the pairs nearest to the cell
//! the one that sees the sample steepest, clear of the mirrored flash. That pair's angles are not the cell's: its texels are scaled
//! to the standard deviation, and moved to the mean, that a line through the logarithms (and the means) of the nearest pairs has
//! at the cell. Energy is kept: smooth part and mean of the slice together are what was measured there.
//!
//! A flat view averages over more of the sample, and more flakes. By how much is measured: of a pair and the pair with eye and
//! light exchanged the flakes are the same (reciprocity), and only the views differ. The exponent of the cosine that explains all of
//! these takes deviations to the view from above.
//!
//! Neighboring slices come from half vectors of any azimuth, and show other flakes.

use super::{Blemishes, PairGeometry, Pairs, Sheet};
use crate::brdf::{ClearCoat, TabulatedBrdf};
use crate::btf::{AngleGrid, FlakeBtf, FlakeSlice};
use crate::color::luminance;
use crate::error::{Error, Result};
use crate::math::half_difference::directions;
use crate::parallel::TryMap;
use glam::{DVec2, DVec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::num::NonZero;

/// Pairs around a cell.
const NEIGHBORS: usize = 8;
/// Width of their weights over the angles, radians: 4 degrees, most of a flake's lifetime.
const WIDTH: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// Distance that is as bad as a view at 60 degrees, radians.
const AS_BAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Rows end with the last cell that has a pair within this many bins.
const REACH_BINS: f64 = 1.0;
/// Most that a texture is scaled by, either way: beyond, it says more of the fit than of the paint.
const MOST_SCALE: f64 = 2.0;
/// Most gloss in a square, as a share of the base: where there is more, what the fit of a gloss misses outshines flakes.
const MOST_GLOSS: f64 = 0.1;
/// Polar and azimuthal cells of the smooth part beside the slices.
const SMOOTH_RESOLUTION: [usize; 2] = [45, 90];

/// How slices are cut.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SliceOptions {
    /// Angle bins per 90 degrees, 2 to 90; dozens of cameras fill 12.
    pub bins: usize,
    /// Side of a texel, millimetres.
    pub texel_mm: f64,
    /// Side of a slice as a share of the sample's, 0.05 to 1.
    pub share: f64,
}

impl SliceOptions {
    /// Twelve bins, slices of half the sample's side.
    pub fn new(texel_mm: f64) -> Self {
        Self { bins: 12, texel_mm, share: 0.5 }
    }

    /// How often [`cut_slices`] calls its `tick` at most.
    pub fn ticks(&self) -> usize {
        (NEIGHBORS + 1) * self.bins * (self.bins + 1) / 2
    }
}

/// How far the slices are from the pairs they come from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SliceReport {
    /// Slices.
    pub slices: usize,
    /// Cells of the triangle beyond the last one of their row that a pair is near to.
    pub unreached: usize,
    /// Mean and greatest distance between a slice's angles and its pair's, degrees.
    pub distance_deg: [f64; 2],
    /// Least and greatest factor on a slice's texels.
    pub scale: [f64; 2],
    /// Power of the cosine of the view by which contrast fades: 0 if pixels resolve flakes, 0.5 if they hold many.
    pub fading: f64,
    /// Pictures left out, with the reason.
    pub left_out: Vec<String>,
}

/// The homogeneous BRDF as seen from outside, 1/sr, of unit directions to light and eye.
pub struct Homogeneous<'a> {
    /// Diffuse and glitter, linear Rec.709.
    pub base: &'a (dyn Fn(DVec3, DVec3) -> DVec3 + Sync),
    /// The gloss.
    pub gloss: &'a (dyn Fn(DVec3, DVec3) -> f64 + Sync),
}

/// A pair with what is left of its picture.
struct Residual {
    camera: usize,
    light: usize,
    /// theta_h, theta_i in the middle of its square, radians.
    angles: [f64; 2],
    cos_o: f64,
    /// First column and row of the square.
    corner: [usize; 2],
    mean: DVec3,
    /// Of the luminance.
    deviation: f64,
}

/// What the smooth part leaves of a square.
struct Square {
    mean: DVec3,
    /// About the quadratic surface through them, row-major.
    texels: Vec<DVec3>,
}

/// Cuts the slices, from squares of the sample without blemishes, and takes `smooth` off them; the smooth part of the result is its
/// base. `tick` is called once a picture looked at and once a slice.
///
/// # Errors
/// An option outside its range; no pair near any cell; a smooth part that is not finite.
pub fn cut_slices(
    pairs: &dyn Pairs,
    sample_mm: [f64; 2],
    smooth: &Homogeneous,
    blemishes: &Blemishes,
    options: &SliceOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<(FlakeBtf, SliceReport)> {
    options.validate(sample_mm)?;
    let cutter = Cutter::new(pairs, sample_mm, smooth, blemishes, options);
    let places = Places::of(pairs)?;
    let grid = places.grid(options.bins)?;
    let (residuals, left_out) = cutter.residuals(&places, &grid, tick)?;
    let fading = fading(&residuals);
    let tree = tree(residuals.iter().map(|r| r.angles).collect())?;
    let cut: Vec<Cut> = (0..grid.len()).into_par_iter().try_map(|k| {
        let cut = cutter.cut(&residuals, fading, &tree, grid.angles(k));
        tick();
        cut
    })?;
    let count = cut.len() as f64;
    let extreme = |f: fn(f64, f64) -> f64, of: fn(&Cut) -> f64| cut.iter().map(of).fold(of(&cut[0]), f);
    let report = SliceReport {
        slices: cut.len(),
        unreached: AngleGrid::triangle(options.bins)?.len() - cut.len(),
        distance_deg: [
            cut.iter().map(|c| c.distance).sum::<f64>() / count,
            extreme(f64::max, |c| c.distance),
        ]
        .map(f64::to_degrees),
        scale: [extreme(f64::min, |c| c.scale), extreme(f64::max, |c| c.scale)],
        fading,
        left_out,
    };
    let [theta, phi] = SMOOTH_RESOLUTION;
    let btf = FlakeBtf {
        grid,
        size: cutter.size,
        texel_mm: options.texel_mm,
        slices: cut.into_iter().map(|c| c.slice).collect(),
        smooth: TabulatedBrdf::from_fn(theta, phi, smooth.base)?,
        coat: ClearCoat::NONE,
        provenance: Value::Null,
    };
    btf.validate()?;
    Ok((btf, report))
}

impl SliceOptions {
    /// Checks every number, for a sample of this size.
    ///
    /// # Errors
    /// One outside its range, named; more texels than a flake BTF may have.
    pub fn validate(&self, sample_mm: [f64; 2]) -> Result<()> {
        if !(2..=90).contains(&self.bins) {
            return Err(Error::invalid("slices", "bins", self.bins, "2 to 90"));
        }
        if !(1e-4..=100.0).contains(&self.texel_mm) {
            return Err(Error::invalid("slices", "texel, mm", self.texel_mm, "0.0001 to 100"));
        }
        if !(0.05..=1.0).contains(&self.share) {
            return Err(Error::invalid("slices", "share of the sample", self.share, "0.05 to 1"));
        }
        let side = |side: f64| (self.share * side / self.texel_mm).ceil();
        let texels = sample_mm.map(side).iter().product::<f64>() * (self.bins * (self.bins + 1) / 2) as f64;
        if texels > FlakeBtf::MAX_TEXELS as f64
            || sample_mm.iter().any(|s| side(*s) > FlakeBtf::MAX_SIDE as f64)
        {
            let legal = format!("sides of up to {}, {} in all", FlakeBtf::MAX_SIDE, FlakeBtf::MAX_TEXELS);
            return Err(Error::invalid("slices", "texels", texels, legal));
        }
        Ok(())
    }
}

/// The angles of all pairs, in the middle of the sample.
struct Places {
    pairs: Vec<(usize, usize)>,
    tree: ImmutableKdTree<f64, 2>,
}

impl Places {
    fn of(pairs: &dyn Pairs) -> Result<Self> {
        let all = (0..pairs.cameras()).flat_map(|c| (0..pairs.cameras()).map(move |l| (c, l)));
        let (known, angles): (Vec<_>, Vec<_>) = all
            .filter_map(|(c, l)| {
                let a = pairs.geometry(c, l)?.angles(DVec2::ZERO);
                Some(((c, l), [a.theta_h, a.theta_i]))
            })
            .unzip();
        Ok(Self { pairs: known, tree: tree(angles)? })
    }

    /// The cells up to the last one of each row that is near a pair.
    fn grid(&self, bins: usize) -> Result<AngleGrid> {
        let full = AngleGrid::triangle(bins)?;
        let near = |k: usize| {
            let (h, i) = full.angles(k);
            nearest(&self.tree, [h, i], 1).first().is_some_and(|(_, d)| *d <= REACH_BINS * full.width())
        };
        let length =
            |j: usize| (0..full.rows()[j]).take_while(|i| full.slice(*i, j).is_some_and(near)).count();
        let rows: Vec<usize> = (0..full.rows().len()).map(length).take_while(|n| *n > 0).collect();
        if rows.is_empty() {
            let found = "far from all cells";
            return Err(Error::invalid(
                "slices",
                "directions of the pairs",
                found,
                "some within a bin of it",
            ));
        }
        AngleGrid::new(bins, rows)
    }
}

fn tree(angles: Vec<[f64; 2]>) -> Result<ImmutableKdTree<f64, 2>> {
    let failed =
        |e: &dyn std::fmt::Debug| Error::invalid("slices", "angles of the pairs", format!("{e:?}"), "some");
    if angles.is_empty() {
        return Err(failed(&"none"));
    }
    ImmutableKdTree::new_from_slice(&angles).map_err(|e| failed(&e))
}

/// The nearest entries of a tree, by number and distance, nearest first.
fn nearest(tree: &ImmutableKdTree<f64, 2>, at: [f64; 2], count: usize) -> Vec<(usize, f64)> {
    let count = NonZero::new(count).unwrap_or(NonZero::<usize>::MIN);
    let mut found: Vec<(usize, f64)> = tree
        .query(&at)
        .nearest_n::<SquaredEuclidean<f64>>(count)
        .execute()
        .into_iter()
        .map(|entry| (entry.item as usize, entry.distance.sqrt()))
        .collect();
    // Of equal distances the first: a tree may have them in any order.
    found.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    found
}

/// A slice and where it came from.
struct Cut {
    slice: FlakeSlice,
    /// Between its angles and its pair's, radians.
    distance: f64,
    scale: f64,
}

struct Cutter<'a> {
    pairs: &'a dyn Pairs,
    smooth: &'a Homogeneous<'a>,
    blemishes: &'a Blemishes,
    sheet: Sheet,
    /// Columns and rows of a slice.
    size: [usize; 2],
}

impl<'a> Cutter<'a> {
    fn new(
        pairs: &'a dyn Pairs,
        sample_mm: [f64; 2],
        smooth: &'a Homogeneous<'a>,
        blemishes: &'a Blemishes,
        options: &SliceOptions,
    ) -> Self {
        let sheet = Sheet::new(sample_mm, options.texel_mm);
        let size = sheet.size.map(|n| ((n as f64 * options.share) as usize).clamp(1, FlakeBtf::MAX_SIDE));
        Self { pairs, smooth, blemishes, sheet, size }
    }

    /// What is left of the pictures of all pairs that are among the nearest of a cell, and what had to be left out.
    fn residuals(
        &self,
        places: &Places,
        grid: &AngleGrid,
        tick: &(dyn Fn() + Sync),
    ) -> Result<(Vec<Residual>, Vec<String>)> {
        let needed: BTreeSet<usize> = (0..grid.len())
            .flat_map(|k| {
                let (h, i) = grid.angles(k);
                nearest(&places.tree, [h, i], NEIGHBORS).into_iter().map(|(pair, _)| pair)
            })
            .collect();
        let needed: Vec<usize> = needed.into_iter().collect();
        let looked = needed.par_iter().try_map(|k| {
            let (camera, light) = places.pairs[*k];
            let found =
                self.residual(camera, light).map_err(|e| format!("camera {camera}, light {light}: {e}"));
            tick();
            Ok(found)
        })?;
        let mut residuals = Vec::new();
        let mut left_out = Vec::new();
        for found in looked {
            match found {
                Ok(residual) => residuals.push(residual),
                Err(why) => left_out.push(why),
            }
        }
        Ok((residuals, left_out))
    }

    /// The first square of a picture, in the middle or around it, that is seen whole and clear of the mirrored flash.
    fn residual(&self, camera: usize, light: usize) -> Result<Residual> {
        let unknown = || Error::invalid("pair", "calibration", "none", "that of both cameras");
        let geometry = self.pairs.geometry(camera, light).ok_or_else(unknown)?;
        let pixels = self.pairs.radiance(camera, light)?;
        for corner in self.corners() {
            if self.sees_gloss(&geometry, corner) || self.blemishes.touch(self.middle(corner), self.half_mm())
            {
                continue;
            }
            let Some(Square { mean, texels }) = self.square(&pixels, &geometry, corner) else { continue };
            let variance = texels.iter().map(|t| luminance(*t).powi(2)).sum::<f64>() / texels.len() as f64;
            let middle = self.middle(corner);
            let angles = geometry.angles(middle);
            return Ok(Residual {
                camera,
                light,
                angles: [angles.theta_h, angles.theta_i],
                cos_o: geometry.rays(middle).1.z,
                corner,
                mean,
                deviation: variance.sqrt(),
            });
        }
        Err(Error::invalid(
            "picture",
            "clear squares",
            "none",
            "one without hidden pixels, gloss, mirrored flash and blemishes",
        ))
    }

    /// First columns and rows of the squares that are tried, the middle one first.
    fn corners(&self) -> impl Iterator<Item = [usize; 2]> + use<'_> {
        let at = |axis: usize, half: usize| (self.sheet.size[axis] - self.size[axis]) * half / 2;
        [(1, 1), (0, 1), (2, 1), (1, 0), (1, 2), (0, 0), (2, 0), (0, 2), (2, 2)]
            .into_iter()
            .map(move |(x, y)| [at(0, x), at(1, y)])
    }

    fn middle(&self, corner: [usize; 2]) -> DVec2 {
        let at = |axis: usize| corner[axis] as f64 + 0.5 * self.size[axis] as f64;
        self.sheet.place_mm(at(0), at(1))
    }

    /// Half of the sides of a square.
    fn half_mm(&self) -> DVec2 {
        0.5 * self.sheet.texel_mm * DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// Whether a broad gloss, or the mirrored flash and as much again about it, reaches into a square.
    fn sees_gloss(&self, pair: &PairGeometry, corner: [usize; 2]) -> bool {
        let parts = [(0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let glossy = |(x, y)| {
            let (wi, wo) = pair.rays(self.middle(corner) + self.half_mm() * DVec2::new(x, y));
            (self.smooth.gloss)(wi, wo) > MOST_GLOSS * luminance((self.smooth.base)(wi, wo)).max(0.0)
        };
        if parts.into_iter().any(glossy) {
            return true;
        }
        let places = pair.corners_mm.map(|c| pair.mirrored_place(c));
        let middle = places.iter().sum::<DVec2>() / 4.0;
        let apart = ((middle - self.middle(corner)).abs() - self.half_mm()).max(DVec2::ZERO).length();
        apart < 1.5 * places.iter().map(|p| p.distance(middle)).fold(0.0, f64::max)
    }

    /// What the smooth part leaves of a square; `None` if one of its texels is not seen.
    fn square(&self, pixels: &[[f32; 3]], pair: &PairGeometry, corner: [usize; 2]) -> Option<Square> {
        let texel = |k: usize| {
            let (column, row) = (corner[0] + k % self.size[0], corner[1] + k / self.size[0]);
            let seen =
                self.sheet.texel(pixels, self.pairs.size(), pair, row * self.sheet.size[0] + column)?;
            let (wi, wo) = pair.rays(self.sheet.place_mm(column as f64 + 0.5, row as f64 + 0.5));
            Some(DVec3::from(seen) - (self.smooth.base)(wi, wo) - DVec3::splat((self.smooth.gloss)(wi, wo)))
        };
        let mut texels: Vec<DVec3> = (0..self.size[0] * self.size[1]).map(texel).collect::<Option<_>>()?;
        let mean = flatten(&mut texels, self.size);
        Some(Square { mean, texels })
    }

    fn cut(
        &self,
        residuals: &[Residual],
        fading: f64,
        tree: &ImmutableKdTree<f64, 2>,
        (theta_h, theta_i): (f64, f64),
    ) -> Result<Cut> {
        let around = nearest(tree, [theta_h, theta_i], NEIGHBORS);
        let badness = |(k, distance): &(usize, f64)| {
            (distance / AS_BAD).powi(2) + (1.0 / residuals[*k].cos_o - 1.0).powi(2)
        };
        let best = around.iter().min_by(|a, b| badness(a).total_cmp(&badness(b)));
        let Some((chosen, distance)) = best.map(|(k, distance)| (&residuals[*k], *distance)) else {
            return Err(Error::invalid("slices", "usable pictures", "none", "at least one"));
        };
        let line = |of: &dyn Fn(&Residual) -> f64| local_line(residuals, &around, [theta_h, theta_i], of);
        // A picture without any flake has no logarithm: 1e-9 of the light of a white is darker than any sensor sees.
        let from_above = |r: &Residual| r.deviation.max(1e-9) / r.cos_o.powf(fading);
        let deviation = line(&|r| from_above(r).ln()).exp();
        let scale =
            (deviation / from_above(chosen)).clamp(1.0 / MOST_SCALE, MOST_SCALE) / chosen.cos_o.powf(fading);
        let mean = DVec3::from([0, 1, 2].map(|c| line(&|r| r.mean[c])));
        let unknown = || Error::invalid("pair", "picture", "changed", "what it was a moment ago");
        let geometry = self.pairs.geometry(chosen.camera, chosen.light).ok_or_else(unknown)?;
        let pixels = self.pairs.radiance(chosen.camera, chosen.light)?;
        let square = self.square(&pixels, &geometry, chosen.corner).ok_or_else(unknown)?;
        let fluctuation = square.texels.iter().map(|t| (*t * scale).as_vec3().to_array()).collect();
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let expectation = ((self.smooth.base)(wi, wo) + mean).to_array();
        Ok(Cut { slice: FlakeSlice { fluctuation, expectation }, distance, scale })
    }
}

/// Takes the quadratic surface off the texels of a square of `size` columns and rows, and returns their mean.
///
/// Of coordinates that are even about 0 the terms 1, x, y, x y and the squares less their means are orthogonal.
fn flatten(texels: &mut [DVec3], size: [usize; 2]) -> DVec3 {
    let at = |k: usize| {
        let axis = |k: usize, n: usize| 2.0 * (k as f64 + 0.5) / n as f64 - 1.0;
        [axis(k % size[0], size[0]), axis(k / size[0], size[1])]
    };
    let count = texels.len() as f64;
    let mean = texels.iter().sum::<DVec3>() / count;
    let square = [0, 1].map(|a| (0..texels.len()).map(|k| at(k)[a].powi(2)).sum::<f64>() / count);
    let terms: [&dyn Fn([f64; 2]) -> f64; 6] =
        [&|_| 1.0, &|p| p[0], &|p| p[1], &|p| p[0] * p[1], &|p| p[0] * p[0] - square[0], &|p| {
            p[1] * p[1] - square[1]
        }];
    let surface: Vec<DVec3> = terms
        .iter()
        .map(|term| {
            let (sum, norm) =
                texels.iter().enumerate().fold((DVec3::ZERO, 0.0), |(sum, norm), (k, texel)| {
                    let value = term(at(k));
                    (sum + *texel * value, norm + value * value)
                });
            // A row of one texel has no slope.
            if norm > 1e-9 * count { sum / norm } else { DVec3::ZERO }
        })
        .collect();
    for (k, texel) in texels.iter_mut().enumerate() {
        *texel -= terms.iter().zip(&surface).map(|(term, height)| *height * term(at(k))).sum::<DVec3>();
    }
    mean
}

/// The power of the cosine of the view that best explains, by least squares of logarithms, how the deviations of a pair and of the
/// pair with eye and light exchanged differ: from 0, to which few pairs draw, to 1.
fn fading(residuals: &[Residual]) -> f64 {
    let of = |camera: usize, light: usize| {
        let k = residuals.partition_point(|r| (r.camera, r.light) < (camera, light));
        residuals.get(k).filter(|r| (r.camera, r.light) == (camera, light))
    };
    let (mut product, mut square) = (0.0, FADING_RIDGE);
    for r in residuals.iter().filter(|r| r.camera < r.light && r.deviation > 0.0) {
        let Some(back) = of(r.light, r.camera).filter(|back| back.deviation > 0.0) else { continue };
        let cosines = (r.cos_o / back.cos_o).ln();
        product += cosines * (r.deviation / back.deviation).ln();
        square += cosines * cosines;
    }
    (product / square).clamp(0.0, 1.0)
}

/// Weight of no fading, in pairs whose cosines are as 1 to e.
const FADING_RIDGE: f64 = 0.1;

/// The value at a place of the line through what the pairs around have, weighed by their distance; of few or of pairs all on one
/// line the weighted mean, towards which a ridge draws.
fn local_line(
    residuals: &[Residual],
    around: &[(usize, f64)],
    at: [f64; 2],
    of: &dyn Fn(&Residual) -> f64,
) -> f64 {
    let mut matrix = Matrix3::from_diagonal(&Vector3::new(0.0, RIDGE, RIDGE));
    let mut right = Vector3::zeros();
    for (k, distance) in around {
        let r = &residuals[*k];
        // The nearest always counts; others by their distance beyond it.
        let weight = (-0.5 * (distance / WIDTH).powi(2)).exp() + f64::MIN_POSITIVE;
        let row = Vector3::new(1.0, (r.angles[0] - at[0]) / WIDTH, (r.angles[1] - at[1]) / WIDTH);
        matrix += row * row.transpose() * weight;
        right += row * (weight * of(r));
    }
    let nearest = around.first().map_or(0.0, |(k, _)| of(&residuals[*k]));
    matrix.lu().solve(&right).map_or(nearest, |line| line[0])
}

/// Weight of a slope of zero, in pairs.
const RIDGE: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    fn residual(theta_h: f64, theta_i: f64, mean: f64) -> Residual {
        Residual {
            camera: 0,
            light: 0,
            angles: [theta_h, theta_i],
            cos_o: 1.0,
            corner: [0; 2],
            mean: DVec3::splat(mean),
            deviation: 1.0,
        }
    }

    #[test]
    fn flakes_stay_and_slow_changes_go() {
        let size = [20, 14];
        let flake = |k: usize| DVec3::splat(if k % 37 == 5 { 1.0 } else { 0.0 });
        let slow = |k: usize| {
            let (x, y) = ((k % size[0]) as f64, (k / size[0]) as f64);
            DVec3::new(0.3 * x - 0.02 * x * y, 5.0 + y * y, 0.1 * x * x)
        };
        let (mut bare, mut both) = (Vec::new(), Vec::new());
        for k in 0..size[0] * size[1] {
            bare.push(flake(k));
            both.push(flake(k) + slow(k));
        }
        let whole = both.iter().sum::<DVec3>() / both.len() as f64;
        flatten(&mut bare, size);
        let mean = flatten(&mut both, size);
        assert_eq!(mean, whole);
        let worst = bare.iter().zip(&both).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max);
        // Heights of 200 in f64.
        assert!(worst < 1e-11, "{worst}");
        let mut column = vec![DVec3::splat(2.0); 5];
        assert_eq!(flatten(&mut column, [1, 5]), DVec3::splat(2.0));
        assert!(column.iter().all(|t| t.length() < 1e-14));
    }

    #[test]
    fn the_fading_of_flat_views_is_read_off_exchanged_pairs() {
        let cosines: [f64; 4] = [1.0, 0.8, 0.5, 0.3];
        let all = |power: f64| -> Vec<Residual> {
            let pairs = (0..4).flat_map(|c| (0..4).map(move |l| (c, l)));
            pairs
                .map(|(camera, light)| {
                    let cos_o = cosines[camera];
                    // What a pair and its exchange share says nothing.
                    let deviation = (cosines[camera] + cosines[light]) * cos_o.powf(power);
                    Residual { camera, light, cos_o, deviation, ..residual(0.1, 0.1, 0.0) }
                })
                .collect()
        };
        for power in [0.0, 0.25, 0.5] {
            // The ridge takes three per cent of it.
            assert!((fading(&all(power)) - power).abs() < 0.03 * power + 1e-12, "{}", fading(&all(power)));
        }
        assert_eq!(fading(&all(-0.4)), 0.0);
        assert_eq!(fading(&all(0.5)[..1]), 0.0, "one pair alone");
    }

    #[test]
    fn lines_meet_constants_and_follow_slopes() {
        let places = [(0.1, 0.1), (0.2, 0.12), (0.12, 0.2), (0.22, 0.2), (0.15, 0.16)];
        let around = |all: &[Residual]| {
            nearest(&tree(all.iter().map(|r| r.angles).collect()).unwrap(), [0.15, 0.15], 8)
        };
        let flat: Vec<_> = places.map(|(h, i)| residual(h, i, 3.0)).into();
        let value = |all: &[Residual]| local_line(all, &around(all), [0.15, 0.15], &|r| r.mean.x);
        assert!((value(&flat) - 3.0).abs() < 1e-12);
        let slope: Vec<_> = places.map(|(h, i)| residual(h, i, 1.0 + 5.0 * h - 2.0 * i)).into();
        // The ridge keeps some per cent of the slope; the pairs lie around the place, which leaves little of that.
        assert!((value(&slope) - 1.45).abs() < 0.03, "{}", value(&slope));
        assert!((value(&slope[..1]) - 1.3).abs() < 1e-12, "one pair alone");
    }
}
