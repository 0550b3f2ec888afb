//! The whole chain on the fixtures: every composition passes `validate`, and the demo's paints couple alike with good_lp.

#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::report::{ChainOptions, run_chain};
use carpaint::simulate::Composition;
use carpaint::transport::{Cost, LinearProgram, Problem, Solver, solve};
use common::carpaint;
use rayon::prelude::*;

fn composition(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"))
}

/// `validate` of a fixture; small slices keep the suite fast, and leave every bar in force.
fn validate(name: &str, extra: &[&str]) -> std::process::Output {
    let file = composition(name);
    carpaint().arg("validate").arg(file).args(["--bins", "9", "--size", "96"]).args(extra).output().unwrap()
}

#[test]
fn every_fixture_passes_validation() {
    for name in ["blue_metallic", "brown_metallic", "silver_metallic", "green_blue_flip_flop"] {
        let out = validate(name, &[]);
        let text = String::from_utf8_lossy(&out.stdout);
        assert!(out.status.success(), "{name}\n{text}\n{}", String::from_utf8_lossy(&out.stderr));
        for stage in ["simulate", "fit", "statistics", "transport", "blend", "picture"] {
            assert!(text.contains(stage), "{name}: no stage {stage}\n{text}");
        }
    }
}

#[test]
fn a_broken_bar_is_exit_code_1() {
    // Half way between a paint and itself at a thirtieth of the flakes: two lobes cannot move into one, and the bar breaks.
    let out = validate("silver_metallic", &["--density", "0.03"]);
    assert_eq!(out.status.code(), Some(1), "{}", String::from_utf8_lossy(&out.stdout));
    assert!(String::from_utf8_lossy(&out.stdout).contains("FAIL"));
    assert_eq!(validate("silver_metallic", &["--density", "-1"]).status.code(), Some(2));
}

/// The demo's own paints (same grid, texel and slice size), every slice of the finest level.
#[test]
fn good_lp_couples_the_demo_at_the_same_cost() {
    let options = ChainOptions { bins: 24, size: 128, texel_mm: Some(0.012), seed: 1 };
    let [a, b] = ["brown_metallic", "blue_metallic"].map(|name| {
        let composition = Composition::read(&composition(name)).unwrap();
        let paint = run_chain(name, &composition, &options, |_, _| || ()).unwrap().paint;
        paint.flakes.unwrap().levels.swap_remove(0).slices
    });
    assert_eq!(a.len(), 300);
    let worst = a.par_iter().zip(&b).map(|(a, b)| {
        let centers = |s: &carpaint::cluster::SliceStatistics| -> (Vec<_>, Vec<_>) {
            s.clusters.iter().map(|c| (c.center(), c.probability)).unzip()
        };
        let ((ca, pa), (cb, pb)) = (centers(a), centers(b));
        let problem = Problem::from_centers(&ca, &pa, &cb, &pb, Cost::Euclidean).unwrap();
        let exact = solve(&problem, Solver::NetworkSimplex).unwrap();
        let reference = solve(&problem, Solver::GoodLp(LinearProgram::MicroLp)).unwrap();
        let scale = exact.certificate.cost.max(1e-3 * problem.mean_cost());
        assert!(exact.certificate.gap <= 1e-12 * scale);
        assert!(exact.entries.len() < pa.len() + pb.len());
        // The LP's feasibility tolerance of 1e-9 costs up to 1e-7.
        let difference = (exact.certificate.cost - reference.certificate.cost).abs() / scale;
        assert!(difference <= 1e-7, "{difference}");
        difference
    });
    println!(
        "largest relative difference of cost to good_lp over 300 slices: {:.1e}",
        worst.reduce(|| 0.0, f64::max)
    );
}
