//! Slices of a flake BTF that have nothing to measure: one color, one texel, one bin, no light, or one texel that outshines all.

use super::extended::{Big, big, pi, relative};
use super::{HardCase, Outcome, decades, larger, pairs, worst};
use crate::btf::AngleGrid;
use crate::cluster::{BoxRule, Cluster, SliceStatistics, cluster_levels, cluster_slice, mean_of_boxes};
use crate::color::luminance;
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

pub(super) fn cases() -> Result<Vec<HardCase>> {
    Ok(vec![one_color()?, flat_box(), one_texel()?, one_bin()?, outlier()?])
}

/// How far the mean of everything drawn is from a color, relative to its length, or to 1 for black.
fn off_mean(statistics: &SliceStatistics, color: DVec3) -> f64 {
    let scale = if color == DVec3::ZERO { 1.0 } else { color.length() };
    (statistics.mean_rgb() - color).length() / scale
}

/// Black, gray, tinted, HDR, and a residual below zero.
const COLORS: [[f32; 3]; 6] =
    [[0.0; 3], [0.1; 3], [0.3, 0.2, 0.1], [1.7, 0.3, 0.9], [1e5, 2e4, 3e3], [-0.02, -0.1, 0.03]];

fn of(color: [f32; 3]) -> DVec3 {
    DVec3::from(color.map(f64::from))
}

fn one_color() -> Result<HardCase> {
    let widest = |statistics: &SliceStatistics| {
        let sides = statistics.clusters.iter().flat_map(|c| [0, 1, 2].map(|k| c.max[k] - c.min[k]));
        sides.fold(0.0, |most, side| larger(most, side.abs().into()))
    };
    let mut stable = Vec::new();
    for (color, rule) in pairs(&COLORS, &[BoxRule::MomentMatched, BoxRule::Bounding]) {
        let statistics = cluster_slice(&[color; 1000], 50, rule)?;
        stable.push(larger(widest(&statistics), off_mean(&statistics, of(color))));
    }
    let naive = |[x, ..]: [f32; 3]| {
        let n = 1000.0;
        let (sum, square) = (0..1000).fold((0.0f32, 0.0f32), |(sum, square), _| (sum + x, square + x * x));
        f64::from((square / n - (sum / n) * (sum / n)).sqrt())
    };
    Ok(HardCase {
        name: "a slice of one color",
        formula: "sigma = sqrt(<x^2> - <x>^2)",
        source: "Golla & Klein 2018, section 3.2; cluster::cluster_slice",
        arguments: "1000 equal texels, 6 colors, both box rules; f32",
        measure: "sides of boxes, Delta-E; mean, relative",
        naive: worst(COLORS, naive),
        stable: worst(stable, |e| e),
        bar: f64::from(f32::EPSILON),
        why: "moments are integers; the offset is an f32",
        worse: 1e3,
    })
}

fn flat_box() -> HardCase {
    let sides = [vec![0.0], decades(-6..=0)].concat();
    // f32 corners, so that truth sees the same box.
    let all: Vec<(f32, f32)> = pairs(&[10.0, 50.0, 400.0], &sides)
        .into_iter()
        .map(|(l, side): (f64, f64)| (l as f32, (l + side) as f32))
        .collect();
    let root = |l: f32| (big(l) + big(16.0)) / big(116.0);
    // Mean of a cube between two ends: (a^2 + b^2) (a + b) / 4.
    let truth = |(low, high): (f32, f32)| -> Big {
        let (a, b) = (root(low), root(high));
        (&a * &a + &b * &b) * (&a + &b) / big(4.0) / pi()
    };
    let naive = |(low, high): (f32, f32)| {
        let fourth = |l: f32| ((f64::from(l) + 16.0) / 116.0).powi(4) * 116.0 / 4.0;
        (fourth(high) - fourth(low)) / (f64::from(high) - f64::from(low)) * std::f64::consts::FRAC_1_PI
    };
    let stable = |(low, high): (f32, f32)| {
        let cluster = Cluster { probability: 1.0, min: [low, 0.0, 0.0], max: [high, 0.0, 0.0] };
        luminance(mean_of_boxes(&[cluster]))
    };
    HardCase {
        name: "the mean of a box without width",
        formula: "(F(L_1) - F(L_0)) / (L_1 - L_0), F' = Y",
        source: "Golla & Klein 2018, section 3.2; cluster::mean_of_boxes",
        arguments: "gray boxes at L* 10, 50, 400, sides from 0 to 1; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |c| relative(stable(c), &truth(c))),
        bar: 32.0 * f64::EPSILON,
        why: "a cube, and two matrices that undo each other with entries of up to 3",
        worse: 1e3,
    }
}

