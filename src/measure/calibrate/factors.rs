//! Scales of all pairs as gain of a camera times light of a flash: the check of the white balance.
//!
//! N + N numbers a channel say N x N scales; what they leave is the scatter of flashes from shot to shot, and pairs whose white
//! targets were misread.

use serde::{Deserialize, Serialize};

/// Sweeps of the alternating means; with all pairs one is exact.
const SWEEPS: usize = 200;
/// They end where nothing moves by more.
const CONVERGED: f64 = 1e-12;
/// Rounds of leaving out.
const ROUNDS: usize = 4;
/// An outlier is this many robust standard deviations off, and at least this share.
const OUTLIER: [f64; 2] = [6.0, 0.03];

/// Gains and lights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhiteFactors {
    /// Gain of each camera, red, green, blue; `None` without a pair.
    pub cameras: Vec<Option<[f64; 3]>>,
    /// Light of each flash, 1 in the (geometric) mean.
    pub lights: Vec<Option<[f64; 3]>>,
    /// Root mean square of what is left of the logarithms, a channel each, without outliers.
    pub rms: [f64; 3],
    /// Pairs (camera, light) that do not fit, with their scale over the expected one.
    pub outliers: Vec<(usize, usize, [f64; 3])>,
}

/// Factors of the scales of pairs (camera, light) by least squares of their logarithms; numbers of cameras below `number`.
/// Pairs outside, or with scales that are not above 0, count as outliers.
pub fn factorize(scales: &[(usize, usize, [f64; 3])], number: usize) -> WhiteFactors {
    let legal = |(camera, light, scale): &(usize, usize, [f64; 3])| {
        *camera < number && *light < number && scale.iter().all(|s| *s > 0.0 && s.is_finite())
    };
    let (good, bad): (Vec<_>, Vec<_>) = scales.iter().copied().partition(legal);
    let mut used = vec![true; good.len()];
    let mut fit = Fit::of(&good, &used, number);
    for _ in 0..ROUNDS {
        let mut sizes: Vec<f64> =
            fit.left.iter().zip(&used).filter(|(_, u)| **u).map(|(l, _)| largest(l)).collect();
        sizes.sort_by(f64::total_cmp);
        // The largest of three normal deviates has a median of 1.25 standard deviations.
        let typical = sizes.get(sizes.len() / 2).map_or(0.0, |median| median / 1.25);
        let limit = (OUTLIER[0] * typical).max(OUTLIER[1]);
        used = fit.left.iter().map(|left| largest(left) <= limit).collect();
        fit = Fit::of(&good, &used, number);
    }
    let kept = used.iter().filter(|u| **u).count().max(1) as f64;
    let square =
        |c: usize| fit.left.iter().zip(&used).filter(|(_, u)| **u).map(|(l, _)| l[c] * l[c]).sum::<f64>();
    let strange = good.iter().zip(&fit.left).zip(&used).filter(|(_, used)| !**used);
    let strange = strange.map(|(((camera, light, _), left), _)| (*camera, *light, left.map(f64::exp)));
    WhiteFactors {
        cameras: exponentials(&fit.sides[0]),
        lights: exponentials(&fit.sides[1]),
        rms: [0, 1, 2].map(|c| (square(c) / kept).sqrt()),
        outliers: strange.chain(bad).collect(),
    }
}

fn largest(left: &[f64; 3]) -> f64 {
    left.iter().fold(0.0, |most, x| most.max(x.abs()))
}

fn exponentials(side: &[Option<[f64; 3]>]) -> Vec<Option<[f64; 3]>> {
    side.iter().map(|logs| logs.map(|l| l.map(f64::exp))).collect()
}

/// Logarithms of cameras and lights, and what they leave of every pair.
struct Fit {
    sides: [Vec<Option<[f64; 3]>>; 2],
    left: Vec<[f64; 3]>,
}

