//! Statistics of slices: laws, hard cases, and how well draws stand for the texels.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "statistics/presets.rs"]
mod presets;
#[path = "statistics/samplers.rs"]
mod samplers;
#[path = "statistics/slices.rs"]
mod slices;

use carpaint::cluster::{BoxRule, SliceStatistics, cluster_slice};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::sampler::{
    GuideTable, InverseCdf, ReconstructionError, ReconstructionSamples, Sampler, color, lab_in_box,
    reconstruction_error,
};
use carpaint::transport::{Cost, Problem, Solver, solve};
use glam::DVec3;
use proptest::prelude::*;

const RULES: [BoxRule; 2] = [BoxRule::MomentMatched, BoxRule::Bounding];

fn exact(statistics: &SliceStatistics) -> Sampler {
    Sampler::exact(statistics).unwrap()
}

fn stepped(statistics: &SliceStatistics, steps: usize) -> Sampler {
    Sampler::inverse_cdf(statistics, steps).unwrap()
}

/// Exact Wasserstein-1 distance of two equally large clouds.
fn wasserstein(a: &[DVec3], b: &[DVec3]) -> f64 {
    let equal = vec![1.0 / a.len() as f64; a.len()];
    let problem = Problem::from_centers(a, &equal, b, &equal, Cost::Euclidean).unwrap();
    solve(&problem, Solver::default()).unwrap().certificate.cost
}

/// Mean and largest standard deviation of the components.
fn mean_and_spread(texels: &[[f32; 3]]) -> (DVec3, f64) {
    let wide = |t: &[f32; 3]| DVec3::from_array(t.map(f64::from));
    let n = texels.len() as f64;
    let mean = texels.iter().map(wide).sum::<DVec3>() / n;
    let variance = texels.iter().map(|t| (wide(t) - mean).powf(2.0)).sum::<DVec3>() / n;
    (mean, variance.max_element().sqrt())
}

/// Slices that break careless code.
fn hard_slices() -> Vec<(&'static str, Vec<[f32; 3]>)> {
    let noise = |n: u32, scale: f32, shift: f32| -> Vec<[f32; 3]> {
        (0..n)
            .map(|k| {
                let [r, g, b, _] = pcg4d([k, 5, 5, 5]).map(|bits| unit(bits) * scale + shift);
                [r, g, b]
            })
            .collect()
    };
    let with = |mut texels: Vec<[f32; 3]>, more: [f32; 3]| {
        texels.push(more);
        texels
    };
    vec![
        ("across zero", noise(3000, 0.02, -0.01)),
        ("negative", noise(3000, 3.0, -4.0)),
        ("bright", noise(3000, 1e3, 10.0)),
        ("very bright", noise(3000, 1e5, -1e3)),
        ("black", vec![[0.0; 3]; 100]),
        ("one texel", vec![[0.3, -0.2, 7.0]]),
        ("two values", with(vec![[0.25, 0.5, 0.125]; 99], [-1.0, 2.0, 3.0])),
        ("one color", vec![[0.2, 0.4, 0.6]; 4096]),
        ("bright outlier", with(noise(4000, 0.3, -0.1), [1e5, 2e4, 1e4])),
        ("dark outlier", with(noise(4000, 0.3, -0.1), [-1e5, -2e4, -1e4])),
        ("chroma outlier", with(noise(4000, 0.3, -0.1), [1e4, -3e3, 0.0])),
        ("one channel", noise(500, 0.5, 0.0).iter().map(|t| [0.0, 0.0, t[2]]).collect()),
        ("tiny", noise(500, 1e-30, -5e-31)),
    ]
}

