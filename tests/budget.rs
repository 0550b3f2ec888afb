//! `--error` and `--time` of simulate, fit, couple and render: what is picked keeps the budget, and is said.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::Paint;
use carpaint::color::delta_e_2000;
use folder::Folder;
use glam::DVec3;

/// One film of flakes without pigments, so that all models know it.
const SILVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/silver_metallic.toml");
const AT: [&str; 3] = ["--at", "45:15,25,45,75,110;15:15", "--json"];

/// The settings that were picked, in the words of the program.
fn picked(said: &str) -> Vec<&str> {
    said.lines().filter_map(|line| line.strip_prefix("picked: ")).collect()
}

/// The number after a word.
fn after(text: &str, word: &str) -> f64 {
    let rest = text.split(word).nth(1).unwrap_or_else(|| panic!("no {word} in {text}"));
    let rest = rest.trim_start().trim_start_matches("below ");
    rest.split([' ', ':'])
        .next()
        .unwrap()
        .parse()
        .unwrap_or_else(|_| panic!("no number after {word}: {text}"))
}

/// L*a*b* of the readings, and what was said on standard error.
fn readings(f: &Folder, options: &[&str]) -> (Vec<DVec3>, String) {
    let [said, notes] = f.succeed_with_warnings(&[&[SILVER], &AT[..], options].concat());
    let summary: serde_json::Value = serde_json::from_str(&said).unwrap();
    let lab =
        |reading: &serde_json::Value| DVec3::from([0, 1, 2].map(|k| reading["lab"][k].as_f64().unwrap()));
    (summary["at"]["readings"].as_array().unwrap().iter().map(lab).collect(), notes)
}

#[test]
fn a_simulation_keeps_its_error_against_the_finest_solution() {
    let f = Folder::new(&["simulate"]);
    let (truth, _) = readings(&f, &["--model", "full", "--tolerance", "1e-5"]);
    let mut settings = Vec::new();
    for error in [10.0, 0.5, 0.01] {
        let (found, said) = readings(&f, &["--error", &error.to_string()]);
        let off = found.iter().zip(&truth).map(|(a, b)| delta_e_2000(*a, *b)).fold(0.0, f64::max);
        assert!(off <= error, "{off} is above {error}: {said}");
        let [line] = picked(&said)[..] else { panic!("{said}") };
        assert!(after(line, ": error") <= error, "{line}");
        settings.push(line.split(": error").next().unwrap().to_owned());
    }
    // Ten is what the fast model is good for, a hundredth is not.
    assert!(settings[0].ends_with("--model fast") && settings[2].contains("full"), "{settings:?}");
}

#[test]
fn a_simulation_takes_the_best_that_time_allows() {
    let f = Folder::new(&["simulate"]);
    let (_, said) = readings(&f, &["--time", "1h"]);
    assert!(picked(&said)[0].contains("--tolerance 0.0001"), "{said}");
    let (_, said) = readings(&f, &["--time", "1ns"]);
    assert!(picked(&said)[0].contains("--model fast:") && said.contains("no setting"), "{said}");
}

/// Two flake BTFs of a few slices.
fn btfs(f: &Folder) {
    for (name, seed) in [("a.btf.exr", "1"), ("b.btf.exr", "2")] {
        f.succeed(&[
            "simulate",
            SILVER,
            "-o",
            name,
            "--bins",
            "4",
            "--size",
            "64",
            "--texel-um",
            "15",
            "--seed",
            seed,
        ]);
    }
}

fn clusters(paint: &Paint) -> usize {
    let slices = &paint.flakes.as_ref().unwrap().levels[0].slices;
    slices.iter().map(|slice| slice.clusters.len()).max().unwrap()
}

#[test]
fn fits_and_couplings_take_as_many_clusters_as_the_error_asks_for() {
    let f = Folder::new(&[]);
    btfs(&f);
    let fitted = |error: &str| {
        let [_, said] = f.succeed_with_warnings(&["fit", "a.btf.exr", "-o", "a.paint.exr", "--error", error]);
        let lines = picked(&said);
        let [starts, statistics] = lines[..] else { panic!("{said}") };
        assert!(starts.contains("--starts"), "{said}");
        (clusters(&Paint::read(&f.path("a.paint.exr")).unwrap()), after(statistics, "--clusters"))
    };
    let (rough, fine) = (fitted("2"), fitted("0.01"));
    assert!(rough.0 as f64 <= rough.1 && fine.0 as f64 <= fine.1, "{rough:?} {fine:?}");
    assert!(rough.0 < fine.0, "{rough:?} {fine:?}");
    let [_, said] =
        f.succeed_with_warnings(&["couple", "a.btf.exr", "b.btf.exr", "-o", "m.paint.exr", "--error", "2"]);
    let lines = picked(&said);
    assert!(lines[0].contains("network-simplex"), "{said}");
    assert_eq!(lines.iter().filter(|line| line.starts_with("statistics --clusters")).count(), 2, "{said}");
}

#[test]
fn pictures_take_as_many_rays_as_the_error_asks_for() {
    let f = Folder::new(&[]);
    btfs(&f);
    f.succeed(&["fit", "a.btf.exr", "-o", "a.paint.exr", "--starts", "1"]);
    let rays = |budget: [&str; 2]| {
        let arguments = [
            "render",
            "a.paint.exr",
            "-o",
            "a.png",
            "--size",
            "40x50",
            "--device",
            "cpu",
            budget[0],
            budget[1],
        ];
        let [_, said] = f.succeed_with_warnings(&arguments);
        let samples = after(picked(&said)[0], "--samples");
        assert!(said.contains(&format!("{samples} rays each")), "{said}");
        samples
    };
    assert!(rays(["--error", "2"]) < rays(["--error", "0.2"]));
    assert_eq!(rays(["--time", "1us"]), 1.0);
}

#[test]
fn budgets_that_are_none_are_refused() {
    let f = Folder::new(&[]);
    let simulate = |rest: &[&'static str]| [&["simulate", SILVER, "--at", "45:15"], rest].concat();
    f.fail(&simulate(&["--error", "0"]), &["--error", "above 0"]);
    f.fail(&simulate(&["--error", "-1"]), &["--error", "-1", "above 0"]);
    f.fail(&simulate(&["--error", "inf"]), &["--error", "inf"]);
    f.fail(&simulate(&["--time", "0s"]), &["--time", "above 0"]);
    f.fail(&simulate(&["--time", "soon"]), &["--time", "soon"]);
    f.fail(&simulate(&["--time", "1s", "--error", "1"]), &["--time", "--error"]);
    f.fail(&simulate(&["--error", "1", "--model", "full"]), &["--error", "--model"]);
    f.fail(&["fit", "x.mbsdf", "-o", "x.paint.exr", "--error", "1", "--clusters", "5"], &["--clusters"]);
    f.fail(&["fit", "x.csv", "-o", "x.ink.json", "--error", "1"], &["--error or --time", "an ink"]);
    f.fail(
        &["couple", "a.exr", "b.exr", "-o", "m.exr", "--time", "1s", "--solver", "network-simplex"],
        &["--solver"],
    );
    f.fail(&["render", "a.exr", "-o", "a.png", "--time", "1s", "--samples", "4"], &["--samples"]);
}
