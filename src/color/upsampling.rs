//! A reflectance for a color.

use super::observer::BANDS;
use super::spectrum::{Spectrum, rgb_weights};
use crate::error::{Error, Result};
use glam::DVec3;
use nalgebra::{DMatrix, DVector};

/// Newton steps; colors a reflectance reaches take some ten, those at the rim a few dozen.
const STEPS: usize = 100;
/// Error of the color, each channel.
const TOLERANCE: f64 = 1e-13;

/// The flattest reflectance strictly inside (0, 1) whose [`Spectrum::linear_rgb`] is `rgb`; a gray is the constant, 0 and 1
/// included.
///
/// Burns 2020 (Numerical methods for smoothest reflectance reconstruction, Color Research & Application 45): with the
/// reflectance `(1 + tanh z)/2`, the sum of squared differences of z of neighboring bands is least under the three
/// conditions of the color; Newton's method on the Lagrange conditions.
///
/// # Errors
/// Channels that are not finite; a color that no reflectance has.
pub fn reflectance_of_rgb(rgb: DVec3) -> Result<Spectrum> {
    let legal = "a color some reflectance has: three numbers, for grays 0 to 1";
    let refuse = || Error::invalid("", "linear RGB", format!("[{}, {}, {}]", rgb.x, rgb.y, rgb.z), legal);
    if rgb.x == rgb.y && rgb.y == rgb.z {
        return if (0.0..=1.0).contains(&rgb.x) { Ok(Spectrum::constant(rgb.x)) } else { Err(refuse()) };
    }
    if !rgb.is_finite() {
        return Err(refuse());
    }
    let mut unknowns = DVector::zeros(BANDS + 3);
    for _ in 0..STEPS {
        let (residual, jacobian) = conditions(&unknowns, rgb);
        if residual.rows(BANDS, 3).amax() < TOLERANCE && residual.amax() < 1e-9 {
            return Ok(Spectrum(std::array::from_fn(|k| reflectance(unknowns[k]))));
        }
        let Some(step) = jacobian.lu().solve(&residual) else { break };
        // Far steps leave the range in which tanh has a slope.
        let most = step.rows(0, BANDS).amax();
        unknowns -= step * if most > 1.0 { 1.0 / most } else { 1.0 };
    }
    Err(refuse())
}

/// `(1 + tanh z)/2`.
fn reflectance(z: f64) -> f64 {
    1.0 / (1.0 + (-2.0 * z).exp())
}

/// Lagrange conditions at `(z, multipliers)` and their derivatives.
fn conditions(unknowns: &DVector<f64>, rgb: DVec3) -> (DVector<f64>, DMatrix<f64>) {
    let mut residual = DVector::zeros(BANDS + 3);
    let mut jacobian = DMatrix::zeros(BANDS + 3, BANDS + 3);
    for c in 0..3 {
        residual[BANDS + c] = -rgb[c];
    }
    for (k, weight) in rgb_weights().iter().enumerate() {
        let value = reflectance(unknowns[k]);
        let slope = 2.0 * value * (1.0 - value);
        let pull: f64 = (0..3).map(|c| weight[c] * unknowns[BANDS + c]).sum();
        for c in 0..3 {
            residual[BANDS + c] += weight[c] * value;
            jacobian[(k, BANDS + c)] = slope * weight[c];
            jacobian[(BANDS + c, k)] = slope * weight[c];
        }
        residual[k] += slope * pull;
        jacobian[(k, k)] += 2.0 * slope * (1.0 - 2.0 * value) * pull;
        if k > 0 {
            let rise = unknowns[k] - unknowns[k - 1];
            residual[k] += 2.0 * rise;
            residual[k - 1] -= 2.0 * rise;
            for (i, j, sign) in [(k, k, 2.0), (k - 1, k - 1, 2.0), (k, k - 1, -2.0), (k - 1, k, -2.0)] {
                jacobian[(i, j)] += sign;
            }
        }
    }
    (residual, jacobian)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_of_the_cube_have_a_reflectance_of_just_that_color() {
        let levels = [0.0, 1e-3, 0.05, 0.3, 0.7, 0.95, 1.0];
        for r in levels {
            for g in levels {
                for b in levels {
                    let rgb = DVec3::new(r, g, b);
                    let found = reflectance_of_rgb(rgb).unwrap();
                    // The tolerance, and rounding of the sum.
                    assert!((found.linear_rgb() - rgb).abs().max_element() < 1e-12, "{rgb}");
                    let gray = r == g && g == b;
                    assert!(gray || found.0.iter().all(|x| *x > 0.0 && *x < 1.0), "{rgb}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn colors_beyond_every_reflectance_are_refused() {
        for bad in
            [[1.1, 1.1, 1.1], [-0.1, -0.1, -0.1], [0.0, 3.0, 0.0], [1.0, 1.0, 1.2], [f64::NAN, 0.0, 0.0]]
        {
            let message = reflectance_of_rgb(DVec3::from(bad)).unwrap_err().to_string();
            assert!(message.contains("some reflectance has"), "{message}");
        }
    }

    #[test]
    fn no_other_reflectance_of_the_color_is_flatter() {
        let rgb = DVec3::new(0.6, 0.1, 0.05);
        let found = reflectance_of_rgb(rgb).unwrap();
        let z: Vec<f64> = found.0.iter().map(|x| (2.0 * x - 1.0).atanh()).collect();
        let slope = |z: &[f64]| z.windows(2).map(|p| (p[1] - p[0]).powi(2)).sum::<f64>();
        // A bump at three bands, corrected to the color by three others: to first order in the bump nothing changes.
        let weights = rgb_weights();
        let effect = |k: usize| weights[k] * (2.0 * found.0[k] * (1.0 - found.0[k]));
        let correct = glam::DMat3::from_cols(effect(8), effect(17), effect(25)).inverse();
        for bump in [5usize, 14, 21, 32] {
            let size = 1e-4;
            let mut other = z.clone();
            other[bump] += size;
            let by = correct * effect(bump) * size;
            for (k, change) in [8usize, 17, 25].into_iter().zip(by.to_array()) {
                other[k] -= change;
            }
            // Changes by the square of the bump, not by the bump.
            let change = slope(&other) - slope(&z);
            assert!(change > 0.0 && change < 1e3 * size * size, "{bump}: {change:e}");
        }
    }
}
