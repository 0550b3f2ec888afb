//! What a fit is worth, in numbers.

use super::choice::Choice;
use super::color_errors::ColorErrors;
use super::samples::SampleCounts;
use super::uncertainty::Uncertainty;
use super::{FitOptions, SmoothFit};
use crate::brdf::{ClearCoat, Lobe};
use crate::color::{delta_e_76, delta_e_2000, lab_from_rgb};
use crate::math::half_difference::spherical;
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::PI;

/// The aspecular angles of the trade, degrees from the mirror direction towards the light.
pub const ASPECULAR_DEG: [f64; 6] = [-15.0, 15.0, 25.0, 45.0, 75.0, 110.0];

/// Everything a fit can say about itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitReport {
    /// What was asked for.
    pub options: FitOptions,
    /// Clear coat, with its gloss lobe if one was found or given.
    pub coat: ClearCoat,
    /// Diffuse intensity.
    pub diffuse: f64,
    /// Lobes, widest first.
    pub lobes: Vec<Lobe>,
    /// What became of the cells or samples.
    pub samples: SampleCounts,
    /// The small constant of eq. 7, 1/sr.
    pub epsilon: f64,
    /// Eq. 7 (Rump et al. 2008) of diffuse and lobes over the cells outside the gloss peak: mean of
    /// `|ln((max(Psi, 0) + eps) / (M + eps))|`.
    pub error: f64,
    /// The same with the color table in: `M` is the mean of the three channels.
    pub colored_error: f64,
    /// Eq. 7 over the cells of the gloss peak, all terms in.
    pub gloss_error: Option<f64>,
    /// Light that the fitted gloss peak sends back, over that of the measured one, all directions summed.
    pub gloss_energy: Option<f64>,
    /// Half-vector angle at which the gloss peak ends, degrees; 0 without gloss.
    pub gloss_end_deg: f64,
    /// Every start of the last round: eq. 7 over the samples they raced on, and evaluations taken. The last one, with the most
    /// lobes, is the result of the round before.
    pub starts: Vec<Start>,
    /// The numbers of lobes tried, most first.
    pub choices: Vec<Choice>,
    /// How well diffuse, lobes and gloss are known.
    pub uncertainty: Uncertainty,
    /// Color at 45 degrees incidence, where there are measurements within 2 degrees.
    pub aspecular: Vec<Aspecular>,
    /// What the color table cannot say.
    pub color: ColorErrors,
    /// Share of white's luminance that lies beyond the bands of spectral samples, 0 to 1.
    pub beyond_bands: Option<f64>,
    /// Color difference over the cells outside the gloss peak.
    pub delta_e_2000: Spread,
    /// Color difference over all usable cells.
    pub delta_e_2000_with_gloss: Spread,
    /// Of a refracting fit, the errors of one with light going straight on under the same coat, if it was made.
    pub without_refraction: Option<Errors>,
    /// Share of the color table's texels that rest on measurements, 0 to 1.
    pub texels_measured: f64,
}

/// The errors of a fit, to be held against another's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// As [`FitReport::error`].
    pub error: f64,
    /// As [`FitReport::colored_error`].
    pub colored_error: f64,
    /// As [`FitReport::delta_e_2000`].
    pub delta_e_2000: Spread,
}

impl FitReport {
    /// Its errors outside the gloss.
    pub fn errors(&self) -> Errors {
        let Self { error, colored_error, delta_e_2000, .. } = *self;
        Errors { error, colored_error, delta_e_2000 }
    }
}

/// One start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Start {
    /// Eq. 7 at its end.
    pub error: f64,
    /// Steps of the solver.
    pub steps: u64,
}

/// Mean and 95 % quantile over cells, every cell counting once.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Value that 95 % of the cells stay below.
    pub q95: f64,
}

/// Table against fit in one direction of the plane of incidence, light at 45 degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Aspecular {
    /// Angle from the mirror direction towards the light, degrees.
    pub aspecular_deg: f64,
    /// Reflectance factor pi f of the table, linear Rec.709.
    pub measured_rgb: [f64; 3],
    /// Reflectance factor pi f of the fit.
    pub fitted_rgb: [f64; 3],
    /// Lab of the table.
    pub measured_lab: [f64; 3],
    /// Lab of the fit.
    pub fitted_lab: [f64; 3],
    /// CIEDE2000 between both.
    pub delta_e_2000: f64,
    /// CIE 1976 difference between both.
    pub delta_e_76: f64,
    /// CIEDE2000 between the table and the mean of the table and itself with light and eye exchanged: what the best
    /// reciprocal model, as every paint here is, would still be off by. `None` where light and eye were never exchanged.
    pub reciprocity_delta_e_2000: Option<f64>,
}

/// Compares `fit` with what was `measured` in pairs of directions at [`ASPECULAR_DEG`].
pub(super) fn aspecular(measured: &dyn Fn(DVec3, DVec3) -> Option<DVec3>, fit: &SmoothFit) -> Vec<Aspecular> {
    let wi = spherical(PI / 4.0, 0.0);
    ASPECULAR_DEG
        .into_iter()
        .filter_map(|aspecular_deg| {
            // Negative polar angles lie on the mirror side.
            let theta = (aspecular_deg - 45.0).to_radians();
            let there = PI * across(theta, |wo| measured(wi, wo))?;
            let back = across(theta, |wo| measured(wo, wi)).map(|back| 0.5 * (there + PI * back));
            let fitted = PI * fit.eval(wi, spherical(theta, 0.0));
            let [lab_m, lab_f] = [there, fitted].map(lab_from_rgb);
            Some(Aspecular {
                aspecular_deg,
                measured_rgb: there.to_array(),
                fitted_rgb: fitted.to_array(),
                measured_lab: lab_m.to_array(),
                fitted_lab: lab_f.to_array(),
                delta_e_2000: delta_e_2000(lab_m, lab_f),
                delta_e_76: delta_e_76(lab_m, lab_f),
                reciprocity_delta_e_2000: back.map(|mean| delta_e_2000(lab_m, lab_from_rgb(mean))),
            })
        })
        .collect()
}

/// `f` at the signed polar angle `theta` in the plane of incidence. The cells of a table lie around the pole, none on it:
/// its value there is the mean of both sides. Anywhere else the step makes no difference.
fn across(theta: f64, f: impl Fn(DVec3) -> Option<DVec3>) -> Option<DVec3> {
    Some(0.5 * (f(spherical(theta - 1e-6, 0.0))? + f(spherical(theta + 1e-6, 0.0))?))
}

/// CIEDE2000 between two BRDF values.
pub(super) fn difference(measured: DVec3, fitted: DVec3) -> f64 {
    delta_e_2000(lab_from_rgb(PI * measured), lab_from_rgb(PI * fitted))
}

/// Mean and quantile of `values`; zeros of none.
pub(super) fn spread(mut values: Vec<f64>) -> Spread {
    if values.is_empty() {
        return Spread { mean: 0.0, q95: 0.0 };
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let at = (values.len() * 19 / 20).min(values.len() - 1);
    Spread { mean, q95: *values.select_nth_unstable_by(at, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_of_a_ramp() {
        let s = spread((0..100).rev().map(f64::from).collect());
        assert_eq!((s.mean, s.q95), (49.5, 95.0));
        assert_eq!(spread(Vec::new()).mean, 0.0);
    }
}
