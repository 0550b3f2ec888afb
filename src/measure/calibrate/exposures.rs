//! The exposures of one pair: which agree, and their true ratios, from pixels that are valid in several.
//!
//! The energy of a flash is not quite what its setting says, so that ratios are estimated anew: a ratio of sums, outliers (flake
//! edges, broken pixels) left out, for every two exposures; then one number an exposure by least squares of the logarithms. An
//! exposure that contradicts the others by more than [`MAX_RATIO`] is one whose flash did not fire.

use super::decoder::Decoder;
use super::response::SensorNoise;
use crate::measure::{Exposure, Picture};
use nalgebra::{DMatrix, DVector};

/// Most of an exposure's departure from nominal.
pub const MAX_RATIO: f64 = 1.5;
/// Pixels looked at.
const SAMPLES: usize = 20_000;
/// Signal over noise of a pixel that takes part.
const MIN_SIGNAL: f64 = 10.0;
/// Share of saturation up to which it takes part: noise must not cut it off.
const MAX_LIGHT: f64 = 0.8;
/// Fewest pixels of a ratio.
const MIN_PIXELS: usize = 30;
/// Outliers of a ratio, standard deviations.
const CUT: f64 = 4.0;
/// Standard deviation of the logarithm of an exposure about its nominal value, where nothing says more.
const PRIOR: f64 = 0.03;
/// Least standard error of a ratio: response curves are not known better.
const MIN_ERROR: f64 = 3e-4;

/// One exposure.
pub struct Shown<'a> {
    /// Its number.
    pub index: usize,
    /// Its setting.
    pub setting: Exposure,
    /// Amplification over the lowest sensitivity.
    pub gain: f64,
    /// Its picture.
    pub picture: &'a Picture,
}

/// What the camera is.
pub struct Camera<'a> {
    /// Its curve.
    pub decoder: &'a Decoder,
    /// Its noise.
    pub noise: &'a SensorNoise,
    /// Light at which its channels saturate.
    pub saturation: [f64; 3],
}

impl Camera<'_> {
    /// Variance of a pixel's light x at a gain, rounding apart.
    pub fn variance(&self, light: f64, gain: f64, channel: usize) -> f64 {
        let read = self.noise.read[channel] * gain;
        read * read + self.noise.shot[channel] * gain * light.max(0.0)
    }
}

/// What became of the exposures.
pub struct Reconciled {
    /// Those that agree: places in what was shown, and true relative values.
    pub kept: Vec<(usize, f64)>,
    /// What is said of those that do not.
    pub warnings: Vec<String>,
}

/// Two exposures compared, the first the less sensitive.
struct Comparison {
    pair: [usize; 2],
    /// Logarithm of the ratio over nominal and its standard error; infinite if one is dark.
    departure: f64,
    error: f64,
}

