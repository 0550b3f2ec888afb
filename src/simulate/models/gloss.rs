//! The gloss of a rough surface: the Fresnel reflectance, smoothed over a bell about the mirror direction.
//!
//! Ershov 2001, end of section 6.4, asks for a Gaussian and names none. Here
//! `f(wi, wo) = g(theta') g(theta) exp(-2 sin^2(delta/2) / sigma^2)`, delta the angle between `wo` and the mirrored `wi`: the
//! Gaussian of the sphere (von Mises and Fisher), of width sigma where that is small. It is reciprocal by its form, and g is
//! the one function for which no energy is lost or won at any incidence:
//! `int f cos(theta) domega = r_eta(theta')`, a symmetric scaling problem with a unique positive solution.
//!
//! The azimuth integral of the bell is `2 pi exp(-2 sin^2((theta - theta')/2) / sigma^2) exp(-x) I0(x)`,
//! `x = sin(theta) sin(theta') / sigma^2`. With `g = r s` the condition reads `s = 1 / (A r s)`: s is smooth on the scale of
//! sigma, even where r is not, and is solved for on its nodes.

use crate::brdf::fresnel::dielectric;
use crate::error::{Error, Result};
use crate::math::quadrature::{breaks, composite};
use crate::simulate::optics::bessel::i0_scaled;
use crate::simulate::optics::piecewise::Piecewise;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Rougher than this is a lobe, smoother a mirror: a 500th of the sun's radius, radians.
const MIRROR: f64 = 1e-5;
/// Each halves the error of log s, or better.
const ITERATIONS: usize = 60;
/// Where panels end, in multiples of the width of a bell; the last is exp(-40).
const STEPS: [f64; 7] = [1.0, 2.0, 3.0, 4.0, 5.5, 7.0, 9.0];

/// Gloss of a surface, mirror or rough.
#[derive(Debug, Clone, PartialEq)]
pub struct Gloss {
    index: f64,
    lobe: Option<Lobe>,
}

/// The lobe of a rough surface.
#[derive(Debug, Clone, PartialEq)]
struct Lobe {
    /// `1 / sigma^2`.
    kappa: f64,
    /// s over theta.
    scale: Piecewise<1>,
}

impl Gloss {
    /// Gloss of a surface of relative index `index`, 1 to 10, and `roughness` sigma, radians, 0 to pi/4; below 1e-5 it is a
    /// mirror. Takes some 10 ms unless it is.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn new(index: f64, roughness: f64) -> Result<Self> {
        if !(1.0..=10.0).contains(&index) {
            return Err(Error::invalid("gloss", "index", index, "1 to 10"));
        }
        if !(0.0..=FRAC_PI_4).contains(&roughness) {
            return Err(Error::invalid("gloss", "roughness in radians", roughness, "0 to pi/4"));
        }
        // An index of 1 is no surface.
        let rough = roughness >= MIRROR && index > 1.0;
        Ok(Self { index, lobe: rough.then(|| Lobe::solve(index, roughness)) })
    }

    /// Whether all gloss goes into the mirror direction: its BRDF is a delta function, which [`Gloss::brdf`] leaves out.
    pub fn is_mirror(&self) -> bool {
        self.lobe.is_none()
    }

    /// BRDF, 1/sr, for unit directions away from the surface; 0 for a mirror, and unless both are above the horizon.
    pub fn brdf(&self, wi: DVec3, wo: DVec3) -> f64 {
        match &self.lobe {
            Some(lobe) if wi.z > 0.0 && wo.z > 0.0 => {
                // |wo - mirrored wi|^2 = 4 sin^2(delta/2).
                let apart = (wi.truncate() + wo.truncate()).length_squared() + (wi.z - wo.z).powi(2);
                let sides = [wi, wo].map(|w| {
                    let theta = w.truncate().length().atan2(w.z);
                    dielectric(w.z, self.index) * lobe.scale.eval(theta)[0]
                });
                sides[0] * sides[1] * (-0.5 * lobe.kappa * apart).exp()
            }
            _ => 0.0,
        }
    }
}

