//! The network simplex against good_lp's microlp on the same problems in the same run: times of one thread, model
//! building included, and how far each cost is from optimal.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::transport::{Cost, LinearProgram, Problem, Solver, solve};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::time::{Duration, Instant};

/// Where the centers of a family lie.
#[derive(Clone, Copy)]
enum Family {
    /// Anywhere in Lab.
    Random,
    /// Around five colors.
    Clustered,
    /// Five colors, nothing else.
    Duplicates,
}

fn lab(rng: &mut Pcg64) -> DVec3 {
    DVec3::new(rng.random_range(0.0..100.0), rng.random_range(-60.0..60.0), rng.random_range(-60.0..60.0))
}

fn side(family: Family, n: usize, rng: &mut Pcg64) -> (Vec<DVec3>, Vec<f64>) {
    let colors: Vec<DVec3> = (0..5).map(|_| lab(rng)).collect();
    let centers = (0..n).map(|k| match family {
        Family::Random => lab(rng),
        Family::Clustered => colors[k % 5] + 0.02 * lab(rng),
        Family::Duplicates => colors[k % 5],
    });
    let centers = centers.collect();
    // Exponential variables over their sum: uniform on the simplex of distributions.
    let masses: Vec<f64> = (0..n).map(|_| -rng.random_range(f64::MIN_POSITIVE..1.0).ln()).collect();
    let total: f64 = masses.iter().sum();
    (centers, masses.iter().map(|mass| mass / total).collect())
}

/// Shortest of `runs` times in milliseconds, and the largest relative gap of the plan.
fn measure(family: Family, n: usize, solver: Solver, runs: usize) -> (f64, f64) {
    let mut rng = Pcg64::seed_from_u64(1);
    let ((source, p), (target, q)) = (side(family, n, &mut rng), side(family, n, &mut rng));
    let (mut best, mut error) = (Duration::MAX, 0.0_f64);
    for _ in 0..runs {
        let start = Instant::now();
        let problem =
            Problem::from_centers(&source, &p, &target, &q, Cost::Euclidean).expect("a legal problem");
        let plan = solve(&problem, solver).expect("solvable");
        best = best.min(start.elapsed());
        error = error.max(plan.certificate.gap.abs() / plan.certificate.cost);
    }
    (1e3 * best.as_secs_f64(), error)
}

fn main() {
    let rows = [
        ("50 random", Family::Random, 50, 5),
        ("50 clustered", Family::Clustered, 50, 5),
        ("50 duplicates", Family::Duplicates, 50, 5),
        ("300 random", Family::Random, 300, 1),
    ];
    println!(
        "{:<14} {:>16} {:>8} {:>16} {:>8} {:>6}",
        "", "network simplex", "gap", "good_lp microlp", "gap", "ratio"
    );
    for (name, family, n, lp_runs) in rows {
        let (simplex, simplex_gap) = measure(family, n, Solver::NetworkSimplex, 200);
        let (lp, lp_gap) = measure(family, n, Solver::GoodLp(LinearProgram::MicroLp), lp_runs);
        println!(
            "{name:<14} {simplex:>13.3} ms {simplex_gap:>8.0e} {lp:>13.2} ms {lp_gap:>8.0e} {:>6.0}",
            lp / simplex
        );
    }
}
