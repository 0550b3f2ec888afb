//! Optimal transport: independent optima, laws on random problems, degenerate families, the binary.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::transport::{Cost, LinearProgram, Plan, Problem, Solver, solve};
use common::{carpaint, reference, reference_json};
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};

const MICROLP: Solver = Solver::GoodLp(LinearProgram::MicroLp);

/// Everything the network simplex promises of a plan, whatever the problem.
fn assert_laws(problem: &Problem, plan: &Plan) {
    let certificate = &plan.certificate;
    let (n_s, n_t) = (problem.supply().len(), problem.demand().len());
    // The promise of the module: 1e-12 of the cost, or of a thousandth of the mean move where the cost vanishes.
    let total: f64 = problem.supply().iter().sum();
    let allowed = 1e-12 * certificate.cost.max(1e-3 * problem.mean_cost() * total);
    assert!(certificate.gap.abs() <= allowed, "gap {:e} > {allowed:e}", certificate.gap);
    // One cut of a cost to fixed point and one rounding of each potential.
    assert!(
        certificate.worst_reduced_cost >= -8.0 * f64::EPSILON * problem.largest_cost(),
        "{certificate:?}"
    );
    // Flows are exact, so only the additions of a sum round; the largest column also bears what the totals differ by.
    assert!(certificate.row_error <= 1e-12, "rows off by {:e}", certificate.row_error);
    assert!(certificate.column_error <= 1e-12, "columns off by {:e}", certificate.column_error);
    assert!(plan.entries.len() < n_s + n_t);
    assert_eq!(plan.entries.len(), certificate.positive_entries);
    assert!(plan.entries.windows(2).all(|pair| (pair[0].0, pair[0].1) < (pair[1].0, pair[1].1)));
    assert!(plan.entries.iter().all(|entry| entry.2 > 0.0));
    for i in 0..n_s {
        assert_eq!(plan.entries.iter().any(|entry| entry.0 == i), problem.supply()[i] > 0.0, "source {i}");
    }
    for j in 0..n_t {
        assert_eq!(plan.entries.iter().any(|entry| entry.1 == j), problem.demand()[j] > 0.0, "target {j}");
    }
}

fn exact(problem: &Problem) -> Plan {
    let plan = solve(problem, Solver::NetworkSimplex).expect("always solvable");
    assert_laws(problem, &plan);
    plan
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("list").iter().map(|x| x.as_f64().expect("number")).collect()
}

fn centers(value: &Value) -> Vec<DVec3> {
    value.as_array().expect("list").iter().map(|c| DVec3::from_slice(&numbers(c))).collect()
}

fn problem_of(row: &Value) -> Problem {
    let (source, target) = (centers(&row["source_centres"]), centers(&row["target_centres"]));
    Problem::from_centers(&source, &numbers(&row["p"]), &target, &numbers(&row["q"]), Cost::Euclidean)
        .expect("legal")
}

fn oracle() -> Option<Vec<Value>> {
    let oracle = reference_json("oracles/06_optimal_transport.json")?;
    let instances = oracle["instances"].as_array().expect("list").clone();
    assert_eq!(instances.len(), 13);
    Some(instances)
}

#[test]
fn the_network_simplex_finds_the_optima_of_pot() {
    for row in oracle().unwrap_or_default() {
        let plan = exact(&problem_of(&row));
        let expected = row["optimal_cost"].as_f64().expect("number");
        // POT certifies its optima to 7e-12; the instances of cost 0 must come out as 0 to rounding of one distance.
        assert!((plan.certificate.cost - expected).abs() <= 1e-9 * expected + 1e-14, "{}", row["name"]);
        if expected == 0.0 {
            assert_eq!(plan.entries.len(), row["n_s"].as_u64().expect("number") as usize, "{}", row["name"]);
        }
    }
}