impl Fit {
    fn of(pairs: &[(usize, usize, [f64; 3])], used: &[bool], number: usize) -> Self {
        let mut sides = [vec![None; number], vec![None; number]];
        let ends = |pair: &(usize, usize, [f64; 3])| [pair.0, pair.1];
        let log_of = |side: &[Option<[f64; 3]>], k: usize| side[k].unwrap_or_default();
        for _ in 0..SWEEPS {
            let mut moved = 0.0f64;
            for (own, other) in [(0, 1), (1, 0)] {
                let mut sums = vec![([0.0; 3], 0.0); number];
                for (pair, _) in pairs.iter().zip(used).filter(|(_, used)| **used) {
                    let (sum, count) = &mut sums[ends(pair)[own]];
                    let theirs = log_of(&sides[other], ends(pair)[other]);
                    (0..3).for_each(|c| sum[c] += pair.2[c].ln() - theirs[c]);
                    *count += 1.0;
                }
                for (k, (sum, count)) in sums.into_iter().enumerate().filter(|(_, (_, count))| *count > 0.0) {
                    let mean = sum.map(|s| s / count);
                    let before = log_of(&sides[own], k);
                    moved = (0..3).fold(moved, |most, c| most.max((mean[c] - before[c]).abs()));
                    sides[own][k] = Some(mean);
                }
            }
            if moved <= CONVERGED {
                break;
            }
        }
        // Lights are 1 in the mean.
        let known = sides[1].iter().flatten().count().max(1) as f64;
        let mean = [0, 1, 2].map(|c| sides[1].iter().flatten().map(|l: &[f64; 3]| l[c]).sum::<f64>() / known);
        sides[1].iter_mut().flatten().for_each(|l| (0..3).for_each(|c| l[c] -= mean[c]));
        sides[0].iter_mut().flatten().for_each(|l| (0..3).for_each(|c| l[c] += mean[c]));
        let left = |pair: &(usize, usize, [f64; 3])| {
            let [own, other] = [0, 1].map(|side| log_of(&sides[side], ends(pair)[side]));
            [0, 1, 2].map(|c| pair.2[c].ln() - own[c] - other[c])
        };
        let left = pairs.iter().map(left).collect();
        Self { sides, left }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{pcg4d, unit};

    #[test]
    fn factors_come_back_and_misread_pairs_are_named() {
        let gain = |k: usize, c: usize| 1.0 + 0.1 * (k as f64 * 1.7 + c as f64).sin();
        let mut scales = Vec::new();
        for camera in 0..7usize {
            for light in (0..7usize).filter(|light| (camera + light) % 3 != 0) {
                let noise =
                    |c: u32| 0.01 * f64::from(unit(pcg4d([camera as u32, light as u32, c, 0])[0]) - 0.5);
                let scale =
                    [0, 1, 2].map(|c| gain(camera, c) * gain(light + 20, c) * (1.0 + noise(c as u32)));
                scales.push((camera, light, scale));
            }
        }
        scales[5].2[1] *= 1.4;
        let stranger = (scales[5].0, scales[5].1);
        scales.push((1, 1, [f64::NAN; 3]));
        scales.push((9, 1, [1.0; 3]));
        let found = factorize(&scales, 7);
        let named: Vec<_> = found.outliers.iter().map(|o| (o.0, o.1)).collect();
        assert_eq!(named, [stranger, (1, 1), (9, 1)]);
        assert!((found.outliers[0].2[1] / 1.4 - 1.0).abs() < 0.02);
        for c in 0..3 {
            let mean = (0..7).map(|k| gain(k + 20, c).ln()).sum::<f64>() / 7.0;
            for k in 0..7 {
                // Uniform noise of 0.3 % over four to five pairs.
                let expected = gain(k, c) * mean.exp();
                assert!((found.cameras[k].unwrap()[c] / expected - 1.0).abs() < 0.006, "{k} {c}");
            }
            // 0.01 / sqrt(12), less what fourteen numbers of thirty-two take.
            assert!((0.0012..0.0030).contains(&found.rms[c]), "{}", found.rms[c]);
        }
    }
}
