//! What of a paint a blend lets go: channels, contrast, lobes, weights inside and outside.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "mix/paints.rs"]
mod paints;

use carpaint::Paint;
use carpaint::brdf::Lobe;
use carpaint::cluster::{Cluster, SliceStatistics, deviation_of_draws};
use carpaint::mix::{BlendOptions, Channels, LobePath, Path, distance_weights, whitened};
use carpaint::sampler::{Sampler, color};
use glam::DVec3;
use paints::{assert_same_smooth_part, mix, mix_along, paint, slices, texels};

#[test]
fn lobes_that_only_one_paint_has_fade_out() {
    let (a, b) = (paint(1, 5), paint(2, 5));
    assert_eq!((a.lobes.len(), b.lobes.len()), (3, 2));
    let mix = mix(&[&a, &b]);
    let back = mix.blend(&[0.0, 1.0]).unwrap();
    assert_eq!(back.lobes[..2], b.lobes[..]);
    assert_eq!(back.lobes[2].coefficient, 0.0);
    let half = mix.blend(&[0.5, 0.5]).unwrap();
    assert_eq!(half.lobes[2].coefficient, 0.5 * a.lobes[2].coefficient);
    assert_eq!(half.coat.gloss.unwrap().coefficient, 0.1);
    // Nor does a paint get a gloss, not even one of coefficient 0, from another without weight.
    assert_eq!(a.coat.gloss, None);
    assert_eq!(mix.blend(&[1.0, 0.0]).unwrap().coat, a.coat);
}

#[test]
fn paints_smoother_than_what_extrapolation_is_kept_to_stay_so() {
    let (mut a, b) = (paint(1, 5), paint(2, 5));
    a.lobes[0].roughness = 5e-5;
    let mix = mix(&[&a, &b]);
    assert_eq!(mix.blend(&[1.0, 0.0]).unwrap().lobes[0], a.lobes[0]);
    assert_eq!(mix.blend(&[9.0, -8.0]).unwrap().lobes[0].roughness, 5e-5);
}

#[test]
fn lightness_alone_leaves_a_and_b_of_every_sample() {
    let (a, b) = (paint(1, 50), paint(3, 50));
    let in_box = |s: &SliceStatistics, sampler: &Sampler, (u, r): (f32, [f32; 3])| {
        carpaint::sampler::lab_in_box(&s.clusters[sampler.lookup(u)], r)
    };
    for (path, source) in Path::ALL.into_iter().flat_map(|p| [(p, 0), (p, 1)]) {
        let mix = mix_along(path, &[&a, &b]);
        let options = |channels| BlendOptions { channels, source, ..BlendOptions::default() };
        let own = mix.blend(&[[1.0, 0.0], [0.0, 1.0]][source]).unwrap();
        for weights in [[1.0, 0.0], [0.7, 0.3], [0.0, 1.0], [-0.5, 1.5]] {
            let lightness = mix.blend_with(&weights, &options(Channels::Lightness)).unwrap();
            let rest = mix.blend_with(&weights, &options(Channels::AllButLightness)).unwrap();
            let all = mix.blend(&weights).unwrap();
            assert_same_smooth_part(&lightness, &own);
            assert_same_smooth_part(&rest, &all);
            for (((l, r), o), all) in
                slices(&lightness).zip(slices(&rest)).zip(slices(&own)).zip(slices(&all))
            {
                let [sl, sr, so] = [l, r, o].map(|s| Sampler::exact(s).unwrap());
                let distance = |x: DVec3, y: DVec3| (x - y).abs().max_element();
                // f32 offsets of a few units.
                assert!(distance(l.mean_rgb(), o.mean_rgb()) < 1e-5);
                assert!(distance(r.mean_rgb(), all.mean_rgb()) < 1e-5);
                for texel in texels(500) {
                    // Cumulative rows are f32: a texel within 1e-6 of an end may be on its other side.
                    let near = |s: &Sampler| match s {
                        Sampler::Exact(t, _) => t.cumulative().iter().any(|c| (c - texel.0).abs() < 1e-6),
                        _ => false,
                    };
                    if near(&sl) || near(&sr) || near(&so) {
                        continue;
                    }
                    let (x, y, z) = (in_box(l, &sl, texel), in_box(r, &sr, texel), in_box(o, &so, texel));
                    assert_eq!([x[1], x[2]], [z[1], z[2]], "{path} {weights:?}");
                    assert_eq!(y[0], z[0], "{path} {weights:?}");
                }
            }
        }
    }
}