#[test]
fn good_lp_finds_the_optima_of_pot_within_its_tolerance() {
    for row in oracle().unwrap_or_default() {
        let plan = solve(&problem_of(&row), MICROLP).expect("solvable");
        let expected = row["optimal_cost"].as_f64().expect("number");
        // microlp meets constraints to an absolute 1e-10 or so, on as many as 200 rows.
        assert!((plan.certificate.cost - expected).abs() <= 1e-7 * expected.max(1.0), "{}", row["name"]);
        assert!(plan.certificate.marginal_error <= 1e-14, "{}: {:?}", row["name"], plan.certificate);
        assert!(plan.entries.iter().all(|entry| entry.2 > 0.0));
    }
}

/// Masses with ties, zeros, tiny ones and ordinary ones.
fn masses(n: usize) -> impl Strategy<Value = Vec<f64>> {
    let mass = prop_oneof![
        4 => 0.0..1.0_f64,
        2 => Just(0.125),
        1 => Just(0.0),
        1 => Just(1e-300),
        1 => Just(1e-17),
        1 => (-40.0..0.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
    ];
    (prop::collection::vec(mass, n), 0.01..1.0_f64).prop_map(|(mut masses, some)| {
        masses[0] += some;
        masses
    })
}

/// Centers on a coarse grid, so that many coincide or lie at equal distances, or anywhere.
fn places(n: usize) -> impl Strategy<Value = Vec<DVec3>> {
    let coarse = (0..3_u8, 0..3_u8, 0..2_u8);
    let coarse = coarse.prop_map(|(x, y, z)| 10.0 * DVec3::new(x.into(), y.into(), z.into()));
    let fine = (0.0..100.0, -60.0..60.0, -60.0..60.0).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    prop_oneof![prop::collection::vec(coarse, n), prop::collection::vec(fine, n)]
}

/// Each ground cost, the capped one with a cap that many pairs exceed.
fn costs() -> impl Strategy<Value = Cost> {
    prop_oneof![Just(Cost::Euclidean), Just(Cost::Squared), Just(Cost::Capped(1.5))]
}

/// A problem whose totals agree but for a relative error, at most `off`.
fn problems(off: f64) -> impl Strategy<Value = Problem> {
    (1..14_usize, 1..14_usize).prop_flat_map(move |(n_s, n_t)| {
        (places(n_s), masses(n_s), places(n_t), masses(n_t), -off..=off, costs()).prop_map(
            |(source, p, target, q, off, cost)| {
                let ratio = p.iter().sum::<f64>() / q.iter().sum::<f64>() * (1.0 + off);
                let q: Vec<f64> = q.iter().map(|mass| mass * ratio).collect();
                Problem::from_centers(&source, &p, &target, &q, cost).expect("legal")
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_problems_obey_the_laws_and_agree_with_good_lp(problem in problems(9e-10)) {
        let plan = exact(&problem);
        let reference = solve(&problem, MICROLP).expect("solvable").certificate;
        let total: f64 = problem.supply().iter().sum();
        // The absolute tolerance of microlp, 1e-10 of the total on up to 26 rows, at the dearest move.
        let allowed = 26.0 * 1e-10 * total * problem.largest_cost();
        prop_assert!((plan.certificate.cost - reference.cost).abs() <= allowed, "{} {}", plan.certificate.cost, reference.cost);
    }

    #[test]
    fn the_order_of_the_clusters_does_not_change_the_cost(problem in problems(0.0), shift in 1..13_usize) {
        let (n_s, n_t) = (problem.supply().len(), problem.demand().len());
        let (from, to) = (|i: usize| (i + shift) % n_s, |j: usize| (n_t - 1 - j + shift) % n_t);
        let p: Vec<f64> = (0..n_s).map(|i| problem.supply()[from(i)]).collect();
        let q: Vec<f64> = (0..n_t).map(|j| problem.demand()[to(j)]).collect();
        let moved = Problem::from_fn(&p, &q, |i, j| problem.cost(from(i), to(j))).expect("legal");
        let (a, b) = (exact(&problem).certificate.cost, exact(&moved).certificate.cost);
        // Both gaps.
        let total: f64 = p.iter().sum();
        prop_assert!((a - b).abs() <= 2e-12 * a.max(1e-3 * problem.mean_cost() * total), "{a} {b}");
    }
}

/// A fixed stream of numbers in [0, 1).
fn stream(seed: u32) -> impl FnMut() -> f64 {
    let mut counter = 0;
    move || {
        counter += 1;
        f64::from(carpaint::math::hash::pcg4d([seed, counter, 0, 0])[0]) / 4_294_967_296.0
    }
}

#[test]
fn degenerate_families_end() {
    for n in [1, 2, 3, 7, 20, 51, 100] {
        let equal = vec![1.0 / n as f64; n];
        let mut next = stream(n as u32);
        // Uniform masses with random costs (assignment), equal costs, costs of a few whole numbers, a grid, a cyclic
        // order, and products of indices, on which pivots are many.
        let random: Vec<f64> = (0..n * n).map(|_| next()).collect();
        let whole: Vec<f64> = (0..n * n).map(|_| (4.0 * next()).floor()).collect();
        let families: [&dyn Fn(usize, usize) -> f64; 6] = [
            &|i, j| random[i * n + j],
            &|_, _| 3.0,
            &|i, j| whole[i * n + j],
            &|i, j| ((i % 10).abs_diff(j % 10) + (i / 10).abs_diff(j / 10)) as f64,
            &|i, j| ((i + n - j) % n) as f64,
            &|i, j| (i * j) as f64,
        ];
        for cost in families {
            let plan = exact(&Problem::from_fn(&equal, &equal, cost).expect("legal"));
            // Vertices of the assignment polytope are permutations (Birkhoff), and the masses are equal to the bit.
            assert_eq!(plan.entries.len(), n);
        }
    }
}

/// What matters costs so little beside the dearest move that costs cut to 48 bits or so, or potentials as f64, cannot prove
/// it; [`exact`] asserts the gap.
#[test]
fn small_costs_beside_large_ones_are_proved() {
    let mut next = stream(13);
    let mut side = |n: usize, center: &dyn Fn([f64; 3]) -> DVec3| -> (Vec<DVec3>, Vec<f64>) {
        (0..n).map(|_| (center([next(), next(), next()]), 1.0 + (32.0 * next()).floor())).unzip()
    };
    // Squared distances on a line, where steps are short.
    let on_a_line = |[x, ..]: [f64; 3]| DVec3::new(100.0 * x, 0.0, 0.0);
    let ((source, p), (target, _)) = (side(1_000, &on_a_line), side(1_000, &on_a_line));
    let q: Vec<f64> = p.iter().rev().copied().collect();
    exact(&Problem::from_centers(&source, &p, &target, &q, Cost::Squared).expect("legal"));
    // A nearby pair far from all others.
    let close = |x: [f64; 3]| 0.01 * DVec3::from_array(x);
    for n in [5, 50, 300] {
        let ((mut source, p), (mut target, _)) = (side(n, &close), side(n, &close));
        (source[0], target[n - 1]) = (DVec3::new(1234.5, 678.9, -901.2), DVec3::new(1234.5, 678.9, -901.1));
        let q: Vec<f64> = p.iter().rev().copied().collect();
        for cost in [Cost::Euclidean, Cost::Squared] {
            exact(&Problem::from_centers(&source, &p, &target, &q, cost).expect("legal"));
        }
    }
}

/// Coincident points are one, wherever in the list they stand.
#[test]
fn coincident_points_share_what_is_moved_in_their_order() {
    let (a, b) = (DVec3::ZERO, DVec3::new(50.0, 0.0, 0.0));
    let (p, q) = ([0.25, 0.125, 0.5, 0.125], [0.125, 0.5, 0.375]);
    let problem = Problem::from_centers(&[a, b, a, b], &p, &[b, a, b], &q, Cost::Euclidean).expect("legal");
    // What leaves the place of 0 and 2 goes first to that of 0 and 2, then to that of 1.
    let expected = [(0, 0, 0.125), (0, 2, 0.125), (1, 2, 0.125), (2, 1, 0.5), (3, 2, 0.125)];
    let plan = exact(&problem);
    assert_eq!(plan.entries, expected);
    assert_eq!(plan.certificate.cost, 12.5);
}

#[test]
fn thousands_of_small_degenerate_problems_end() {
    let mut next = stream(5);
    for _ in 0..4_000 {
        let (n_s, n_t) = (1 + (8.0 * next()) as usize, 1 + (8.0 * next()) as usize);
        // n_t units in each source and n_s in each target: all sums of subsets tie.
        let (p, q) = (vec![n_t as f64; n_s], vec![n_s as f64; n_t]);
        let costs = (0..n_s * n_t).map(|_| (3.0 * next()).floor()).collect();
        exact(&Problem::new(p, q, costs).expect("legal"));
    }
}

#[test]
fn shapes_and_sizes() {
    for (n_s, n_t) in [(1, 1), (1, 77), (77, 1), (2, 150), (150, 3), (13, 29), (101, 97)] {
        let mut next = stream((1_000 * n_s + n_t) as u32);
        let p: Vec<f64> = (0..n_s).map(|_| next()).collect();
        let q: Vec<f64> = (0..n_t).map(|_| next()).collect();
        let ratio = p.iter().sum::<f64>() / q.iter().sum::<f64>();
        let q: Vec<f64> = q.iter().map(|mass| mass * ratio).collect();
        let costs = (0..n_s * n_t).map(|_| 100.0 * next()).collect();
        exact(&Problem::new(p, q, costs).expect("legal"));
    }
}

/// Beside a large mass, masses so small that nothing of them would be left in a difference of f64.
#[test]
fn masses_of_all_magnitudes_keep_their_row_and_column() {
    for n in [5, 50] {
        let mut next = stream(n);
        let masses: Vec<f64> = (0..n).map(|k| next() * 10_f64.powi(-((300 * k / n) as i32))).collect();
        let reversed: Vec<f64> = masses.iter().rev().copied().collect();
        let costs = (0..n * n).map(|_| next()).collect();
        exact(&Problem::new(masses, reversed, costs).expect("legal"));
    }
}

#[test]
fn the_plan_depends_on_the_problem_alone() {
    let mut next = stream(3);
    let n = 60;
    // Coincident centers on a line: the optimum is far from unique.
    let place: Vec<f64> = (0..2 * n).map(|_| (6.0 * next()).floor()).collect();
    let p: Vec<f64> = (0..n).map(|_| 1.0 + (3.0 * next()).floor()).collect();
    let q: Vec<f64> = p.iter().rev().copied().collect();
    let problem = Problem::from_fn(&p, &q, |i, j| (place[i] - place[n + j]).abs()).expect("legal");
    let first = exact(&problem);
    let others: Vec<Plan> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|k| {
                let problem = &problem;
                scope.spawn(move || {
                    // Another problem before it leaves no trace.
                    exact(
                        &Problem::new(vec![1.0; k + 1], vec![1.0; k + 1], vec![1.0; (k + 1) * (k + 1)])
                            .unwrap(),
                    );
                    exact(problem)
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert!(others.iter().all(|plan| *plan == first));
}

#[test]
fn a_distribution_is_coupled_with_itself_by_the_identity() {
    let mut next = stream(8);
    let place: Vec<DVec3> = (0..50).map(|_| 100.0 * DVec3::new(next(), next(), next())).collect();
    let p: Vec<f64> = (0..50).map(|_| next() / 25.0).collect();
    let plan = exact(&Problem::from_centers(&place, &p, &place, &p, Cost::Euclidean).expect("legal"));
    let identity: Vec<(usize, usize, f64)> = p.iter().enumerate().map(|(k, mass)| (k, k, *mass)).collect();
    assert_eq!(plan.entries, identity);
    assert_eq!(plan.certificate.cost, 0.0);
}

/// Centers in general position: the costs alone decide, whatever the order.
#[test]
fn the_plan_moves_with_the_clusters() {
    let mut next = stream(21);
    for n in [3, 16, 51] {
        let mut side = || -> (Vec<DVec3>, Vec<f64>) {
            let center = |next: &mut dyn FnMut() -> f64| 100.0 * DVec3::new(next(), next(), next());
            (0..n).map(|_| (center(&mut next), (1.0 + (8.0 * next()).floor()) / 64.0)).unzip()
        };
        let ((source, p), (target, _)) = (side(), side());
        let q: Vec<f64> = p.iter().rev().copied().collect();
        let moved = |k: usize| (2 * k + 1) % n;
        // n is no multiple of 2, but for 16: there neighbors are exchanged.
        let moved = |k: usize| if n % 2 == 0 { k ^ 1 } else { moved(k) };
        let permuted = |x: &[DVec3]| (0..n).map(|k| x[moved(k)]).collect::<Vec<_>>();
        let permuted_masses = |x: &[f64]| (0..n).map(|k| x[moved(k)]).collect::<Vec<_>>();
        for cost in [Cost::Euclidean, Cost::Squared] {
            let plan = exact(&Problem::from_centers(&source, &p, &target, &q, cost).expect("legal"));
            let other = Problem::from_centers(
                &permuted(&source),
                &permuted_masses(&p),
                &permuted(&target),
                &permuted_masses(&q),
                cost,
            );
            let other = exact(&other.expect("legal"));
            let mut back: Vec<_> =
                other.entries.iter().map(|&(i, j, mass)| (moved(i), moved(j), mass)).collect();
            back.sort_by_key(|entry| (entry.0, entry.1));
            assert_eq!(back, plan.entries, "{n} {cost}");
        }
    }
}

#[test]
fn far_moves_under_a_cap_are_coupled_in_order() {
    let row = |l: f64| -> Vec<DVec3> { (0..4).map(|k| DVec3::new(l, 40.0 * f64::from(k), 0.0)).collect() };
    let (p, q) = ([0.25; 4], [0.125, 0.375, 0.25, 0.25]);
    let plan =
        exact(&Problem::from_centers(&row(0.0), &p, &row(60.0), &q, Cost::Capped(30.0)).expect("legal"));
    let expected = [(0, 0, 0.125), (0, 1, 0.125), (1, 1, 0.25), (2, 2, 0.25), (3, 3, 0.25)];
    assert_eq!(plan.entries, expected);
    assert_eq!(plan.certificate.cost, 30.0);
}

// The binary.

fn run(arguments: &[&str], file: &str) -> (i32, String, String) {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("problem.json");
    std::fs::write(&path, file).expect("writable");
    let output = carpaint().arg("transport").arg(&path).args(arguments).output().expect("runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (output.status.code().expect("ended"), text(output.stdout), text(output.stderr))
}

fn small() -> Value {
    json!({ "name": "small", "source_centres": [[0, 0, 0], [10, 0, 0]], "target_centres": [[0, 3, 4]], "p": [0.5, 0.5], "q": [1] })
}

#[test]
fn the_binary_reads_all_three_forms() {
    for file in [small(), json!([small()]), json!({ "meta": 1, "instances": [small()] })] {
        for (solver, name) in [
            ("network-simplex", "network-simplex"),
            ("good-lp:microlp", "good-lp:microlp"),
            ("good-lp:minilp", "good-lp:microlp"),
        ] {
            let (code, out, err) = run(&["--json", "--solver", solver], &file.to_string());
            assert_eq!(code, 0, "{err}");
            let out: Value = serde_json::from_str(&out).expect("JSON");
            assert_eq!(out["solver"], name);
            let row = &out["instances"][0];
            let cost = 0.5 * 5.0 + 0.5 * 125_f64.sqrt();
            // LP tolerance; 1 x n problems are forced, so it is in fact rounding.
            assert!((row["optimal_cost"].as_f64().expect("number") - cost).abs() < 1e-9);
            assert_eq!((&row["n_s"], &row["n_t"], &row["plan_nonzeros"]), (&json!(2), &json!(1), &json!(2)));
        }
        let (code, out, _) = run(&[], &file.to_string());
        assert_eq!(code, 0);
        assert!(out.lines().nth(1).expect("a row").starts_with("small "), "{out}");
    }
}

#[test]
fn the_binary_solves_the_reference_file() {
    let Some(path) = reference("oracles/06_optimal_transport.json") else { return };
    let output = carpaint().arg("transport").arg(path).arg("--json").output().expect("runs");
    let out: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for (row, expected) in out["instances"].as_array().expect("list").iter().zip(oracle().expect("there")) {
        assert_eq!(row["name"], expected["name"]);
        let (found, expected) =
            (row["optimal_cost"].as_f64().unwrap(), expected["optimal_cost"].as_f64().unwrap());
        assert!((found - expected).abs() <= 1e-9 * expected + 1e-14);
    }
}

#[test]
fn bad_files_are_refused_with_their_fault() {
    let with = |field: &str, value: Value| {
        let mut row = small();
        row[field] = value;
        json!([small(), row]).to_string()
    };
    for (file, message) in [
        ("{".to_owned(), "problem.json: JSON: text: found EOF"),
        ("[1e999]".to_owned(), "problem.json: JSON: text: found number out of range"),
        ("7".to_owned(), "problem.json: JSON: value: found 7, expected one object or a list of objects"),
        ("[]".to_owned(), "problem.json: instances: number: found 0, expected at least 1"),
        (
            "{\"instances\": 3}".to_owned(),
            "problem.json: instances: value: found 3, expected a list of objects",
        ),
        ("[3]".to_owned(), "problem.json: instance 0: source_centres: value: found nothing"),
        (with("name", json!(1)), "problem.json: instance 1: name: value: found 1, expected a text"),
        (
            with("q", json!("x")),
            "instance 1 (small): q: value: found \"x\", expected a list, each item a number",
        ),
        (with("p", json!([0.5, null])), "instance 1 (small): p[1]: value: found null, expected a number"),
        (with("p", json!([0.5, -0.5])), "instance 1 (small): p[1]: mass: found -0.5, expected 0 to 1e150"),
        (with("p", json!([0, 0])), "instance 1 (small): p: total mass: found 0, expected above 0"),
        (
            with("q", json!([1.01])),
            "instance 1 (small): q: total mass: found 1.01, expected the total of p, 1,",
        ),
        (
            with("q", json!([0.5, 0.5])),
            "instance 1 (small): target centers: number: found 1, expected 2, as many",
        ),
        (with("q", json!([])), "instance 1 (small): target centers: number: found 1, expected 0"),
        (
            with("source_centres", json!([[0, 0, 0], [1, 2]])),
            "instance 1 (small): source_centres[1]: value: found [1,2], expected a list of three numbers",
        ),
        (
            with("source_centres", json!([[0, 0, 0], [1, 2, 1e200]])),
            "instance 1 (small): source centers[1]: coordinates: found [1, 2, 1000000",
        ),
    ] {
        let (code, out, err) = run(&["--json"], &file);
        assert_eq!(code, 2, "{err}");
        assert!(out.is_empty());
        assert!(err.contains(message), "expected {message}\nfound {err}");
    }
}

#[test]
fn a_missing_file_a_folder_and_an_unknown_solver_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    for path in [folder.path().to_owned(), folder.path().join("none.json")] {
        let output = carpaint().arg("transport").arg(&path).output().expect("runs");
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains(&path.display().to_string()));
    }
    let (code, _, err) = run(&["--solver", "cbc"], &small().to_string());
    assert_eq!(code, 2);
    assert!(err.contains("cbc") && err.contains("network-simplex, good-lp:microlp,"), "{err}");
    let (code, _, err) = run(&["--cost", "capped:0"], &small().to_string());
    assert_eq!(code, 2);
    assert!(err.contains("euclidean, squared, capped:T"), "{err}");
}

#[test]
fn help_lists_the_solvers_of_this_build() {
    for command in ["transport", "couple"] {
        let output = carpaint().args([command, "--help"]).output().expect("runs");
        let help = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(help.contains(&Solver::names()), "{help}");
    }
}

#[test]
fn the_binary_takes_the_cost() {
    for (cost, expected) in [("squared", 0.5 * 25.0 + 0.5 * 125.0), ("capped:7", 0.5 * 5.0 + 0.5 * 7.0)] {
        let (code, out, err) = run(&["--json", "--cost", cost], &small().to_string());
        assert_eq!(code, 0, "{err}");
        let out: Value = serde_json::from_str(&out).expect("JSON");
        let found = out["instances"][0]["optimal_cost"].as_f64().expect("number");
        // A rounding of each distance.
        assert!((found - expected).abs() < 1e-12, "{cost}: {found}");
    }
}
