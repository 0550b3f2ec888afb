//! From what the pixels of a camera say back to linear light.

use super::response::CameraResponse;
use crate::error::Result;
use crate::measure::Picture;

/// Steps of the table where values are continuous.
const STEPS: usize = 4095;

/// Linear light of a camera's pixels, by a table.
#[derive(Debug, Clone)]
pub struct Decoder {
    /// Light and its change with the value, at values evenly from 0 to 1.
    table: Vec<[[f32; 2]; 3]>,
    /// Step between two values of a pixel.
    quantum: f64,
    /// Values from here on are saturated.
    full: f32,
}

impl Decoder {
    /// The table of a camera whose values come in steps of `quantum` (0: continuous).
    ///
    /// # Errors
    /// A response that is no curve.
    pub fn new(response: &CameraResponse, quantum: f64) -> Result<Self> {
        response.validate()?;
        let steps =
            if (1.0 / 65_535.0..=0.01).contains(&quantum) { (1.0 / quantum).round() as usize } else { STEPS };
        let light = |k: usize, c: usize| inverse(response, k as f64 / steps as f64, c);
        let entry = |k: usize, c: usize| {
            let (low, high) = (k.saturating_sub(1), (k + 1).min(steps));
            let slope = (light(high, c) - light(low, c)) * steps as f64 / (high - low) as f64;
            [light(k, c) as f32, slope as f32]
        };
        let table = (0..=steps).map(|k| [0, 1, 2].map(|c| entry(k, c))).collect();
        Ok(Self { table, quantum, full: (1.0 - 1.5 * quantum.max(1e-4)) as f32 })
    }

    /// Whether a value (or no number) tells nothing but that there is much light.
    pub fn is_full(&self, value: f32) -> bool {
        value >= self.full
    }

    /// Light of a value of a channel, and the variance that its rounding adds; values outside 0 to 1 as the nearest inside.
    pub fn light(&self, value: f32, channel: usize) -> (f64, f64) {
        let last = self.table.len() - 1;
        let place = f64::from(value).clamp(0.0, 1.0) * last as f64;
        let cell = (place as usize).min(last - 1);
        let [low, high] = [cell, cell + 1].map(|k| self.table[k][channel].map(f64::from));
        let share = place - cell as f64;
        let [light, slope] = [0, 1].map(|k| low[k] + share * (high[k] - low[k]));
        (light, (slope * self.quantum).powi(2) / 12.0)
    }

    /// The value that a channel says of light.
    pub fn value(&self, light: f64, channel: usize) -> f32 {
        let above = self.table.partition_point(|entry| f64::from(entry[channel][0]) < light);
        above.min(self.table.len() - 1) as f32 / (self.table.len() - 1) as f32
    }

    /// Mean light of the channels of every pixel, and that of a saturated one.
    pub fn mean_light(&self, picture: &Picture) -> (Vec<f32>, f32) {
        let mean = |p: &[f32; 3]| {
            let sum: f64 = [0, 1, 2].map(|c| self.light(p[c], c).0).iter().sum();
            if p.iter().all(|v| v.is_finite()) { (sum / 3.0) as f32 } else { f32::NAN }
        };
        (picture.pixels.iter().map(mean).collect(), mean(&[self.full; 3]))
    }
}

/// The light of which a camera says `value`, straight between knots.
fn inverse(response: &CameraResponse, value: f64, channel: usize) -> f64 {
    let CameraResponse { light, says, .. } = response;
    // Of black it is the most light that still is black.
    let black = says.partition_point(|s| s[channel] <= says[0][channel]).max(1) - 1;
    let above = says.partition_point(|s| s[channel] < value);
    if above <= black {
        return light[black];
    }
    let above = above.min(light.len() - 1);
    let [from, to] = [above - 1, above].map(|k| says[k][channel]);
    let share = if to > from { ((value - from) / (to - from)).min(1.0) } else { 0.0 };
    light[above - 1] + share * (light[above] - light[above - 1])
}
