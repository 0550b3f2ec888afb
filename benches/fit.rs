//! The fit of the lobes: optimizer x starts x lobes, time, error (eq. 7 of Rump et al. 2008), and how often the best optimum is
//! found, over seeds of the starts.
//!
//! Data: 20,000 samples of the paints of that paper's Table 1 with 5 % noise and, where CARPAINT_REFERENCE names the folder of the
//! measured tables, of those. The rival of the errors is SciPy's best of 200 random starts on the same samples
//! (fixtures/fit/rival.json); of the times, in the same run, basin's trust-region reflective method with as many starts. Times
//! are of the whole fit, color table, uncertainty and report included.
//!
//! Arguments: parts of names of data, to measure those alone. `--csv FOLDER` writes the samples as the rival reads them, and
//! measures nothing.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/paints.rs"]
mod paints;

use carpaint::brdf::{ClearCoat, LobeGeometry, SampleSet, read_measured};
use carpaint::fit::{FitOptions, Optimizer, fit_samples};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

const SAMPLES: usize = 20_000;
/// Seeds of the starts: of basin's method, which takes ten times as long, one.
fn seeds(optimizer: Optimizer) -> u32 {
    if optimizer == Optimizer::TrustRegionReflective { 1 } else { 6 }
}

/// Every so-manyth cell of a measured table that an instrument has seen and the gloss has not reached.
fn measured(path: &Path) -> SampleSet {
    let table = read_measured(path).expect("a table");
    let all = SampleSet::from(&table);
    let seen = |k: &usize| {
        let s = &all.samples()[*k];
        let theta_h = LobeGeometry::of(s.wi, s.wo).tan2_h.sqrt().atan().to_degrees();
        let steepest = |degrees: f64| degrees.to_radians().cos();
        theta_h > 8.0
            && s.wi.z > steepest(65.0)
            && s.wo.z > steepest(78.0)
            && all.values(*k).iter().sum::<f64>() > 0.0
    };
    let kept: Vec<usize> = (0..all.len()).filter(seen).collect();
    let mut set = SampleSet::new(all.bands().clone()).expect("bands");
    for n in 0..SAMPLES.min(kept.len()) {
        let k = kept[n * kept.len() / SAMPLES.min(kept.len())];
        set.push(all.samples()[k].clone(), all.values(k)).expect("above the horizon");
    }
    set
}

fn data() -> Vec<(String, SampleSet)> {
    let mut all: Vec<(String, SampleSet)> = paints::table1()
        .iter()
        .map(|paint| (paint.name.to_owned(), paint.base_samples(SAMPLES, 0.05, 1)))
        .collect();
    if let Some(root) = std::env::var_os("CARPAINT_REFERENCE") {
        for name in ["carpaint_blue", "carpaint_green"] {
            let path = Path::new(&root).join("data/mbsdf").join(format!("{name}.mbsdf"));
            all.push((name.to_owned(), measured(&path)));
        }
    }
    all
}

/// Nothing of the samples is gloss.
fn options(optimizer: Optimizer, starts: usize, lobes: usize, seed: u32) -> FitOptions {
    let coat = Some(ClearCoat { mirror: 1.0, ..ClearCoat::NONE });
    FitOptions { optimizer, starts, lobes, seed, coat, ..FitOptions::default() }
}

/// The rival's best errors by data and number of lobes.
fn rival() -> BTreeMap<String, BTreeMap<String, f64>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/fit/rival.json");
    let text = std::fs::read_to_string(path).expect("the rival's errors");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    serde_json::from_value(json["errors"].clone()).expect("errors by data and lobes")
}

/// Seconds and errors over seeds.
fn runs(set: &SampleSet, optimizer: Optimizer, starts: usize, lobes: usize) -> (f64, Vec<f64>) {
    let start = Instant::now();
    let errors: Vec<f64> = (1..=seeds(optimizer))
        .map(|seed| {
            fit_samples(set, None, &options(optimizer, starts, lobes, seed), &|| ()).expect("fits").1.error
        })
        .collect();
    (start.elapsed().as_secs_f64() / f64::from(seeds(optimizer)), errors)
}

fn compare(name: &str, set: &SampleSet, lobes: usize, starts: &[usize], rival: Option<f64>) {
    let mut rows = Vec::new();
    for starts in starts {
        let timed = Optimizer::ALL.map(|optimizer| (optimizer, runs(set, optimizer, *starts, lobes)));
        let reference = timed
            .iter()
            .find(|(o, _)| *o == Optimizer::TrustRegionReflective)
            .map_or(f64::NAN, |(_, (s, _))| *s);
        rows.extend(
            timed.map(|(optimizer, (seconds, errors))| (*starts, optimizer, seconds, reference, errors)),
        );
    }
    let best = rows.iter().flat_map(|row| &row.4).copied().chain(rival).fold(f64::INFINITY, f64::min);
    for (starts, optimizer, seconds, reference, mut errors) in rows {
        // Within a thousandth: optima that differ differ by more.
        let found = errors.iter().filter(|e| **e <= best * 1.001).count();
        errors.sort_by(f64::total_cmp);
        let of = errors.len();
        let optimizer = serde_json::to_value(optimizer).expect("a name");
        let against = rival.map_or("-".to_owned(), |rival| format!("{:+.1e}", errors[0] / rival - 1.0));
        println!(
            "{name:<21} {lobes:>5} {starts:>6} {:<25} {:>7.0} ms {:>7.2} {:>10.6} {:>10.6} {:>9} {found:>6}/{of}",
            optimizer.as_str().expect("a text"),
            1e3 * seconds,
            seconds / reference,
            errors[0],
            errors[errors.len() / 2],
            against
        );
    }
}

fn export(folder: &Path) {
    for (name, set) in data() {
        let mut text = String::from("tan2_h,cos_h,cos_i,cos_o,cos_d,intensity\n");
        for (k, s) in set.samples().iter().enumerate() {
            let g = LobeGeometry::of(s.wi, s.wo);
            let intensity = set.values(k).iter().sum::<f64>() / 3.0;
            let _ =
                writeln!(text, "{},{},{},{},{},{intensity}", g.tan2_h, g.cos_h, g.cos_i, g.cos_o, g.cos_d);
        }
        std::fs::write(folder.join(format!("{}.csv", name.replace(' ', "_"))), text).expect("written");
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|a| a == "--csv") {
        return export(Path::new(arguments.get(at + 1).expect("--csv FOLDER")));
    }
    println!(
        "{:<21} {:>5} {:>6} {:<25} {:>10} {:>7} {:>10} {:>10} {:>9} {:>9}",
        "samples",
        "lobes",
        "starts",
        "optimizer",
        "time",
        "/ basin",
        "best E",
        "median E",
        "to SciPy",
        "found"
    );
    let rival = rival();
    let wanted: Vec<&String> = arguments[1..].iter().filter(|a| !a.starts_with('-')).collect();
    for (name, set) in data() {
        if !wanted.is_empty() && !wanted.iter().any(|part| name.contains(part.as_str())) {
            continue;
        }
        for lobes in 1..=3 {
            let starts: &[usize] = if lobes == 3 { &[1, 4, 8, 16] } else { &[8] };
            let known = rival.get(&name).and_then(|by_lobes| by_lobes.get(&lobes.to_string()));
            compare(&name, &set, lobes, starts, known.copied());
        }
    }
}