impl Lobe {
    fn solve(index: f64, sigma: f64) -> Self {
        let kappa = 1.0 / (sigma * sigma);
        // Towards grazing, where 1/cos(theta) grows, panels shrink until the bell smooths it.
        let from_grazing = STEPS.into_iter().chain((1..24).map(|k| 9.0 * f64::from(1 << k)));
        let panels = breaks(0.0, FRAC_PI_2, from_grazing.map(|m| FRAC_PI_2 - m * sigma));
        let nodes = Piecewise::<1>::nodes(&panels);
        let rows: Vec<Vec<f64>> = nodes.iter().map(|theta| row(*theta, index, sigma, &panels)).collect();
        // Starts from the narrow bell, whose integral is 2 pi sigma^2.
        let mut s: Vec<f64> = nodes
            .iter()
            .map(|theta| (kappa / (2.0 * PI * dielectric(theta.cos(), index) * (theta.cos() + sigma))).sqrt())
            .collect();
        for _ in 0..ITERATIONS {
            let sums = rows.iter().map(|row| row.iter().zip(&s).map(|(a, s)| a * s).sum::<f64>());
            s = s.iter().zip(sums).map(|(s, sum)| (s / sum).sqrt()).collect();
        }
        let values: Vec<[f64; 1]> = s.into_iter().map(|s| [s]).collect();
        Self { kappa, scale: Piecewise::from_values(&panels, &values) }
    }
}

