//! Coupling: certificates, and the same cost from a linear programming solver.

use super::Check;
use super::stage::largest;
use crate::error::Result;
use crate::mix::CoupleReport;
use crate::paint::Flakes;
use crate::parallel::TryMap;
use crate::transport::{Cost, LinearProgram, Problem, Solver, solve};
use glam::DVec3;
use rayon::prelude::*;

/// Gaps and marginals of all problems, and for every slice of the finest level the cost that good_lp finds.
///
/// # Errors
/// Those of the solvers.
pub fn checks(report: &CoupleReport, a: &Flakes, b: &Flakes) -> Result<Vec<Check>> {
    let differences = a.levels[0].slices.par_iter().zip(&b.levels[0].slices).try_map(|(a, b)| {
        let side = |s: &crate::cluster::SliceStatistics| -> (Vec<DVec3>, Vec<f64>) {
            s.clusters.iter().map(|c| (c.center(), c.probability)).unzip()
        };
        let ((ca, pa), (cb, pb)) = (side(a), side(b));
        let problem = Problem::from_centers(&ca, &pa, &cb, &pb, Cost::Euclidean)?;
        let exact = solve(&problem, Solver::NetworkSimplex)?.certificate.cost;
        let reference = solve(&problem, Solver::GoodLp(LinearProgram::MicroLp))?.certificate.cost;
        Ok((exact - reference).abs() / exact.max(1e-3 * problem.mean_cost()))
    })?;
    let count = differences.len();
    Ok(vec![
        Check::new("duality gap over max(cost, 1e-3 mean edge), largest", report.worst_relative_gap, 1e-12),
        Check::new(
            "row and column sums, relative error, largest",
            report.worst_row_error.max(report.worst_column_error),
            1e-12,
        ),
        // The LP loses masses below its feasibility tolerance of 1e-9: up to 1e-7 of the cost.
        Check::new(
            format!("cost against good_lp, relative, largest of {count} slices"),
            largest(differences),
            1e-7,
        ),
    ])
}
