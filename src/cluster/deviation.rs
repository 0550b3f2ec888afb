//! How far the colors drawn from clusters scatter, without drawing any.
//!
//! Lab is uniform in a box and its axes are independent, so each moment of RGB is an integral over three uniform numbers.
//! Given L, X hangs on a and Z on b alone, with moments in closed form on either side of the joint of the companding
//! function, and by Gauss' rule of three nodes across it; over L goes the same rule. The deviation of a real slice is met
//! within a thousandth.

use super::Cluster;
use super::bands::arcs;
use crate::color::{WHITE_XYZ, rgb_from_xyz};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

const DELTA: f64 = 6.0 / 29.0;
const ZERO: f64 = 4.0 / 29.0;
/// Slope of the inverse companding function on its straight part, and where that ends.
const SLOPE: f64 = 3.0 * DELTA * DELTA;
const JOINT: f64 = DELTA - ZERO;

/// Standard deviation an RGB channel of what clusters give before gain and offset, 1/sr, bands included (`fades` as in
/// [`super::SliceStatistics`], empty for none).
pub fn deviation_of_draws(clusters: &[Cluster], fades: &[f32]) -> DVec3 {
    let moments: Vec<Moments> = clusters.iter().map(Moments::of).collect();
    let mean: DVec3 = clusters.iter().zip(&moments).map(|(c, m)| c.probability * m.mean).sum();
    // About the mean: a slice that hardly scatters would be left with the rounding of two equal squares.
    let about = |m: &Moments| m.variance + (m.mean - mean) * (m.mean - mean);
    let boxes: DVec3 = clusters.iter().zip(&moments).map(|(c, m)| c.probability * about(m)).sum();
    let mut lost = DVec3::ZERO;
    for arc in arcs(clusters, fades) {
        arc.overlaps(clusters, |j, l, overlap| lost += overlap * moments[j].square_distance(&moments[l]));
    }
    (boxes - lost).max(DVec3::ZERO).map(f64::sqrt)
}

/// Mean, 1/sr, and variance of the colors of one box.
#[derive(Clone, Copy)]
struct Moments {
    mean: DVec3,
    variance: DVec3,
}

/// Nodes of Gauss' rule of three on (-1, 1), and their weights.
const RULE: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483_4, 5.0 / 18.0)];

impl Moments {
    fn of(cluster: &Cluster) -> Self {
        let half = |axis: usize| 0.5 * (f64::from(cluster.max[axis]) - f64::from(cluster.min[axis]));
        let middle = |axis: usize| 0.5 * (f64::from(cluster.max[axis]) + f64::from(cluster.min[axis]));
        // X and Z alone, as colors.
        let (of_x, of_z) = (rgb_from_xyz(DVec3::X * WHITE_XYZ), rgb_from_xyz(DVec3::Z * WHITE_XYZ));
        let at_nodes = RULE.map(|(node, weight)| {
            let y = (middle(0) + half(0) * node) / 116.0;
            let (x, x_variance) = spread(y + middle(1) / 500.0, half(1) / 500.0);
            let (z, z_variance) = spread(y - middle(2) / 200.0, half(2) / 200.0);
            let rgb = rgb_from_xyz(DVec3::new(x, expand(y), z) * WHITE_XYZ);
            (weight, rgb, of_x * of_x * x_variance + of_z * of_z * z_variance)
        });
        let mean: DVec3 = at_nodes.iter().map(|(weight, rgb, _)| *weight * *rgb).sum();
        let variance =
            at_nodes.iter().map(|(weight, rgb, rest)| *weight * ((*rgb - mean) * (*rgb - mean) + *rest));
        Self { mean: mean * FRAC_1_PI, variance: variance.sum::<DVec3>() * (FRAC_1_PI * FRAC_1_PI) }
    }

    /// Mean square of the difference of two colors drawn with the same random numbers, so that they go together:
    /// E XY = E X E Y + std X std Y. A texel of shares s and 1 - s of both has s (1 - s) of it less than the mean of
    /// their squares.
    fn square_distance(&self, other: &Self) -> DVec3 {
        let mean = self.mean - other.mean;
        let deviation = self.variance.map(f64::sqrt) - other.variance.map(f64::sqrt);
        mean * mean + deviation * deviation
    }
}

/// The inverse companding function, its argument counted from its center 4/29.
fn expand(f: f64) -> f64 {
    let above = f.abs();
    let root = above + ZERO;
    let x = if above > JOINT { root * root * root } else { above * SLOPE };
    x.copysign(f)
}

/// Mean and variance of [`expand`] at `mean` + U(-half, half).
fn spread(mean: f64, half: f64) -> (f64, f64) {
    let (reach, square) = (half.abs(), half * half);
    if mean.abs() - reach >= JOINT {
        // Moments of a cube: E xi^2 = h^2 / 3, E xi^4 = h^4 / 5, E xi^6 = h^6 / 7.
        let root = mean.abs() + ZERO;
        let power = root * root;
        let variance = square * (3.0 * power * power + square * (2.0 * power + square / 7.0));
        return ((root * (power + square)).copysign(mean), variance);
    }
    if mean.abs() + reach <= JOINT {
        return (SLOPE * mean, SLOPE * SLOPE * square / 3.0);
    }
    let values = RULE.map(|(node, weight)| (expand(mean + half * node), weight));
    let first: f64 = values.iter().map(|(x, w)| w * x).sum();
    (first, values.iter().map(|(x, w)| w * (x - first) * (x - first)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn points_do_not_scatter() {
        let point = Cluster { probability: 1.0, min: [40.0, 1.0, 2.0], max: [40.0, 1.0, 2.0] };
        // The rounding of a sum of three equal colors of 0.1.
        assert!(deviation_of_draws(&[point], &[]).max_element() < 1e-15);
    }
}
