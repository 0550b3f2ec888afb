//! Goniochromatic reflection: a color that changes with angle, from two spectra and a roughness (Pranovich et al. 2024).
//!
//! Torrance and Sparrow's model with the distribution of Trowbridge and Reitz (GGX), whose Fresnel term, shadowing and
//! cosines are replaced by an empirical exponential (eqs 4, 5):
//! `f = D(theta_h) rho exp(c (1 - cos((theta_i + theta_o) / 2))) / 4`, `rho` and `c` a value a wavelength.
//! It is reciprocal, but not bound to keep energy: `c > 0` multiplies it by up to `exp(c)`, so that fits say where it gives
//! back more light than it gets.

use super::LobeGeometry;
use crate::check::range;
use crate::error::Result;
use glam::DVec3;
use num_traits::{Float, FloatConst};
use std::f64::consts::TAU;

/// The model at one wavelength. `F` as in [`super::Lobe`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goniochromatic<F = f64> {
    /// Roughness alpha, 1e-4 to 1; the same at all wavelengths.
    pub roughness: F,
    /// Reflectance rho, 0 to 1e6.
    pub reflectance: F,
    /// Coefficient c: how fast reflectance grows towards grazing angles, -50 to 50; the paper's inks have -1 to 6.
    pub growth: F,
}

impl Goniochromatic {
    /// Largest coefficient c, either sign: with the largest rho and the smallest alpha the BRDF is still an f32.
    pub const MAX_GROWTH: f64 = 50.0;
    /// Largest reflectance rho.
    pub const MAX_REFLECTANCE: f64 = 1e6;
    /// Smallest roughness alpha.
    pub const MIN_ROUGHNESS: f64 = 1e-4;

    /// Checks the numbers.
    ///
    /// # Errors
    /// One outside its range.
    pub fn validate(&self) -> Result<()> {
        range("goniochromatic model", "alpha", self.roughness, Self::MIN_ROUGHNESS..=1.0)?;
        range("goniochromatic model", "rho", self.reflectance, 0.0..=Self::MAX_REFLECTANCE)?;
        range("goniochromatic model", "c", self.growth, -Self::MAX_GROWTH..=Self::MAX_GROWTH)
    }

    /// BRDF, 1/sr (eq. 5); finite up to the horizon, 0 below it.
    pub fn eval(&self, g: &LobeGeometry) -> f64 {
        if g.cos_i < 0.0 || g.cos_o < 0.0 {
            return 0.0;
        }
        0.25 * ggx(g.tan2_h, self.roughness) * self.directional(cos_mean_angle(g.cos_i, g.cos_o))
    }

    /// BRDF, 1/sr, where light is mirrored at a cosine (eq. 7: equal polar angles on opposite sides, which the paper writes as
    /// equal directions).
    pub fn mirrored(&self, cos_i: f64) -> f64 {
        0.25 * ggx(0.0, self.roughness) * self.directional(cos_i)
    }
}

impl<F: Float> Goniochromatic<F> {
    /// What takes the place of Fresnel term, shadowing and cosines (eq. 4), from the cosine of the mean angle, in [0, 1].
    pub fn directional(&self, cos_mean: F) -> F {
        self.reflectance * (self.growth * (F::one() - cos_mean)).exp()
    }
}

/// Distribution of Trowbridge and Reitz by the squared tangent of the half vector's angle, 1/sr (eq. 3).
///
/// `alpha^2 / (pi ((alpha^2 - 1) cos^2 + 1)^2`, divided through by cosines: `1 + (1 - alpha^2) / (alpha^2 + tan^2)` has no
/// difference of near numbers at any roughness. Light and eye opposite each other along the surface have no half vector: NaN
/// counts as the normal, as on the mirror side.
pub fn ggx<F: Float + FloatConst>(tan2_h: F, roughness: F) -> F {
    let a2 = roughness * roughness;
    let tan2_h = if tan2_h.is_nan() { F::zero() } else { tan2_h };
    let root = F::one() + (F::one() - a2) / (a2 + tan2_h);
    a2 * root * root * F::FRAC_1_PI()
}

/// Cosine of the mean of two polar angles from their cosines in [0, 1].
///
/// Eq. 6, `(sqrt((1 + a)(1 + b)) - sqrt((1 - a)(1 - b))) / 2`, multiplied by the sum of the same roots: at grazing angles the
/// difference loses all digits, and the quotient none.
pub fn cos_mean_angle<F: Float>(cos_i: F, cos_o: F) -> F {
    let one = F::one();
    let outer = ((one + cos_i) * (one + cos_o)).sqrt();
    let inner = ((one - cos_i) * (one - cos_o)).max(F::zero()).sqrt();
    (cos_i + cos_o) / (outer + inner)
}

/// A direction to the light for one to the eye, drawn by [`ggx`] about the normal; `None` below the horizon. `u` in [0, 1).
pub fn sample(wo: DVec3, roughness: f64, u: [f64; 2]) -> Option<DVec3> {
    let tan2 = roughness * roughness * u[0] / (1.0 - u[0]);
    let cos = 1.0 / (1.0 + tan2).sqrt();
    let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
    let sin = cos * tan2.sqrt();
    let h = DVec3::new(sin * cos_phi, sin * sin_phi, cos);
    let along = h.dot(wo);
    let wi = (2.0 * along * h - wo).normalize();
    (along > 0.0 && wi.z > 0.0).then_some(wi)
}

