//! A clear sky: the luminance of the CIE standard general sky, tinted.
//!
//! Type 12 of CIE S 011 / ISO 15469:2004 ("standard clear sky, low luminance turbidity"): at zenith angle Z, at an angle chi from
//! the sun, luminance is `f(chi) phi(Z)` over its value at the zenith, with `phi = 1 + a exp(b / cos Z)` and
//! `f = 1 + c (exp(d chi) - exp(d pi/2)) + e cos^2 chi`. The standard gives no color: what the air adds along long ways
//! (`phi`) and around the sun (`f`) is whiter than the zenith, half way to its gray where it is twice as bright.

use super::panorama::Panorama;
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Columns and rows of the panorama; the glow around the sun is some degrees wide.
const SIZE: [usize; 2] = [512, 256];

/// A sky above a ground of the same radiance everywhere.
pub(super) fn sky(sun: DVec3, zenith: DVec3, ground: DVec3) -> Result<Panorama> {
    let sun = sun.normalize();
    let [width, height] = SIZE;
    let direction = |k: usize| {
        let longitude = TAU * ((k % width) as f64 + 0.5) / width as f64 - PI;
        let colatitude = PI * ((k / width) as f64 + 0.5) / height as f64;
        let (sin, cos) = colatitude.sin_cos();
        DVec3::new(sin * longitude.sin(), sin * longitude.cos(), cos)
    };
    let above: Vec<DVec3> = (0..width * height / 2).map(|k| radiance(sun, zenith, direction(k))).collect();
    // Irradiance of the ground over pi: the cosine-weighted mean.
    let weight = |k: usize| direction(k).z * (1.0 - direction(k).z.powi(2)).sqrt();
    let total: f64 = (0..above.len()).map(weight).sum();
    let mean = above.iter().enumerate().map(|(k, c)| *c * weight(k)).sum::<DVec3>() / total;
    let below = std::iter::repeat_n(ground * mean, width * height / 2);
    let pixels = above.into_iter().chain(below).map(|c| c.as_vec3().to_array()).collect();
    Panorama::new(SIZE, pixels, 1.0, 0.0)
}

/// Radiance from a direction above the horizon.
fn radiance(sun: DVec3, zenith: DVec3, direction: DVec3) -> DVec3 {
    let gradation = |cosine: f64| 1.0 - (-0.32 / cosine.max(1e-3)).exp();
    let glow = |cosine: f64| {
        let angle = cosine.clamp(-1.0, 1.0).acos();
        1.0 + 10.0 * ((-3.0 * angle).exp() - (-3.0 * FRAC_PI_2).exp()) + 0.45 * cosine * cosine
    };
    let relative = gradation(direction.z) * glow(direction.dot(sun)) / (gradation(1.0) * glow(sun.z));
    let gray = DVec3::splat(zenith.dot(DVec3::new(0.2126, 0.7152, 0.0722)));
    let whiteness = (1.0 - 1.0 / relative.max(1.0)).clamp(0.0, 1.0);
    zenith.lerp(gray, whiteness) * relative
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_zenith_is_as_given_and_the_sky_is_brightest_at_the_sun() {
        let sun = DVec3::new(0.6, 0.0, 0.8);
        let zenith = DVec3::new(0.2, 0.4, 0.8);
        let sky = sky(sun, zenith, DVec3::splat(0.5)).unwrap();
        // The middle of the texels next to it is 0.35 degrees away.
        let seen = sky.radiance(Vec3::Z).as_dvec3();
        assert!((seen / zenith - 1.0).abs().max_element() < 0.02, "{seen}");
        let luminance = |v: DVec3| sky.radiance(v.normalize().as_vec3()).element_sum();
        let brightest = luminance(sun);
        for k in 0..500 {
            let (a, z) = (f64::from(k) * 2.4, f64::from(k) / 500.0);
            let level = (1.0 - z * z).sqrt();
            let direction = DVec3::new(level * a.cos(), level * a.sin(), z);
            assert!(luminance(direction) < 1.01 * brightest, "{direction}");
        }
        // The same ground everywhere, half of a white one's radiance.
        let [below, aside] = [Vec3::NEG_Z, Vec3::new(0.6, 0.0, -0.8)].map(|v| sky.radiance(v));
        // Roundings of bilinear weights.
        assert!((below - aside).abs().max_element() < 1e-6, "{below} {aside}");
    }
}
