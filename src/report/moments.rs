//! Luminances, their mean, standard deviation and correlation.

use crate::color::luminance;
use glam::DVec3;

/// Mean and standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    pub mean: f64,
    pub deviation: f64,
}

impl Moments {
    pub fn of(values: &[f32]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        let square = values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / n;
        Self { mean, deviation: square.sqrt() }
    }

    /// Correlation of two lists of equal length.
    pub fn correlation(a: &[f32], b: &[f32]) -> f64 {
        let [m, n] = [a, b].map(Self::of);
        let products = a.iter().zip(b).map(|(x, y)| (f64::from(*x) - m.mean) * (f64::from(*y) - n.mean));
        products.sum::<f64>() / (m.deviation * n.deviation * a.len() as f64)
    }
}

/// Luminance of every texel.
pub(super) fn luminances(texels: &[[f32; 3]]) -> Vec<f32> {
    texels.iter().map(|t| luminance(DVec3::from(t.map(f64::from))) as f32).collect()
}
