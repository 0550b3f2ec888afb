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
///
/// Bands between clusters need to know how far u is from a cluster's end: an inverse CDF in steps does not, and draws
/// without them.
#[inline]
pub fn color(statistics: &SliceStatistics, sampler: &Sampler, u: f32, random: [f32; 3]) -> [f32; 3] {
    let k = sampler.lookup(u);
    let mut reflectance = rgb_from_lab_f32(lab_in_box(&statistics.clusters[k], random));
    if !statistics.fades.is_empty()
        && let Some((other, share)) = band(&statistics.fades, sampler, k, u)
    {
        let beyond = rgb_from_lab_f32(lab_in_box(&statistics.clusters[other], random));
        reflectance = [0, 1, 2].map(|c| reflectance[c] + share * (beyond[c] - reflectance[c]));
    }
    [0, 1, 2].map(|c| reflectance[c] * FRAC_1_PI * statistics.gain[c] + statistics.offset[c])
}

/// The cluster whose band with cluster `k` holds u, and its share in the color: a half at the end of `k`, 0 at the edge of
/// the band.
#[inline]
fn band(fades: &[f32], sampler: &Sampler, k: usize, u: f32) -> Option<(usize, f32)> {
    let Sampler::Exact(table) = sampler else { return None };
    let cumulative = table.cumulative();
    let (above, upper) = (cumulative[k] - u, fades[k]);
    if above < upper && k + 1 < fades.len() {
        return Some((k + 1, 0.5 - 0.5 * above / upper));
    }
    let below = k.checked_sub(1)?;
    let (depth, lower) = (u - cumulative[below], fades[below]);
    (depth < lower).then(|| (below, 0.5 - 0.5 * depth / lower))
}
