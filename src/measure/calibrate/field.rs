//! What one picture of an evenly lit gray field says: level, noise, and pixels that are broken.

use crate::measure::Picture;

/// Differences beyond this many standard deviations belong to broken pixels.
const CUT: f64 = 6.0;
/// A pixel this many standard deviations (and four steps of quantization) off the others is broken.
const BROKEN: f64 = 10.0;

/// One channel of a gray field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// The median, 0 to 1: noise before a monotone curve leaves it in its place, cut off at black or not.
    pub level: f64,
    /// Standard error of the level.
    pub level_error: f64,
    /// Variance of a pixel, quantization taken off.
    pub variance: f64,
    /// Relative standard error of the variance.
    pub variance_error: f64,
    /// Share of pixels at `saturation` or above.
    pub saturated: f64,
}

impl Field {
    /// Measures a channel whose values come in steps of `quantum` (0: continuous), saturated at 1; `None` without any number.
    pub fn measure(picture: &Picture, channel: usize, quantum: f64) -> Option<Self> {
        let values: Vec<f64> = picture.pixels.iter().map(|p| f64::from(p[channel])).collect();
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        if sorted.is_empty() {
            return None;
        }
        sorted.sort_unstable_by(f64::total_cmp);
        let count = sorted.len() as f64;
        let full = 1.0 - 0.5 * quantum.max(1e-6);
        let saturated = (sorted.len() - sorted.partition_point(|v| *v < full)) as f64 / count;
        let (total, pairs) = pair_variance(&values, picture.size[0], quantum);
        let variance = (total - quantum * quantum / 12.0).max(0.0);
        // Of a field that does not cover some steps of quantization only the step is known.
        let unknown = if total.sqrt() < 0.3 * quantum { quantum / 12f64.sqrt() } else { 0.02 * quantum };
        let level_error = (std::f64::consts::FRAC_PI_2 * total / count + unknown * unknown).sqrt();
        let level = grouped_median(&sorted, quantum);
        Some(Self { level, level_error, variance, variance_error: (3.0 / pairs.max(1.0)).sqrt(), saturated })
    }

    /// Pixels of the channel that stand far above (`sign` 1: hot) or below (-1: dead) the level.
    pub fn broken(&self, picture: &Picture, channel: usize, sign: f64, quantum: f64) -> Vec<u32> {
        let reach = BROKEN * self.variance.sqrt() + 4.0 * quantum + 1e-6;
        let is_off =
            |p: &[f32; 3]| p[channel].is_nan() || sign * (f64::from(p[channel]) - self.level) > reach;
        (0u32..).zip(&picture.pixels).filter(|(_, p)| is_off(p)).map(|(k, _)| k).collect()
    }
}

/// The median of values rounded to steps, as if spread evenly over their steps.
fn grouped_median(sorted: &[f64], quantum: f64) -> f64 {
    let middle = sorted[sorted.len() / 2];
    if quantum == 0.0 {
        return middle;
    }
    let below = sorted.partition_point(|v| *v < middle - 0.5 * quantum);
    let within = sorted.partition_point(|v| *v <= middle + 0.5 * quantum) - below;
    middle + quantum * ((0.5 * sorted.len() as f64 - below as f64) / within as f64 - 0.5)
}

/// Half the mean square difference of neighbors in a row, which slow changes of the light do not enter, and how many pairs.
fn pair_variance(values: &[f64], width: usize, quantum: f64) -> (f64, f64) {
    let rows = values.chunks_exact(width).flat_map(|row| row.chunks_exact(2));
    let mut squares: Vec<f64> =
        rows.map(|pair| (pair[1] - pair[0]).powi(2)).filter(|s| s.is_finite()).collect();
    if squares.is_empty() {
        return (0.0, 0.0);
    }
    squares.sort_unstable_by(f64::total_cmp);
    // 68 % lie within one standard deviation.
    let typical = squares[(0.6827 * (squares.len() - 1) as f64) as usize].max(quantum * quantum);
    let kept = squares.partition_point(|s| *s <= CUT * CUT * typical);
    (0.5 * squares[..kept].iter().sum::<f64>() / kept as f64, kept as f64)
}
