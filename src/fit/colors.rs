//! The color table chi of a measurement.
//!
//! Rump et al. 2008 divide each measured color by its intensity (eqs 4, 5). Here chi is what the measured color has to
//! be divided by the *fitted* brightness to give, so that it takes up the intensity error of the lobes too: over all usable
//! cells, `sum w (T B chi(theta_h, theta_i) + gloss - C)^2 + lambda |grad chi|^2` is least, with chi interpolated
//! bilinearly as it will be read, and `w = solid angle / (T B + eps)^2`, for errors count relatively. The second term, weak
//! where there are data, continues chi smoothly (harmonically) where there are none: below the horizon, beyond the
//! instrument's reach, and under the gloss peak, which stays uncolored (eq. 6) and would drown what lies below it.
//!
//! A channel of chi may be negative: a saturated paint lies outside the gamut of Rec.709, and clamping would shift its hue.

use super::samples::Sample;
use crate::brdf::ColorTable;
use crate::error::{Error, Result};
use crate::parallel::TryMap;
use rayon::prelude::*;

/// Weight of the smoothness, relative to the data of a median texel. Ten times more or less moves the color difference
/// of the two measured paints by less than 0.1.
const SMOOTHNESS: f64 = 0.03;
/// Cells' worth of bilinear weight from which a texel counts as measured.
const MEASURED: f64 = 0.5;

/// A sample as chi sees it: `value = brightness * chi` in every band.
pub(super) struct ColorSample<'a> {
    pub sample: &'a Sample<'a>,
    /// Transmittance times fitted brightness.
    pub brightness: f64,
    /// Gloss, in every band the same.
    pub gloss: f64,
    /// Measured values, one a band.
    pub values: &'a [f64],
}

/// A fitted table.
pub(super) struct Channels {
    /// A table a band, row-major.
    pub bands: Vec<Vec<f64>>,
    /// Whether each texel rests on a measurement.
    pub measured: Vec<bool>,
}

/// Fits chi in all of `bands`.
///
/// # Errors
/// No sample at all; an equation that the solver does not solve.
pub(super) fn fit(samples: &[ColorSample], bands: usize, size: [usize; 2], epsilon: f64) -> Result<Channels> {
    let texels = size[0] * size[1];
    let probe = ColorTable::new(size, vec![[0.0; 3]; texels], vec![false; texels])?;
    let mut matrix = Grid::new(size);
    let mut right = vec![vec![0.0; texels]; bands];
    let mut mass = vec![0.0; texels];
    for s in samples {
        let weight = s.sample.solid_angle / (s.brightness + epsilon).powi(2);
        let angles = s.sample.angles;
        let taps = probe.taps(angles.theta_h as f32, angles.theta_i as f32).map(|(t, w)| (t, f64::from(w)));
        matrix.add_square(&taps, weight * s.brightness * s.brightness);
        for (texel, share) in taps {
            for (right, value) in right.iter_mut().zip(s.values) {
                right[texel] += (value - s.gloss) * (weight * s.brightness * share);
            }
            mass[texel] += share;
        }
    }
    let measured: Vec<bool> = mass.iter().map(|m| *m >= MEASURED).collect();
    let mut diagonals: Vec<f64> =
        matrix.diagonal.iter().zip(&measured).filter(|(d, m)| **m && **d > 0.0).map(|(d, _)| *d).collect();
    if diagonals.is_empty() {
        return Err(Error::invalid("color table", "usable cells", 0, "at least one above the horizon"));
    }
    let middle = diagonals.len() / 2;
    let median = *diagonals.select_nth_unstable_by(middle, f64::total_cmp).1;
    matrix.add_smoothness(SMOOTHNESS * median);
    let bands = (0..bands).into_par_iter().try_map(|band| matrix.solve(&right[band]))?;
    Ok(Channels { bands, measured })
}

/// A symmetric matrix over the texels of a table that couples each to its eight neighbors.
struct Grid {
    size: [usize; 2],
    diagonal: Vec<f64>,
    /// Couplings to the next column, the next row, the next of both, and the next row of the column before.
    couplings: [Vec<f64>; 4],
}

impl Grid {
    fn new(size: [usize; 2]) -> Self {
        let zeros = || vec![0.0; size[0] * size[1]];
        Self { size, diagonal: zeros(), couplings: std::array::from_fn(|_| zeros()) }
    }

    /// Adds `weight (sum_k share_k x_k)^2` over the four texels of a bilinear look-up, in the order of
    /// [`ColorTable::taps`]: this, next column, next row, both.
    fn add_square(&mut self, taps: &[(usize, f64); 4], weight: f64) {
        for (texel, share) in taps {
            self.diagonal[*texel] += weight * share * share;
        }
        for (kind, a, b) in [(0, 0, 1), (0, 2, 3), (1, 0, 2), (1, 1, 3), (2, 0, 3), (3, 1, 2)] {
            self.couplings[kind][taps[a].0] += weight * taps[a].1 * taps[b].1;
        }
    }