#[test]
fn laws_hold_for_hard_slices() {
    for (name, texels) in hard_slices() {
        let (mean, spread) = mean_and_spread(&texels);
        for n in [1, 2, 7, 50, 1024] {
            for rule in RULES {
                let statistics = cluster_slice(&texels, n, rule).unwrap();
                statistics.validate().unwrap_or_else(|e| panic!("{name} {n} {rule:?}: {e}"));
                assert!(statistics.clusters.len() <= n, "{name}");
                let sum: f64 = statistics.clusters.iter().map(|c| c.probability).sum();
                // A rounding for each of n ratios and for each addition.
                assert!((sum - 1.0).abs() <= 1e-15 * n as f64, "{name} {n}: {sum}");
                let centers: Vec<f64> =
                    statistics.clusters.iter().map(|c| f64::from(c.min[0]) + f64::from(c.max[0])).collect();
                assert!(centers.is_sorted(), "{name} {n} {rule:?}");
                // 1e-6 of (|mean| + std): the offset is rounded to f32, which is 6e-8 of it, and it is not larger than a few
                // standard deviations.
                let error = (statistics.mean_rgb() - mean).abs().max_element();
                assert!(error <= 1e-6 * (mean.length() + spread), "{name} {n} {rule:?}: {error}");
                for cluster in &statistics.clusters {
                    assert!((0..3).all(|axis| cluster.min[axis] <= cluster.max[axis]), "{name} {n}");
                }
            }
        }
    }
}

#[test]
fn draws_have_the_mean_of_the_source() {
    for (name, texels) in hard_slices() {
        let (mean, spread) = mean_and_spread(&texels);
        let statistics = cluster_slice(&texels, 50, BoxRule::MomentMatched).unwrap();
        let sampler = exact(&statistics);
        let draws = 200_000;
        let drawn: Vec<[f32; 3]> = (0..draws)
            .map(|k| {
                let [u, r0, r1, r2] = pcg4d([k, 1, 2, 3]).map(unit);
                color(&statistics, &sampler, u, [r0, r1, r2])
            })
            .collect();
        let (drawn, _) = mean_and_spread(&drawn);
        // Five standard errors of the draws, and the f32 arithmetic of a conversion (1e-6 of the color).
        let tolerance = 5.0 * spread / f64::from(draws).sqrt() + 2e-6 * mean.length();
        assert!((drawn - mean).abs().max_element() <= tolerance, "{name}: {drawn} {mean} {tolerance:e}");
    }
}

#[test]
fn few_colors_are_kept_exactly() {
    let colors = [[0.1f32, 0.2, 0.3], [0.5, 0.1, 0.0], [-0.2, -0.1, 0.4], [3.0, 2.0, 1.0]];
    let texels: Vec<[f32; 3]> = (0..1000).map(|k| colors[[0, 0, 0, 0, 1, 1, 1, 2, 2, 3][k % 10]]).collect();
    for rule in RULES {
        let statistics = cluster_slice(&texels, 50, rule).unwrap();
        let sampler = exact(&statistics);
        assert_eq!(statistics.clusters.len(), 4);
        for (k, cluster) in statistics.clusters.iter().enumerate() {
            assert_eq!(cluster.min, cluster.max, "a color has no extent");
            let middle: f64 = statistics.clusters[..k].iter().map(|c| c.probability).sum::<f64>()
                + 0.5 * cluster.probability;
            let drawn = color(&statistics, &sampler, middle as f32, [0.1, 0.5, 0.9]);
            let near = colors.iter().position(|c| (0..3).all(|i| (c[i] - drawn[i]).abs() < 2e-5));
            // Half a lattice step (1e-6 of a range of 250 Delta-E) is 2e-5 at the slope of bright colors.
            let near = near.unwrap_or_else(|| panic!("{drawn:?}"));
            assert_eq!(cluster.probability, [0.4, 0.3, 0.2, 0.1][near]);
        }
    }
}

#[test]
fn the_order_of_the_texels_does_not_matter() {
    for flakes in slices::ALL {
        let texels = slices::slice(flakes, 64, 9);
        let n = texels.len() as u32;
        // 2,731 is odd, so its multiples run through all 4,096 texels.
        let shuffled: Vec<[f32; 3]> = (0..n).map(|k| texels[(k * 2731 % n) as usize]).collect();
        for rule in RULES {
            let (a, b) =
                (cluster_slice(&texels, 50, rule).unwrap(), cluster_slice(&shuffled, 50, rule).unwrap());
            assert_eq!(a.clusters, b.clusters);
            // The mean of the texels is a floating-point sum.
            assert!((0..3).all(|c| (a.offset[c] - b.offset[c]).abs() <= 1e-7 * (1e-3 + a.offset[c].abs())));
        }
    }
}