fn one_texel() -> Result<HardCase> {
    let mut stable = Vec::new();
    for color in COLORS {
        let levels = cluster_levels(1, |_| Ok(vec![color]), [1, 1], 50, BoxRule::default(), &|| ())?;
        let [level] = levels.as_slice() else { continue };
        stable.push(larger(off_mean(&level.slices[0], of(color)), (level.pitch_texels - 1.0).abs()));
    }
    let naive = |color: [f32; 3]| {
        let texels = [f64::from(color[0])];
        let n = texels.len() as f64;
        let mean = texels.iter().sum::<f64>() / n;
        (texels.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
    };
    Ok(HardCase {
        name: "a slice of one texel",
        formula: "sigma^2 = sum (x - <x>)^2 / (n - 1)",
        source: "Rump et al. 2008, section 6, the last level; cluster::cluster_levels",
        arguments: "6 colors",
        measure: "mean, relative; lattice of 1 texel, off by",
        naive: worst(COLORS, naive),
        // Six answers, or none.
        stable: if stable.len() == COLORS.len() { worst(stable, |e| e) } else { Outcome::Fails("levels") },
        bar: f64::from(f32::EPSILON),
        why: "the offset is an f32",
        worse: 1e3,
    })
}

fn one_bin() -> Result<HardCase> {
    let grid = AngleGrid::triangle(1)?;
    let angles = [0.0, 1e-9, 0.3, 1.0, FRAC_PI_2];
    // Slices are there at 0 alone: a bilinear weight, which fades to nothing at 90 degrees.
    let stable = |(h, i): (f64, f64)| {
        let taps = grid.taps(h as f32, i as f32);
        let held: f64 = taps.iter().filter(|tap| tap.0.is_some()).map(|tap| f64::from(tap.1)).sum();
        let all: f64 = taps.iter().map(|tap| f64::from(tap.1)).sum();
        let due = (1.0 - h / FRAC_PI_2) * (1.0 - i / FRAC_PI_2);
        [held - due, all - 1.0, grid.angles(0).0].into_iter().fold(0.0, |most, e| larger(most, e.abs()))
    };
    // The angle of the only slice.
    let naive = |bins: usize| (0.0 * FRAC_PI_2 / (bins - 1) as f64).abs();
    Ok(HardCase {
        name: "an angle grid of one bin",
        formula: "theta_k = k (pi / 2) / (n - 1)",
        source: "Golla & Klein 2018, section 3.1; btf::AngleGrid",
        arguments: "theta_h, theta_i from 0 to 90 degrees; f32",
        measure: "weights of slices, absolute",
        naive: worst([grid.bins()], naive),
        stable: worst(pairs(&angles, &angles), stable),
        bar: 4.0 * f64::from(f32::EPSILON),
        why: "angles are f32, weights products of two differences from 1",
        worse: 1e3,
    })
}

fn outlier() -> Result<HardCase> {
    let n = 1 << 17;
    let mut stable = Vec::new();
    let mut naive = Vec::new();
    for glint in [1e3f32, 1e5, 1e7] {
        let mut texels = vec![[1e-3f32; 3]; n];
        texels[0] = [glint; 3];
        // A mean that the running sum in f32 cannot hold.
        let truth = (big(glint) + big((n - 1) as f64) * big(1e-3f32)) / big(n as f64);
        let sum: f32 = texels.iter().map(|t| t[0]).sum();
        naive.push(relative(sum / n as f32, &truth));
        for rule in [BoxRule::MomentMatched, BoxRule::Bounding] {
            stable.push(relative(cluster_slice(&texels, 50, rule)?.mean_rgb().x, &truth));
        }
    }
    Ok(HardCase {
        name: "a glint of HDR in a dark slice",
        formula: "<x> = sum x / n",
        source: "Golla & Klein 2018, section 3.2; cluster::cluster_slice",
        arguments: "131,071 texels of 1e-3 and one of 1e3, 1e5, 1e7; f32",
        measure: "mean, relative",
        naive: worst(naive, |e| e),
        stable: worst(stable, |e| e),
        bar: 4.0 * f64::from(f32::EPSILON),
        why: "the offset, which brings boxes to the mean, is an f32",
        worse: 1e2,
    })
}
