//! From a cluster to a color. Twin of the shader function of the same name: f32, sums and products only.

use super::{GuideTable, Sampler};
use crate::cluster::{Cluster, Ramp, SliceStatistics};
use crate::color::rgb_from_lab_f32;
use std::f32::consts::FRAC_1_PI;

/// The point of a box at `random`, three numbers in (0, 1): signed Lab of `pi f`.
#[inline]
pub fn lab_in_box(cluster: &Cluster, random: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|axis| cluster.min[axis] + (cluster.max[axis] - cluster.min[axis]) * random[axis])
}

/// The color drawn by u (which cluster) and `random` (where in its box), all in (0, 1): linear Rec.709, 1/sr, gain and
/// offset included. `sampler` is one of these statistics, which were not left out.
///
/// Bands between clusters need to know how far u is from a cluster's end: only the exact sampler does, the others draw
/// without them.
#[inline]
pub fn color(statistics: &SliceStatistics, sampler: &Sampler, u: f32, random: [f32; 3]) -> [f32; 3] {
    let cluster = |k: usize| rgb_from_lab_f32(lab_in_box(&statistics.clusters[k], random));
    let k = sampler.lookup(u);
    let reflectance = match sampler {
        Sampler::Exact(table, ramps) if !ramps.is_empty() => faded(table, ramps, cluster, k, u),
        _ => cluster(k),
    };
    [0, 1, 2].map(|c| reflectance[c] * FRAC_1_PI * statistics.gain[c] + statistics.offset[c])
}

/// The color at u, in cluster `k`, of the clusters linked to it, each with its share.
#[inline]
fn faded(
    table: &GuideTable,
    ramps: &[Ramp],
    cluster: impl Fn(usize) -> [f32; 3],
    mut k: usize,
    u: f32,
) -> [f32; 3] {
    let behind = |k: usize| ramps[k].share(u - table.cumulative()[k]);
    while k > 0 && ramps[k - 1].slope > 0.0 && behind(k - 1) < 1.0 {
        k -= 1;
    }
    let mut color = cluster(k);
    let mut last = color;
    while ramps[k].slope > 0.0 && behind(k) > 0.0 {
        let (share, next) = (behind(k), cluster(k + 1));
        color = [0, 1, 2].map(|c| color[c] + share * (next[c] - last[c]));
        (last, k) = (next, k + 1);
    }
    color
}
