//! Samplers: what each promises, and that all of them draw the same distribution up to that.

use super::slices;
use carpaint::cluster::{BoxRule, cluster_slice};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::sampler::{ForwardCdf, InverseCdf, QuantileRow, Sampler};
use glam::DVec3;
use proptest::prelude::*;

/// Probabilities of the draws, from the middles of 2^18 parts of (0, 1).
fn drawn(clusters: usize, lookup: impl Fn(f32) -> usize) -> Vec<f64> {
    const PARTS: u32 = 1 << 18;
    let mut out = vec![0.0; clusters];
    for k in 0..PARTS {
        out[lookup((k as f32 + 0.5) / PARTS as f32)] += 1.0 / f64::from(PARTS);
    }
    out
}

fn total_variation(p: &[f64], q: &[f64]) -> f64 {
    0.5 * p.iter().zip(q).map(|(p, q)| (p - q).abs()).sum::<f64>()
}

#[test]
fn all_samplers_draw_the_same_distribution() {
    for flakes in slices::ALL {
        let statistics = cluster_slice(&slices::slice(flakes, 60, 2), 50, BoxRule::MomentMatched).unwrap();
        let p: Vec<f64> = statistics.clusters.iter().map(|c| c.probability).collect();
        let forward = ForwardCdf::new(&p).unwrap();
        let inverse = InverseCdf::new(&p, 500).unwrap();
        // Parts of 2^-18 that a threshold cuts count for one side; 50 thresholds.
        let rounding = 50.0 / f64::from(1 << 18);
        let stated = [0.0, forward.total_variation(), inverse.total_variation()];
        let samplers = [
            Sampler::exact(&statistics).unwrap(),
            Sampler::ForwardCdf(forward),
            Sampler::InverseCdf(inverse),
        ];
        for (sampler, stated) in samplers.iter().zip(stated) {
            let found = total_variation(&p, &drawn(p.len(), |u| sampler.lookup(u)));
            assert!((found - stated).abs() <= rounding, "{} {found} {stated}", flakes.name);
        }
        assert!(stated[1] <= 0.5 * 50.0 / 65_536.0);
        // Two bytes a cluster against four and a guide of two a cluster or more.
        assert_eq!(samplers[1].bytes(), 2 * p.len());
        assert!(samplers[0].bytes() >= 3 * samplers[1].bytes() && samplers[2].bytes() == 1000);
    }
}

proptest! {
    #[test]
    fn the_forward_row_rounds_to_its_steps(
        weights in prop::collection::vec(prop_oneof![Just(0.0), 1e-9..1.0f64], 1..200),
    ) {
        prop_assume!(weights.iter().any(|w| *w > 0.0));
        let total: f64 = weights.iter().sum();
        let row = ForwardCdf::new(&weights).unwrap();
        prop_assert!(row.starts().is_sorted() && row.starts()[0] == 0);
        // Every step's middle, so that the counts are exact.
        let mut counts = vec![0usize; weights.len()];
        for step in 0..ForwardCdf::STEPS {
            counts[row.lookup((step as f32 + 0.5) / ForwardCdf::STEPS as f32)] += 1;
        }
        for (k, w) in weights.iter().enumerate() {
            let share = w / total * ForwardCdf::STEPS as f64;
            prop_assert!((counts[k] as f64 - share).abs() <= 1.0 + 1e-6, "{} {}", counts[k], share);
            prop_assert_eq!(counts[k] == 0 && *w > 0.0, row.lost().contains(&k));
            prop_assert!(share < 0.5 || counts[k] > 0);
        }
        let p: Vec<f64> = weights.iter().map(|w| w / total).collect();
        let q: Vec<f64> = counts.iter().map(|n| *n as f64 / ForwardCdf::STEPS as f64).collect();
        prop_assert!((total_variation(&p, &q) - row.total_variation()).abs() < 1e-9);
        for edge in [-1.0, 0.0, 1.0, f32::NAN] {
            prop_assert!(row.lookup(edge) < weights.len());
        }
    }
}

