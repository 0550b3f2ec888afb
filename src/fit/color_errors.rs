//! What a color table of two angles cannot say.
//!
//! Rump et al. 2008 keep the scaled colors `C / I` (eqs 4, 5) in a table of four angles, for an isotropic paint three:
//! theta_h, theta_i and phi_d. The table of a paint has the first two. Here its colors, scaled to an intensity of 1 too, are held
//! against those of every sample. Samples are gathered in the texels nearest to them: how much they scatter inside of a
//! texel is what no table of two angles can follow (phi_d, and the noise of the measurement); how far the table is from their
//! mean is what this one gives away by its smoothness. The squares of both sum to that of the whole, but for what the table changes
//! within a texel.

use super::report::{Spread, difference, spread};
use super::samples::Sample;
use crate::brdf::ColorTable;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Errors of scaled colors: root of the mean square of the distance in (R, G, B) / I, samples counting by their solid angle and
/// by `I / (I + eps)`, for the color of the dark is noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ColorErrors {
    /// Table against the samples.
    pub all: f64,
    /// The mean over phi_d at (theta_h, theta_i) against the samples: what every table of two angles is off by.
    pub azimuth: f64,
    /// Table against that mean.
    pub table: f64,
    /// Color difference of table and samples at the samples' intensities.
    pub delta_e_2000: Spread,
    /// The same of the mean over phi_d.
    pub delta_e_2000_azimuth: Spread,
}

/// A sample's color over its intensity, and the table's.
pub(super) struct Scaled {
    angles: [f64; 2],
    weight: f64,
    intensity: f64,
    measured: DVec3,
    table: DVec3,
}

impl Scaled {
    /// None where a color has no intensity to be divided by.
    pub fn new(sample: &Sample, color: DVec3, chi: DVec3, epsilon: f64) -> Option<Self> {
        let (intensity, of_table) = (color.element_sum() / 3.0, chi.element_sum() / 3.0);
        (intensity > epsilon && of_table > 0.0).then(|| Self {
            angles: [sample.angles.theta_h, sample.angles.theta_i],
            weight: sample.solid_angle * intensity / (intensity + epsilon),
            intensity,
            measured: color / intensity,
            table: chi / of_table,
        })
    }
}

impl ColorErrors {
    /// Over the samples given; zeros over none.
    pub(super) fn of(samples: &[Scaled], table: &ColorTable) -> Self {
        let [columns, rows] = table.size();
        let texel = |s: &Scaled| {
            let at = |angle: f64, n: usize| {
                ((angle * std::f64::consts::FRAC_2_PI * (n - 1) as f64).round() as usize).min(n - 1)
            };
            at(s.angles[1], rows) * columns + at(s.angles[0], columns)
        };
        let mut sums = vec![(0.0, DVec3::ZERO); columns * rows];
        for s in samples {
            let sum = &mut sums[texel(s)];
            *sum = (sum.0 + s.weight, sum.1 + s.weight * s.measured);
        }
        let mean = |s: &Scaled| {
            let (weight, measured) = sums[texel(s)];
            if weight > 0.0 { measured / weight } else { s.measured }
        };
        let root = |square: &dyn Fn(&Scaled) -> f64| {
            let whole: f64 = samples.iter().map(|s| s.weight).sum();
            let sum: f64 = samples.iter().map(|s| s.weight * square(s)).sum();
            if whole > 0.0 { (sum / whole).sqrt() } else { 0.0 }
        };
        let differences = |color: &(dyn Fn(&Scaled) -> DVec3 + Sync)| {
            let of = |s: &Scaled| difference(s.intensity * s.measured, s.intensity * color(s));
            spread(samples.par_iter().map(of).collect())
        };
        Self {
            all: root(&|s| (s.measured - s.table).length_squared()),
            azimuth: root(&|s| (s.measured - mean(s)).length_squared()),
            table: root(&|s| (mean(s) - s.table).length_squared()),
            delta_e_2000: differences(&|s| s.table),
            delta_e_2000_azimuth: differences(&mean),
        }
    }
}
