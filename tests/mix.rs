//! Laws of a mix: end points, identity, continuity, mean, files.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{Cluster, SliceStatistics, mean_of_boxes};
use carpaint::mix::{Mix, couple};
use carpaint::paint::{FlakeLevel, Flakes, MissingSlice};
use carpaint::transport::Solver;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

/// Statistics like those of a flake slice: many dark clusters, a few bright and rare ones.
fn slice(rng: &mut Pcg64, n: usize) -> SliceStatistics {
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

fn paint(seed: u64, n: usize) -> Paint {
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
            knot_spacing: Some(0.1),
        }),
        provenance: Value::Null,
    }
}

fn mix(paints: &[&Paint]) -> Mix {
    let named: Vec<_> = paints.iter().enumerate().map(|(k, p)| (format!("paint {k}"), *p)).collect();
    couple(&named, Solver::default(), &|| ()).unwrap().0
}

/// Clusters with equal boxes made one, in an order of their own.
fn merged(clusters: &[Cluster]) -> Vec<Cluster> {
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

fn slices(paint: &Paint) -> impl Iterator<Item = &SliceStatistics> {
    paint.flakes.as_ref().unwrap().levels.iter().flat_map(|l| &l.slices)
}

fn assert_same_distribution(a: &Paint, b: &Paint) {
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
    }
}

fn assert_same_smooth_part(a: &Paint, b: &Paint) {
    assert_eq!(a.coat, b.coat);
    assert_eq!(a.diffuse.to_bits(), b.diffuse.to_bits());
    assert_eq!(a.colors, b.colors);
}

#[test]
fn a_weight_of_one_gives_back_the_paint() {
    let paints = [paint(1, 50), paint(3, 37), paint(5, 20)];
    for set in [vec![&paints[0], &paints[1]], paints.iter().collect()] {
        let mix = mix(&set);
        for (k, end) in set.iter().enumerate() {
            let weights: Vec<f64> = (0..set.len()).map(|j| f64::from(u8::from(j == k))).collect();
            let back = mix.blend(&weights).unwrap();
            assert_same_distribution(&back, end);
            assert_same_smooth_part(&back, end);
            assert_eq!(back.lobes, end.lobes);
        }
    }
}

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
}

#[test]
fn a_paint_mixed_with_itself_is_itself_at_every_weight() {
    let a = paint(4, 50);
    let mix = mix(&[&a, &a]);
    for percent in -50..=150 {
        let w = f64::from(percent) / 100.0;
        let back = mix.blend(&[1.0 - w, w]).unwrap();
        assert_same_distribution(&back, &a);
        assert_same_smooth_part(&back, &a);
        assert_eq!(back.lobes, a.lobes);
    }
}

/// The drawn color of the texel with random numbers (u, r): Lab.
fn texel(s: &SliceStatistics, u: f64, r: [f64; 3]) -> DVec3 {
    let mut sum = 0.0;
    let cluster = s.clusters.iter().find(|c| {
        sum += c.probability;
        u < sum
    });
    let c = cluster.or(s.clusters.last()).unwrap();
    DVec3::from(std::array::from_fn(|k| f64::from(c.min[k]) + r[k] * f64::from(c.max[k] - c.min[k])))
}