#[test]
fn long_hostile_rows() {
    // All shares round up (too many steps), all round down (too few), and a giant among dwarfs.
    for (n, steps) in [(65_535, 40_000), (65_535, 30_000), (40_000, 65_535), (65_535, 3)] {
        let mut weights = vec![1.0; n];
        for giant in [1.0, 1e5] {
            weights[n / 2] = giant;
            let table = InverseCdf::new(&weights, steps).unwrap();
            assert_eq!(table.steps().len(), steps);
            assert!(table.steps().is_sorted());
            assert!(ForwardCdf::new(&weights).unwrap().starts().is_sorted());
        }
    }
}

/// Mean and standard deviation of the luminance-like sum of channels.
fn mean_and_std(colors: &[[f32; 3]]) -> (DVec3, f64) {
    let n = colors.len() as f64;
    let wide = |c: &[f32; 3]| DVec3::from_array(c.map(f64::from));
    let mean = colors.iter().map(wide).sum::<DVec3>() / n;
    let variance = colors.iter().map(|c| (wide(c) - mean).element_sum().powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

#[test]
fn rows_of_colors_keep_the_mean() {
    for flakes in slices::ALL {
        let texels = slices::slice(flakes, slices::SIDE, 3);
        let mut statistics = cluster_slice(&texels, 50, BoxRule::MomentMatched).unwrap();
        statistics.gain = [0.5, 1.0, 2.0];
        let (_, std) = mean_and_std(
            &texels.iter().map(|t| [0, 1, 2].map(|c| t[c] * statistics.gain[c])).collect::<Vec<_>>(),
        );
        for steps in [1, 100, 1000] {
            let expected = QuantileRow::expected(&statistics, steps).unwrap();
            let realized = QuantileRow::realized(&statistics, steps, 7).unwrap();
            for row in [&expected, &realized] {
                assert_eq!(row.colors().len(), steps);
                let colors: Vec<[f32; 3]> =
                    (0..steps).map(|k| row.lookup((k as f32 + 0.5) / steps as f32)).collect();
                let (mean, spread) = mean_and_std(&colors);
                // A half float is good to 2^-11 of the colors, and these are of the size of their spread.
                let tolerance = (std + statistics.mean_rgb().length()) / 2048.0;
                assert!(
                    (mean - statistics.mean_rgb()).abs().max_element() <= tolerance,
                    "{} {steps}",
                    flakes.name
                );
                if std::ptr::eq(row, &expected) {
                    // Means over parts of a distribution never spread wider than it does.
                    assert!(spread <= 1.01 * std, "{} {steps}: {spread} {std}", flakes.name);
                }
                for edge in [-1.0, 0.0, 1.0, f32::NAN] {
                    assert!(row.lookup(edge).iter().all(|c| c.is_finite()));
                }
            }
        }
    }
    let one = cluster_slice(&[[1.0; 3]], 1, BoxRule::MomentMatched).unwrap();
    assert!(QuantileRow::expected(&one, 0).is_err() && QuantileRow::realized(&one, 65_536, 1).is_err());
    let none = carpaint::cluster::SliceStatistics::left_out();
    assert!(QuantileRow::expected(&none, 5).is_err() && QuantileRow::realized(&none, 5, 1).is_err());
}

#[test]
fn samplers_agree_where_nothing_is_rare() {
    // Sixteen equal clusters: every table holds them exactly, so that the same u finds the same cluster everywhere.
    let p = vec![1.0 / 16.0; 16];
    let (forward, inverse) = (ForwardCdf::new(&p).unwrap(), InverseCdf::new(&p, 512).unwrap());
    for k in 0..1000 {
        let u = unit(pcg4d([k, 1, 1, 1])[0]);
        assert_eq!(forward.lookup(u), (u * 16.0) as usize);
        assert_eq!(inverse.lookup(u), (u * 16.0) as usize);
    }
}
