//! Blends far beyond their paints, of paints without light, by distances of any size.

use super::extended::{Big, absolute, big, squared};
use super::{HardCase, larger, worst};
use crate::Paint;
use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::btf::AngleGrid;
use crate::cluster::{BoxRule, Cluster, SliceStatistics, cluster_slice, mean_of_boxes};
use crate::error::Result;
use crate::mix::{CoupleOptions, Mix, MixSlice, Path, couple, distance_weights};
use crate::paint::{FlakeLevel, Flakes, MissingSlice};
use glam::DVec3;
use serde_json::Value;

/// Weights of two paints that go past either, and one in between.
const WEIGHTS: [[f64; 2]; 4] = [[10.0, -9.0], [-9.0, 10.0], [-10.0, 11.0], [0.5, 0.5]];

pub(super) fn cases() -> Result<Vec<HardCase>> {
    Ok(vec![far_means()?, far_roughness()?, all_black()?, distances()?])
}

/// A paint of one slice of one texel.
fn paint(slice: SliceStatistics, roughness: f64) -> Result<Paint> {
    Ok(Paint {
        coat: ClearCoat::NONE,
        diffuse: 0.0,
        lobes: vec![Lobe { coefficient: 0.2, roughness, f0: 0.3 }],
        colors: ColorTable::white(),
        flakes: Some(Flakes {
            grid: AngleGrid::triangle(1)?,
            missing: MissingSlice::Zero,
            size: [1, 1],
            texel_mm: 0.02,
            levels: vec![FlakeLevel { pitch_mm: 0.02, slices: vec![slice] }],
            inverse_cdf_steps: 100,
            knots: None,
        }),
        provenance: Value::Null,
    })
}

/// A blue paint with few bright flakes, and a brown one with many.
fn mix(path: Path) -> Result<Mix> {
    let slice = |body: [f32; 3], flake: [f32; 3], every: usize| {
        let texel = |k: usize| {
            let scale = 1.0 + 0.3 * (k % 7) as f32;
            if k.is_multiple_of(every) { flake } else { body }.map(|c| scale * c)
        };
        cluster_slice(&(0..4096).map(texel).collect::<Vec<_>>(), 12, BoxRule::default())
    };
    let blue = paint(slice([0.01, 0.03, 0.2], [1.0, 1.5, 4.0], 40)?, 0.1)?;
    let brown = paint(slice([0.1, 0.05, 0.02], [0.5, 0.3, 0.2], 5)?, 0.3)?;
    let options = CoupleOptions { path, ..CoupleOptions::default() };
    Ok(couple(&[("blue".into(), &blue), ("brown".into(), &brown)], &options, &|| ())?.0)
}

/// The finest slices of a mix; these mixes have one.
fn slices(mix: &Mix) -> impl Iterator<Item = &MixSlice> {
    mix.flakes.iter().flat_map(|f| &f.levels).flat_map(|level| &level.slices)
}

/// The mean that is due at these weights, and its size without cancellation.
fn due(slice: &MixSlice, weights: &[f64; 2]) -> (DVec3, f64) {
    let parts = [0, 1].map(|k| weights[k] * slice.means[k]);
    (parts[0] + parts[1], parts[0].length() + parts[1].length())
}

fn far_means() -> Result<HardCase> {
    let (mut stable, mut naive) = (Vec::new(), Vec::new());
    for path in [Path::default(), Path::Transport] {
        let mix = mix(path)?;
        for weights in &WEIGHTS {
            let blend = mix.blend(weights)?;
            let drawn = blend.flakes.iter().flat_map(|f| &f.levels).flat_map(|level| &level.slices);
            for (slice, drawn) in slices(&mix).zip(drawn) {
                let (mean, scale) = due(slice, weights);
                drawn.validate()?;
                stable.push((drawn.mean_rgb() - mean).length() / scale);
                naive.push((mean_of_boxes(&moved(slice, weights)) - mean).length() / scale);
            }
        }
    }
    Ok(HardCase {
        name: "the mean of a blend at weights of +-10",
        formula: "B_ij(t) = sum w_k B_k",
        source: "Golla & Klein 2018, eqs 14, 15; mix::Mix::blend",
        arguments: "two paints at (10, -9), (-9, 10), (-10, 11), (0.5, 0.5)",
        measure: "mean of the slice beside the blend of the means, relative",
        naive: worst(naive, |e| e),
        stable: worst(stable, |e| e),
        bar: 1e-5,
        why: "the offset is an f32, and boxes at these weights are up to 100 times as bright as the means",
        worse: 1e3,
    })
}

