//! Transport solvers on the same problems in the same run, each on one thread: the network simplex, POT's `ot.emd` where
//! Python has it, the back ends of good_lp in this build, and Sinkhorn. Then the slices of a paint on one and two threads.
//!
//! Times are the shortest of several runs, averaged over the instances of a row. Ours hold building the costs and the
//! certificate, POT's neither. Errors are against the exact cost. `CARPAINT_PYTHON` names the interpreter, else it is `python3`.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::transport::{Cost, Plan, Problem, SinkhornOptions, Solver, sinkhorn, solve};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Where the centers of a family lie.
#[derive(Clone, Copy)]
enum Family {
    /// Anywhere in Lab.
    Random,
    /// Around five colors.
    Clustered,
    /// Five colors, nothing else.
    Duplicates,
    /// On the gray axis.
    Gray,
    /// On a grid, so that many ways are equally long.
    Grid,
}

const KINDS: [(&str, Family, Cost); 8] = [
    ("random", Family::Random, Cost::Euclidean),
    ("clustered", Family::Clustered, Cost::Euclidean),
    ("duplicates", Family::Duplicates, Cost::Euclidean),
    ("gray", Family::Gray, Cost::Euclidean),
    ("grid", Family::Grid, Cost::Euclidean),
    ("random, squared", Family::Random, Cost::Squared),
    ("random, capped:50", Family::Random, Cost::Capped(50.0)),
    ("random, capped:30", Family::Random, Cost::Capped(30.0)),
];

struct Instance {
    source: Vec<DVec3>,
    p: Vec<f64>,
    target: Vec<DVec3>,
    q: Vec<f64>,
    cost: Cost,
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
        Family::Gray => DVec3::new(lab(rng).x, 0.0, 0.0),
        Family::Grid => 12.5 * (lab(rng) / 12.5).round(),
    });
    let centers = centers.collect();
    // Exponential variables over their sum: uniform on the simplex of distributions.
    let masses: Vec<f64> = (0..n).map(|_| -rng.random_range(f64::MIN_POSITIVE..1.0).ln()).collect();
    let total: f64 = masses.iter().sum();
    (centers, masses.iter().map(|mass| mass / total).collect())
}

impl Instance {
    fn new(family: Family, cost: Cost, n: usize, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed);
        let ((source, p), (target, q)) = (side(family, n, &mut rng), side(family, n, &mut rng));
        Self { source, p, target, q, cost }
    }

    fn problem(&self) -> Problem {
        Problem::from_centers(&self.source, &self.p, &self.target, &self.q, self.cost).expect("legal")
    }

    fn json(&self) -> Value {
        let list = |centers: &[DVec3]| centers.iter().map(DVec3::to_array).collect::<Vec<_>>();
        let cap = if let Cost::Capped(cap) = self.cost { json!(cap) } else { Value::Null };
        let squared = self.cost == Cost::Squared;
        json!({ "x": list(&self.source), "y": list(&self.target), "p": self.p, "q": self.q, "cap": cap, "squared": squared })
    }
}

/// Shortest time in milliseconds, and the last plan.
fn timed(runs: usize, solve: impl Fn() -> Plan) -> (f64, Plan) {
    let mut best = f64::INFINITY;
    let mut plan = solve();
    for _ in 0..runs {
        let start = Instant::now();
        plan = solve();
        best = best.min(1e3 * start.elapsed().as_secs_f64());
    }
    (best, plan)
}

/// Reads instances, prints the shortest milliseconds of `ot.emd` and its cost for each.
const POT: &str = r#"
import json, sys, time, warnings
import numpy, ot
warnings.simplefilter("ignore")
answers = []
for row in json.load(sys.stdin):
    x, y, p, q = (numpy.array(row[name]) for name in "xypq")
    w = ot.dist(x, y, "sqeuclidean" if row["squared"] else "euclidean")
    if row["cap"]: w = numpy.minimum(w, row["cap"])
    best, runs = float("inf"), 40 if len(p) < 200 else 8 if len(p) < 1000 else 3
    for _ in range(runs):
        start = time.perf_counter()
        plan = ot.emd(p, q, w, numItermax=10**8, numThreads=1)
        best = min(best, time.perf_counter() - start)
    answers.append([1e3 * best, float((plan * w).sum())])
print(json.dumps(answers))
"#;

