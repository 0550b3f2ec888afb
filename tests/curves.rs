//! `validate --curves`: errors against clusters, steps, levels and solvers, as a table and a drawing.

#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use common::carpaint;
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// `validate` of a fixture with three slices of 64 x 64 texels, in a folder of its own.
fn validate(folder: &Path, name: &str, extra: &[&str]) -> Output {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let small = ["--bins", "2", "--size", "64"];
    carpaint().current_dir(folder).arg("validate").arg(file).args(small).args(extra).output().unwrap()
}

fn column(table: &Value, name: &str) -> Vec<f64> {
    table.as_array().unwrap().iter().map(|row| row[name].as_f64().unwrap()).collect()
}

#[test]
fn errors_fall_with_what_is_spent() {
    let folder = tempfile::tempdir().unwrap();
    let out = validate(folder.path(), "blue_metallic", &["--curves", "--json", "--svg", "curves.svg"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let curves: Value = serde_json::from_slice(&out.stdout).unwrap();
    clusters(&curves["clusters"]);
    steps(&curves["steps"]);
    assert_eq!(column(&curves["levels"], "level"), [0.0, 1.0, 2.0, 3.0]);
    solvers(&curves["solvers"]);
    drawing(&std::fs::read_to_string(folder.path().join("curves.svg")).unwrap());
}

fn clusters(table: &Value) {
    assert_eq!(column(table, "clusters"), [16.0, 25.0, 50.0, 100.0, 200.0, 400.0, 1024.0]);
    assert!(column(table, "bytes").is_sorted_by(|a, b| a < b));
    // Three standard errors, each known to a quarter: from four repeats of three slices.
    let (distance, noise) = (column(table, "wasserstein"), column(table, "wasserstein_noise"));
    let chance = |j: usize, k: usize| 3.0 * noise[j].hypot(noise[k]);
    assert!(distance[0] > distance[6] + 0.5, "{distance:?}");
    assert!((1..7).all(|k| distance[k] < distance[k - 1] + chance(k - 1, k)), "{distance:?} {noise:?}");
    // Draws hold every cluster's share exactly, and a million leave a ten-thousandth in its box. A box less may by luck be the
    // better one: six seeds show 0.0015 more at most.
    let deviation = column(table, "deviation");
    assert!(deviation.is_sorted_by(|a, b| *b < a + 0.003) && deviation[6] < 5e-4, "{deviation:?}");
    // Of 4,096 texels four are brighter than the quantile: it jumps within the box of the fifth. At n = 1024 that box is a texel.
    let quantile = column(table, "quantile");
    assert!(quantile.is_sorted_by(|a, b| *b < a + 0.02) && quantile[6] < 1e-3, "{quantile:?}");
}

fn steps(table: &Value) {
    assert_eq!(table[6]["steps"], Value::Null);
    // From row to row the rounding of shares to steps may fall well by luck. A single texel, 1/4,096, gets half of one of 2,000
    // steps, all but nothing of 125: six seeds show the three coarse ones to be 20 times worse and more.
    let deviation = column(table, "deviation");
    let [coarse, fine] = [&deviation[..3], &deviation[4..]].map(|part| part.iter().sum::<f64>());
    assert!(coarse > 5.0 * fine, "{deviation:?}");
}

fn solvers(table: &Value) {
    let error = |name: &str| {
        let row = table.as_array().unwrap().iter().find(|row| row["solver"] == name);
        row.unwrap_or_else(|| panic!("no {name}"))["cost_error"].as_f64().unwrap()
    };
    // What each promises: duality closed to rounding, and the tolerance of the linear program.
    assert!(error("network-simplex") <= 1e-12);
    assert!(error("good-lp:microlp") <= 1e-7);
    // Entropy of a tenth of the mean cost blurs moves over about that much; a tenth of it, less.
    let entropic = [0.1, 0.01].map(|share| error(&format!("Sinkhorn, {share} mean cost")));
    assert!(entropic[0] > entropic[1] && entropic[1] > 1e-7, "{entropic:?}");
}

/// Well-formed, three curves in each of three panels, all inside of the picture.
fn drawing(text: &str) {
    let document = roxmltree::Document::parse(text).unwrap();
    let root = document.root_element();
    let [width, height]: [f64; 2] =
        ["width", "height"].map(|side| root.attribute(side).unwrap().parse().unwrap());
    let lines: Vec<_> = document.descendants().filter(|node| node.has_tag_name("polyline")).collect();
    let counts: Vec<usize> = lines
        .iter()
        .map(|line| {
            let points = line.attribute("points").unwrap().split(' ');
            let inside = |point: &str| {
                let (x, y) = point.split_once(',').unwrap();
                (0.0..width).contains(&x.parse().unwrap()) && (0.0..height).contains(&y.parse().unwrap())
            };
            points.inspect(|point| assert!(inside(point), "{point}")).count()
        })
        .collect();
    assert_eq!(counts, [7, 7, 7, 7, 7, 7, 4, 4, 4]);
    let words: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
    for word in ["blue metallic", "1024", "exact"] {
        assert!(words.contains(&word), "{word}");
    }
}

#[test]
fn bad_flags_are_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, word) in [
        (&["--svg", "a.svg"][..], "--curves"),
        (&["--curves", "--coherence"], "cannot be used with"),
        (&["--curves", "--reconstruction"], "cannot be used with"),
        (&["--curves", "--svg", "a.png"], "one that ends in .svg"),
        (&["--curves", "--svg", "missing/a.svg"], "missing"),
    ] {
        let out = validate(folder.path(), "blue_metallic", flags);
        let error = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{flags:?}: {error}");
        assert!(error.contains(word), "{flags:?}: {error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
