//! How sparkles and texture fade with distance (1999, section 5.2).
//!
//! A sparkle is smaller than any pixel: what the eye sees is its light spread over the footprint, so its luminance falls as
//! `1 / Sigma`, eq. 1. Where a pixel holds many, the contrast of the texture, standard deviation over mean, falls as
//! `Sigma^(-1/2)`, eq. 2. The footprint grows with the square of the distance.

use super::view::SparkleView;
use crate::color::{BANDS, Spectrum};

/// Area on the surface that a square pixel of angular side `pixel_angle`, radians, sees from `distance` at the cosine `cos`
/// with the normal; in the square of the distance's unit.
pub fn footprint(distance: f64, pixel_angle: f64, cos: f64) -> f64 {
    (distance * pixel_angle).powi(2) / cos
}

/// Luminance of a pixel that a source of power `energy` into the solid angle `cone` lights alone, seen at the cosine `cos`
/// (1999, eq. 1).
pub fn visible_luminance(energy: f64, cone: f64, footprint: f64, cos: f64) -> f64 {
    energy / (cone * footprint * cos)
}

/// Luminance, over the illuminance of the surface, of a mean sparkle alone in a pixel of `footprint_um2`: the mean over all
/// kinds, weighted by their numbers; 0 without sparkles. Unit 1/sr.
pub fn sparkle_luminance(view: &SparkleView, footprint_um2: f64) -> Spectrum {
    let count = view.mean_count(footprint_um2);
    if count > 0.0 { Spectrum(view.mean().0.map(|mean| mean / count)) } else { Spectrum::constant(0.0) }
}

/// Standard deviation over mean of the luminance of a pixel of `footprint_um2`; 0 without sparkles.
pub fn texture_contrast(view: &SparkleView, footprint_um2: f64) -> Spectrum {
    let (mean, variance) = (view.mean(), view.variance(footprint_um2));
    Spectrum(std::array::from_fn::<f64, BANDS, _>(|k| {
        if mean.0[k] > 0.0 { variance.0[k].sqrt() / mean.0[k] } else { 0.0 }
    }))
}