#[test]
fn white_flakes_keep_the_mean() {
    let (a, b) = (paint(1, 50), paint(3, 50));
    let flakes = a.flakes.as_ref().unwrap();
    let white = whitened(flakes);
    let options = BlendOptions { channels: Channels::WhiteFlakes, ..BlendOptions::default() };
    let blend = mix(&[&a, &b]).blend_with(&[1.0, 0.0], &options).unwrap();
    for ((s, w), blend) in slices(&a).zip(white.levels.iter().flat_map(|l| &l.slices)).zip(slices(&blend)) {
        assert!(
            w.clusters
                .iter()
                .chain(&blend.clusters)
                .all(|c| [c.min[1], c.min[2], c.max[1], c.max[2]] == [0.0; 4])
        );
        for s in [s, blend].map(|s| s.mean_rgb() - w.mean_rgb()) {
            // f32 offsets of a few units.
            assert!(s.abs().max_element() < 1e-5, "{s}");
        }
    }
}

#[test]
fn contrast_keeps_the_deviation() {
    let paints = [paint(1, 50), paint(3, 40), paint(6, 30)];
    let mix = mix(&paints.iter().collect::<Vec<_>>());
    let texels = texels(20_000);
    let deviation = |s: &SliceStatistics| {
        let sampler = Sampler::exact(s).unwrap();
        let colors = || texels.iter().map(|(u, r)| DVec3::from(color(s, &sampler, *u, *r).map(f64::from)));
        let mean = colors().sum::<DVec3>() / texels.len() as f64;
        (colors().map(|c| (c - mean) * (c - mean)).sum::<DVec3>() / texels.len() as f64).map(f64::sqrt)
    };
    let options = BlendOptions { path: Some(Path::Contrast), ..BlendOptions::default() };
    // The last is extrapolated: linear in what its weights are beyond (0, 1/2, 1/2).
    for (weights, shares) in [
        ([0.2, 0.3, 0.5], [0.2, 0.3, 0.5]),
        ([0.5, 0.5, 0.0], [0.5, 0.5, 0.0]),
        ([-0.2, 0.6, 0.6], [0.0, 0.5, 0.5]),
    ] {
        let blend = mix.blend_with(&weights, &options).unwrap();
        let ends: Vec<Vec<DVec3>> =
            paints.iter().map(|p| slices(p).take(6).map(deviation).collect()).collect();
        for (k, s) in slices(&blend).take(6).enumerate() {
            let root: DVec3 = shares.iter().zip(&ends).map(|(s, e)| *s * e[k].map(f64::cbrt)).sum();
            let beyond: DVec3 = weights.iter().zip(shares).zip(&ends).map(|((w, s), e)| (w - s) * e[k]).sum();
            let ratio = deviation(s) / (root * root * root + beyond);
            // 20,000 draws of long tails: a standard deviation scatters by about 1 %, and there are three ends.
            assert!((ratio - 1.0).abs().max_element() < 0.05, "{ratio}");
        }
    }
}

#[test]
fn deviations_in_closed_form_are_those_of_draws() {
    let cluster = |probability, l: f32, a: f32, b: f32, half: f32| Cluster {
        probability,
        min: [l - half, a - 0.7 * half, b - 0.5 * half],
        max: [l + half, a + 0.7 * half, b + 0.5 * half],
    };
    // Dark boxes about zero, where the companding function is straight, one across the joint, a wide bright one.
    let clusters = vec![
        cluster(0.4, -5.0, 2.0, -3.0, 4.0),
        cluster(0.3, 9.0, -2.0, 3.0, 6.0),
        cluster(0.2, 50.0, 10.0, -30.0, 15.0),
        cluster(0.1, 120.0, -5.0, 10.0, 30.0),
    ];
    let texels = texels(200_000);
    let inside = [vec![], vec![0.0, 0.1, 0.05, 0.0], vec![0.1, 0.0, 0.0, 0.0]];
    // Ramps that are cut off at one end of an arc, at both, and three that overlap.
    let cut = [
        vec![0.0, 0.0, 0.15, 0.0],
        vec![0.0, 0.25, 0.25, 0.0],
        vec![0.5, 0.5, 0.5, 0.0],
        vec![0.02, 0.4, 0.0, 0.0],
    ];
    for fades in inside.into_iter().chain(cut) {
        let statistics = SliceStatistics { fades, ..SliceStatistics::new(clusters.clone(), [0.1; 3]) };
        let sampler = Sampler::exact(&statistics).unwrap();
        let colors =
            || texels.iter().map(|(u, r)| DVec3::from(color(&statistics, &sampler, *u, *r).map(f64::from)));
        let mean = colors().sum::<DVec3>() / texels.len() as f64;
        let variance = colors().map(|c| (c - mean) * (c - mean)).sum::<DVec3>() / texels.len() as f64;
        let closed = deviation_of_draws(&statistics.clusters, &statistics.fades);
        // Bands leave the mean alone: three standard errors of it.
        let error = (mean - statistics.mean_rgb()) / (closed / (texels.len() as f64).sqrt());
        assert!(error.abs().max_element() < 3.5, "{error}");
        let ratio = closed / variance.map(f64::sqrt);
        // A deviation of 200,000 long-tailed draws scatters by 0.3 %; bands assume that the colors of two boxes at the same
        // random numbers go together perfectly.
        assert!((ratio - 1.0).abs().max_element() < 0.01, "{ratio}");
    }
}

