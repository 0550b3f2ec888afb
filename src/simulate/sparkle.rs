//! Sparkles of a film with flakes under a small light: how many in a pixel, and how bright.
//!
//! Ershov 2001, section 7, corrected. The observer's direction is fixed and a flake sparkles where the mirrored eye ray
//! meets the disc of the light; so it is the cosine of the *incident* angle that comes with the light's solid angle. The
//! published text has the observer's: the same mean, but a variance wrong by up to 1.6.

use super::fast_model::mean_attenuation;
use super::geometry::Geometry;
use std::f64::consts::PI;

/// A light of angular radius Delta over a flake film, seen by a distant eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sparkles {
    /// Directions of light and eye.
    pub geometry: Geometry,
    /// Index eta of the binder.
    pub index: f64,
    /// Angular radius Delta of the light, outside, radians; the sun's is 0.00465. Small against the spread of the flakes.
    pub light_radius: f64,
}

impl Sparkles {
    /// Solid angle of flake normals that mirror the light into the eye:
    /// `pi Delta^2 cos(theta') / (4 eta^2 cos(alpha) cos(bar theta'))`. Times P(beta) it is the probability for a flake.
    pub fn normals(&self) -> f64 {
        let g = &self.geometry;
        PI * self.light_radius.powi(2) * g.cos_outside[0]
            / (4.0 * self.index.powi(2) * g.cos_alpha * g.cos_inside[0])
    }

    /// Mean number of sparkles in a pixel that holds `flakes` flakes on average, with density P(beta) = `density`, 1/sr. The
    /// number is a Poisson deviate with this mean.
    pub fn mean_count(&self, density: f64, flakes: f64) -> f64 {
        flakes * density * self.normals()
    }

    /// Luminance, over the illuminance of the surface, that one flake of reflectance r_p = `reflectance` at the surface adds
    /// to a pixel, of whose area it is the share `area_share` (eqs 34, 35).
    pub fn luminance(&self, reflectance: f64, area_share: f64) -> f64 {
        let g = &self.geometry;
        g.transmission * reflectance * g.cos_alpha * area_share
            / (PI * self.light_radius.powi(2) * g.cos_outside[0] * g.cos_inside[1])
    }

    /// Mean and variance of the pixel's luminance for flakes of one area at uniformly distributed depths: `count` sparkles
    /// on average, each of [`Sparkles::luminance`] `brightest` at depth 0, film of [optical
    /// thickness](super::fast_model::FastModel::optical_thickness) `thickness` along both rays.
    pub fn moments(&self, count: f64, brightest: f64, thickness: f64) -> (f64, f64) {
        let mean = count * brightest * mean_attenuation(thickness);
        (mean, count * brightest * brightest * mean_attenuation(2.0 * thickness))
    }
}
