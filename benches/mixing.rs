//! A blend of two paints, 465 slices of 50 clusters: raw corners, every path with its corrections, level 0 and all levels;
//! beside it the time to copy the boxes of one paint; and coupling of two to eight paints. The error beside a blend's time is
//! that of the slices' means over |mean| + std, beside a coupling's the largest relative gap.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{Cluster, SliceStatistics, deviation_of_draws};
use carpaint::mix::{BlendOptions, CoupleOptions, CoupleReport, Mix, Path, add, couple};
use carpaint::paint::{FlakeLevel, Flakes, MissingSlice};
use carpaint::transport::Solver;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use std::time::Instant;

/// Like those of a flake slice: many dark clusters about zero, a few bright and rare ones, narrow boxes.
fn slice(rng: &mut Pcg64, n: usize) -> SliceStatistics {
    let weights: Vec<f64> =
        (0..n).map(|k| (-5.0 * k as f64 / n as f64).exp() * rng.random_range(0.5..1.5)).collect();
    let total: f64 = weights.iter().sum();
    let clusters = (0..n)
        .map(|k| {
            let lightness = -25.0 + 150.0 * k as f32 / n as f32;
            let center = [lightness, 8.0 * rng.random::<f32>(), 8.0 * rng.random::<f32>()];
            let half: [f32; 3] = std::array::from_fn(|_| 2.0 * rng.random::<f32>());
            Cluster {
                probability: weights[k] / total,
                min: std::array::from_fn(|c| center[c] - half[c]),
                max: std::array::from_fn(|c| center[c] + half[c]),
            }
        })
        .collect();
    SliceStatistics::new(clusters, [0.0; 3])
}

fn paint(seed: u64, levels: usize) -> Paint {
    let mut rng = Pcg64::seed_from_u64(seed);
    let grid = AngleGrid::triangle(30).expect("legal");
    let mut level = |n: usize, k: usize| FlakeLevel {
        pitch_mm: 0.02 * f64::from(1u32 << k),
        slices: (0..grid.len()).map(|_| slice(&mut rng, n)).collect(),
    };
    let mut all: Vec<FlakeLevel> = (0..levels - 1).map(|k| level(50, k)).collect();
    all.push(level(1, levels - 1));
    let side = 1 << (levels - 1);
    Paint {
        coat: ClearCoat::NONE,
        diffuse: 0.2,
        lobes: Vec::new(),
        colors: ColorTable::white(),
        flakes: Some(Flakes {
            grid,
            missing: MissingSlice::Zero,
            size: [side; 2],
            texel_mm: 0.015,
            levels: all,
            inverse_cdf_steps: 500,
            knots: None,
        }),
        provenance: serde_json::Value::Null,
    }
}

/// Shortest of many times, milliseconds.
fn best<T>(work: impl FnMut() -> T) -> f64 {
    best_of(30, work)
}

fn best_of<T>(runs: usize, mut work: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        std::hint::black_box(work());
        1e3 * start.elapsed().as_secs_f64()
    };
    (0..runs).map(time).fold(f64::INFINITY, f64::min)
}

/// Time to couple two, three and eight paints of all levels, and to add one to a mix, milliseconds.
fn couplings() {
    let paints: Vec<_> = (0..8).map(|k| (format!("paint {k}"), paint(k, 8))).collect();
    let named: Vec<_> = paints.iter().map(|(name, p)| (name.clone(), p)).collect();
    let coupled = |n: usize| couple(&named[..n], &CoupleOptions::default(), &|| ()).expect("legal");
    let row = |what: &str, couple: &dyn Fn() -> (Mix, CoupleReport)| {
        let report = couple().1;
        let (time, gap) = (best_of(5, couple), report.worst_relative_gap);
        println!("  {what:<24} {time:8.1} ms, {} arcs, gap {gap:.1e}", report.arcs);
    };
    println!("coupling 465 slices, 7 levels of 50 clusters and one of 1");
    for n in [2, 3, 8] {
        row(&format!("{n} paints"), &|| coupled(n));
    }
    let two = coupled(2).0;
    row("a third paint added", &|| add(&two, &named[2..3], Solver::default(), &|| ()).expect("legal"));
}

/// Largest distance of a slice's mean from the blend of the ends' means, over |mean| + std.
fn error(mix: &Mix, blend: &Paint, weights: [f64; 2]) -> f64 {
    let slices = mix.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices);
    let blends = blend.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices);
    let errors = slices.zip(blends).map(|(ends, s)| {
        let wanted: DVec3 = weights.iter().zip(&ends.means).map(|(w, m)| *w * *m).sum();
        let scale = wanted.length() + deviation_of_draws(&s.clusters, &s.fades).length();
        (s.mean_rgb() - wanted).length() / scale.max(1e-3)
    });
    errors.fold(0.0, f64::max)
}

fn main() {
    let weights = [0.37, 0.63];
    println!("{} threads", rayon::current_num_threads());
    for levels in [2, 8] {
        let paints = [paint(1, levels), paint(2, levels)];
        let named: Vec<_> = paints.iter().map(|p| ("paint".to_owned(), p)).collect();
        let (mix, report) = couple(&named, &CoupleOptions::default(), &|| ()).expect("legal");
        println!("{} levels of 50 clusters: {} arcs", levels - 1, report.arcs);
        let slices: Vec<_> = mix.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices).collect();
        let narrow = weights.map(|w| w as f32);
        let corners = best(|| {
            slices.par_iter().for_each_init(Vec::new, |buffer, s| {
                s.corners(&narrow, buffer);
                std::hint::black_box(&buffer);
            });
        });
        let copies = best(|| {
            slices.par_iter().for_each_init(Vec::new, |buffer, s| {
                buffer.clear();
                buffer.extend_from_slice(&s.boxes[0]);
                std::hint::black_box(&buffer);
            });
        });
        println!("  raw corners  {corners:8.3} ms  ({:.1} times a copy)", corners / copies);
        for path in Path::ALL {
            let options = BlendOptions { path: Some(path), ..BlendOptions::default() };
            let blend = mix.blend_with(&weights, &options).expect("legal");
            let time = best(|| mix.blend_with(&weights, &options));
            println!("  {path:<11}  {time:8.3} ms  mean off by {:.1e}", error(&mix, &blend, weights));
        }
    }
    couplings();
}