/// Finds the exposures that agree, and their ratios.
pub fn reconcile(shown: &[Shown<'_>], camera: &Camera<'_>) -> Reconciled {
    let mut comparisons = Vec::new();
    for a in 0..shown.len() {
        for b in 0..shown.len() {
            if shown[a].setting.relative < shown[b].setting.relative {
                comparisons.extend(compare([a, b], shown, camera));
            }
        }
    }
    let mut kept: Vec<usize> = (0..shown.len()).collect();
    let mut warnings = Vec::new();
    while let Some((worst, departure)) = worst(&kept, &comparisons) {
        kept.retain(|k| *k != worst);
        comparisons.retain(|c| !c.pair.contains(&worst));
        let factor = departure.exp();
        warnings.push(format!(
            "exposure {} has {factor:.3} of the light that the others say",
            shown[worst].index
        ));
    }
    let logs = settle(&kept, &comparisons);
    let relative = kept.iter().zip(logs).map(|(k, log)| (*k, shown[*k].setting.relative * log.exp()));
    Reconciled { kept: relative.collect(), warnings }
}

/// The exposure with most contradictions, among equals the darkest, and its departure; `None` if all agree.
fn worst(kept: &[usize], comparisons: &[Comparison]) -> Option<(usize, f64)> {
    let scored = kept.iter().filter_map(|k| {
        let (mut bad, mut good, mut departures) = (0i32, 0i32, Vec::new());
        for c in comparisons.iter().filter(|c| c.pair.contains(k)) {
            let is_bad = c.departure.is_nan() || c.departure.abs() > MAX_RATIO.ln();
            *(if is_bad { &mut bad } else { &mut good }) += 1;
            if is_bad {
                departures.push(if c.pair[1] == *k { c.departure } else { -c.departure });
            }
        }
        let departure = departures.iter().sum::<f64>() / departures.len().max(1) as f64;
        (bad > 0).then_some((bad - good, *k, departure))
    });
    scored.min_by(|a, b| b.0.cmp(&a.0).then(a.2.total_cmp(&b.2)).then(a.1.cmp(&b.1))).map(|(_, k, d)| (k, d))
}

/// Logarithms over nominal by least squares; what is nowhere compared stays nominal.
fn settle(kept: &[usize], comparisons: &[Comparison]) -> Vec<f64> {
    let place = |k: usize| kept.iter().position(|other| *other == k);
    let mut normal = DMatrix::<f64>::identity(kept.len(), kept.len()) / (PRIOR * PRIOR);
    let mut side = DVector::<f64>::zeros(kept.len());
    for c in comparisons {
        let Some((a, b)) = place(c.pair[0]).zip(place(c.pair[1])) else { continue };
        let w = c.error.max(MIN_ERROR).powi(-2);
        for (k, sign) in [(a, -1.0), (b, 1.0)] {
            normal[(k, k)] += w;
            side[k] += sign * w * c.departure;
        }
        normal[(a, b)] -= w;
        normal[(b, a)] -= w;
    }
    normal.cholesky().map_or(vec![0.0; kept.len()], |c| c.solve(&side).as_slice().to_vec())
}

/// `None` where too few pixels are valid in both.
fn compare(pair: [usize; 2], shown: &[Shown<'_>], camera: &Camera<'_>) -> Option<Comparison> {
    let [a, b] = pair.map(|k| &shown[k]);
    let [ra, rb] = [a, b].map(|s| s.setting.relative);
    let number = a.picture.pixels.len().min(b.picture.pixels.len());
    let mut valid: Vec<[f64; 4]> = Vec::new();
    let (mut bounds, mut dark) = (0usize, 0usize);
    for k in (0..number).step_by(1 + number / SAMPLES) {
        for c in 0..3 {
            let [va, vb] = [a, b].map(|s| s.picture.pixels[k][c]);
            if !(va.is_finite() && vb.is_finite()) || camera.decoder.is_full(va) {
                continue;
            }
            let (xa, rounding) = camera.decoder.light(va, c);
            if camera.decoder.is_full(vb) {
                let least = camera.saturation[c] * ra / rb;
                let is_telling = least > MIN_SIGNAL * (camera.variance(least, a.gain, c) + rounding).sqrt();
                bounds += usize::from(is_telling);
                dark += usize::from(is_telling && xa < least / MAX_RATIO);
                continue;
            }
            let (xb, rounding_b) = camera.decoder.light(vb, c);
            let scene = (xa / ra).max(xb / rb);
            let variance_a = camera.variance(scene * ra, a.gain, c) + rounding;
            if scene * ra > MIN_SIGNAL * variance_a.sqrt() && scene * rb < MAX_LIGHT * camera.saturation[c] {
                valid.push([xa, xb, variance_a, camera.variance(scene * rb, b.gain, c) + rounding_b]);
            }
        }
    }
    if bounds >= MIN_PIXELS && 2 * dark > bounds {
        return Some(Comparison { pair, departure: f64::INFINITY, error: f64::INFINITY });
    }
    let (ratio, error) = ratio(&valid)?;
    Some(Comparison { pair, departure: (ratio * ra / rb).max(0.0).ln(), error })
}

/// Ratio of the second to the first, and its relative error.
fn ratio(valid: &[[f64; 4]]) -> Option<(f64, f64)> {
    if valid.len() < MIN_PIXELS {
        return None;
    }
    let middle = |k: usize| {
        let mut all: Vec<f64> = valid.iter().map(|v| v[k]).collect();
        let half = all.len() / 2;
        *all.select_nth_unstable_by(half, f64::total_cmp).1
    };
    let (mut ratio, mut error) = (middle(1) / middle(0), f64::INFINITY);
    for _ in 0..4 {
        if !(ratio.is_finite() && ratio > 0.0) {
            // One of them is dark.
            return Some((if middle(0) > middle(1) { 0.0 } else { f64::INFINITY }, error));
        }
        let (mut sums, mut variance) = ([0.0; 2], 0.0);
        for [xa, xb, a, b] in valid {
            let spread = b + ratio * ratio * a;
            if (xb - ratio * xa).powi(2) <= CUT * CUT * spread {
                sums = [sums[0] + xa, sums[1] + xb];
                variance += spread;
            }
        }
        if sums[0] > 0.0 {
            ratio = sums[1] / sums[0];
            error = variance.sqrt() / sums[1].max(f64::MIN_POSITIVE);
        }
    }
    Some((ratio, error))
}