/// Density of [`sample`], 1/sr.
pub fn density(g: &LobeGeometry, roughness: f64) -> f64 {
    if g.cos_d > 0.0 { ggx(g.tan2_h, roughness) * g.cos_h / (4.0 * g.cos_d) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use std::f64::consts::PI;

    /// The form with arc cosines keeps its digits away from 0, where it loses half of them.
    #[test]
    fn the_mean_angle_equals_that_of_arc_cosines() {
        for a in (1..=89).map(|k| f64::from(k).to_radians()) {
            for b in (1..=89).map(|k| f64::from(k).to_radians()) {
                let (cos_a, cos_b) = (a.cos(), b.cos());
                let expected = (0.5 * (cos_a.acos() + cos_b.acos())).cos();
                let found = cos_mean_angle(cos_a, cos_b);
                assert!((found - expected).abs() < 1e-14, "{a} {b}: {found} {expected}");
            }
        }
        // At the horizon the cosine itself is what is left: relative to it nothing is lost.
        for tiny in [1e-300, 1e-17, 1e-8, 1e-3] {
            let found = cos_mean_angle(tiny, tiny);
            assert!((found / tiny - 1.0).abs() < 4.0 * f64::EPSILON, "{tiny}: {found}");
        }
        assert_eq!((cos_mean_angle(1.0, 1.0), cos_mean_angle(0.0, 0.0)), (1.0, 0.0));
        assert!((cos_mean_angle(1.0, 0.0) - 0.5f64.sqrt()).abs() < f64::EPSILON);
    }

    #[test]
    fn nothing_is_no_number() {
        let angles = [0.0, 1e-9, 0.3, 1.2, PI / 2.0 - 1e-9, PI / 2.0];
        for roughness in [1e-3, 0.19, 1.0] {
            for growth in [-10.0, 0.0, 40.0] {
                for reflectance in [0.0, 0.7] {
                    let model = Goniochromatic { roughness, reflectance, growth };
                    model.validate().unwrap();
                    for (theta_i, theta_o, phi) in angles
                        .iter()
                        .flat_map(|a| angles.iter().flat_map(|b| [0.0, 1.0, PI].map(|p| (*a, *b, p))))
                    {
                        let g = LobeGeometry::of(spherical(theta_i, 0.0), spherical(theta_o, phi));
                        let f = model.eval(&g);
                        assert!(f.is_finite() && f >= 0.0, "{model:?} {theta_i} {theta_o} {phi}: {f}");
                        assert!(reflectance > 0.0 || f == 0.0);
                    }
                }
            }
        }
        let opposite = LobeGeometry::of(DVec3::X, -DVec3::X);
        assert!(Goniochromatic { roughness: 0.2, reflectance: 1.0, growth: 3.0 }.eval(&opposite).is_finite());
    }

    #[test]
    fn it_is_reciprocal_and_mirrors_by_equation_7() {
        let model = Goniochromatic { roughness: 0.19, reflectance: 0.4, growth: 2.5 };
        let (wi, wo) = (spherical(0.7, 0.2), spherical(1.3, 2.0));
        let [f, back] = [LobeGeometry::of(wi, wo), LobeGeometry::of(wo, wi)].map(|g| model.eval(&g));
        assert!((f / back - 1.0).abs() < 1e-14);
        for theta in [0.0, 0.4, 1.0, 1.5] {
            let g = LobeGeometry::of(spherical(theta, 0.0), spherical(theta, PI));
            assert!((model.eval(&g) / model.mirrored(theta.cos()) - 1.0).abs() < 1e-12, "{theta}");
        }
    }

    /// What is mirrored in all, by samples and by a sum over half vectors: the density is that of the samples.
    #[test]
    fn samples_have_their_density() {
        for roughness in [0.1, 0.19, 0.5, 1.0] {
            for theta in [0.0, 0.5, 1.05, 1.4] {
                let wo = spherical(theta, 0.3);
                let model = Goniochromatic { roughness, reflectance: 1.0, growth: 1.5 };
                let weigh = |wi: DVec3| {
                    let g = LobeGeometry::of(wi, wo);
                    (model.eval(&g) * wi.z, density(&g, roughness))
                };
                const N: u32 = 400;
                let (mut sampled, mut squares) = (0.0, 0.0);
                for k in 0..N * N {
                    let u =
                        [(f64::from(k % N) + 0.5) / f64::from(N), (f64::from(k / N) + 0.5) / f64::from(N)];
                    if let Some(wi) = sample(wo, roughness, u) {
                        let (f, density) = weigh(wi);
                        sampled += f / density;
                        squares += (f / density) * (f / density);
                    }
                }
                let count = f64::from(N * N);
                let mut summed = 0.0;
                for k in 0..N * N {
                    // Even in both: a spherical grid of light.
                    let (theta_i, phi) = (
                        (f64::from(k / N) + 0.5) * 0.5 * PI / f64::from(N),
                        (f64::from(k % N) + 0.5) * TAU / f64::from(N),
                    );
                    let wi = spherical(theta_i, phi);
                    summed += weigh(wi).0 * theta_i.sin() * 0.5 * PI * TAU / count;
                }
                let (sampled, error) = (sampled / count, (squares / count / count).sqrt());
                // Regular samples are far better than their standard error but for the horizon's edge; the grid resolves a lobe of 0.1
                // radians to a thousandth.
                assert!(
                    (sampled / summed - 1.0).abs() < 2e-3 + error,
                    "{roughness} {theta}: {sampled} {summed}"
                );
            }
        }
    }
}
