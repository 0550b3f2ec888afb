//! Entropic transport (Cuturi 2013), for the comparison with exact plans only.
//!
//! The plan `exp((u + v - w) / regularization)` spreads every mass over many targets and meets row sums only as far as the
//! iteration got; its certificate says by how much. In the log domain (Peyré & Cuturi 2019, section 4.4) no exponential
//! under- or overflows, however small the regularization is.

use super::Plan;
use super::certificate::{Certificate, Potentials};
use super::problem::Problem;
use crate::error::{Error, Result};

/// How far Sinkhorn's iteration goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SinkhornOptions {
    /// Weight of the entropy, in units of the cost, above 0: moves blur over about that much cost.
    pub regularization: f64,
    /// Largest number of updates of both sides, at least 1.
    pub iterations: usize,
    /// It ends early when the row sums are off by at most this share of the total mass.
    pub tolerance: f64,
}

/// The entropic plan, columns right to rounding, and its certificate.
///
/// # Errors
/// A regularization that is not above 0 or not finite, no iteration.
pub fn sinkhorn(problem: &Problem, options: SinkhornOptions) -> Result<Plan> {
    let SinkhornOptions { regularization, iterations, tolerance } = options;
    if !(regularization > 0.0 && regularization.is_finite()) {
        return Err(Error::invalid("sinkhorn", "regularization", regularization, "a finite number above 0"));
    }
    if iterations == 0 {
        return Err(Error::invalid("sinkhorn", "number of iterations", iterations, "at least 1"));
    }
    let (p, q) = (problem.supply(), problem.demand());
    let total: f64 = p.iter().sum();
    let mut u = vec![0.0; p.len()];
    let mut v = vec![0.0; q.len()];
    for _ in 0..iterations {
        let before = u.clone();
        for (i, u) in u.iter_mut().enumerate() {
            *u = dual(p[i], regularization, problem.cost_row(i).iter().zip(&v).map(|(w, v)| w - v));
        }
        // Until u changes, row i sums up to p exp((old u - new u) / regularization).
        let off = (0..p.len())
            .filter(|&i| p[i] > 0.0)
            .map(|i| p[i] * ((before[i] - u[i]) / regularization).exp_m1().abs());
        if off.sum::<f64>() <= tolerance * total {
            u = before;
            break;
        }
        for (j, v) in v.iter_mut().enumerate() {
            *v = dual(q[j], regularization, u.iter().enumerate().map(|(i, u)| problem.cost(i, j) - u));
        }
    }
    let mut entries = Vec::new();
    for (i, u) in u.iter().enumerate().filter(|(i, _)| p[*i] > 0.0) {
        let row = problem.cost_row(i).iter().zip(&v).enumerate().filter(|(j, _)| q[*j] > 0.0);
        let row = row.map(|(j, (w, v))| (i, j, ((u + v - w) / regularization).exp()));
        entries.extend(row.filter(|entry| entry.2 > 0.0));
    }
    fill(&mut u, |i| least(problem.cost_row(i).iter().zip(&v).map(|(w, v)| w - v)));
    fill(&mut v, |j| least(u.iter().enumerate().map(|(i, u)| problem.cost(i, j) - u)));
    let certificate = Certificate::new(problem, &entries, &Potentials { source: u, target: v });
    Ok(Plan { entries, certificate })
}

/// The dual that gives a node its mass, from the costs beyond the duals of the other side; none without mass.
fn dual(mass: f64, regularization: f64, costs: impl Iterator<Item = f64> + Clone) -> f64 {
    if mass == 0.0 {
        return f64::NEG_INFINITY;
    }
    let least = least(costs.clone());
    let sum: f64 = costs.map(|cost| ((least - cost) / regularization).exp()).sum();
    least + regularization * (mass.ln() - sum.ln())
}

/// Without mass the largest feasible dual is as good as any.
fn fill(duals: &mut [f64], largest_feasible: impl Fn(usize) -> f64) {
    for (k, dual) in duals.iter_mut().enumerate().filter(|(_, dual)| **dual == f64::NEG_INFINITY) {
        *dual = largest_feasible(k);
    }
}

fn least(costs: impl Iterator<Item = f64>) -> f64 {
    costs.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(regularization: f64) -> SinkhornOptions {
        SinkhornOptions { regularization, iterations: 10_000, tolerance: 1e-14 }
    }

    /// Two masses of a half at distances 0 and 1: by symmetry u + v is the same for all pairs, and
    /// x_00 / x_01 = exp(1 / regularization).
    #[test]
    fn a_symmetric_problem_has_its_closed_form() {
        let problem = Problem::from_fn(&[0.5, 0.5], &[0.5, 0.5], |i, j| i.abs_diff(j) as f64).expect("legal");
        let plan = sinkhorn(&problem, options(0.25)).expect("legal");
        let stays = 0.5 / (1.0 + (-4.0_f64).exp());
        let expected = [stays, 0.5 - stays, 0.5 - stays, stays];
        for ((_, _, mass), expected) in plan.entries.iter().zip(expected) {
            assert!((mass - expected).abs() < 1e-14, "{:?}", plan.entries);
        }
        assert!((plan.certificate.cost - 2.0 * (0.5 - stays)).abs() < 1e-14);
    }

    #[test]
    fn less_entropy_comes_closer_and_too_few_iterations_are_seen() {
        let cost = |i, j| ((7 * i + 5 * j) % 11) as f64;
        let problem = Problem::from_fn(&[0.2, 0.0, 0.5, 0.3], &[0.4, 0.1, 0.5], cost);
        let problem = problem.expect("legal");
        let exact = super::super::solve(&problem, Default::default()).expect("solvable").certificate.cost;
        let error = |regularization| {
            sinkhorn(&problem, options(regularization)).expect("legal").certificate.cost - exact
        };
        let errors = [3.0, 0.5, 0.1].map(error);
        assert!(errors[0] > errors[1] && errors[1] > errors[2] && errors[2] >= -1e-12, "{errors:?}");
        let early = sinkhorn(&problem, SinkhornOptions { iterations: 1, ..options(0.1) }).expect("legal");
        assert!(early.certificate.row_error > 0.01, "{:?}", early.certificate);
        assert!(early.certificate.column_error < 1e-12, "{:?}", early.certificate);
    }

    #[test]
    fn illegal_options_are_refused() {
        let problem = Problem::from_fn(&[1.0], &[1.0], |_, _| 1.0).expect("legal");
        for regularization in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(sinkhorn(&problem, options(regularization)).is_err());
        }
        assert!(sinkhorn(&problem, SinkhornOptions { iterations: 0, ..options(1.0) }).is_err());
    }
}
