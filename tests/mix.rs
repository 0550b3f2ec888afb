//! Laws of a mix: end points, identity, swapped paints, continuity, mean.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "mix/paints.rs"]
mod paints;

use carpaint::cluster::{Cluster, SliceStatistics};
use carpaint::mix::{BlendOptions, LobePath, Mix, Path};
use glam::DVec3;
use paints::{
    assert_same_distribution, assert_same_smooth_part, drawn, mix, mix_along, paint, slices, texels,
};

#[test]
fn a_weight_of_one_gives_back_the_paint() {
    let paints = [paint(1, 50), paint(3, 37), paint(5, 20)];
    for set in [vec![&paints[0], &paints[1]], paints.iter().collect()] {
        for (path, coupled) in Path::ALL.into_iter().flat_map(|p| Path::ALL.map(|c| (p, c))) {
            let mix = mix_along(coupled, &set);
            for (k, end) in set.iter().enumerate() {
                let weights: Vec<f64> = (0..set.len()).map(|j| f64::from(u8::from(j == k))).collect();
                let options = BlendOptions { path: Some(path), ..BlendOptions::default() };
                let back = mix.blend_with(&weights, &options).unwrap();
                assert_same_distribution(&back, end);
                assert_same_smooth_part(&back, end);
                assert_eq!(back.lobes, end.lobes);
            }
        }
    }
}

#[test]
fn a_paint_mixed_with_itself_is_itself_at_every_weight() {
    let a = paint(4, 50);
    for path in Path::ALL {
        let mix = mix_along(path, &[&a, &a]);
        for percent in -50..=150 {
            let w = f64::from(percent) / 100.0;
            for lobes in LobePath::ALL {
                let options = BlendOptions { lobes, ..BlendOptions::default() };
                let back = mix.blend_with(&[1.0 - w, w], &options).unwrap();
                assert_same_distribution(&back, &a);
                assert_same_smooth_part(&back, &a);
                assert_eq!(back.lobes, a.lobes);
            }
        }
    }
}

/// A paint whose slices hardly scatter, as those far from the highlight.
fn nearly_flat(seed: u64) -> carpaint::paint::Paint {
    let mut flat = paint(seed, 50);
    let slices = flat.flakes.iter_mut().flat_map(|f| &mut f.levels).flat_map(|l| &mut l.slices);
    for cluster in slices.flat_map(|s| &mut s.clusters) {
        for corner in cluster.min.iter_mut().chain(&mut cluster.max) {
            *corner = 50.0 + 1e-5 * (*corner - 50.0);
        }
    }
    flat
}

#[test]
fn end_points_are_exact_where_next_to_nothing_scatters() {
    let (a, b) = (nearly_flat(1), paint(3, 37));
    for path in Path::ALL {
        let mix = mix_along(path, &[&a, &b]);
        assert_same_distribution(&mix.blend(&[1.0, 0.0]).unwrap(), &a);
        assert_same_distribution(&mix.blend(&[0.0, 1.0]).unwrap(), &b);
    }
    // Nor does a step away from the end make contrast out of rounding: a paint with itself stays what it is.
    let mix = mix_along(Path::Contrast, &[&a, &a]);
    for s in slices(&mix.blend(&[0.7, 0.3]).unwrap()) {
        assert!(s.gain.iter().all(|g| (g - 1.0).abs() < 1e-5), "{:?}", s.gain);
    }
}

#[test]
fn swapped_paints_with_swapped_weights_are_the_same() {
    let (a, b) = (paint(1, 50), paint(3, 37));
    for path in Path::ALL {
        let (there, back) = (mix_along(path, &[&a, &b]), mix_along(path, &[&b, &a]));
        for w in [-0.5, 0.0, 0.3, 0.5, 1.0, 1.4] {
            let (x, y) = (there.blend(&[1.0 - w, w]).unwrap(), back.blend(&[w, 1.0 - w]).unwrap());
            for (x, y) in slices(&x).zip(slices(&y)) {
                assert_eq!(x.clusters.len(), y.clusters.len());
                for (x, y) in x.clusters.iter().zip(&y.clusters) {
                    // The same sums in another order: a few roundings of f32 corners near 150.
                    for (x, y) in x.min.iter().chain(&x.max).zip(y.min.iter().chain(&y.max)) {
                        assert!((x - y).abs() < 1e-4, "{x} {y}");
                    }
                    assert!((x.probability - y.probability).abs() < 1e-12);
                }
                for c in 0..3 {
                    // Gains come from second moments of f32 corners, offsets from gains and means of about 1.
                    assert!((x.offset[c] - y.offset[c]).abs() < 1e-4 * (1.0 + x.offset[c].abs()));
                    assert!((x.gain[c] - y.gain[c]).abs() <= 1e-4 * x.gain[c]);
                }
                assert!(x.fades.iter().zip(&y.fades).all(|(x, y)| (x - y).abs() < 1e-7));
            }
            for (x, y) in x.lobes.iter().zip(&y.lobes) {
                assert!((x.roughness / y.roughness - 1.0).abs() < 1e-12, "{x:?} {y:?}");
            }
        }
    }
}

