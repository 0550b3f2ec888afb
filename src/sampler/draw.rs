//! From a cluster to a color. Twin of the shader function of the same name: f32, sums and products only.

use super::Sampler;
use crate::cluster::{Cluster, SliceStatistics};
use crate::color::rgb_from_lab_f32;
use std::f32::consts::FRAC_1_PI;

/// The point of a box at `random`, three numbers in (0, 1): signed Lab of `pi f`.
#[inline]
pub fn lab_in_box(cluster: &Cluster, random: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|axis| cluster.min[axis] + (cluster.max[axis] - cluster.min[axis]) * random[axis])
}

/// The color drawn by u (which cluster) and `random` (where in its box), all in (0, 1): linear Rec.709, 1/sr, gain and
/// offset included. `sampler` is one of these statistics, which were not left out.
#[inline]
pub fn color(statistics: &SliceStatistics, sampler: &Sampler, u: f32, random: [f32; 3]) -> [f32; 3] {
    let cluster = &statistics.clusters[sampler.lookup(u)];
    let reflectance = rgb_from_lab_f32(lab_in_box(cluster, random));
    [0, 1, 2].map(|c| reflectance[c] * FRAC_1_PI * statistics.gain[c] + statistics.offset[c])
}
