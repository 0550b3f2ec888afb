//! 2Q: what flakes and surface return of a Lambertian substrate's light (Ershov 2001, eq. 26 and what follows (28)).
//!
//! `2Q = sum D<S>h int r_p(theta) (1 - exp(-2 tau h)) / (2 tau h) sin(2 theta) dtheta
//!     + int r_(1/eta)(theta) exp(-2 tau h) sin(2 theta) dtheta`, both over [0, pi/2].
//!
//! The flake term is the paper's: nearly parallel flakes mirror a ray into its own polar angle. Eq. 26 itself (with the
//! cosine of the incident angle) is 1 % lower at a spread of 5 degrees and 9 % at 15, and farther from the full solution, in
//! which light is also returned after several scatterings.

use super::fast_model::{KindModel, mean_attenuation};
use super::piecewise::Piecewise;
use crate::brdf::fresnel::dielectric;
use crate::color::{BANDS, Spectrum};
use crate::math::quadrature::{breaks, composite};
use std::f64::consts::FRAC_PI_2;

/// 2Q over wavelength, for the binder's index, `tau h cos` over the angle, and the flakes.
pub fn substrate_return(index: f64, extinction: &Piecewise<BANDS>, kinds: &[KindModel]) -> Spectrum {
    let mut sum = [0.0; BANDS];
    for (theta, weight) in rule(index) {
        let (sin_t, cos_t) = theta.sin_cos();
        let weight = 2.0 * weight * sin_t * cos_t;
        let thickness = extinction.eval(theta).map(|x| 2.0 * x / cos_t);
        let surface = weight * dielectric(cos_t, 1.0 / index);
        for (s, x) in sum.iter_mut().zip(&thickness) {
            *s += surface * (-x).exp();
        }
        for kind in kinds {
            let reflectance = kind.optics.reflectance(cos_t);
            for ((s, x), r) in sum.iter_mut().zip(&thickness).zip(reflectance) {
                *s += weight * kind.area_density * r * mean_attenuation(*x);
            }
        }
    }
    Spectrum(sum)
}

/// Quadrature over [0, pi/2]: panels on both sides of the critical angle, below it with the square-root singularity of the
/// Fresnel reflectance taken out, above it shrinking towards grazing, where a thin film turns opaque.
fn rule(index: f64) -> Vec<(f64, f64)> {
    let critical = (1.0 / index).asin();
    let below = composite(&[0.0, 0.3, 1.0])
        .map(|(v, w)| (critical * (1.0 - v * v), 2.0 * critical * v * w))
        .collect::<Vec<_>>();
    let rest = FRAC_PI_2 - critical;
    let steps = [0.5, 0.2, 0.05, 0.01, 0.001].map(|x| FRAC_PI_2 - x * rest);
    below.into_iter().chain(composite(&breaks(critical, FRAC_PI_2, steps))).collect()
}

/// F(eta), eq. 31: mean inner reflectance of a surface for Lambertian light from below.
///
/// `F = int_0^(pi/2) r_(1/eta)(theta) sin(2 theta) dtheta`; 0.596345759708 for eta = 1.5. `index` >= 1.
pub fn mean_inner_reflectance(index: f64) -> f64 {
    rule(index).iter().map(|(theta, w)| w * dielectric(theta.cos(), 1.0 / index) * (2.0 * theta).sin()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_inner_reflectance_is_the_published_one() {
        // Quadrature of an integrand made smooth: rounding.
        assert!((mean_inner_reflectance(1.5) - 0.596_345_759_707_711_6).abs() < 1e-12);
        assert!(mean_inner_reflectance(1.0).abs() < 1e-12);
    }

    #[test]
    fn the_surface_rule_covers_the_quarter_circle() {
        for index in [1.0, 1.33, 1.5, 4.0] {
            let total: f64 = rule(index).iter().map(|x| x.1).sum();
            assert!((total - FRAC_PI_2).abs() < 1e-13, "{index}");
        }
    }
}
