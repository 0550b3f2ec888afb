//! Proof of how good a plan is.

use super::lanes;
use super::problem::Problem;
use super::sum::Sum;

/// Dual variables u and v: prices at the sources and the targets, in units of the cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Potentials {
    /// u of every source.
    pub source: Vec<f64>,
    /// v of every target.
    pub target: Vec<f64>,
}

/// What a plan costs, and what every plan costs at least.
///
/// By weak duality `sum p u + sum q v` bounds the cost of every plan from below if no reduced cost `w - u - v` is
/// negative. Whether that holds is checked here, in f64 against the costs of the problem: a certificate needs no trust
/// in the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// `sum w_ij x_ij` of the plan.
    pub cost: f64,
    /// A lower bound of the cost of any plan: the dual objective, the worst negative reduced cost taken off every unit
    /// of mass.
    pub dual_bound: f64,
    /// `cost - dual_bound`: how much the plan can be too expensive. Below 0 only by rounding, or because the plan
    /// misses masses.
    pub gap: f64,
    /// Least `w_ij - u_i - v_j`: 0, or negative by rounding.
    pub worst_reduced_cost: f64,
    /// Largest error of a row sum, relative to its own mass; infinite for flow out of a mass of 0.
    pub row_error: f64,
    /// Largest error of a column sum, relative to its own mass; infinite for flow into a mass of 0.
    pub column_error: f64,
    /// Largest error of a row or column sum, absolute.
    pub marginal_error: f64,
    /// Number of positive entries.
    pub positive_entries: usize,
}

impl Certificate {
    /// Judges any plan, given as source, target and mass, by any potentials, one for each source and target.
    pub fn new(problem: &Problem, entries: &[(usize, usize, f64)], potentials: &Potentials) -> Self {
        Self::exact(problem, entries, [potentials])
    }

    /// The same by potentials that are sums: rounded, and what rounding takes from them.
    pub(super) fn exact<const N: usize>(
        problem: &Problem,
        entries: &[(usize, usize, f64)],
        potentials: [&Potentials; N],
    ) -> Self {
        let (p, q) = (problem.supply(), problem.demand());
        let mut cost = Sum::default();
        let (mut rows, mut columns) = (vec![0.0; p.len()], vec![0.0; q.len()]);
        for &(i, j, mass) in entries {
            cost.add_product(problem.cost(i, j), mass);
            rows[i] += mass;
            columns[j] += mass;
        }
        let worst_reduced_cost = worst_reduced_cost(problem, potentials);
        let mut bound = Sum::default();
        for (masses, duals) in potentials.iter().flat_map(|part| [(p, &part.source), (q, &part.target)]) {
            masses.iter().zip(duals).for_each(|(mass, dual)| bound.add_product(*mass, *dual));
        }
        bound.add_product(p.iter().sum(), worst_reduced_cost.min(0.0));
        let (row_error, row_absolute) = errors(&rows, p);
        let (column_error, column_absolute) = errors(&columns, q);
        let (cost, dual_bound) = (cost.value(), bound.value());
        Self {
            cost,
            dual_bound,
            gap: cost - dual_bound,
            worst_reduced_cost,
            row_error,
            column_error,
            marginal_error: row_absolute.max(column_absolute),
            positive_entries: entries.iter().filter(|entry| entry.2 > 0.0).count(),
        }
    }
}

/// Rounded only once where a reduced cost is as small as rounding: elsewhere it cannot be the least.
fn worst_reduced_cost<const N: usize>(problem: &Problem, potentials: [&Potentials; N]) -> f64 {
    let [rounded, ..] = potentials.as_slice() else { return f64::NEG_INFINITY };
    let exact = |i: usize, j: usize| {
        let mut sum = Sum::default();
        sum.add(problem.cost(i, j));
        potentials.iter().for_each(|part| sum.extend([-part.source[i], -part.target[j]]));
        sum.value()
    };
    let size = |duals: &[f64]| duals.iter().fold(0.0, |most: f64, dual| most.max(dual.abs()));
    let rounding = 4.0 * f64::EPSILON * (size(&rounded.source) + size(&rounded.target));
    let mut worst = f64::INFINITY;
    for (i, u) in rounded.source.iter().enumerate() {
        let least = lanes::least_difference(problem.cost_row(i), &rounded.target) - u;
        let most = (least + 2.0 * rounding).min(worst + rounding);
        if least <= most {
            let close = problem.cost_row(i).iter().zip(&rounded.target).map(|(w, v)| w - v - u <= most);
            let close = close.enumerate().filter(|(_, close)| *close);
            worst = close.map(|(j, _)| exact(i, j)).fold(worst, f64::min);
        }
    }
    worst
}