/// The boxes, moved as the paper says, without an offset.
fn moved(slice: &MixSlice, weights: &[f64; 2]) -> Vec<Cluster> {
    let corner = |arc: usize, end: usize| {
        [0, 1, 2].map(|axis| {
            let at = |k: usize| weights[k] * f64::from(slice.boxes[k][arc][end][axis]);
            (at(0) + at(1)) as f32
        })
    };
    let probabilities = slice.probabilities.iter().enumerate();
    probabilities
        .map(|(arc, p)| Cluster { probability: *p, min: corner(arc, 0), max: corner(arc, 1) })
        .collect()
}

fn far_roughness() -> Result<HardCase> {
    let mix = mix(Path::default())?;
    // How far below the smallest legal roughness.
    let below = |roughness: f64| (1e-4 - roughness).max(0.0);
    let mut stable = Vec::new();
    for weights in &WEIGHTS {
        let blend = mix.blend(weights)?;
        blend.validate()?;
        stable.extend(blend.lobes.iter().map(|lobe| below(lobe.roughness)));
    }
    let ends: Vec<f64> = mix.constituents.iter().flat_map(|c| &c.lobes).map(|lobe| lobe.roughness).collect();
    Ok(HardCase {
        name: "roughness at weights of +-10",
        formula: "alpha = sum w_k alpha_k",
        source: "Golla & Klein 2018, section 4.2; mix::LobePath",
        arguments: "alpha 0.1 and 0.3 at the same weights",
        measure: "below the smallest legal roughness by",
        naive: worst(WEIGHTS, |w| below(w.iter().zip(&ends).map(|(w, a)| w * a).sum())),
        stable: worst(stable, |e| e),
        bar: 0.0,
        why: "a geometric mean is above 0 at any weights",
        worse: 1.0,
    })
}

fn all_black() -> Result<HardCase> {
    let black = paint(cluster_slice(&[[0.0; 3]; 64], 50, BoxRule::default())?, 0.2)?;
    let pair = [("black".to_owned(), &black), ("as black".to_owned(), &black)];
    let (mix, report) = couple(&pair, &CoupleOptions::default(), &|| ())?;
    let mut stable = vec![report.worst_relative_gap.abs(), report.worst_row_error, report.worst_column_error];
    for weights in &WEIGHTS {
        let blend = mix.blend(weights)?;
        blend.validate()?;
        let drawn = blend.flakes.iter().flat_map(|f| &f.levels).flat_map(|level| &level.slices);
        stable.extend(drawn.map(|slice| slice.mean_rgb().length()));
    }
    Ok(HardCase {
        name: "paints without any light",
        formula: "gap / cost, gain = sigma / sigma_0",
        source: "Golla & Klein 2018, sections 4.1, 4.2; mix::couple, mix::Mix::blend",
        arguments: "slices of nothing but 0, coupled, at the same weights",
        measure: "gap, masses, mean of blends: absolute",
        naive: worst([report.mean_distance], |cost| (0.0 / cost).abs()),
        stable: worst(stable, |e| e),
        bar: 0.0,
        why: "nothing is moved, nothing is drawn",
        worse: 1.0,
    })
}

/// Weights that are due; at no distance, all of it.
fn shares(distances: &[f64; 3]) -> [Big; 3] {
    let at_once = distances.contains(&0.0);
    let share = |d: f64| if at_once { big(u8::from(d == 0.0)) } else { big(1.0) / squared(&big(d)) };
    let each = distances.map(share);
    let sum = each.iter().fold(big(0.0), |sum, share| sum + share);
    each.map(|share| share / &sum)
}

fn distances() -> Result<HardCase> {
    let all: [[f64; 3]; 4] =
        [[0.0, 1.0, 2.0], [1e-200, 2e-200, 1.0], [1e200, 2e200, 1e300], [1.0, 1.0, 1e-320]];
    let mut stable = Vec::new();
    for distances in &all {
        let weights = distance_weights(distances)?;
        stable.extend(weights.iter().zip(shares(distances)).map(|(w, due)| absolute(*w, &due)));
    }
    let naive = |distances: [f64; 3]| {
        let each = distances.map(|d| 1.0 / (d * d));
        let weights = each.map(|share| share / each.iter().sum::<f64>());
        let errors = weights.into_iter().zip(shares(&distances)).map(|(w, due)| absolute(w, &due));
        errors.fold(0.0, larger)
    };
    Ok(HardCase {
        name: "weights of paints at next to no distance",
        formula: "w_k = d_k^-2 / sum d^-2",
        source: "Shepard 1968; Golla & Klein 2018, Fig. 7; mix::distance_weights",
        arguments: "distances from 0 to 1e300; f64",
        measure: "absolute",
        naive: worst(all, naive),
        stable: worst(stable, |e| e),
        bar: 4.0 * f64::EPSILON,
        why: "three quotients and two sums",
        worse: 1e3,
    })
}
