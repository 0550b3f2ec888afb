//! Optimal transport between two discrete distributions (Golla & Klein 2018, section 4.1, eqs 8-13).
//!
//! A [`Problem`] has n_s supplies p, n_t demands q and the costs w of moving a unit of mass. [`solve`] finds the flows
//! x >= 0 of least total cost `sum w_ij x_ij` whose row sums are p and whose column sums are q:
//!
//! ```
//! use carpaint::transport::{Problem, Solver, solve};
//! let problem = Problem::from_fn(&[0.5, 0.5], &[0.25, 0.75], |i, j| if i == j { 0.0 } else { 8.0 })?;
//! let plan = solve(&problem, Solver::default())?;
//! assert_eq!(plan.entries, [(0, 0, 0.25), (0, 1, 0.25), (1, 1, 0.5)]);
//! assert_eq!(plan.certificate.cost, 2.0);
//! assert_eq!(plan.certificate.dual_bound, 2.0);
//! # Ok::<(), carpaint::Error>(())
//! ```
//!
//! What the network simplex guarantees: the plan is a function of the problem alone; every row and column sum is right
//! relative to its own mass, however small that is; a positive mass keeps a positive entry, a zero mass has none; there
//! are at most `n_s + n_t - 1` entries. Every plan carries a [`Certificate`] of how far from optimal it can be.

mod certificate;
mod coincident;
mod cost;
mod dense;
mod few;
mod fixed_point;
mod lanes;
mod lp;
mod mass;
mod multi_marginal;
mod network_simplex;
mod problem;
mod sinkhorn;
mod solver;
mod start;
mod sum;
mod tie;
mod tree;

pub use certificate::{Certificate, Potentials};
pub use cost::Cost;
pub use multi_marginal::{Marginal, MultiMarginalPlan, multi_marginal, pairwise_cost};
pub use problem::Problem;
pub use sinkhorn::{SinkhornOptions, sinkhorn};
pub use solver::{LinearProgram, Solver};

use crate::error::Result;

/// A transport plan and the proof of its quality.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Source, target and mass moved, above 0; sorted by source, then target.
    pub entries: Vec<(usize, usize, f64)>,
    /// How far from optimal the plan can be, and how well it meets the masses.
    pub certificate: Certificate,
}

/// Solves a transport problem.
///
/// # Errors
/// The linear program solver gave up. The network simplex never fails.
pub fn solve(problem: &Problem, solver: Solver) -> Result<Plan> {
    // Any potentials prove a bound (weak duality), and microlp tells none: the network simplex supplies them for both.
    let optimum = network_simplex::solve(problem);
    let entries = match solver {
        Solver::NetworkSimplex => optimum.entries,
        Solver::GoodLp(back_end) => lp::solve(problem, back_end)?,
    };
    let certificate = Certificate::exact(problem, &entries, optimum.potentials.each_ref());
    Ok(Plan { entries, certificate })
}
