//! Optimal transport: masses of all magnitudes, plans of equal cost, degenerate bases.

use super::{HardCase, Outcome, larger, worst};
use crate::error::Result;
use crate::transport::{Certificate, LinearProgram, Plan, Potentials, Problem, Solver, solve};

pub(super) fn cases() -> Result<Vec<HardCase>> {
    Ok(vec![tiny_masses()?, ties()?, degenerate()?])
}

/// Sources to targets in their order: a first basic plan, by subtraction of what is moved.
fn north_west(p: &[f64], q: &[f64]) -> Vec<(usize, usize, f64)> {
    let (mut left, mut open) = (p.to_vec(), q.to_vec());
    let (mut i, mut j, mut entries) = (0, 0, Vec::new());
    while i < p.len() && j < q.len() {
        let moved = left[i].min(open[j]);
        entries.push((i, j, moved));
        (left[i], open[j]) = (left[i] - moved, open[j] - moved);
        (i, j) = (i + usize::from(left[i] <= 0.0), j + usize::from(open[j] <= 0.0));
    }
    entries
}

/// Error of the worst row or column, relative to its mass.
fn worst_marginal(certificate: &Certificate) -> f64 {
    larger(certificate.row_error, certificate.column_error)
}

fn tiny_masses() -> Result<HardCase> {
    let p = [0.5, 1e-300, 0.25, 5e-324, 0.25, 1e-17];
    let q = [0.375, 1e-310, 0.625, 3e-17, 1e-200];
    let problem = Problem::from_fn(&p, &q, |i, j| ((7 * i + 5 * j) % 11) as f64)?;
    let none = Potentials { source: vec![0.0; p.len()], target: vec![0.0; q.len()] };
    let naive = Certificate::new(&problem, &north_west(&p, &q), &none);
    let plan = solve(&problem, Solver::NetworkSimplex)?;
    Ok(HardCase {
        name: "masses of 1e-300 beside one half",
        formula: "p_i <- p_i - x_ij, q_j <- q_j - x_ij",
        source: "Golla & Klein 2018, eqs 9-13; transport::solve",
        arguments: "masses 0.5 to 5e-324 on both sides; f64",
        measure: "row or column, relative to its own mass",
        naive: worst([naive], |c| worst_marginal(&c)),
        stable: worst([plan.certificate], |c| worst_marginal(&c)),
        bar: 8.0 * f64::EPSILON,
        why: "flows are exact; each entry and each addition of a sum rounds once",
        worse: 1e9,
    })
}

/// Gray paints: centers on a line, where a continuum of plans costs the same.
fn ties() -> Result<HardCase> {
    let n = 12;
    let order: Vec<usize> = (0..n).map(|k| 5 * k % n).collect();
    let mass = |k: usize| (1 + k % 3) as f64;
    let cost = |i: usize, j: usize| (40.0 + 1.25 * j as f64) - 1.5 * i as f64;
    let plan_of = |order: &[usize], solver| -> Result<Plan> {
        let masses: Vec<f64> = order.iter().map(|k| mass(*k)).collect();
        solve(&Problem::from_fn(&masses, &masses, |i, j| cost(order[i], order[j]))?, solver)
    };
    let straight: Vec<usize> = (0..n).collect();
    // Mass that moves otherwise if clusters are listed in another order, over all mass.
    let moved = |solver| -> Result<f64> {
        let mut flow = vec![0.0; n * n];
        for (order, sign) in [(&straight, 1.0), (&order, -1.0)] {
            for (i, j, x) in plan_of(order, solver)?.entries {
                flow[order[i] * n + order[j]] += sign * x;
            }
        }
        let total: f64 = (0..n).map(mass).sum();
        Ok(flow.iter().map(|x| x.abs()).sum::<f64>() / (2.0 * total))
    };
    Ok(HardCase {
        name: "plans of equal cost",
        formula: "min sum w_ij x_ij, any basic solution",
        source: "Golla & Klein 2018, eqs 9-13, as a linear program; transport::solve",
        arguments: "12 clusters on a line, in two orders; f64",
        measure: "mass that moves otherwise in another order",
        naive: worst([moved(Solver::GoodLp(LinearProgram::MicroLp))?], |e| e),
        stable: worst([moved(Solver::NetworkSimplex)?], |e| e),
        bar: 1e-12,
        why: "flows are whole numbers: the canonical plan is the same but for the rounding of entries",
        worse: 1e3,
    })
}

fn degenerate() -> Result<HardCase> {
    let n = 16;
    let masses = vec![1.0; n];
    let cost = |i: usize, j: usize| ((7 * i + 3 * j) % 5) as f64;
    let problem = Problem::from_fn(&masses, &masses, cost)?;
    // Stepping stones: u_i + v_j = w_ij at every entry, from u_0 = 0 on. Equal masses leave n entries where 2 n - 1 are needed.
    let entries = north_west(&masses, &masses);
    let (mut source, mut target) = (vec![f64::NAN; n], vec![f64::NAN; n]);
    source[0] = 0.0;
    for _ in 0..n {
        for &(i, j, _) in &entries {
            if target[j].is_nan() {
                target[j] = cost(i, j) - source[i];
            }
            if source[i].is_nan() {
                source[i] = cost(i, j) - target[j];
            }
        }
    }
    let unknown = source.iter().chain(&target).any(|dual| dual.is_nan());
    let certificate = solve(&problem, Solver::NetworkSimplex)?.certificate;
    let gap = certificate.gap.abs() / certificate.cost.max(1e-3 * problem.mean_cost());
    Ok(HardCase {
        name: "a degenerate basis",
        formula: "u_i + v_j = w_ij at the 2 n - 1 entries of the basis",
        source: "Dantzig 1951; transport::solve, whose masses are perturbed by less than their last bit",
        arguments: "16 equal masses on both sides, whole costs from 0 to 4; f64",
        measure: "duality gap, relative",
        naive: if unknown { Outcome::Fails("no duals") } else { Outcome::Error(0.0) },
        stable: worst([gap, worst_marginal(&certificate)], |e| e),
        bar: 1e-12,
        why: "what the network simplex promises",
        worse: 1e3,
    })
}