    /// Adds `weight` times the squared difference of every two neighbors of a row or a column.
    fn add_smoothness(&mut self, weight: f64) {
        let [columns, rows] = self.size;
        for k in 0..columns * rows {
            for (kind, exists, step) in
                [(0, k % columns + 1 < columns, 1), (1, k / columns + 1 < rows, columns)]
            {
                if exists {
                    self.diagonal[k] += weight;
                    self.diagonal[k + step] += weight;
                    self.couplings[kind][k] -= weight;
                }
            }
        }
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        for ((y, x), d) in y.iter_mut().zip(x).zip(&self.diagonal) {
            *y = d * x;
        }
        let columns = self.size[0];
        for (coupling, step) in self.couplings.iter().zip([1, columns, columns + 1, columns - 1]) {
            for k in 0..x.len().saturating_sub(step) {
                y[k] += coupling[k] * x[k + step];
                y[k + step] += coupling[k] * x[k];
            }
        }
    }

    /// Solves for `right` by conjugate gradients, preconditioned by the diagonal, to 1e-9 of the right side.
    fn solve(&self, right: &[f64]) -> Result<Vec<f64>> {
        let n = right.len();
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(&self.diagonal).map(|(r, d)| r / d).collect() };
        let (mut x, mut r) = (vec![0.0; n], right.to_vec());
        let mut z = scaled(&r);
        let mut p = z.clone();
        let mut product = vec![0.0; n];
        let mut rho = dot(&r, &z);
        let target = 1e-18 * rho;
        // Exact arithmetic ends after n steps; rounding lengthens that a little.
        for _ in 0..2 * n {
            if rho <= target {
                return Ok(x);
            }
            self.multiply(&p, &mut product);
            let step = rho / dot(&p, &product);
            for k in 0..n {
                x[k] += step * p[k];
                r[k] -= step * product[k];
            }
            z = scaled(&r);
            let next = dot(&r, &z);
            let turn = next / rho;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + turn * *p);
            rho = next;
        }
        let found = format!("relative residual {:.1e}", (rho / dot(right, &scaled(right))).sqrt());
        Err(Error::not_converged("color table", "conjugate gradients", found, "1e-9"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::LobeGeometry;
    use crate::math::half_difference::{HalfDifference, directions};
    use glam::DVec3;

    fn sample(theta_h: f64, theta_i: f64, color: DVec3) -> Sample<'static> {
        let (wi, wo) = directions(theta_h, theta_i, 1.5);
        let geometry = LobeGeometry::of(wi, wo);
        Sample {
            geometry,
            outer: geometry,
            angles: HalfDifference { theta_h, theta_i },
            transmittance: 1.0,
            solid_angle: 1.0,
            color,
            intensity: color.element_sum() / 3.0,
            wi,
            wo,
            lights: &[],
            apart: false,
        }
    }

    fn fit_function(chi: impl Fn(f64, f64) -> DVec3, reach: f64) -> ColorTable {
        let mut samples = Vec::new();
        for h in 0..60 {
            for i in 0..60 {
                let (theta_h, theta_i) = (reach * f64::from(h) / 59.0, reach * f64::from(i) / 59.0);
                // Brightness over four orders of magnitude: errors are relative.
                let brightness = (-8.0 * theta_h).exp() + 1e-4;
                samples.push((sample(theta_h, theta_i, chi(theta_h, theta_i) * brightness), brightness));
            }
        }
        let colors: Vec<[f64; 3]> = samples.iter().map(|(s, _)| s.color.to_array()).collect();
        let seen: Vec<_> = samples
            .iter()
            .zip(&colors)
            .map(|((sample, brightness), values)| ColorSample {
                sample,
                brightness: *brightness,
                gloss: 0.0,
                values,
            })
            .collect();
        let fitted = fit(&seen, 3, [17, 17], 1e-6).unwrap();
        let texels = (0..17 * 17).map(|k| [0, 1, 2].map(|c| fitted.bands[c][k] as f32)).collect();
        ColorTable::new([17, 17], texels, fitted.measured).unwrap()
    }

    #[test]
    fn a_constant_is_found_and_continued() {
        let table = fit_function(|_, _| DVec3::new(0.2, 1.7, -0.1), 1.0);
        for texel in table.texels() {
            // f32 texels, and 1e-9 of the solver amplified where the equations are stiff.
            assert!((texel[0] - 0.2).abs() < 1e-5 && (texel[2] + 0.1).abs() < 1e-5, "{texel:?}");
        }
        assert!(table.measured()[0] && !table.measured()[17 * 17 - 1]);
    }

    #[test]
    fn a_slope_is_found_where_it_is_measured() {
        let chi = |h: f64, i: f64| DVec3::new(0.5 + 0.4 * h, 1.0 - 0.3 * i, 1.0 + 0.2 * h * i);
        let table = fit_function(chi, 1.5);
        for (h, i) in [(0.3, 0.3), (0.8, 0.4), (0.5, 1.2), (1.2, 1.1)] {
            let found = table.sample(h as f32, i as f32);
            let truth = chi(h, i);
            // What the smoothness of 3 % bends inside, where the slope is even.
            assert!(
                (DVec3::from(found.map(f64::from)) - truth).abs().max_element() < 5e-3,
                "{found:?} {truth}"
            );
        }
    }

    #[test]
    fn nothing_measured_is_an_error() {
        assert!(fit(&[], 3, [8, 8], 1e-6).is_err());
    }
}