#[test]
fn an_outlier_does_not_blur_the_rest() {
    let texels = slices::slice(slices::DENSE, slices::SIDE, 4);
    let mut spoiled = texels.clone();
    spoiled[77] = [3e4, 1e4, 2e4];
    let body = |statistics: &SliceStatistics| -> (usize, f64) {
        let dim = statistics.clusters.iter().filter(|c| c.max[0] < 1000.0);
        let size = |c: &carpaint::cluster::Cluster| {
            (0..3).map(|k| f64::from(c.max[k] - c.min[k]).powi(2)).sum::<f64>().sqrt()
        };
        (dim.clone().count(), dim.map(|c| c.probability * size(c)).sum())
    };
    let (count, size) = body(&cluster_slice(&texels, 50, BoxRule::MomentMatched).unwrap());
    let (spoiled_count, spoiled_size) = body(&cluster_slice(&spoiled, 50, BoxRule::MomentMatched).unwrap());
    assert_eq!((count, spoiled_count), (50, 49));
    // One cluster of fifty less: 2 %, and the octree starts from another root cube.
    assert!(spoiled_size < 1.1 * size, "{spoiled_size} {size}");
}

#[test]
fn bad_input_is_refused() {
    let error =
        |texels: &[[f32; 3]], n: usize| cluster_slice(texels, n, BoxRule::default()).unwrap_err().to_string();
    assert_eq!(error(&[[0.0; 3]], 0), "clusters: number: found 0, expected 1 to 1024");
    assert_eq!(error(&[[0.0; 3]], 1025), "clusters: number: found 1025, expected 1 to 1024");
    assert_eq!(error(&[], 50), "slice: texels: found 0, expected 1 to 16777216");
    for bad in [f32::NAN, f32::INFINITY, -1e13] {
        assert!(error(&[[0.0; 3], [0.0, bad, 0.0]], 50).starts_with("texel 1: value: found [0.0, "));
    }
}

#[test]
fn samplers_draw_with_their_probabilities() {
    let statistics =
        cluster_slice(&slices::slice(slices::MEDIUM, 64, 2), 50, BoxRule::MomentMatched).unwrap();
    let forward = Sampler::forward_cdf(&statistics).unwrap();
    let draws = 400_000u32;
    for (name, sampler) in
        [("exact", exact(&statistics)), ("steps", stepped(&statistics, 4096)), ("forward", forward)]
    {
        let mut counts = vec![0u32; statistics.clusters.len()];
        for k in 0..draws {
            counts[sampler.lookup(unit(pcg4d([k, 8, 1, 1])[0]))] += 1;
        }
        let chi_squared: f64 = counts
            .iter()
            .zip(&statistics.clusters)
            .map(|(count, cluster)| {
                let expected = cluster.probability * f64::from(draws);
                (f64::from(*count) - expected).powi(2) / expected
            })
            .sum();
        // The texels number 4,096, so that as many steps hold every probability exactly. 49 degrees of freedom: mean 49,
        // standard deviation 9.9; five of them.
        assert!(chi_squared < 49.0 + 5.0 * 9.9, "{name}: {chi_squared}");
    }
}

#[test]
fn fewer_steps_lose_more_sparkles() {
    for flakes in slices::ALL {
        let statistics =
            cluster_slice(&slices::slice(flakes, slices::SIDE, 3), 50, BoxRule::MomentMatched).unwrap();
        let p: Vec<f64> = statistics.clusters.iter().map(|c| c.probability).collect();
        let mut before = usize::MAX;
        for steps in [100, 500, 2000, 10_000] {
            let table = InverseCdf::new(&p, steps).unwrap();
            assert!(table.lost().len() <= before);
            before = table.lost().len();
            assert!(table.lost().iter().all(|k| p[*k] < 0.5 / steps as f64));
            // Every cluster is off by at most one step, and as much is missing as there is too much.
            assert!(table.total_variation() <= 0.5 * p.len() as f64 / steps as f64);
        }
        // A texel is 1/16,384, so that 10,000 steps keep every one.
        assert_eq!(before, 0);
    }
}

