//! How far the colors drawn from clusters scatter, without drawing any.
//!
//! Lab is uniform in a box and its axes are independent, so each moment of RGB is an integral over three uniform numbers.
//! X hangs on L and a, Z on L and b: Gauss' rule of three nodes on L, and for each of these one of three nodes on a and b.
//! Where the companding function is cubic the sixth powers leave an error of a 400th of the box's own sixth moment; at the
//! joint to its straight part the second derivative jumps. The deviation of a real slice is met within a thousandth.

use super::Cluster;
use crate::color::{relative_from_lab_f32, rgb_from_relative_f32};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Standard deviation an RGB channel of what clusters give before gain and offset, 1/sr, bands included (`fades` as in
/// [`super::SliceStatistics`], empty for none).
pub fn deviation_of_draws(clusters: &[Cluster], fades: &[f32]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let mut square = DVec3::ZERO;
    let mut last = Moments::default();
    for (k, cluster) in clusters.iter().enumerate() {
        let this = Moments::of(cluster);
        sum += cluster.probability * this.mean;
        square += cluster.probability * this.square;
        if let Some(fade) = k.checked_sub(1).and_then(|b| fades.get(b)).filter(|f| **f > 0.0) {
            square -= f64::from(*fade) * last.lost_in_band(&this);
        }
        last = this;
    }
    (square - sum * sum).max(DVec3::ZERO).map(f64::sqrt)
}

/// First two moments of the colors of one box, 1/sr.
#[derive(Clone, Copy, Default)]
struct Moments {
    mean: DVec3,
    square: DVec3,
}

/// Nodes of Gauss' rule of three on (-1, 1), and their weights.
const NODES: [f32; 3] = [-0.774_596_7, 0.0, 0.774_596_7];
const WEIGHTS: [f32; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

impl Moments {
    fn of(cluster: &Cluster) -> Self {
        let middle: [f32; 3] = [0, 1, 2].map(|c| 0.5 * (cluster.max[c] + cluster.min[c]));
        let half: [f32; 3] = [0, 1, 2].map(|c| 0.5 * (cluster.max[c] - cluster.min[c]));
        let (mut mean, mut square) = ([0.0f32; 3], [0.0f32; 3]);
        for l in 0..3 {
            // Given L, X and Z are independent, and Y is a number.
            let (mut first, mut second) = ([0.0f32; 3], [0.0f32; 3]);
            for n in 0..3 {
                let at = |c: usize, node: f32| middle[c] + half[c] * node;
                let value = relative_from_lab_f32([at(0, NODES[l]), at(1, NODES[n]), at(2, NODES[n])]);
                for c in 0..3 {
                    first[c] += WEIGHTS[n] * value[c];
                    second[c] += WEIGHTS[n] * value[c] * value[c];
                }
            }
            let rgb = rgb_from_relative_f32(first);
            let scatter = |c: usize| (second[c] - first[c] * first[c]).max(0.0).sqrt();
            // The deviations of X and of Z alone, as colors.
            let (x, z) = (
                rgb_from_relative_f32([scatter(0), 0.0, 0.0]),
                rgb_from_relative_f32([0.0, 0.0, scatter(2)]),
            );
            for c in 0..3 {
                mean[c] += WEIGHTS[l] * rgb[c];
                square[c] += WEIGHTS[l] * (rgb[c] * rgb[c] + x[c] * x[c] + z[c] * z[c]);
            }
        }
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        Self { mean: wide(mean) * FRAC_1_PI, square: wide(square) * (FRAC_1_PI * FRAC_1_PI) }
    }

    fn deviation(&self) -> DVec3 {
        (self.square - self.mean * self.mean).max(DVec3::ZERO).map(f64::sqrt)
    }

    /// What a band of half-width 1 takes from the second moment: twice `(X^2 + Y^2) / 2 - (X^2 + X Y + Y^2) / 3`, means over
    /// the band. Both colors are drawn with the same random numbers, so they go together: E XY = E X E Y + std X std Y.
    fn lost_in_band(&self, next: &Self) -> DVec3 {
        let product = self.mean * next.mean + self.deviation() * next.deviation();
        (self.square + next.square - 2.0 * product) / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn points_do_not_scatter() {
        let point = Cluster { probability: 1.0, min: [40.0, 1.0, 2.0], max: [40.0, 1.0, 2.0] };
        // f32 squares of a reflectance of 0.1.
        assert!(deviation_of_draws(&[point], &[]).max_element() < 1e-4);
    }
}
