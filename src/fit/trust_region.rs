//! A trust-region minimizer inside a box, for few parameters: quasi-Newton SR1, or Levenberg-Marquardt.
//!
//! Nocedal & Wright 2006, algorithms 4.1 and 6.2 and section 4.3: the step is the exact minimum of a quadratic model inside a
//! ball, found in the eigenvectors of its matrix, so that an indefinite one does as well. That matrix is learnt from the change
//! of the gradient by symmetric updates of rank one (SR1, the optimizer of Rump et al. 2008), or is the loss's Gauss-Newton
//! matrix (Levenberg-Marquardt as More 1978 writes it). The parameter that a step takes farthest beyond its bound stays on it, and
//! the others' step is found anew.

use super::objective::{Loss, Objective};
use nalgebra::{DMatrix, DVector};

/// Where the quadratic model comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Model {
    /// Symmetric rank-one updates.
    Sr1,
    /// The Gauss-Newton matrix of every point.
    GaussNewton,
}

/// A minimum, or where the steps ran out.
#[derive(Debug, Clone)]
pub(super) struct Minimum {
    /// Parameters.
    pub x: DVector<f64>,
    /// Evaluations taken.
    pub steps: u64,
}

/// Evaluations at most; a three-lobe fit takes 20 to 60.
const STEPS: u64 = 300;
/// Promised relative decrease of the loss at which the search ends: far below any difference between two starts that matters.
const TOLERANCE: f64 = 1e-9;
/// Smallest radius: the digits of the loss are used up.
const SMALLEST: f64 = 1e-9;

/// Lowers `objective` from `x` on.
pub(super) fn minimize(objective: &Objective, x: &DVector<f64>, knee: f64, model: Model) -> Minimum {
    let loss = |r: f64| Loss::soft(r, knee);
    let mut x = objective.clamp(x.clone());
    let mut here = objective.local(&x, loss);
    let mut radius: f64 = 1.0;
    let mut matrix = match model {
        // A first step as long as the radius.
        Model::Sr1 => DMatrix::identity(x.len(), x.len()) * here.gradient.norm(),
        Model::GaussNewton => here.curvature.clone(),
    };
    let mut steps = 1;
    while steps < STEPS && radius > SMALLEST {
        let step =
            box_step(&here.gradient, &matrix, &(&objective.lower - &x), &(&objective.upper - &x), radius);
        let promised = -(here.gradient.dot(&step) + 0.5 * step.dot(&(&matrix * &step)));
        if promised <= TOLERANCE * here.cost {
            // A model learnt in other directions may promise nothing in this one; a smaller ball asks the gradient alone.
            if model == Model::GaussNewton || here.cost == 0.0 || radius < 1e-4 {
                break;
            }
            radius *= 0.1;
            continue;
        }
        let there_x = objective.clamp(&x + &step);
        let there = objective.local(&there_x, loss);
        steps += 1;
        if model == Model::Sr1 {
            rank_one(&mut matrix, &step, &(&there.gradient - &here.gradient), steps == 2);
        }
        let kept = (here.cost - there.cost) / promised;
        let length = step.norm();
        if kept < 0.25 || kept.is_nan() {
            radius = 0.25 * length.min(radius);
        } else if kept > 0.75 && length > 0.8 * radius {
            radius *= 2.0;
        }
        if kept > 1e-4 {
            if model == Model::GaussNewton {
                matrix = there.curvature.clone();
            }
            (x, here) = (there_x, there);
        }
    }
    Minimum { x, steps }
}

/// The symmetric matrix of rank one that makes `matrix` map `step` to `change` (eq. 6.24), left out where it is not safe
/// (6.26). The first also sets the scale (6.20).
fn rank_one(matrix: &mut DMatrix<f64>, step: &DVector<f64>, change: &DVector<f64>, first: bool) {
    let curvature = change.dot(step);
    if first && curvature > 0.0 {
        *matrix = DMatrix::identity(step.len(), step.len()) * (change.norm_squared() / curvature);
    }
    let gap = change - &*matrix * step;
    let along = gap.dot(step);
    if along.abs() >= 1e-8 * gap.norm() * step.norm() && along != 0.0 {
        *matrix += &gap * gap.transpose() / along;
    }
}

