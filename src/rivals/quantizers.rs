//! Quantizers that could find the clusters of a slice: k-means (Lloyd 1982) and Wu's (1991), on the texels themselves. Both give their
//! sets boxes of the members' moments.

use crate::cluster::{Cluster, SliceStatistics, mean_of_boxes};
use crate::color::lab_from_rgb;
use crate::error::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

fn wide(texel: [f32; 3]) -> DVec3 {
    DVec3::from_array(texel.map(f64::from))
}

/// Lab of texels, of which there are some, all finite; `n` sets are asked for.
fn lab(texels: &[[f32; 3]], n: usize) -> Result<Vec<DVec3>> {
    if n == 0 {
        return Err(Error::invalid("clusters", "number", n, "1 or more"));
    }
    if texels.is_empty() || !texels.as_flattened().iter().all(|value| value.is_finite()) {
        return Err(Error::invalid("slice", "texels", "none, or not finite", "some, all finite"));
    }
    Ok(texels.iter().map(|t| lab_from_rgb(PI * wide(*t))).collect())
}

fn mean(set: &[DVec3]) -> DVec3 {
    set.iter().sum::<DVec3>() / set.len() as f64
}

fn statistics(texels: &[[f32; 3]], sets: &[Vec<DVec3>]) -> SliceStatistics {
    let n = texels.len() as f64;
    let cluster = |set: &Vec<DVec3>| {
        let (center, count) = (mean(set), set.len() as f64);
        let variance = set.iter().map(|c| (*c - center) * (*c - center)).sum::<DVec3>() / count;
        let half = (3.0 * variance).map(f64::sqrt);
        let [min, max] = [center - half, center + half].map(|c| c.as_vec3().to_array());
        Cluster { probability: count / n, min, max }
    };
    let mut clusters: Vec<Cluster> = sets.iter().map(cluster).collect();
    clusters.sort_by(|a, b| a.center().x.total_cmp(&b.center().x));
    let offset = texels.iter().map(|t| wide(*t)).sum::<DVec3>() / n - mean_of_boxes(&clusters);
    SliceStatistics::new(clusters, offset.as_vec3().to_array())
}

/// Lloyd's algorithm, 25 rounds from the centers of Wu's sets: at most `n` clusters.
///
/// # Errors
/// No texels or clusters; a component that is not finite.
pub fn k_means(texels: &[[f32; 3]], n: usize) -> Result<SliceStatistics> {
    const ROUNDS: usize = 25;
    let colors = lab(texels, n)?;
    let mut sets = wu_sets(colors.clone(), n);
    for _ in 0..ROUNDS {
        let centers: Vec<DVec3> = sets.iter().map(|set| mean(set)).collect();
        sets = vec![Vec::new(); centers.len()];
        for color in &colors {
            let distances = centers.iter().map(|c| c.distance_squared(*color)).enumerate();
            let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(nearest, _)| nearest);
            sets[nearest].push(*color);
        }
        sets.retain(|set| !set.is_empty());
    }
    Ok(statistics(texels, &sets))
}

/// Wu 1991: the box of largest squared error is cut where that becomes least, across any axis. The original looks at a
/// histogram of 32^3 cells; here every texel counts. At most `n` clusters.
///
/// # Errors
/// No texels or clusters; a component that is not finite.
pub fn wu(texels: &[[f32; 3]], n: usize) -> Result<SliceStatistics> {
    Ok(statistics(texels, &wu_sets(lab(texels, n)?, n)))
}

fn wu_sets(colors: Vec<DVec3>, n: usize) -> Vec<Vec<DVec3>> {
    let error = |set: &[DVec3]| {
        let center = mean(set);
        set.iter().map(|c| c.distance_squared(center)).sum::<f64>()
    };
    let mut sets = vec![(error(&colors), colors)];
    while sets.len() < n {
        let errors = sets.iter().map(|s| s.0).enumerate();
        let worst = errors.filter(|(_, error)| *error > 1e-9).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((worst, _)) = worst else { break };
        let (_, set) = sets.swap_remove(worst);
        sets.extend(best_cut(set).map(|half| (error(&half), half)));
    }
    sets.into_iter().map(|s| s.1).collect()
}

/// The cut that leaves the least squared error: the one of the largest sum of |sum|^2 / count.
fn best_cut(mut set: Vec<DVec3>) -> [Vec<DVec3>; 2] {
    let (total, n) = (set.iter().sum::<DVec3>(), set.len() as f64);
    let (mut most, mut best) = (f64::NEG_INFINITY, (0, 0.0));
    for axis in 0..3 {
        set.sort_by(|x, y| x[axis].total_cmp(&y[axis]));
        let mut sum = DVec3::ZERO;
        for (k, pair) in set.windows(2).enumerate() {
            sum += pair[0];
            let left = (k + 1) as f64;
            let score = sum.length_squared() / left + (total - sum).length_squared() / (n - left);
            if pair[0][axis] < pair[1][axis] && score > most {
                (most, best) = (score, (axis, pair[1][axis]));
            }
        }
    }
    let (axis, threshold) = best;
    let (low, high) = set.into_iter().partition(|c| c[axis] < threshold);
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_groups_are_told_apart_and_keep_shares_and_mean() {
        let texels: Vec<[f32; 3]> = (0..300u16)
            .map(|k| {
                let wobble = 1e-3 * f32::from(k % 7);
                [[0.3, 0.02, 0.01], [0.01, 0.2, 0.02], [0.02, 0.03, 0.3]][usize::from(k % 3)]
                    .map(|v| v + wobble)
            })
            .collect();
        for quantizer in [wu, k_means] {
            let found = quantizer(&texels, 3).unwrap();
            let shares: Vec<f64> = found.clusters.iter().map(|c| c.probability).collect();
            assert_eq!(shares, [1.0 / 3.0; 3]);
            assert!(quantizer(&texels, 1000).unwrap().clusters.len() <= 21, "no more than there are colors");
            assert!(quantizer(&texels, 0).is_err() && quantizer(&[], 3).is_err());
            assert!(quantizer(&[[f32::NAN; 3]], 1).is_err());
        }
    }
}
