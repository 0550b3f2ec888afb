//! One flake under a small light: which normals mirror it into the eye, and how bright that is.
//!
//! The observer's direction is fixed and a flake sparkles where the mirrored eye ray meets the disc of the light; so it is
//! the cosine of the *incident* angle that comes with the light's solid angle. The text of 2001 has the observer's: the same
//! mean, but a variance wrong by up to 1.7. Energies after 1999, eqs 9 and 10, whose prefactor is unreadable: that of eq. 3
//! with the losses at the surface, and no factor for the observer's size, which the division by the solid angle holds.

use crate::simulate::optics::geometry::Geometry;
use std::f64::consts::PI;

/// A light of angular radius Delta over a flake film, seen by a distant eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparkleGeometry {
    /// Directions of light and eye, in the film.
    pub geometry: Geometry,
    /// Index eta of the film's binder.
    pub index: f64,
    /// What passes all boundaries above the film, both ways.
    pub transmission: f64,
    /// Angular radius Delta of the light, outside, radians; the sun's is 0.00465. Small against the spread of the flakes.
    pub light_radius: f64,
}

impl SparkleGeometry {
    /// Solid angle of flake normals that mirror the light into the eye:
    /// `pi Delta^2 cos(theta') / (4 eta^2 cos(alpha) cos(bar theta'))`. Times P(beta) it is the probability for a flake.
    pub fn normals(&self) -> f64 {
        let g = &self.geometry;
        PI * self.light_radius.powi(2) * g.cos_outside[0]
            / (4.0 * self.index.powi(2) * g.cos_alpha * g.cos_inside[0])
    }

    /// Energy that the surface receives, sends back outside by one flake at the top of the film: power over the illuminance
    /// of the surface, in the unit of `area`, for reflectance r_p = `reflectance` (1999, eq. 10; eq. 9 has the attenuation on
    /// the way down and up as well).
    pub fn energy(&self, reflectance: f64, area: f64) -> f64 {
        self.transmission * reflectance * area * self.geometry.cos_alpha / self.geometry.cos_inside[0]
    }

    /// Solid angle outside of the cone of light that a flake sends back: the light's own, as refraction in and out changes
    /// it.
    pub fn reflected_cone(&self) -> f64 {
        let g = &self.geometry;
        let squeezed = g.cos_outside[0] * g.cos_inside[1] / (g.cos_inside[0] * g.cos_outside[1]);
        PI * self.light_radius.powi(2) * squeezed
    }

    /// Luminance over the illuminance of the surface that such a flake gives a pixel, times the area of the pixel's footprint
    /// (1999, eq. 11; 2001, eqs 34, 35).
    pub fn luminance(&self, reflectance: f64, area: f64) -> f64 {
        self.energy(reflectance, area) / (self.reflected_cone() * self.geometry.cos_outside[1])
    }
}

/// Angular radius inside a binder of relative index `index` of a disc of radius `radius` seen at `cos` outside (1999, eq. 7):
/// the disc of the same solid angle; it is an ellipse in truth.
pub fn refracted_radius(radius: f64, cos: f64, index: f64) -> f64 {
    radius / index * (cos / crate::brdf::fresnel::refracted_cosine(cos, index)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;

    fn at(theta_i: f64, theta_o: f64, phi: f64) -> SparkleGeometry {
        let g = Geometry::new(spherical(theta_i, 0.2), spherical(theta_o, 0.2 + phi), 1.5).unwrap();
        SparkleGeometry { geometry: g, index: 1.5, transmission: g.transmission, light_radius: 0.01 }
    }

    #[test]
    fn the_solid_angle_is_that_of_the_refracted_light_on_the_flake() {
        // 1999: d2n = d2v / (4 cos alpha), d2v = pi Delta^2 with the radius inside.
        for (i, o, phi) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.6, 1.2, 2.0), (1.5, 0.9, 3.1)] {
            let sparkle = at(i, o, phi);
            let inside = refracted_radius(0.01, i.cos(), 1.5);
            let normals = PI * inside * inside / (4.0 * sparkle.geometry.cos_alpha);
            assert!((sparkle.normals() / normals - 1.0).abs() < 1e-14, "{i} {o}");
        }
    }

    #[test]
    fn the_radius_shrinks_as_refraction_does() {
        // Derivatives of Snell's law by differences: in the plane of incidence and across it.
        for theta in [0.1f64, 0.7, 1.3] {
            let inside = |t: f64| (t.sin() / 1.5).asin();
            let along = (inside(theta + 1e-5) - inside(theta - 1e-5)) / 2e-5;
            let across = inside(theta).sin() / theta.sin();
            let expected = (along * across).sqrt();
            // Third derivative times 1e-10.
            assert!((refracted_radius(1.0, theta.cos(), 1.5) / expected - 1.0).abs() < 1e-8, "{theta}");
        }
    }

    #[test]
    fn radiance_is_kept() {
        // A flake shows the light's own radiance, I / (pi Delta^2 cos theta'), dimmed by surface and mirror, over its
        // projection on the surface along the refracted eye ray.
        for (i, o, phi) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.6, 1.2, 2.0), (1.5, 0.9, 3.1)] {
            let sparkle = at(i, o, phi);
            let g = sparkle.geometry;
            let light = 1.0 / (PI * 0.01f64.powi(2) * i.cos());
            let shown = light * g.transmission * 0.7 * (3.0 * g.cos_alpha / g.cos_inside[1]);
            assert!((sparkle.luminance(0.7, 3.0) / shown - 1.0).abs() < 1e-13, "{i} {o}");
        }
    }
}