/// The step of least model in the ball, no parameter beyond `low` or `high` from where it is.
fn box_step(
    gradient: &DVector<f64>,
    matrix: &DMatrix<f64>,
    low: &DVector<f64>,
    high: &DVector<f64>,
    radius: f64,
) -> DVector<f64> {
    let n = gradient.len();
    let mut step = DVector::zeros(n);
    let mut free: Vec<usize> = (0..n).collect();
    loop {
        // What the fixed parameters' part of the step adds to the slopes of the free ones.
        let slopes = gradient + matrix * &step;
        let g = DVector::from_iterator(free.len(), free.iter().map(|k| slopes[*k]));
        let b = DMatrix::from_fn(free.len(), free.len(), |i, j| matrix[(free[i], free[j])]);
        let found = ball_step(&g, &b, radius);
        // How far beyond its bound a step takes a parameter, in units of the way there.
        let beyond = |k: usize, s: f64| {
            if s < low[k] {
                s / low[k]
            } else if s > high[k] {
                s / high[k]
            } else {
                0.0
            }
        };
        let worst = (0..free.len())
            .max_by(|a, b| beyond(free[*a], found[*a]).total_cmp(&beyond(free[*b], found[*b])));
        match worst.filter(|worst| beyond(free[*worst], found[*worst]) > 0.0) {
            Some(worst) => {
                let k = free.remove(worst);
                step[k] = found[worst].clamp(low[k], high[k]);
            }
            None => {
                free.iter().zip(found.iter()).for_each(|(k, s)| step[*k] = *s);
                return step;
            }
        }
    }
}

/// The least of `g.s + s.B s / 2` over `|s| <= radius` (section 4.3).
fn ball_step(g: &DVector<f64>, b: &DMatrix<f64>, radius: f64) -> DVector<f64> {
    if g.is_empty() {
        return g.clone();
    }
    let eigen = b.clone().symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(g);
    let values = &eigen.eigenvalues;
    let least = values.min();
    let scale = values.amax().max(f64::MIN_POSITIVE);
    let at = |shift: f64| along.zip_map(values, |g, value| -g / (value + shift));
    if least > 1e-14 * scale {
        let newton = at(0.0);
        if newton.norm() <= radius {
            return eigen.eigenvectors * newton;
        }
    }
    // The shift that makes the step as long as the radius: at it the length falls from above the radius to below.
    let mut low = (-least).max(0.0) + 1e-14 * scale;
    let mut high = low + g.norm() / radius;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at(middle).norm() > radius { low = middle } else { high = middle }
    }
    eigen.eigenvectors * at(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_the_least_in_the_ball() {
        let b = DMatrix::from_row_slice(2, 2, &[2.0, 0.5, 0.5, -1.0]);
        let g = DVector::from_vec(vec![0.3, -0.2]);
        let value = |s: &DVector<f64>| g.dot(s) + 0.5 * s.dot(&(&b * s));
        let step = ball_step(&g, &b, 0.7);
        assert!((step.norm() - 0.7).abs() < 1e-9);
        for k in 0..360 {
            let (sin, cos) = f64::from(k).to_radians().sin_cos();
            assert!(value(&step) <= value(&DVector::from_vec(vec![0.7 * cos, 0.7 * sin])) + 1e-12);
        }
        // Inside the ball it is Newton's.
        let b = DMatrix::from_row_slice(2, 2, &[2.0, 0.0, 0.0, 4.0]);
        assert!((ball_step(&g, &b, 9.0) - DVector::from_vec(vec![-0.15, 0.05])).norm() < 1e-15);
    }

    #[test]
    fn a_bound_is_kept_and_the_others_go_on() {
        let b = DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.5, 1.0]);
        let g = DVector::from_vec(vec![-2.0, 0.0]);
        let (low, high) = (DVector::from_vec(vec![-1.0, -1.0]), DVector::from_vec(vec![0.5, 1.0]));
        let step = box_step(&g, &b, &low, &high, 10.0);
        // With the first held at 0.5 the second's slope 0.25 + s vanishes at -0.25.
        assert!((step - DVector::from_vec(vec![0.5, -0.25])).norm() < 1e-14);
    }

    #[test]
    fn a_quadratic_is_learnt_by_updates_of_rank_one() {
        let truth = DMatrix::from_row_slice(3, 3, &[3.0, 1.0, 0.0, 1.0, -2.0, 0.5, 0.0, 0.5, 1.0]);
        let mut matrix = DMatrix::identity(3, 3);
        for k in 0..3 {
            let step = DVector::from_fn(3, |i, _| if i == k { 0.5 } else { 0.1 * i as f64 });
            rank_one(&mut matrix, &step, &(&truth * &step), false);
        }
        // Theorem 6.1: n independent steps, and the matrix is exact.
        assert!((matrix - truth).amax() < 1e-12);
    }
}