/// Largest relative and absolute error of the sums.
fn errors(sums: &[f64], masses: &[f64]) -> (f64, f64) {
    sums.iter().zip(masses).fold((0.0, 0.0), |(relative, absolute): (f64, f64), (sum, mass)| {
        let error = (sum - mass).abs();
        let own = if error == 0.0 { 0.0 } else { error / mass };
        (relative.max(own), absolute.max(error))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Plan, Solver, solve};

    fn solved() -> (Problem, Plan, Potentials) {
        let problem =
            Problem::from_fn(&[0.25, 0.75], &[0.5, 0.5], |i, j| (10 * i.abs_diff(j)) as f64).expect("legal");
        let plan = solve(&problem, Solver::default()).expect("solvable");
        // Mass must flow from 1 to 0, at 10 a unit.
        (problem, plan, Potentials { source: vec![-10.0, 0.0], target: vec![10.0, 0.0] })
    }

    #[test]
    fn the_optimum_closes_the_gap() {
        let (problem, plan, potentials) = solved();
        let certificate = Certificate::new(&problem, &plan.entries, &potentials);
        assert_eq!((certificate.cost, certificate.dual_bound, certificate.gap), (2.5, 2.5, 0.0));
        assert_eq!(
            (certificate.row_error, certificate.column_error, certificate.marginal_error),
            (0.0, 0.0, 0.0)
        );
        assert_eq!((certificate.worst_reduced_cost, certificate.positive_entries), (0.0, 3));
        assert_eq!(certificate, plan.certificate);
    }

    #[test]
    fn a_legal_detour_opens_the_gap() {
        let (problem, mut plan, potentials) = solved();
        // Move 0.125 around the cycle 0 -> 1 -> 0: all sums stay, the cost rises by 2 * 10 * 0.125.
        plan.entries = vec![(0, 0, 0.125), (0, 1, 0.125), (1, 0, 0.375), (1, 1, 0.375)];
        let certificate = Certificate::new(&problem, &plan.entries, &potentials);
        assert_eq!((certificate.marginal_error, certificate.gap), (0.0, 2.5));
    }

    #[test]
    fn lost_mass_shows_in_the_sums() {
        let (problem, mut plan, potentials) = solved();
        plan.entries[0].2 *= 0.5;
        let certificate = Certificate::new(&problem, &plan.entries, &potentials);
        assert_eq!((certificate.row_error, certificate.column_error), (0.5, 0.25));
        assert_eq!(certificate.marginal_error, 0.125);
    }

    #[test]
    fn flow_without_mass_is_an_infinite_error() {
        let problem = Problem::from_fn(&[1.0, 0.0], &[1.0], |_, _| 1.0).expect("legal");
        let potentials = Potentials { source: vec![1.0, 1.0], target: vec![0.0] };
        let certificate = Certificate::new(&problem, &[(0, 0, 1.0), (1, 0, 1e-300)], &potentials);
        assert_eq!((certificate.row_error, certificate.column_error), (f64::INFINITY, 0.0));
    }

    #[test]
    fn wrong_potentials_never_prove_too_much() {
        let (problem, plan, mut potentials) = solved();
        for (side, change) in [(0, 3.0), (0, -3.0), (1, 3.0), (1, -3.0)] {
            let original = potentials.clone();
            [&mut potentials.source, &mut potentials.target][side][0] += change;
            let certificate = Certificate::new(&problem, &plan.entries, &potentials);
            assert!(certificate.gap > 0.5, "side {side} by {change}: {certificate:?}");
            assert!(change < 0.0 || certificate.worst_reduced_cost == -change);
            potentials = original;
        }
    }
}
