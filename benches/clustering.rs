//! Our clusters against k-means and Wu's quantizer at equal n: error and time, in one run; the error against n; 465 slices
//! on two threads; and the samplers.
//!
//! Texels: the fluctuations of energetic slices of the fixtures, 128 x 128. Error: Wasserstein-1 above its sampling floor
//! (Delta-E, mean of slices), the largest |ln| of std and of the 99.9 % quantile of the luminance. Names of fixtures as
//! arguments choose some.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::btf::AngleGrid;
use carpaint::cluster::{BoxRule, SliceStatistics, cluster_levels, cluster_slice};
use carpaint::report::{energetic_slices, sampler_costs, wasserstein};
use carpaint::rivals::{k_means, wu};
use carpaint::sampler::{ReconstructionSamples, Sampler, reconstruction_error};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};
use std::path::Path;
use std::time::Instant;

type Texels = Vec<[f32; 3]>;
/// Side of a slice, texels.
const SIDE: usize = 128;
const SAMPLES: ReconstructionSamples =
    ReconstructionSamples { draws: 200_000, points: 1000, repeats: 2, seed: 1 };
const FIXTURES: [&str; 11] = [
    "blue_metallic",
    "brown_metallic",
    "green_blue_flip_flop",
    "metallic_like_pearl",
    "pearl_200nm",
    "pearl_43nm",
    "pearl_on_black",
    "pearl_on_white",
    "silver_metallic",
    "three_layers",
    "two_flake_layers",
];

/// Three energetic slices of a fixture.
fn slices(name: &str) -> Vec<Texels> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let composition = Composition::read(&file).expect("a legal composition");
    let model = Model::new(&composition, ModelOptions::default()).expect("a model");
    let grid = AngleGrid::triangle(12).expect("a grid");
    let options = SynthesisOptions { size: [SIDE; 2], texel_mm: None, ..SynthesisOptions::new(grid) };
    let btf = synthesize(&model, &options, &|| ()).expect("slices");
    let energetic = energetic_slices(&btf);
    let thinned = energetic.iter().step_by(energetic.len().div_ceil(3));
    thinned.map(|k| btf.slices[*k].fluctuation.clone()).collect()
}

/// Excess, |ln std|, |ln q99.9|, milliseconds a slice.
fn measure(slices: &[Texels], method: impl Fn(&[[f32; 3]]) -> SliceStatistics) -> [f64; 4] {
    let (mut out, n) = ([0.0f64; 4], slices.len() as f64);
    for texels in slices {
        let start = Instant::now();
        let statistics = method(texels);
        out[3] += 1e3 * start.elapsed().as_secs_f64() / n;
        let sampler = Sampler::exact(&statistics).expect("a sampler");
        let error =
            reconstruction_error(texels, &statistics, &sampler, SAMPLES, wasserstein).expect("an error");
        out[0] += error.excess() / n;
        out[1] = out[1].max(error.std_ratio().ln().abs());
        out[2] = out[2].max(error.quantile_ratio().ln().abs());
    }
    out
}

fn ours(texels: &[[f32; 3]], n: usize) -> SliceStatistics {
    cluster_slice(texels, n, BoxRule::MomentMatched).expect("statistics")
}

fn rivals(fixtures: &[(String, Vec<Texels>)]) {
    println!("{:<22} excess, |ln std|, |ln q99.9|, ms a slice at n = 50", "");
    println!("{:<22} {:^27} {:^27} {:^27} {:^27}", "", "ours", "bounding boxes", "k-means", "Wu");
    let mut sums = [[0.0; 4]; 4];
    let print = |name: &str, rows: &[[f64; 4]; 4]| {
        let cells = rows.map(|[e, s, q, t]| format!("{e:6.2} {s:6.4} {q:6.4} {t:6.1}"));
        println!("{name:<22} {}", cells.join(" "));
    };
    for (name, slices) in fixtures {
        let rows = [
            measure(slices, |texels| ours(texels, 50)),
            measure(slices, |texels| cluster_slice(texels, 50, BoxRule::Bounding).expect("statistics")),
            measure(slices, |texels| k_means(texels, 50).expect("statistics")),
            measure(slices, |texels| wu(texels, 50).expect("statistics")),
        ];
        print(name, &rows);
        for (sum, row) in sums.as_flattened_mut().iter_mut().zip(rows.as_flattened()) {
            *sum += row / fixtures.len() as f64;
        }
    }
    print("mean", &sums);
}

fn sweep(fixtures: &[(String, Vec<Texels>)]) {
    const NUMBERS: [usize; 7] = [16, 32, 50, 100, 200, 400, 1024];
    println!("\nexcess at n =          {}", NUMBERS.map(|n| format!("{n:>7}")).concat());
    for (name, slices) in fixtures {
        let row = NUMBERS.map(|n| format!("{:7.2}", measure(slices, |texels| ours(texels, n))[0]));
        println!("{name:<22} {}", row.concat());
    }
}

fn speed(fixtures: &[(String, Vec<Texels>)]) {
    let all: Vec<&Texels> = fixtures.iter().flat_map(|(_, slices)| slices).collect();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let run = || {
            let start = Instant::now();
            let slice = |k: usize| Ok(all[k % all.len()].clone());
            let levels =
                pool.install(|| cluster_levels(465, slice, [SIDE; 2], 50, BoxRule::MomentMatched, &|| ()));
            assert_eq!(levels.expect("statistics").len(), 8);
            start.elapsed().as_secs_f64()
        };
        let best = (0..3).map(|_| run()).fold(f64::INFINITY, f64::min);
        println!("\n465 slices, all levels, n = 50, {threads} threads: {best:.3} s, best of three");
    }
}

fn samplers(texels: &[[f32; 3]]) {
    let statistics = ours(texels, 50);
    let costs = sampler_costs(texels, &statistics, &[500, 2000], SAMPLES).expect("samplers");
    println!(
        "\n{:<24} {:>6} {:>7} {:>7} {:>9} {:>5} {:>7} {:>7} {:>7}",
        "sampler", "ns", "bytes", "+boxes", "TV", "lost", "excess", "std", "q99.9"
    );
    for c in costs {
        let variation = c.total_variation.map_or("-".to_owned(), |v| format!("{v:.1e}"));
        let lost = c.lost.map_or("-".to_owned(), |n| n.to_string());
        println!(
            "{:<24} {:>6.1} {:>7} {:>7} {variation:>9} {lost:>5} {:>7.2} {:>7.3} {:>7.3}",
            c.sampler,
            c.nanoseconds,
            c.bytes,
            c.box_bytes,
            c.error.excess(),
            c.error.std_ratio(),
            c.error.quantile_ratio()
        );
    }
}

fn main() {
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let names = if named.is_empty() { FIXTURES.map(str::to_owned).to_vec() } else { named };
    let fixtures: Vec<(String, Vec<Texels>)> =
        names.into_iter().map(|name| (name.clone(), slices(&name))).collect();
    speed(&fixtures);
    rivals(&fixtures);
    sweep(&fixtures);
    samplers(&fixtures[0].1[0]);
}