/// What s at each node counts in `int r s cos sin` over theta and azimuth times the bell, for the incidence `at`.
fn row(at: f64, index: f64, sigma: f64, panels: &[f64]) -> Vec<f64> {
    let kappa = 1.0 / (sigma * sigma);
    let widest = STEPS[STEPS.len() - 1] * sigma;
    let (low, high) = ((at - widest).max(0.0), (at + widest).min(FRAC_PI_2));
    let around = STEPS.iter().flat_map(|m| [at - m * sigma, at + m * sigma]).chain([at]);
    // r turns from 1 to its plateau over a distance from grazing that falls with the index.
    let onset = (1..12).map(|k| FRAC_PI_2 - 0.5f64.powi(k));
    Piecewise::<1>::node_weights(panels, |add| {
        for (theta, weight) in composite(&breaks(low, high, around.chain(onset))) {
            let (sin_t, cos_t) = theta.sin_cos();
            let bell = (-2.0 * kappa * (0.5 * (theta - at)).sin().powi(2)).exp();
            let ring = 2.0 * PI * bell * i0_scaled(kappa * sin_t * at.sin());
            add(theta, weight * ring * dielectric(cos_t, index) * cos_t * sin_t);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;

    /// Hemispherical reflectance of the lobe by brute force: a product rule over both angles, none of the closed forms.
    fn reflectance(gloss: &Gloss, sigma: f64, theta: f64) -> f64 {
        let wi = spherical(theta, 0.0);
        let around = (-12..=12).map(|k| theta + 0.75 * f64::from(k) * sigma);
        let low = (theta - 9.0 * sigma).max(0.0);
        let high = (theta + 9.0 * sigma).min(FRAC_PI_2);
        // The reflectance of a weak surface rises within degrees of grazing.
        let onset = (1..9).map(|k| FRAC_PI_2 - 0.5f64.powi(k));
        let mut sum = 0.0;
        for (t, w) in composite(&breaks(low, high, around.chain(onset))) {
            // At a polar angle the lobe is sigma / sin wide in azimuth.
            let width = sigma / (t.sin() * theta.sin()).sqrt().max(1e-9);
            let turns = (-12..=12).map(|k| PI + 0.75 * f64::from(k) * width);
            let (from, to) = ((PI - 9.0 * width).max(0.0), (PI + 9.0 * width).min(2.0 * PI));
            for (phi, v) in composite(&breaks(from, to, turns)) {
                sum += w * v * gloss.brdf(wi, spherical(t, phi)) * t.cos() * t.sin();
            }
        }
        sum
    }

    #[test]
    fn no_energy_is_lost_or_won_at_any_angle() {
        let mut worst = 0.0f64;
        for degrees in [0.1f64, 1.0, 5.0, 20.0, 45.0] {
            for index in [1.001, 1.5, 4.0] {
                let sigma = degrees.to_radians();
                let gloss = Gloss::new(index, sigma).unwrap();
                for angle in [0.0, 0.05, 0.3, 10.0, 45.0, 60.0, 75.0, 85.0, 88.0, 89.0, 89.7, 89.9f64] {
                    let theta = angle.to_radians();
                    let expected = dielectric(theta.cos(), index);
                    let error = (reflectance(&gloss, sigma, theta) / expected - 1.0).abs();
                    worst = worst.max(error);
                    assert!(error < 1e-6, "{degrees} {index} {angle}: {error:e}");
                }
            }
        }
        println!("gloss: energy to {worst:.1e}");
    }

    #[test]
    fn the_lobe_is_reciprocal_to_rounding() {
        let gloss = Gloss::new(1.5, 0.2).unwrap();
        for (a, b, phi) in [(0.1, 1.2, 3.0), (0.8, 0.6, 3.1), (1.5, 0.0, 0.0), (1.57, 1.4, 2.9)] {
            let (wi, wo) = (spherical(a, 0.3), spherical(b, 0.3 + phi));
            let (there, back) = (gloss.brdf(wi, wo), gloss.brdf(wo, wi));
            // The same numbers, the two factors in another order.
            assert!((there - back).abs() <= 1e-15 * there, "{there} {back}");
            assert_eq!(gloss.brdf(wi, -wo), 0.0);
        }
    }

    #[test]
    fn sigma_is_the_width_and_the_peak_is_that_of_a_gaussian() {
        for degrees in [0.1f64, 0.5, 2.0] {
            let sigma = degrees.to_radians();
            let gloss = Gloss::new(1.5, sigma).unwrap();
            let (wi, theta) = (spherical(0.7, 0.0), 0.7f64);
            let at = |shift: f64| gloss.brdf(wi, spherical(theta, PI + shift / theta.sin()));
            // Off the plane of incidence the cosines stay: only the bell falls, up to the curvature of the sphere.
            assert!((at(sigma) / at(0.0) - (-0.5f64).exp()).abs() < sigma * sigma, "{degrees}");
            // Times cos: the density of a plane Gaussian times the reflectance, up to terms of the second order.
            let peak = at(0.0) * theta.cos() * 2.0 * PI * sigma * sigma / dielectric(theta.cos(), 1.5);
            assert!((peak - 1.0).abs() < 3.0 * sigma * sigma, "{degrees}: {peak}");
        }
    }

    #[test]
    fn a_narrow_lobe_tends_to_the_mirror() {
        // What falls within a degree of the mirror direction.
        let share = |degrees: f64| {
            let gloss = Gloss::new(1.5, degrees.to_radians()).unwrap();
            let theta = 1.2f64;
            let (wi, mirror) = (spherical(theta, 0.0), spherical(theta, PI));
            let (across, along) = (DVec3::Y, mirror.cross(DVec3::Y));
            let sum: f64 = composite(&breaks(0.0, 1f64.to_radians(), [1e-4, 1e-3, 5e-3]))
                .flat_map(|(d, w)| {
                    let ring = (0..64).map(move |k| (d, w, 2.0 * PI * f64::from(k) / 64.0));
                    ring.collect::<Vec<_>>()
                })
                .map(|(d, w, a)| {
                    let wo = mirror * d.cos() + (across * a.sin() + along * a.cos()) * d.sin();
                    w * d.sin() * 2.0 * PI / 64.0 * gloss.brdf(wi, wo) * wo.z
                })
                .sum();
            sum / dielectric(theta.cos(), 1.5)
        };
        // 1 - exp(-1/(2 sigma^2)): 86 % at half a degree, all at a tenth, up to the slope of the reflectance.
        assert!((share(0.5) - 0.8647).abs() < 1e-3, "{}", share(0.5));
        assert!((share(0.1) - 1.0).abs() < 1e-6, "{}", share(0.1));
    }

    #[test]
    fn mirrors_and_no_surface_have_no_lobe_and_bad_values_are_refused() {
        for (index, roughness) in [(1.5, 0.0), (1.5, 1e-9), (1.0, 0.3)] {
            let gloss = Gloss::new(index, roughness).unwrap();
            assert!(gloss.is_mirror());
            assert_eq!(gloss.brdf(DVec3::Z, DVec3::Z), 0.0);
        }
        for (index, roughness, word) in
            [(0.9, 0.1, "index"), (f64::NAN, 0.1, "index"), (1.5, -0.1, "roughness"), (1.5, 0.8, "pi/4")]
        {
            assert!(Gloss::new(index, roughness).unwrap_err().to_string().contains(word));
        }
    }
}