#[test]
fn brightness_rises_along_u() {
    let statistics = cluster_slice(&slices::slice(slices::DENSE, 64, 2), 50, BoxRule::MomentMatched).unwrap();
    for sampler in [exact(&statistics), stepped(&statistics, 500)] {
        let lightness =
            |k: u32| lab_in_box(&statistics.clusters[sampler.lookup(k as f32 / 4096.0)], [0.5; 3])[0];
        assert!((1..4096).map(lightness).is_sorted());
    }
}

/// A million draws: a thousand of them lie above the 99.9 % quantile.
const DRAWS: u32 = 1_000_000;

fn reconstruction(
    texels: &[[f32; 3]],
    statistics: &SliceStatistics,
    sampler: &Sampler,
) -> ReconstructionError {
    let samples = ReconstructionSamples { draws: DRAWS, points: 700, repeats: 4, seed: 1 };
    reconstruction_error(texels, statistics, sampler, samples, wasserstein).unwrap()
}

/// What is expected of a slice.
struct Expected {
    flakes: slices::Flakes,
    /// Wasserstein-1 above the floor of moment-matched boxes with exact draws, Delta-E, at most: 0.8 to 1.2, 0.07 and 0.04
    /// measured, and half a Delta-E for chance where the colors spread wide.
    excess: f64,
    /// How much more bounding boxes have at least, with the same random numbers: 1.3 to 1.9, 0.3 and 0.07 measured.
    bounding_adds: f64,
    /// Clusters that 500 steps lose at least; standard deviation, then quantile of the luminance that they leave, and error of
    /// the mean that they make.
    steps: (usize, [f64; 3]),
}

const EXPECTED: [Expected; 3] = [
    Expected { flakes: slices::DENSE, excess: 1.8, bounding_adds: 0.8, steps: (1, [0.993, 0.934, 0.014]) },
    Expected { flakes: slices::MEDIUM, excess: 0.5, bounding_adds: 0.14, steps: (2, [0.944, 0.896, 0.023]) },
    // Flakes rarer than half a step are gone, and with them nearly half of the contrast.
    Expected { flakes: slices::SPARSE, excess: 0.3, bounding_adds: 0.05, steps: (30, [0.539, 0.642, 0.058]) },
];

#[test]
fn exact_draws_stand_for_the_texels() {
    for Expected { flakes, excess, bounding_adds, .. } in EXPECTED {
        let texels = slices::slice(flakes, slices::SIDE, 3);
        let [ours, bounding] = RULES.map(|rule| {
            let statistics = cluster_slice(&texels, 50, rule).unwrap();
            let e = reconstruction(&texels, &statistics, &exact(&statistics));
            let name = format!("{} {rule:?}", flakes.name);
            // The offset makes the mean exact whatever the boxes; four standard errors of the draws, and a tenth more for
            // boxes that spread wider than the texels.
            assert!(e.mean_error() < 1.1 * 4.0 / f64::from(DRAWS).sqrt(), "{name}: {}", e.mean_error());
            // Ten seeds scatter by 0.001 for the dense slice, by 0.009 for the sparse one. Bounding boxes have no variance to keep.
            let most = if rule == BoxRule::MomentMatched { 0.03 } else { 0.06 };
            let std = e.std_ratio();
            assert!((std - 1.0).abs() < most, "{name}: {std}");
            // Bounding boxes know the ends of a band of sparkles, not where in it most lie.
            assert!((0.94..1.06).contains(&e.quantile_ratio()), "{name}: {}", e.quantile_ratio());
            e
        });
        assert!((ours.quantile_ratio() - 1.0).abs() < 0.05, "{}: {}", flakes.name, ours.quantile_ratio());
        assert!(ours.excess() < excess, "{}: {}", flakes.name, ours.excess());
        let added = bounding.wasserstein - ours.wasserstein;
        assert!(added > bounding_adds, "{}: {added}", flakes.name);
    }
}

