//! From the texels of a slice to its statistics.

use super::lattice::{Cube, lab_planes};
use super::mean::mean_of_boxes;
use super::moments::Moments;
use super::octree::fine_cells;
use super::reduction::leaves;
use super::{BoxRule, Cluster, SliceStatistics};
use crate::error::{Error, Result};
use glam::DVec3;

/// Number of clusters of a slice unless asked otherwise (Golla & Klein 2018, section 3.2).
pub const DEFAULT_CLUSTERS: usize = 50;
/// Most clusters that can be asked for.
pub const MAX_CLUSTERS: usize = 1024;
/// Fine cells of the octree at most, for the usual number of clusters; half as many cost 0.1 Delta-E.
const FINE_CELLS: usize = 2048;
/// Most texels of a slice.
const MAX_TEXELS: usize = 1 << 24;

/// Statistics of one slice: at most `n` clusters, sorted by lightness.
///
/// `texels`: signed linear Rec.709, 1/sr, in any order; the result depends on which colors occur how often, not on where.
/// Lab is taken of `pi f`. Fewer than `n` clusters come out where there are fewer colors.
///
/// # Errors
/// `n` outside 1-1024; no texels or more than 2^24; a component that is not a number within +-1e12.
pub fn cluster_slice(texels: &[[f32; 3]], n: usize, rule: BoxRule) -> Result<SliceStatistics> {
    if !(1..=MAX_CLUSTERS).contains(&n) {
        return Err(Error::invalid("clusters", "number", n, "1 to 1024"));
    }
    if !(1..=MAX_TEXELS).contains(&texels.len()) {
        return Err(Error::invalid("slice", "texels", texels.len(), "1 to 16777216"));
    }
    let planes = lab_planes(texels)?;
    let cube = Cube::around(&planes);
    let coordinates = [0, 1, 2].map(|axis| cube.coordinates(axis, &planes[axis]));
    // At least eight cells a leaf: one octree level more or less never leaves too few.
    let cells = fine_cells(&coordinates, &cube, FINE_CELLS.max(8 * n));
    let total = texels.len() as f64;
    let mut clusters: Vec<Cluster> =
        leaves(&cells, n).iter().map(|leaf| cluster(leaf, &cube, total, rule)).collect();
    clusters.sort_by(by_lightness);
    let offset = mean_of_texels(texels) - mean_of_boxes(&clusters);
    Ok(SliceStatistics::new(clusters, offset.as_vec3().to_array()))
}

/// A leaf of the octree as a box with its share of the texels.
fn cluster(leaf: &Moments, cube: &Cube, total: f64, rule: BoxRule) -> Cluster {
    let (mean, variance) = (leaf.mean(), leaf.variance());
    let corner = |sign: f64| {
        [0, 1, 2].map(|axis| {
            let coordinate = match rule {
                BoxRule::MomentMatched => mean[axis] + sign * (3.0 * variance[axis]).sqrt(),
                BoxRule::Bounding if sign < 0.0 => f64::from(leaf.min[axis]),
                BoxRule::Bounding => f64::from(leaf.max[axis]),
            };
            cube.lab(axis, coordinate) as f32
        })
    };
    Cluster { probability: leaf.count as f64 / total, min: corner(-1.0), max: corner(1.0) }
}

/// Ascending lightness of the center, then a, b, probability.
fn by_lightness(x: &Cluster, y: &Cluster) -> std::cmp::Ordering {
    let key = |c: &Cluster| {
        let [l, a, b] = [0, 1, 2].map(|axis| f64::from(c.min[axis]) + f64::from(c.max[axis]));
        [l, a, b, c.probability]
    };
    let orders = key(x).into_iter().zip(key(y)).map(|(x, y)| x.total_cmp(&y));
    orders.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
}

/// Mean of the texels; there is at least one.
fn mean_of_texels(texels: &[[f32; 3]]) -> DVec3 {
    let mut sum = [0.0f64; 3];
    for texel in texels {
        for (s, c) in sum.iter_mut().zip(texel) {
            *s += f64::from(*c);
        }
    }
    DVec3::from_array(sum) / texels.len() as f64
}
