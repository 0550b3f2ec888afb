//! Paints for tests of mixing, and how they are compared.
#![allow(dead_code)]

use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{Cluster, SliceStatistics};
use carpaint::mix::{CoupleOptions, Mix, Path, couple};
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice};
use carpaint::sampler::{Sampler, color};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

/// Statistics like those of a flake slice: many dark clusters, a few bright and rare ones.
pub fn slice(rng: &mut Pcg64, n: usize) -> SliceStatistics {
    let weights: Vec<f64> = (0..n).map(|_| (-6.0 * rng.random::<f64>()).exp()).collect();
    let total: f64 = weights.iter().sum();
    let clusters = weights
        .iter()
        .map(|w| {
            let center = [
                150.0 * rng.random::<f32>() - 30.0,
                60.0 * rng.random::<f32>() - 30.0,
                60.0 * rng.random::<f32>() - 40.0,
            ];
            let half: [f32; 3] = std::array::from_fn(|_| 4.0 * rng.random::<f32>());
            Cluster {
                probability: w / total,
                min: std::array::from_fn(|c| center[c] - half[c]),
                max: std::array::from_fn(|c| center[c] + half[c]),
            }
        })
        .collect();
    SliceStatistics::new(clusters, std::array::from_fn(|_| 0.01 * rng.random::<f32>()))
}

pub fn paint(seed: u64, n: usize) -> Paint {
    let mut rng = Pcg64::seed_from_u64(seed);
    let grid = AngleGrid::triangle(3).unwrap();
    let level = |rng: &mut Pcg64, n: usize, pitch_mm: f64| FlakeLevel {
        pitch_mm,
        slices: (0..grid.len()).map(|_| slice(rng, n)).collect(),
    };
    let levels = vec![level(&mut rng, n, 0.02 + 1e-3 * seed as f64), level(&mut rng, 1, 0.04)];
    let texels = (0..16).map(|_| std::array::from_fn(|_| rng.random::<f32>() * 1.5)).collect();
    Paint {
        coat: ClearCoat {
            ior: 1.0 + rng.random::<f64>(),
            refracts: false,
            mirror: rng.random(),
            gloss: seed.is_multiple_of(2).then_some(Lobe { coefficient: 0.2, roughness: 0.004, f0: 0.05 }),
        },
        diffuse: rng.random(),
        lobes: (0..2 + seed as usize % 2)
            .map(|_| Lobe {
                coefficient: rng.random(),
                roughness: 0.05 + rng.random::<f64>(),
                f0: rng.random(),
            })
            .collect(),
        colors: ColorTable::new([4, 4], texels, vec![true; 16]).unwrap(),
        flakes: Some(Flakes {
            grid,
            missing: MissingSlice::Zero,
            size: [2, 2],
            texel_mm: 0.015,
            levels,
            inverse_cdf_steps: 100,
            knots: Some(Knots::usual(0.1)),
        }),
        provenance: Value::Null,
    }
}

pub fn named<'a>(paints: &[&'a Paint]) -> Vec<(String, &'a Paint)> {
    paints.iter().enumerate().map(|(k, p)| (format!("paint {k}"), *p)).collect()
}

pub fn mix_along(path: Path, paints: &[&Paint]) -> Mix {
    let options = CoupleOptions { path, ..CoupleOptions::default() };
    couple(&named(paints), &options, &|| ()).unwrap().0
}

pub fn mix(paints: &[&Paint]) -> Mix {
    mix_along(Path::default(), paints)
}

/// Clusters with equal boxes made one, in an order of their own.
pub fn merged(clusters: &[Cluster]) -> Vec<Cluster> {
    let key = |c: &Cluster| (c.min.map(f32::to_bits), c.max.map(f32::to_bits));
    let mut sorted = clusters.to_vec();
    sorted.sort_by_key(key);
    let mut out: Vec<Cluster> = Vec::new();
    for c in sorted {
        match out.last_mut() {
            Some(last) if key(last) == key(&c) => last.probability += c.probability,
            _ => out.push(c),
        }
    }
    out
}

pub fn slices(paint: &Paint) -> impl Iterator<Item = &SliceStatistics> {
    paint.flakes.as_ref().unwrap().levels.iter().flat_map(|l| &l.slices)
}

pub fn assert_same_distribution(a: &Paint, b: &Paint) {
    for (a, b) in slices(a).zip(slices(b)) {
        let (x, y) = (merged(&a.clusters), merged(&b.clusters));
        assert_eq!(x.len(), y.len());
        for (x, y) in x.iter().zip(&y) {
            assert_eq!((x.min, x.max), (y.min, y.max), "corners to the bit");
            // A probability is a sum of up to n + m - 1 arcs of a plan whose row sums are exact to rounding.
            assert!((x.probability - y.probability).abs() <= 1e-15, "{} {}", x.probability, y.probability);
        }
        for c in 0..3 {
            // A difference of means that are equal up to rounding, in f32 offsets near 0.01.
            assert!((a.offset[c] - b.offset[c]).abs() < 2e-9, "{:?} {:?}", a.offset, b.offset);
        }
        assert_eq!(a.gain, b.gain);
        assert!(a.fades.is_empty());
    }
}

pub fn assert_same_smooth_part(a: &Paint, b: &Paint) {
    assert_eq!(a.coat, b.coat);
    assert_eq!(a.diffuse.to_bits(), b.diffuse.to_bits());
    assert_eq!(a.colors, b.colors);
}

/// Colors of the slices with these random numbers.
pub fn drawn(paint: &Paint, texels: &[(f32, [f32; 3])]) -> Vec<DVec3> {
    slices(paint)
        .take(6)
        .flat_map(|s| {
            let sampler = Sampler::exact(s).unwrap();
            texels.iter().map(move |(u, r)| DVec3::from(color(s, &sampler, *u, *r).map(f64::from)))
        })
        .collect()
}

pub fn texels(n: usize) -> Vec<(f32, [f32; 3])> {
    let mut rng = Pcg64::seed_from_u64(9);
    (0..n).map(|_| (rng.random(), rng.random())).collect()
}
