//! Weights of the paints, and the ways in which values are blended with them.

use crate::color::{lab_from_rgb, rgb_from_lab};
use crate::error::{Error, Result};
use glam::DVec3;

/// Weights of samples at these distances from the place of a movable one (Golla & Klein 2018, Fig. 7): inversely
/// proportional to the square of the distance (Shepard 1968), exactly 1 at a sample; several at no distance share equally.
///
/// # Errors
/// No distances, one that is negative or no number, none that is finite.
pub fn distance_weights(distances: &[f64]) -> Result<Vec<f64>> {
    if let Some(k) = distances.iter().position(|d| d.is_nan() || *d < 0.0) {
        return Err(Error::invalid(format!("distances[{k}]"), "value", distances[k], "0 or more"));
    }
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    if nearest.is_infinite() {
        return Err(Error::invalid("distances", "values", format!("{distances:?}"), "at least one finite"));
    }
    // Relative to the nearest, so that no square overflows.
    let share = |d: &f64| if *d == nearest { 1.0 } else { (nearest / d).powi(2) };
    let shares: Vec<f64> = distances.iter().map(share).collect();
    let sum: f64 = shares.iter().sum();
    Ok(shares.iter().map(|s| s / sum).collect())
}

/// Checked weights that sum to 1.
pub(super) struct Weights(pub Vec<f64>);

impl Weights {
    pub(super) fn new(weights: &[f64], paints: usize) -> Result<Self> {
        if weights.len() != paints {
            return Err(Error::invalid("weights", "number", weights.len(), format!("{paints}, one a paint")));
        }
        if let Some(bad) = weights.iter().find(|w| w.is_nan() || w.abs() > 1e3) {
            return Err(Error::invalid("weights", "value", bad, "a number from -1000 to 1000"));
        }
        let sum: f64 = weights.iter().sum();
        // People type thirds as 0.333333; what is missing is shared out, so that no mean is lost.
        if (sum - 1.0).abs() > 1e-5 {
            return Err(Error::invalid("weights", "sum", sum, "1"));
        }
        let scale = if (sum - 1.0).abs() > 1e-12 { sum } else { 1.0 };
        Ok(Self(weights.iter().map(|w| w / scale).collect()))
    }

    /// All weight on paint `k` of `paints`.
    pub(super) fn only(k: usize, paints: usize) -> Self {
        Self((0..paints).map(|j| f64::from(u8::from(j == k))).collect())
    }

    /// Sum of weight times value. Values that all paints with a weight share come back as they are.
    pub(super) fn linear(&self, values: impl Iterator<Item = f64> + Clone) -> f64 {
        self.shared(values.clone()).unwrap_or_else(|| self.0.iter().zip(values).map(|(w, v)| w * v).sum())
    }

    /// [`Weights::linear`] of `map`ped values, mapped back by `inverse`; shared values come back as they are.
    pub(super) fn along(
        &self,
        values: impl Iterator<Item = f64> + Clone,
        map: impl Fn(f64) -> f64,
        inverse: impl Fn(f64) -> f64,
    ) -> f64 {
        let blended = || {
            inverse(
                self.0
                    .iter()
                    .zip(values.clone())
                    .map(|(w, v)| if *w == 0.0 { 0.0 } else { w * map(v) })
                    .sum(),
            )
        };
        self.shared(values.clone()).unwrap_or_else(blended)
    }

    /// The value that all paints with a weight share, if they do.
    fn shared(&self, values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut used = self.0.iter().zip(values).filter(|(w, _)| **w != 0.0).map(|(_, v)| v);
        let first = used.next()?;
        used.all(|v| v == first).then_some(first)
    }

    /// [`Weights::linear`] component by component.
    pub(super) fn vector(&self, values: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
        DVec3::from([0, 1, 2].map(|c| self.linear(values.clone().map(|v| v[c]))))
    }

    /// Standard deviations of a texture, 0 or more, an RGB channel each, 1/sr: linear in their cube roots, as lightness is.
    /// Ours, in place of the linear blend of contrast. Where flakes become fewer, deviations fall like a square root, under a
    /// pigment that absorbs more and more like an exponential: this law lies between, and no flakes at all are a legal end.
    /// Against paints simulated between the ends it leaves a twentieth less of |ln std| than the linear one. Weights are 0
    /// or more.
    pub(super) fn deviation(&self, values: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
        let cube = |x: f64| x.powi(3);
        DVec3::from([0, 1, 2].map(|c| self.along(values.clone().map(|v| v[c]), f64::cbrt, cube)))
    }

    /// One color, linear in Lab (Golla & Klein 2018, section 4.2); a color that all paints with a weight share comes back as
    /// it is.
    pub(super) fn color(&self, colors: &[[f32; 3]]) -> [f32; 3] {
        let mut used = self.0.iter().zip(colors).filter(|(w, _)| **w != 0.0).map(|(_, c)| c);
        match used.next() {
            Some(first) if used.all(|c| c == first) => *first,
            _ => {
                let lab = |c: &[f32; 3]| lab_from_rgb(DVec3::from(c.map(f64::from)));
                let blend: DVec3 = self.0.iter().zip(colors).map(|(w, c)| *w * lab(c)).sum();
                rgb_from_lab(blend).as_vec3().to_array()
            }
        }
    }

    /// Shares of the probability: negative weights count 0, the others are scaled to sum to 1.
    pub(super) fn shares(&self) -> Self {
        let sum: f64 = self.0.iter().map(|w| w.max(0.0)).sum();
        if self.0.iter().all(|w| *w >= 0.0) {
            Self(self.0.clone())
        } else {
            Self(self.0.iter().map(|w| w.max(0.0) / sum).collect())
        }
    }
}