#[test]
fn weights_of_distances() {
    assert_eq!(distance_weights(&[1.0, 0.0, 2.0]).unwrap(), [0.0, 1.0, 0.0]);
    assert_eq!(distance_weights(&[0.0, 3.0, 0.0]).unwrap(), [0.5, 0.0, 0.5]);
    assert_eq!(distance_weights(&[1.0, 2.0, f64::INFINITY]).unwrap(), [0.8, 0.2, 0.0]);
    assert_eq!(distance_weights(&[1e-300, 2e-300]).unwrap(), [0.8, 0.2]);
    for bad in [&[][..], &[-1.0, 1.0], &[f64::NAN], &[f64::INFINITY]] {
        assert!(distance_weights(bad).is_err(), "{bad:?}");
    }
}

#[test]
fn extrapolated_paints_stay_legal() {
    let (a, b) = (paint(2, 20), paint(5, 20));
    let mix = mix(&[&a, &b]);
    for (path, lobes) in Path::ALL.into_iter().flat_map(|p| LobePath::ALL.map(|l| (p, l))) {
        let options = BlendOptions { path: Some(path), lobes, ..BlendOptions::default() };
        for w in [-10.0, -0.5, 1.5, 11.0] {
            mix.blend_with(&[1.0 - w, w], &options).unwrap().validate().unwrap();
        }
    }
}

#[test]
fn lobes_are_matched_by_roughness() {
    let lobe = |coefficient, roughness, f0| Lobe { coefficient, roughness, f0 };
    let with = |seed, lobes: Vec<Lobe>| Paint { lobes, ..paint(seed, 3) };
    let a = with(1, vec![lobe(0.1, 1.0, 0.5), lobe(0.2, 0.3, 0.0), lobe(0.3, 0.1, 1.0)]);
    let b = with(3, vec![lobe(0.4, 0.12, 0.2), lobe(0.5, 0.9, 0.3)]);
    let options = BlendOptions { lobes: LobePath::Matched, ..BlendOptions::default() };
    for pair in [[&a, &b], [&b, &a]] {
        let mix = mix(&pair);
        for (k, end) in pair.iter().enumerate() {
            let mut back = mix.blend_with(&[1.0 - k as f64, k as f64], &options).unwrap().lobes;
            back.retain(|l| l.coefficient != 0.0);
            for own in &end.lobes {
                assert!(back.contains(own), "{own:?} {back:?}");
            }
            assert_eq!(back.len(), end.lobes.len());
        }
        let half = mix.blend_with(&[0.5, 0.5], &options).unwrap().lobes;
        let near =
            |roughness: f64| half.iter().find(|l| (l.roughness / roughness - 1.0).abs() < 1e-12).unwrap();
        // Geometric means of 1 and 0.9, of 0.1 and 0.12; what has no partner is half as strong.
        assert!((near(0.9f64.sqrt()).coefficient - 0.05f64.sqrt()).abs() < 1e-12);
        assert!((near(0.012f64.sqrt()).coefficient - 0.12f64.sqrt()).abs() < 1e-12);
        assert_eq!(near(0.3).coefficient, 0.1);
        for w in (-50..=150).map(|p| f64::from(p) / 100.0) {
            for lobe in mix.blend_with(&[1.0 - w, w], &options).unwrap().lobes {
                lobe.validate().unwrap();
                assert!(lobe.roughness > 0.0 && (0.0..=1.0).contains(&lobe.f0));
            }
        }
    }
}

#[test]
fn boxes_never_turn_inside_out() {
    let (a, b) = (paint(1, 50), paint(3, 50));
    let mix = mix(&[&a, &b]);
    assert_eq!(mix.inverted_mass(&[0.4, 0.6]).unwrap(), 0.0);
    for weights in [[3.0, -2.0], [-2.0, 3.0]] {
        // Widths are up to 8 and uniform: far outside most arcs have an axis whose width came out negative.
        assert!(mix.inverted_mass(&weights).unwrap() > 0.5);
        let blend = mix.blend(&weights).unwrap();
        for cluster in slices(&blend).flat_map(|s| &s.clusters) {
            assert!((0..3).all(|c| cluster.min[c] <= cluster.max[c]), "{cluster:?}");
        }
    }
}

#[test]
fn weights_that_do_not_fit_are_refused() {
    let (a, b) = (paint(1, 3), paint(2, 3));
    let mix = mix(&[&a, &b]);
    for bad in [&[1.0][..], &[0.3, 0.3, 0.4], &[0.5, 0.6], &[f64::NAN, 1.0], &[2000.0, -1999.0]] {
        assert!(mix.blend(bad).is_err(), "{bad:?}");
    }
    // Thirds as people type them.
    assert!(mix.blend(&[0.333333, 0.666667]).is_ok());
}
