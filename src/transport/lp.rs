//! The transport problem as a linear program (Golla & Klein 2018, eqs 9-13), solved through good_lp.
//!
//! The reference the network simplex is compared with. Linear programs are met within absolute tolerances: masses near
//! 1e-9 of the total may come back empty or slightly negative, and the cost is off by up to about 1e-7 of the mean
//! cost. Those flows are repaired so that the plan is legal; its cost stays what the tolerance made of it, and the repair
//! may add entries beyond the n_s + n_t - 1 of a basic solution.

use super::problem::Problem;
use super::solver::{LinearProgram, Solver};
use crate::error::{Error, Result};
use good_lp::{Expression, ProblemVariables, Solution, SolverModel, variable};

/// Source, target and mass of every positive flow, sorted.
pub(super) fn solve(problem: &Problem, back_end: LinearProgram) -> Result<Vec<(usize, usize, f64)>> {
    let total: f64 = problem.supply().iter().sum();
    let flows = flows(problem, total, back_end).map_err(|cause| {
        Error::not_converged(
            "transport",
            "linear program",
            cause,
            "an optimum; network-simplex always has one",
        )
    })?;
    Ok(repaired(problem, flows, total))
}

fn flows(problem: &Problem, total: f64, back_end: LinearProgram) -> std::result::Result<Vec<f64>, String> {
    match back_end {
        LinearProgram::MicroLp => basic_flows(problem, total, good_lp::microlp),
        #[cfg(feature = "highs")]
        LinearProgram::Highs => basic_flows(problem, total, good_lp::highs),
        #[cfg(feature = "clarabel")]
        LinearProgram::Clarabel => {
            // From the interior every flow is positive: what its tolerance cannot tell from 0 is left to the repair.
            let mut flows = basic_flows(problem, total, good_lp::clarabel)?;
            flows.iter_mut().filter(|flow| **flow < 1e-8).for_each(|flow| *flow = 0.0);
            Ok(flows)
        }
        #[allow(unreachable_patterns)]
        _ => Err(format!("not in this build, which has {}", Solver::names())),
    }
}

/// Flows as the linear program has them, row by row, for a total mass and a largest cost of 1.
fn basic_flows<S>(problem: &Problem, total: f64, solver: S) -> std::result::Result<Vec<f64>, String>
where
    S: good_lp::Solver,
    S::Model: SolverModel,
    <S::Model as SolverModel>::Error: std::fmt::Display,
{
    let (p, q) = (problem.supply(), problem.demand());
    let unit = if problem.largest_cost() > 0.0 { problem.largest_cost() } else { 1.0 };
    let mut variables = ProblemVariables::new();
    let flows = variables.add_vector(variable().min(0.0), p.len() * q.len());
    let costs = (0..p.len()).flat_map(|i| problem.cost_row(i));
    let objective: Expression = flows.iter().zip(costs).map(|(&flow, cost)| cost / unit * flow).sum();
    let mut model = variables.minimise(objective).using(solver);
    for (row, mass) in flows.chunks_exact(q.len()).zip(p) {
        model = model.with(row.iter().sum::<Expression>().eq(mass / total));
    }
    // The largest column follows from all others and from eq. 13; stated, it could only contradict them by rounding.
    let largest = (0..q.len()).max_by(|&a, &b| q[a].total_cmp(&q[b]));
    for j in (0..q.len()).filter(|&j| Some(j) != largest) {
        let column = flows[j..].iter().step_by(q.len());
        model = model.with(column.sum::<Expression>().eq(q[j] / total));
    }
    let solution = model.solve().map_err(|error| error.to_string())?;
    Ok(flows.iter().map(|&flow| solution.value(flow)).collect())
}

/// The nearest legal plan, nearly: no negative flow, none beyond its row or column, and what rows and columns then lack
/// shipped greedily. Row sums come out right relative to their own masses, column sums to rounding of the total.
fn repaired(problem: &Problem, mut flows: Vec<f64>, total: f64) -> Vec<(usize, usize, f64)> {
    let (p, q) = (problem.supply(), problem.demand());
    let mut lacking = q.to_vec();
    let mut entries = Vec::new();
    for (i, row) in flows.chunks_exact_mut(q.len()).enumerate() {
        row.iter_mut().for_each(|flow| *flow = flow.max(0.0) * total);
        let sum: f64 = row.iter().sum();
        let shrink = if sum > p[i] { p[i] / sum } else { 1.0 };
        for (flow, lacking) in row.iter_mut().zip(&mut lacking) {
            *flow = (*flow * shrink).min(*lacking);
            *lacking -= *flow;
        }
    }
    for (i, row) in flows.chunks_exact_mut(q.len()).enumerate() {
        let mut rest = p[i] - row.iter().sum::<f64>();
        let mut order: Vec<usize> = (0..q.len()).filter(|&j| q[j] > 0.0).collect();
        order.sort_by(|&a, &b| problem.cost(i, a).total_cmp(&problem.cost(i, b)));
        for &j in &order {
            let flow = rest.min(lacking[j]).max(0.0);
            row[j] += flow;
            lacking[j] -= flow;
            rest -= flow;
        }
        // Rounding may have filled every column early: the nearest one takes the rest.
        if let Some(&j) = order.first() {
            row[j] += rest.max(0.0);
        }
        entries
            .extend(row.iter().enumerate().filter(|(_, flow)| **flow > 0.0).map(|(j, &flow)| (i, j, flow)));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flows_off_by_the_tolerance_become_a_legal_plan() {
        let problem = Problem::from_fn(&[1.0, 2.0, 1e-12], &[1.5, 1.5, 1e-12], |i, j| i.abs_diff(j) as f64);
        let problem = problem.expect("legal");
        let flows = vec![0.25, 1e-10, -1e-10, 0.125 - 1e-10, 0.375 + 1e-10, 1e-10, -1e-13, 0.0, 0.0];
        let entries = repaired(&problem, flows.iter().map(|x| x * 4.0 / 3.0).collect(), 3.0);
        let mut rows = [0.0; 3];
        let mut columns = [0.0; 3];
        for (i, j, mass) in entries {
            assert!(mass > 0.0);
            rows[i] += mass;
            columns[j] += mass;
        }
        // A few roundings of each row's own mass; of the total for columns.
        for i in 0..3 {
            assert!((rows[i] / problem.supply()[i] - 1.0).abs() < 1e-15, "{rows:?}");
            assert!((columns[i] - problem.demand()[i]).abs() < 3.0 * 4.0 * f64::EPSILON, "{columns:?}");
        }
    }
}