/// POT's milliseconds and cost for each instance; none where it is not installed.
fn pot<'a>(instances: impl Iterator<Item = &'a Instance>) -> Option<Vec<[f64; 2]>> {
    let python = std::env::var_os("CARPAINT_PYTHON").unwrap_or_else(|| "python3".into());
    let mut child = Command::new(python)
        .args(["-c", POT])
        .env("OMP_NUM_THREADS", "1")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let rows: Vec<Value> = instances.map(Instance::json).collect();
    // Where POT is missing it ends before it has read all.
    let _ = child.stdin.take()?.write_all(json!(rows).to_string().as_bytes());
    serde_json::from_slice(&child.wait_with_output().ok()?.stdout).ok()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// Mean time, and largest error relative to the exact cost.
struct Row {
    ms: f64,
    error: f64,
}

fn row(answers: &[(f64, f64)], exact: &[(f64, Plan)]) -> Row {
    let error =
        |((_, cost), (_, plan)): (&(f64, f64), &(f64, Plan))| (cost / plan.certificate.cost - 1.0).abs();
    Row {
        ms: mean(answers.iter().map(|a| a.0)),
        error: answers.iter().zip(exact).map(error).fold(0.0, f64::max),
    }
}

fn print(name: &str, Row { ms, error }: &Row, own: f64) {
    println!("    {name:<30} {ms:>10.4} {:>8.2} {error:>10.1e}", ms / own);
}

/// Instances of each kind, and how often they are solved.
fn effort(n: usize) -> (u64, usize) {
    match n {
        ..200 => (5, 40),
        200..1000 => (3, 8),
        _ => (3, 3),
    }
}

/// All kinds of one size. POT answers them in one process: importing it takes longer than most of its answers.
fn compare_size(n: usize) {
    let instances = KINDS.map(|(_, family, cost)| {
        (0..effort(n).0).map(|seed| Instance::new(family, cost, n, seed)).collect::<Vec<_>>()
    });
    let pot = pot(instances.iter().flatten());
    if pot.is_none() {
        println!("POT: not installed (pip install POT)");
    }
    for (k, ((kind, ..), instances)) in KINDS.iter().zip(&instances).enumerate() {
        let count = instances.len();
        compare(kind, n, instances, pot.as_ref().map(|answers| &answers[k * count..][..count]));
    }
}

fn compare(kind: &str, n: usize, instances: &[Instance], pot: Option<&[[f64; 2]]>) {
    let (_, runs) = effort(n);
    let simplex =
        |i: &Instance| timed(runs, || solve(&i.problem(), Solver::NetworkSimplex).expect("solvable"));
    let exact: Vec<(f64, Plan)> = instances.iter().map(simplex).collect();
    let own = mean(exact.iter().map(|e| e.0));
    println!("{n} x {n}, {kind}");
    let gap =
        exact.iter().map(|(_, plan)| plan.certificate.gap.abs() / plan.certificate.cost).fold(0.0, f64::max);
    print("network-simplex (gap)", &Row { ms: own, error: gap }, own);
    if let Some(answers) = pot {
        let answers: Vec<(f64, f64)> = answers.iter().map(|a| (a[0], a[1])).collect();
        print("POT ot.emd", &row(&answers, &exact), own);
    }
    let answers = |solve: &dyn Fn(&Problem) -> Plan| -> Vec<(f64, f64)> {
        let answer = |i: &Instance| timed(1, || solve(&i.problem()));
        instances.iter().map(answer).map(|(ms, plan)| (ms, plan.certificate.cost)).collect()
    };
    if n == 50 {
        for solver in Solver::compiled_in().filter(|solver| *solver != Solver::NetworkSimplex) {
            let answers = answers(&|problem| solve(problem, solver).expect("solvable"));
            print(&solver.to_string(), &row(&answers, &exact), own);
        }
    }
    if n == 50 {
        for share in [0.05, 0.005] {
            let answers = answers(&|problem| {
                let regularization = share * problem.mean_cost();
                let options = SinkhornOptions { regularization, iterations: 200, tolerance: 1e-9 };
                sinkhorn(problem, options).expect("legal")
            });
            print(&format!("Sinkhorn, {share} mean cost"), &row(&answers, &exact), own);
        }
    }
}

/// Milliseconds for 465 problems of 50 x 50, certificates included.
fn slices(threads: usize) -> f64 {
    let instances: Vec<Instance> =
        (0..465).map(|seed| Instance::new(Family::Random, Cost::Euclidean, 50, seed)).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let once = || {
        let start = Instant::now();
        pool.install(|| {
            instances.par_iter().for_each(|i| {
                std::hint::black_box(solve(&i.problem(), Solver::NetworkSimplex).expect("solvable"));
            });
        });
        1e3 * start.elapsed().as_secs_f64()
    };
    (0..20).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn main() {
    println!("{:<34} {:>10} {:>8} {:>10}", "", "ms", "ratio", "error");
    for n in [16, 50, 51, 100, 101, 300, 301, 1024] {
        compare_size(n);
    }
    for threads in [1, 2] {
        println!("465 problems of 50 x 50, threads: {threads}, {:.1} ms", slices(threads));
    }
}