/// Steps of all texels, Delta-E, over a sweep of the weight of the second paint from `from` to `to`, percent.
fn steps(mix: &Mix, path: Path, from: f64, to: f64, step: f64) -> Vec<f64> {
    let texels = texels(500);
    let options = BlendOptions { path: Some(path), ..BlendOptions::default() };
    let mut all = Vec::new();
    let mut before: Option<Vec<DVec3>> = None;
    for k in 0..=((to - from) / step) as usize {
        let w = (from + k as f64 * step) / 100.0;
        let blend = mix.blend_with(&[1.0 - w, w], &options).unwrap();
        // Flakes over a gray of 20 %.
        let lab = |c: DVec3| carpaint::color::lab_from_rgb(std::f64::consts::PI * c + 0.2);
        let now: Vec<DVec3> = drawn(&blend, &texels).into_iter().map(lab).collect();
        all.extend(before.iter().flatten().zip(&now).map(|(a, b)| a.distance(*b)));
        before = Some(now);
    }
    all
}

fn largest(steps: &[f64]) -> f64 {
    steps.iter().copied().fold(0.0, f64::max)
}

#[test]
fn every_texel_moves_continuously_with_the_weights() {
    let (a, b) = (paint(1, 50), paint(3, 50));
    let mix = mix(&[&a, &b]);
    for path in Path::ALL {
        let sweep = steps(&mix, path, -50.0, 150.0, 1.0);
        let far = sweep.iter().filter(|d| **d > 2.0).count() as f64 / sweep.len() as f64;
        println!(
            "{path}: steps of texels per 1 %: largest {:.2} Delta-E, {:.2} % above 2",
            largest(&sweep),
            100.0 * far
        );
        let fine = largest(&steps(&mix, path, -50.0, 150.0, 0.25));
        match path {
            // A quarter of the slider's step is a quarter of the texel's, up to curvature.
            Path::Transport | Path::Contrast => assert!(fine < 0.4 * largest(&sweep)),
            Path::Hybrid => {
                // A share leaves 0 like the square root of the weight: half as far in a quarter of the step, in RGB.
                assert!(fine < 0.75 * largest(&sweep));
                // One percent away from an end, a ramp of half-width 1/8 stands at sqrt(0.08) = 28 %. The brightest boxes
                // here have a luminance of 3.2: that much more than 20 % is 50 Delta-E in lightness, with chroma 70.
                assert!(largest(&sweep) < 70.0);
            }
        }
    }
}

#[test]
fn exchanged_arcs_that_share_a_box_keep_to_themselves() {
    let of = |clusters: &[(f64, f32)]| {
        let mut paint = paint(1, 5);
        let cluster = |(probability, l): &(f64, f32)| Cluster {
            probability: *probability,
            min: [*l, 0.0, 0.0],
            max: [l + 1.0, 0.0, 0.0],
        };
        let clusters: Vec<Cluster> = clusters.iter().map(cluster).collect();
        for level in &mut paint.flakes.as_mut().unwrap().levels {
            level.slices.fill(SliceStatistics::new(clusters.clone(), [0.0; 3]));
        }
        paint
    };
    // Both clusters of the second paint are too far from the first one's for its box to travel.
    let mix = mix(&[&of(&[(1.0, 0.0)]), &of(&[(0.1, -100.0), (0.9, 100.0)])]);
    for w in [0.02, 0.5, 0.98] {
        for s in slices(&mix.blend(&[1.0 - w, w]).unwrap()) {
            assert_eq!(s.clusters.len(), 4);
            assert_eq!((s.clusters[1].min, s.clusters[1].max), (s.clusters[2].min, s.clusters[2].max));
            assert!(s.fades[0] > 0.0 && s.fades[1] == 0.0 && s.fades[2] > 0.0, "{:?}", s.fades);
            assert!((s.fades[2] / s.fades[0] - 9.0).abs() < 1e-5);
        }
    }
}

#[test]
fn the_mean_of_a_blend_is_the_blend_of_the_means() {
    let paints = [paint(1, 50), paint(3, 40), paint(6, 30)];
    let mix = mix(&paints.iter().collect::<Vec<_>>());
    for weights in [[0.2, 0.3, 0.5], [-0.5, 1.0, 0.5], [1.5, -0.25, -0.25]] {
        let blend = mix.blend(&weights).unwrap();
        let ends: Vec<Vec<DVec3>> =
            paints.iter().map(|p| slices(p).map(SliceStatistics::mean_rgb).collect()).collect();
        for (k, s) in slices(&blend).enumerate() {
            let wanted: DVec3 = weights.iter().zip(&ends).map(|(w, e)| e[k] * *w).sum();
            let offset = DVec3::from(s.offset.map(f64::from));
            let error = (s.mean_rgb() - wanted).abs().max_element();
            // The offset is stored in f32: half a unit in the last place of an offset of at most a few units.
            assert!(error < 1e-6 * (1.0 + offset.abs().max_element()), "{error}");
        }
    }
}
