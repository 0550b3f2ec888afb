//! What lies beneath the inks.

use crate::check::range;
use crate::error::Result;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// A gray substrate that shines dimly wherever its print is: Phong's highlight with a low exponent, and light that is scattered once
/// in an endless depth (Pranovich et al. 2024, Fig. 8; Hanrahan & Krueger 1993, isotropic, no boundary).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paper {
    /// Share of light from above that the highlight reflects, about: 0 to 1.
    pub highlight: f32,
    /// Phong's exponent, 0 to 1000; the paper's is "very low".
    pub shininess: f32,
    /// Share of light that an encounter scatters on, 0 to 1.
    pub albedo: f32,
}

impl Paper {
    /// Nothing beneath.
    pub const NONE: Self = Self { highlight: 0.0, shininess: 1.0, albedo: 0.0 };
    /// Black paper: reflects some 2 % near the mirror direction and 1 % elsewhere.
    pub const BLACK: Self = Self { highlight: 0.02, shininess: 3.0, albedo: 0.06 };

    /// Checks the numbers.
    ///
    /// # Errors
    /// One outside its range.
    pub fn validate(&self) -> Result<()> {
        range("paper", "highlight", self.highlight, 0.0..=1.0)?;
        range("paper", "shininess", self.shininess, 0.0..=1000.0)?;
        range("paper", "albedo", self.albedo, 0.0..=1.0)
    }

    /// BRDF, 1/sr; 0 below the horizon.
    pub fn reflectance(&self, wi: Vec3, wo: Vec3) -> f32 {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        let along = (wi.z * wo.z - wi.truncate().dot(wo.truncate())).max(0.0);
        // The lobe's integral over the directions around its middle is 2 pi / (n + 2) with the cosine.
        let highlight = self.highlight * (self.shininess + 2.0) / (2.0 * PI) * along.powf(self.shininess);
        highlight + 0.25 * FRAC_1_PI * self.albedo / (wi.z + wo.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use std::f64::consts::{FRAC_PI_2, TAU};

    /// Light from above: the highlight's share exactly, and of the rest `albedo (1 - ln 2) / 2`, by the integral of
    /// `cos / (1 + cos)`.
    #[test]
    fn shares_of_light_are_those_of_the_integrals() {
        let share = |paper: Paper| {
            let (n, m) = (2000, 16);
            let mut sum = 0.0;
            for a in 0..n {
                let theta = (f64::from(a) + 0.5) * FRAC_PI_2 / f64::from(n);
                for b in 0..m {
                    let wi = spherical(theta, f64::from(b) * TAU / f64::from(m));
                    let weight = theta.cos() * theta.sin() * FRAC_PI_2 / f64::from(n) * TAU / f64::from(m);
                    sum += f64::from(paper.reflectance(wi.as_vec3(), Vec3::Z)) * weight;
                }
            }
            sum
        };
        for shininess in [0.0, 3.0, 20.0] {
            let found = share(Paper { highlight: 0.3, shininess, albedo: 0.0 });
            assert!((found - 0.3).abs() < 1e-5, "{shininess}: {found}");
        }
        let found = share(Paper { highlight: 0.0, shininess: 1.0, albedo: 0.5 });
        assert!((found - 0.25 * (1.0 - 2f64.ln())).abs() < 1e-5, "{found}");
        assert!(Paper { albedo: 1.5, ..Paper::BLACK }.validate().is_err());
        assert!(Paper { shininess: f32::NAN, ..Paper::BLACK }.validate().is_err());
        let (wi, wo) = (spherical(0.4, 0.0).as_vec3(), spherical(1.2, 2.8).as_vec3());
        assert!((Paper::BLACK.reflectance(wi, wo) / Paper::BLACK.reflectance(wo, wi) - 1.0).abs() < 1e-5);
    }
}
