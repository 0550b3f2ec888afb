//! Statistics of a set of slices at every level of detail (Rump et al. 2008, section 6: box-filtered levels).

use super::{BoxRule, SliceStatistics, cluster_slice};
use crate::btf::{half, level_count};
use crate::color::luminance;
use crate::error::{Error, Result};
use crate::parallel::TryMap;
use glam::DVec3;
use rayon::prelude::*;

/// What is kept of one level of all slices.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelStatistics {
    /// Pitch of the lattice on which independent random numbers are drawn, in texels of this level, at least 1: the square
    /// root of the integral range of the luminance, so that averages over many draws have the variance of averages over
    /// the source.
    pub pitch_texels: f64,
    /// Statistics of every slice, in the order of the slices.
    pub slices: Vec<SliceStatistics>,
}

/// Statistics of slices 0 to `count - 1` at every level of detail, finest first, the last of one texel.
///
/// `slice(k)` gives the `size[0] * size[1]` texels of slice k, row-major (linear Rec.709, 1/sr); it is called once a slice,
/// from several threads, and one slice a thread is held at a time. `n` and `rule`: see [`cluster_slice`]. `tick` is called
/// once a slice. The result does not depend on the number of threads.
///
/// # Errors
/// No slices; a side of 0; what `slice` returns, or texels that do not fit `size` or that [`cluster_slice`] refuses, with
/// the slice named.
pub fn cluster_levels(
    count: usize,
    slice: impl Fn(usize) -> Result<Vec<[f32; 3]>> + Sync,
    size: [usize; 2],
    n: usize,
    rule: BoxRule,
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<LevelStatistics>> {
    if count == 0 {
        return Err(Error::invalid("slices", "number", count, "1 or more"));
    }
    let slices = (0..count).into_par_iter().try_map(|k| {
        let levels = slice(k).and_then(|texels| slice_levels(texels, size, n, rule));
        tick();
        levels.map_err(|e| e.within(format!("slice {k}")))
    })?;
    Ok(transposed(slices, size))
}

/// One slice at one level.
struct SliceLevel {
    statistics: SliceStatistics,
    /// Of the luminance over the texels.
    variance: f64,
}

fn slice_levels(
    mut texels: Vec<[f32; 3]>,
    mut size: [usize; 2],
    n: usize,
    rule: BoxRule,
) -> Result<Vec<SliceLevel>> {
    if texels.len() != size[0] * size[1] {
        let legal = format!("{} ({} x {})", size[0] * size[1], size[0], size[1]);
        return Err(Error::invalid("", "texels", texels.len(), legal));
    }
    let levels = level_count(size);
    let mut out = Vec::with_capacity(levels);
    for level in 0..levels {
        if level > 0 {
            (texels, size) = half(&texels, size);
        }
        let statistics = cluster_slice(&texels, n, rule).map_err(|e| e.within(format!("level {level}")))?;
        out.push(SliceLevel { statistics, variance: variance(&texels) });
    }
    Ok(out)
}

/// Variance of the luminance over the texels.
fn variance(texels: &[[f32; 3]]) -> f64 {
    let values: Vec<f64> = texels.iter().map(|t| luminance(DVec3::from_array(t.map(f64::from)))).collect();
    // Sums of eight are a vector loop each, and of numbers of the same size.
    let sum = |f: &dyn Fn(&[f64]) -> f64| values.chunks(8).map(f).sum::<f64>() / values.len() as f64;
    let mean = sum(&|values| values.iter().sum());
    sum(&|values| values.iter().map(|v| (v - mean) * (v - mean)).sum())
}

/// Levels of slices to slices of levels.
fn transposed(slices: Vec<Vec<SliceLevel>>, size: [usize; 2]) -> Vec<LevelStatistics> {
    let sizes: Vec<[usize; 2]> = std::iter::successors(Some(size), |s| Some(s.map(|n| n.div_ceil(2))))
        .take(level_count(size))
        .collect();
    // A sum over slices weighs each by its energy, as the eye will see them.
    let energies: Vec<f64> =
        (0..sizes.len()).map(|level| slices.iter().map(|s| s[level].variance).sum()).collect();
    let mut levels: Vec<LevelStatistics> = (0..sizes.len())
        .map(|level| LevelStatistics {
            pitch_texels: pitch(&energies[level..], &sizes[level..]),
            slices: Vec::with_capacity(slices.len()),
        })
        .collect();
    for slice in slices {
        for (level, of_slice) in levels.iter_mut().zip(slice) {
            level.slices.push(of_slice.statistics);
        }
    }
    levels
}

/// Square root of the integral range of the first of these levels, in its texels.
///
/// The variance of the mean over a block of B texels a side is A/B^2 of that of a texel, where A tends to the integral range
/// as B grows; the coarser levels are those means. What a block of side B misses is, to first order, proportional to 1/B,
/// so two block sizes give the limit: good for a range up to about half the larger block.
fn pitch(energies: &[f64], sizes: &[[usize; 2]]) -> f64 {
    let texels = |level: usize| (sizes[level][0] * sizes[level][1]) as f64;
    // Blocks of up to 16 texels; no fewer than 256, since a variance over m blocks is right to sqrt(2 / m).
    let coarsest = (1..sizes.len().min(5)).rev().find(|level| texels(*level) >= 256.0);
    let Some(coarsest) = coarsest.filter(|_| energies[0] > 0.0) else {
        return 1.0;
    };
    // The mean that was taken off is the texture's own, which lacks a share 1/m of the variance of m blocks.
    let lost = |level: usize| 1.0 - 1.0 / texels(level);
    let range =
        |level: usize| energies[level] / energies[0] * texels(0) / texels(level) * lost(0) / lost(level);
    (2.0 * range(coarsest) - range(coarsest - 1)).max(1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{pcg4d, unit};

    /// White noise averaged over blocks of `side` texels a side, on a torus: integral range side^2.
    fn blurred_noise(size: [usize; 2], side: usize, seed: u32) -> Vec<[f32; 3]> {
        let noise: Vec<f32> =
            (0..size[0] * size[1]).map(|k| unit(pcg4d([k as u32, seed, 0, 9])[0]) - 0.5).collect();
        let at = |x: usize, y: usize| noise[y % size[1] * size[0] + x % size[0]];
        let blurred = |k: usize| {
            let (x, y) = (k % size[0], k / size[0]);
            (0..side * side).map(|d| at(x + d % side, y + d / side)).sum::<f32>() / (side * side) as f32
        };
        (0..noise.len()).map(|k| [blurred(k); 3]).collect()
    }

    #[test]
    fn pitch_is_the_root_of_the_integral_range() {
        let size = [128, 128];
        for side in 1..=4 {
            let slice = |k: usize| Ok(blurred_noise(size, side, k as u32));
            let levels = cluster_levels(24, slice, size, 4, BoxRule::MomentMatched, &|| ()).unwrap();
            // The range of 24 slices is known to 14 % / sqrt(24), its root to half of that; three standard errors.
            assert!(
                (levels[0].pitch_texels / side as f64 - 1.0).abs() < 0.045,
                "{side} {}",
                levels[0].pitch_texels
            );
            // Half as wide on a level of twice the texel, but never below one.
            assert!(levels[1].pitch_texels < 0.5 * side as f64 + 0.6);
            assert!(levels.iter().all(|level| level.pitch_texels >= 1.0));
            assert_eq!(levels.len(), 8);
        }
    }

    #[test]
    fn every_level_keeps_the_mean_and_the_last_is_the_mean() {
        let size = [24, 10];
        let slice = |k: usize| blurred_noise(size, 2, k as u32);
        let levels = cluster_levels(3, |k| Ok(slice(k)), size, 20, BoxRule::MomentMatched, &|| ()).unwrap();
        for k in 0..3 {
            let mean = slice(k).iter().map(|t| f64::from(t[0])).sum::<f64>() / 240.0;
            for level in &levels {
                // Halving rounds to f32 on each of up to six levels; the values are below 0.5.
                assert!((level.slices[k].mean_rgb() - DVec3::splat(mean)).abs().max_element() < 3e-7);
                level.slices[k].validate().unwrap();
            }
            assert_eq!(levels[5].slices[k].clusters.len(), 1);
        }
    }

    #[test]
    fn threads_and_ticks() {
        let size = [32, 32];
        let slice = |k: usize| Ok(blurred_noise(size, 2, k as u32));
        let run = |threads: usize| {
            let count = std::sync::atomic::AtomicUsize::new(0);
            let tick = || {
                count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let levels =
                pool.install(|| cluster_levels(9, slice, size, 50, BoxRule::Bounding, &tick)).unwrap();
            assert_eq!(count.into_inner(), 9);
            levels
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn errors_name_the_slice() {
        let run = |slice: fn(usize) -> Result<Vec<[f32; 3]>>, count: usize| {
            cluster_levels(count, slice, [2, 2], 5, BoxRule::MomentMatched, &|| ()).unwrap_err().to_string()
        };
        assert!(run(|_| Ok(vec![[0.0; 3]; 3]), 1).contains("slice 0: texels: found 3, expected 4 (2 x 2)"));
        let text = run(|k| Ok(vec![[0.0, if k == 2 { f32::NAN } else { 1.0 }, 0.0]; 4]), 3);
        assert!(text.contains("slice 2: level 0: texel 0: value: found [0.0, NaN, 0.0]"), "{text}");
        assert!(run(|_| Ok(vec![]), 0).contains("slices: number: found 0"));
    }
}
