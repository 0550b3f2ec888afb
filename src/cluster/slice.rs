//! From the texels of a slice to its statistics.

use super::cells::{BANDS, Cell, cells};
use super::lattice::{Cube, lab_planes};
use super::mean::mean_of_boxes;
use super::moments::{Moments, Point};
use super::reduction::clusters;
use super::{BoxRule, Cluster, SliceStatistics};
use crate::error::{Error, Result};
use glam::DVec3;

/// Number of clusters of a slice unless asked otherwise (Golla & Klein 2018, section 3.2).
pub const DEFAULT_CLUSTERS: usize = 50;
/// Most clusters that can be asked for.
pub const MAX_CLUSTERS: usize = 1024;
/// Cells a cluster, and most cells more than clusters: see the table of the reduction.
const CELLS: usize = 3;
const MORE_CELLS: usize = 75;
/// Fewest texels a cell, on average: coarse levels have few cells, but a quarter more than clusters. Without this bound
/// clustering all levels takes a tenth longer, for the sake of levels of some hundred texels.
const TEXELS: usize = 4;
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
    let mut points = cube.points(&planes);
    let kept = kept(n);
    let cells = cells(&mut points, cell_count(n, texels.len()), kept);
    let of_cells = clusters(&cells, n, kept);
    let mut moments = vec![Moments::EMPTY; of_cells.iter().max().map_or(0, |last| last + 1)];
    of_cells.iter().zip(&cells).for_each(|(c, cell)| moments[*c] = moments[*c].merged(&cell.moments));
    let boxes: Vec<[[f64; 3]; 2]> = match rule {
        BoxRule::MomentMatched => moments.iter().map(moment_matched).collect(),
        BoxRule::Bounding => bounding(&points, &cells, &of_cells, moments.len()),
    };
    let total = texels.len() as f64;
    let cluster = |(moments, corners): (&Moments, [[f64; 3]; 2])| {
        let [min, max] = corners.map(|at| [0, 1, 2].map(|axis| cube.lab(axis, at[axis]) as f32));
        Cluster { probability: moments.count as f64 / total, min, max }
    };
    let mut clusters: Vec<Cluster> = moments.iter().zip(boxes).map(cluster).collect();
    clusters.sort_by(by_lightness);
    let offset = mean_of_texels(texels) - mean_of_boxes(&clusters);
    Ok(SliceStatistics::new(clusters, offset.as_vec3().to_array()))
}

/// Clusters kept for the body and for each band of sparkles, of `n`; too few are better left to the error.
fn kept(n: usize) -> [usize; BANDS] {
    if n < 16 { [0; BANDS] } else { [1, n / 16, (n / 50).max(1), (n / 50).max(1)] }
}

/// Number of cells that `n` clusters are merged from.
fn cell_count(n: usize, texels: usize) -> usize {
    (CELLS * n).min(n + MORE_CELLS).min((texels / TEXELS).max(n + n / 4))
}

/// Corners of a box with the mean and variance of the members.
fn moment_matched(moments: &Moments) -> [[f64; 3]; 2] {
    let (mean, variance) = (moments.mean(), moments.variance());
    [-1.0, 1.0].map(|sign| [0, 1, 2].map(|axis| mean[axis] + sign * (3.0 * variance[axis]).sqrt()))
}

/// Corners of the smallest boxes around the members of each of `n` clusters; `of_cells`: the cluster of each cell.
fn bounding(points: &[Point], cells: &[Cell], of_cells: &[usize], n: usize) -> Vec<[[f64; 3]; 2]> {
    let mut boxes = vec![[[f64::INFINITY; 3], [0.0; 3]]; n];
    for (cell, k) in cells.iter().zip(of_cells) {
        let [min, max] = &mut boxes[*k];
        for point in &points[cell.points.clone()] {
            for axis in 0..3 {
                let x = point.on(axis) as f64;
                (min[axis], max[axis]) = (min[axis].min(x), max[axis].max(x));
            }
        }
    }
    boxes
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
    // Four sums of a component each: one would wait for the addition before.
    let (chunks, rest) = texels.as_chunks::<4>();
    let mut sums = [0.0f64; 12];
    for chunk in chunks {
        for (sum, c) in sums.iter_mut().zip(chunk.as_flattened()) {
            *sum += f64::from(*c);
        }
    }
    for (k, c) in rest.as_flattened().iter().enumerate() {
        sums[k] += f64::from(*c);
    }
    let sum = |c: usize| sums.iter().skip(c).step_by(3).sum::<f64>();
    DVec3::new(sum(0), sum(1), sum(2)) / texels.len() as f64
}