#[test]
fn five_hundred_steps_lose_clusters_and_their_contrast() {
    for Expected { flakes, steps: (lost, [std, quantile, mean]), .. } in EXPECTED {
        let texels = slices::slice(flakes, slices::SIDE, 3);
        for rule in RULES {
            let statistics = cluster_slice(&texels, 50, rule).unwrap();
            let p: Vec<f64> = statistics.clusters.iter().map(|c| c.probability).collect();
            let found = InverseCdf::new(&p, 500).unwrap().lost().len();
            assert!(found >= lost, "{} {rule:?}: {found} clusters lost", flakes.name);
            let e = reconstruction(&texels, &statistics, &stepped(&statistics, 500));
            for (what, found, expected) in [
                ("std", e.std_ratio(), std),
                ("quantile", e.quantile_ratio(), quantile),
                ("mean", e.mean_error(), mean),
            ] {
                // Seeds scatter by up to 0.004, the two rules are up to 0.05 apart.
                assert!((found - expected).abs() < 0.03, "{} {rule:?}: {what} {found}", flakes.name);
            }
        }
    }
}

proptest! {
    #[test]
    fn the_exact_sampler_inverts_the_distribution(
        weights in prop::collection::vec(prop_oneof![Just(0.0), 1e-9..1.0f64], 1..200),
        bits in any::<u32>(),
    ) {
        prop_assume!(weights.iter().any(|w| *w > 0.0));
        let table = GuideTable::new(&weights).unwrap();
        let u = unit(bits);
        let k = table.lookup(u);
        let expected = table.cumulative().iter().position(|c| u < *c).unwrap();
        prop_assert_eq!(k, expected);
        prop_assert!(weights[k] > 0.0, "a cluster without probability is never drawn");
        for edge in [-1.0, 0.0, 1.0, f32::NAN] {
            prop_assert!(table.lookup(edge) < weights.len());
        }
    }

    #[test]
    fn steps_are_shared_out_fairly(
        weights in prop::collection::vec(1e-9..1.0f64, 1..100),
        steps in 1..2000usize,
    ) {
        let total: f64 = weights.iter().sum();
        let table = InverseCdf::new(&weights, steps).unwrap();
        prop_assert_eq!(table.steps().len(), steps);
        prop_assert!(table.steps().is_sorted());
        let halves = weights.iter().filter(|w| *w / total * steps as f64 >= 0.5).count();
        for (k, w) in weights.iter().enumerate() {
            let count = table.steps().iter().filter(|s| usize::from(**s) == k).count();
            prop_assert_eq!(count == 0, table.lost().contains(&k));
            if w / total * steps as f64 >= 0.5 && halves <= steps {
                prop_assert!(count >= 1, "cluster {} of weight {} has no step", k, w / total);
            }
        }
    }

    #[test]
    fn boxes_hold_the_moments_of_any_slice(
        texels in prop::collection::vec([-1.0..4.0f32, -1.0..4.0f32, -1.0..4.0f32], 1..400),
        n in 1..60usize,
    ) {
        let statistics = cluster_slice(&texels, n, BoxRule::MomentMatched).unwrap();
        let lab: Vec<DVec3> = texels
            .iter()
            .map(|t| carpaint::color::lab_from_rgb(std::f64::consts::PI * DVec3::from_array(t.map(f64::from))))
            .collect();
        for axis in 0..3 {
            let count = lab.len() as f64;
            let mean = lab.iter().map(|c| c[axis]).sum::<f64>() / count;
            let second = lab.iter().map(|c| c[axis] * c[axis]).sum::<f64>() / count;
            let (mut ours, mut ours_second) = (0.0, 0.0);
            for c in &statistics.clusters {
                let (low, high) = (f64::from(c.min[axis]), f64::from(c.max[axis]));
                let middle = 0.5 * (low + high);
                ours += c.probability * middle;
                ours_second += c.probability * (middle * middle + (high - low).powi(2) / 12.0);
            }
            // f32 Lab and corners: 1e-4 where XYZ cancels; a lattice step is 1e-6 of the range.
            prop_assert!((ours - mean).abs() < 1e-3, "{ours} {mean}");
            prop_assert!((ours_second - second).abs() < 1e-4 * (1.0 + second), "{ours_second} {second}");
        }
    }
}