#[test]
fn every_texel_moves_continuously_with_the_weights() {
    let (a, b) = (paint(1, 50), paint(3, 50));
    let mix = mix(&[&a, &b]);
    let mut rng = Pcg64::seed_from_u64(9);
    let texels: Vec<(f64, [f64; 3])> = (0..2000).map(|_| (rng.random(), rng.random())).collect();
    let longest =
        mix.flakes.as_ref().unwrap().levels[0].slices.iter().flat_map(|s| &s.arcs).fold(0.0f64, |d, arc| {
            (0..2).fold(d, |d, end| {
                let [x, y] = [0, 1].map(|p: usize| DVec3::from(arc.boxes[p][end].map(f64::from)));
                d.max((x - y).abs().element_sum())
            })
        });
    let mut largest = 0.0f64;
    let mut before: Option<Vec<DVec3>> = None;
    for percent in -50..=150 {
        let w = f64::from(percent) / 100.0;
        let blend = mix.blend(&[1.0 - w, w]).unwrap();
        let now: Vec<DVec3> =
            slices(&blend).take(6).flat_map(|s| texels.iter().map(|(u, r)| texel(s, *u, *r))).collect();
        if let Some(before) = before {
            let step = before.iter().zip(&now).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            largest = largest.max(step);
        }
        before = Some(now);
    }
    println!("largest step of a texel per 1 % of slider: {largest:.3} Delta-E; longest arc {longest:.1}");
    // One percent of the longest way a corner has to go (its 1-norm bounds the Euclidean one), plus f32 corners near 150.
    assert!(largest <= 0.01 * longest + 1e-4, "{largest} {longest}");
    assert!(largest > 0.0);
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
            let error = (mean_of_boxes(&s.clusters) + offset - wanted).abs().max_element();
            // The offset is stored in f32: half a unit in the last place of an offset of at most a few units.
            assert!(error < 1e-6 * (1.0 + offset.abs().max_element()), "{error}");
        }
    }
}

#[test]
fn extrapolated_paints_stay_legal() {
    let (a, b) = (paint(2, 20), paint(5, 20));
    let mix = mix(&[&a, &b]);
    for w in [-10.0, -0.5, 1.5, 11.0] {
        mix.blend(&[1.0 - w, w]).unwrap().validate().unwrap();
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

#[test]
fn paints_that_cannot_be_coupled_are_refused() {
    let a = paint(1, 3);
    let refuse = |change: &dyn Fn(&mut Paint), word: &str| {
        let mut b = paint(2, 3);
        change(&mut b);
        let named = [("a".to_owned(), &a), ("b".to_owned(), &b)];
        let message = couple(&named, Solver::default(), &|| ()).unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
    };
    refuse(&|p| p.flakes = None, "flakes");
    refuse(&|p| p.coat.refracts = true, "refract");
    refuse(&|p| p.flakes.as_mut().unwrap().grid = AngleGrid::new(4, vec![3, 2, 1]).unwrap(), "grid");
    refuse(&|p| p.flakes.as_mut().unwrap().texel_mm = 0.016, "texel size");
    refuse(&|p| p.flakes.as_mut().unwrap().size = [4, 4], "slice size");
    refuse(&|p| p.flakes.as_mut().unwrap().missing = MissingSlice::Nearest, "missing");
    refuse(&|p| p.colors = ColorTable::white(), "color table size");
    assert!(couple(&[("a".to_owned(), &a)], Solver::default(), &|| ()).is_err());
}

#[test]
fn files_give_back_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let (a, mut b) = (paint(1, 50), paint(2, 7));
    // Masses that f32 cannot hold travel too.
    let clusters = &mut b.flakes.as_mut().unwrap().levels[0].slices[0].clusters;
    clusters[1].probability += clusters[0].probability - 1e-300;
    clusters[0].probability = 1e-300;
    let path = folder.path().join("b.paint.exr");
    b.write(&path).unwrap();
    assert_eq!(Paint::read(&path).unwrap(), b);
    let mut bare = a.clone();
    bare.flakes = None;
    bare.write(&path).unwrap();
    assert_eq!(Paint::read(&path).unwrap(), bare);

    let mix = mix(&[&a, &b]);
    let path = folder.path().join("m.paint.exr");
    mix.write(&path).unwrap();
    assert_eq!(Mix::read(&path).unwrap(), mix);
    let message = Paint::read(&path).unwrap_err().to_string();
    assert!(message.contains("kind of file"), "{message}");
}

#[test]
fn the_plan_does_not_depend_on_the_number_of_threads() {
    let (a, b) = (paint(1, 50), paint(2, 50));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| mix(&[&a, &b])), mix(&[&a, &b]));
}
