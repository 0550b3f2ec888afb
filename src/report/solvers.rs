//! Transport solvers side by side: cost, error, time.

use super::stage::{largest, mean};
use crate::cluster::SliceStatistics;
use crate::error::Result;
use crate::transport::{Cost, Plan, Problem, SinkhornOptions, Solver, sinkhorn, solve};
use glam::DVec3;
use serde::Serialize;
use std::time::Instant;

/// Weight of Sinkhorn's entropy, in mean costs.
const REGULARIZATIONS: [f64; 3] = [0.1, 0.01, 0.001];
/// Updates of both sides that Sinkhorn gets.
const ITERATIONS: usize = 1000;

/// A transport solver on pairs of slices.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SolverError {
    /// Its name.
    pub solver: String,
    /// Distance of the cost from the proven lower bound, over the larger of that and a thousandth of the mean edge; largest
    /// of the pairs.
    pub cost_error: f64,
    /// Error of a row or column sum, of a total mass of 1, largest of the pairs.
    pub marginal_error: f64,
    /// Mean time of a pair, one thread, milliseconds: the shortest of three runs, certificate included.
    pub milliseconds: f64,
}

/// The transport problem between two slices.
///
/// # Errors
/// Those of [`Problem::from_centers`].
pub fn problem(a: &SliceStatistics, b: &SliceStatistics) -> Result<Problem> {
    let [(ca, pa), (cb, pb)] = [a, b].map(|side| -> (Vec<DVec3>, Vec<f64>) {
        side.clusters.iter().map(|c| (c.center(), c.probability)).unzip()
    });
    Problem::from_centers(&ca, &pa, &cb, &pb, Cost::Euclidean)
}

/// The solvers of this build, then Sinkhorn with less and less entropy.
///
/// # Errors
/// Those of the solvers.
pub fn solver_errors(pairs: &[Problem]) -> Result<Vec<SolverError>> {
    let bounds = pairs
        .iter()
        .map(|pair| Ok(solve(pair, Solver::NetworkSimplex)?.certificate.dual_bound))
        .collect::<Result<Vec<f64>>>()?;
    let exact = Solver::compiled_in()
        .map(|solver| solver_error(solver.to_string(), pairs, &bounds, |pair| solve(pair, solver)));
    let entropic = REGULARIZATIONS.into_iter().map(|share| {
        solver_error(format!("Sinkhorn, {share} mean cost"), pairs, &bounds, |pair| {
            let regularization = share * pair.mean_cost();
            sinkhorn(pair, SinkhornOptions { regularization, iterations: ITERATIONS, tolerance: 1e-9 })
        })
    });
    exact.chain(entropic).collect()
}

fn solver_error(
    solver: String,
    pairs: &[Problem],
    bounds: &[f64],
    run: impl Fn(&Problem) -> Result<Plan>,
) -> Result<SolverError> {
    let (mut errors, mut marginals, mut times) = (Vec::new(), Vec::new(), Vec::new());
    for (pair, bound) in pairs.iter().zip(bounds) {
        let mut shortest = f64::INFINITY;
        for _ in 0..3 {
            let start = Instant::now();
            let certificate = run(pair)?.certificate;
            shortest = shortest.min(1e3 * start.elapsed().as_secs_f64());
            errors.push((certificate.cost - bound).abs() / bound.max(1e-3 * pair.mean_cost()));
            marginals.push(certificate.marginal_error);
        }
        times.push(shortest);
    }
    let (cost_error, marginal_error, milliseconds) = (largest(errors), largest(marginals), mean(times));
    Ok(SolverError { solver, cost_error, marginal_error, milliseconds })
}
