//! Least squares of a scale and one shape parameter: `y_k ~ scale * g_k(shape)`.
//!
//! The scale is linear, so that for every shape the best one is known (Golub & Pereyra 1973): a scan finds the valley, damped
//! Gauss-Newton steps over both parameters its floor, to the last digits where the model is exact.

use std::ops::RangeInclusive;

/// What is fitted.
pub(super) struct Separable<'a, G> {
    /// Measured values.
    pub values: &'a [f64],
    /// What the square of each residual counts, 0 or more.
    pub weights: &'a [f64],
    /// Value `k` of the model for a shape, above 0, and the derivative of its logarithm by the shape.
    pub model: G,
    /// Shapes that may be.
    pub bounds: RangeInclusive<f64>,
}

/// The minimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    /// Scale, 0 or more.
    pub scale: f64,
    /// Shape, within its bounds.
    pub shape: f64,
    /// Whether the shape lies on one of them, or the values are too small to tell.
    pub on_bound: bool,
}

/// Shapes of the scan.
const SCAN: u32 = 100;
/// Steps at most; exact data take five to eight.
const STEPS: u32 = 60;

impl<G: Fn(f64, usize) -> (f64, f64)> Separable<'_, G> {
    /// The least sum of squares.
    pub fn solve(&self) -> Found {
        let (low, high) = (*self.bounds.start(), *self.bounds.end());
        let scanned = (0..=SCAN).map(|k| low + (high - low) * f64::from(k) / f64::from(SCAN));
        let start = scanned.min_by(|a, b| self.cost(*a).total_cmp(&self.cost(*b)));
        let mut shape = start.unwrap_or(low);
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let scale = self.scale(shape);
            if scale == 0.0 {
                break;
            }
            let ([a, b, c], [p, q]) = self.normal_equations(scale, shape);
            // Of the pair of equations the shape's row, the scale eliminated; the scale follows anyway.
            let step = (q - b * p / a) / (c * (1.0 + damping) - b * b / a).max(f64::MIN_POSITIVE);
            let next = (shape + step).clamp(low, high);
            if next == shape {
                break;
            }
            if self.cost(next) <= self.cost(shape) {
                damping *= 0.1;
                shape = next;
            } else {
                damping = damping.max(1e-12) * 10.0;
                if damping > 1e12 {
                    break;
                }
            }
        }
        let scale = self.scale(shape);
        Found { scale, shape, on_bound: scale == 0.0 || shape == low || shape == high }
    }

    /// The best scale for a shape.
    fn scale(&self, shape: f64) -> f64 {
        let (mut along, mut square) = (0.0, 0.0);
        for (k, (y, w)) in self.values.iter().zip(self.weights).enumerate() {
            let g = (self.model)(shape, k).0;
            along += w * y * g;
            square += w * g * g;
        }
        if square > 0.0 { (along / square).max(0.0) } else { 0.0 }
    }

    fn cost(&self, shape: f64) -> f64 {
        let scale = self.scale(shape);
        let terms = self.values.iter().zip(self.weights).enumerate();
        terms.map(|(k, (y, w))| w * (y - scale * (self.model)(shape, k).0).powi(2)).sum()
    }

    /// The matrix [scale scale, scale shape, shape shape] of the derivatives' products, and their products with the residuals.
    fn normal_equations(&self, scale: f64, shape: f64) -> ([f64; 3], [f64; 2]) {
        let (mut matrix, mut slope) = ([0.0; 3], [0.0; 2]);
        for (k, (y, w)) in self.values.iter().zip(self.weights).enumerate() {
            let (g, log_slope) = (self.model)(shape, k);
            let (by_scale, by_shape) = (g, scale * g * log_slope);
            let residual = y - scale * g;
            matrix[0] += w * by_scale * by_scale;
            matrix[1] += w * by_scale * by_shape;
            matrix[2] += w * by_shape * by_shape;
            slope[0] += w * by_scale * residual;
            slope[1] += w * by_shape * residual;
        }
        (matrix, slope)
    }

    /// Sum over the values of squared residuals, as shares of the fit, that is to be expected where each value is off by all of itself,
    /// independently: between the number of values and that less two, which it is if weights go by noise.
    pub fn expected_scatter(&self, found: Found) -> f64 {
        let Found { scale, shape, .. } = found;
        let ([a, b, c], _) = self.normal_equations(scale, shape);
        let determinant = a * c - b * b;
        let slopes: Vec<[f64; 2]> = (0..self.values.len())
            .map(|k| {
                let (g, log_slope) = (self.model)(shape, k);
                [g, scale * g * log_slope]
            })
            .collect();
        let fitted = |k: usize| scale * slopes[k][0];
        let pull = |k: usize, j: usize| {
            let ([p, q], [r, s]) = (slopes[k], slopes[j]);
            self.weights[j] * (c * p * r - b * (p * s + q * r) + a * q * s) / determinant
        };
        let pairs = (0..slopes.len()).flat_map(|k| (0..slopes.len()).map(move |j| (k, j)));
        let term = |(k, j): (usize, usize)| {
            let share = f64::from(u8::from(k == j)) - pull(k, j);
            (share * fitted(j) / fitted(k)).powi(2)
        };
        pairs.map(term).sum()
    }

    /// Variances of the logarithm of the scale and of the shape, and their covariance, where each value is off by `noise` of itself,
    /// independently.
    pub fn covariance(&self, found: Found, noise: f64) -> [f64; 3] {
        let Found { scale, shape, .. } = found;
        let ([a, b, c], _) = self.normal_equations(scale, shape);
        let determinant = a * c - b * b;
        let mut sums = [0.0; 3];
        for (k, w) in self.weights.iter().enumerate() {
            let (g, log_slope) = (self.model)(shape, k);
            let (by_scale, by_shape) = (g, scale * g * log_slope);
            let pull = w * scale * g * noise / determinant;
            let log_scale = (c * by_scale - b * by_shape) * pull / scale;
            let shape = (a * by_shape - b * by_scale) * pull;
            sums[0] += log_scale * log_scale;
            sums[1] += shape * shape;
            sums[2] += log_scale * shape;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exponential(x: &[f64]) -> impl Fn(f64, usize) -> (f64, f64) + '_ {
        |c, k| ((c * x[k]).exp(), x[k])
    }

    /// 1 - cos of the paper's angles, about.
    const X: [f64; 6] = [0.06, 0.13, 0.23, 0.36, 0.5, 0.58];

    fn problem(values: &[f64]) -> Separable<'_, impl Fn(f64, usize) -> (f64, f64)> {
        Separable { values, weights: &[1.0; 6], model: exponential(&X), bounds: -10.0..=40.0 }
    }

    #[test]
    fn exact_data_are_explained_to_the_last_digits() {
        for (scale, shape) in [(0.7, 2.5), (1e-9, -9.9), (3e5, 39.0), (2.0, 0.0)] {
            let values: Vec<f64> = X.iter().map(|x| scale * f64::exp(shape * x)).collect();
            let found = problem(&values).solve();
            assert!((found.scale / scale - 1.0).abs() < 1e-11, "{found:?}");
            assert!((found.shape - shape).abs() < 1e-11 && !found.on_bound, "{found:?}");
        }
    }

    #[test]
    fn bounds_hold_and_nothing_is_told_apart_from_them() {
        let x = [0.1, 0.3, 0.5];
        let solve = |values: &[f64]| {
            Separable { values, weights: &[1.0; 3], model: exponential(&x), bounds: -1.0..=1.0 }.solve()
        };
        let steep = solve(&x.map(|x| (3.0 * x).exp()));
        assert!(steep.shape == 1.0 && steep.on_bound);
        for dark in [[0.0; 3], [-1e-3, -2e-3, -1e-3]] {
            let found = solve(&dark);
            assert!(found.scale == 0.0 && found.on_bound && found.shape.is_finite());
        }
    }

    /// Variances and covariance against the scatter of many fits.
    #[test]
    fn covariances_are_those_of_repeated_fits() {
        use crate::math::hash::{pcg4d, unit};
        let noise = 0.01;
        let (mut count, mut sums, mut expected) = (0.0, [0.0; 3], [0.0; 3]);
        for seed in 0..4000u32 {
            // Twelve uniform numbers have variance 1.
            let normal = |k: usize| -> f64 {
                (0..3).flat_map(|j| pcg4d([seed, k as u32, j, 7])).map(|b| f64::from(unit(b))).sum::<f64>()
                    - 6.0
            };
            let values: Vec<f64> = X
                .iter()
                .enumerate()
                .map(|(k, x)| 0.7 * f64::exp(2.5 * x) * (1.0 + noise * normal(k)))
                .collect();
            let problem = problem(&values);
            let found = problem.solve();
            let (scale, shape) = ((found.scale / 0.7).ln(), found.shape - 2.5);
            sums[0] += scale * scale;
            sums[1] += shape * shape;
            sums[2] += scale * shape;
            expected = problem.covariance(found, noise);
            count += 1.0;
        }
        for k in 0..3 {
            // A variance of 4,000 draws scatters by 2 %.
            let ratio: f64 = sums[k] / count / expected[k];
            assert!((ratio - 1.0).abs() < 0.08, "{k}: {ratio}");
        }
    }
}
