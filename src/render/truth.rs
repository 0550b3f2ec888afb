//! What a paint's flakes are, in place of their statistics: to judge those in the picture.

use super::footprint::Surface;
use super::paint::RenderPaint;
use super::shade::{Geometry, transmittance};
use super::slices::RenderSlices;
use crate::scene::Incidence;
use crate::simulate::sparkle::{Arrival, Pixel, SparkleModel};
use glam::{DMat3, DVec3, Vec3};

/// Where the fluctuation of the flakes about their mean comes from.
#[derive(Debug, Clone, Copy)]
pub enum FlakeTruth<'a> {
    /// The raw slices that statistics were made from. Lamps count with their middle.
    Slices(&'a RenderSlices),
    /// Ershov's sparkles: drawn anew for every sample of every pixel, lamps independent of each other and as large as they are.
    Sparkles(&'a SparkleModel<'a>),
}

/// A lamp as it meets a patch of paint, in the frame that is fixed to the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shine {
    /// Towards the middle of the lamp.
    pub wi: DVec3,
    /// On a surface that faces the lamp.
    pub irradiance: DVec3,
    /// Radians.
    pub angular_radius: f64,
}

impl Shine {
    /// A lamp in the local frame `to_local`.
    pub(super) fn new(lamp: &Incidence, to_local: &DMat3) -> Self {
        Self {
            wi: *to_local * lamp.direction,
            irradiance: lamp.irradiance,
            angular_radius: lamp.angular_radius,
        }
    }
}

/// Radiance of the mean of a paint's flakes, about which truths fluctuate.
pub(super) fn flakes_mean(paint: &RenderPaint, shines: &[Shine], wo: Vec3) -> Vec3 {
    let Some(flakes) = paint.flakes.as_ref().filter(|_| wo.z > 0.0) else { return Vec3::ZERO };
    shines.iter().filter(|shine| shine.wi.z > 0.0).fold(Vec3::ZERO, |sum, shine| {
        let wi = shine.wi.as_vec3();
        let g = Geometry::of(paint.coat.inner(wi), paint.coat.inner(wo));
        let mean = flakes.mean(g.theta_h, g.theta_i) * transmittance(&paint.coat, wi.z, wo.z);
        sum + mean * shine.irradiance.as_vec3() * wi.z
    })
}

impl FlakeTruth<'_> {
    /// Radiance of the fluctuation under all lamps, its mean 0. `place` and `seed` say whose random numbers.
    pub(super) fn radiance(&self, surface: &Surface, wo: Vec3, shines: &[Shine], place: [u32; 2]) -> Vec3 {
        match self {
            Self::Slices(slices) => shines.iter().fold(Vec3::ZERO, |sum, shine| {
                let wi = shine.wi.as_vec3();
                if wi.z <= 0.0 || wo.z <= 0.0 {
                    return sum;
                }
                let g = Geometry::of(wi, wo);
                sum + slices.xi(surface, g.theta_h, g.theta_i) * shine.irradiance.as_vec3() * wi.z
            }),
            Self::Sparkles(model) => {
                let arrivals: Vec<Arrival> = shines
                    .iter()
                    .map(|s| Arrival { direction: s.wi, irradiance: s.irradiance, radius: s.angular_radius })
                    .collect();
                let [a, b] = surface.footprint;
                // Square micrometres; a footprint without an area has no flakes.
                let area_um2 = f64::from(a.perp_dot(b).abs()) * 1e6;
                if area_um2 <= 0.0 {
                    return Vec3::ZERO;
                }
                let pixel = Pixel { place, area_um2 };
                let wo = wo.as_dvec3().normalize();
                model.pixel(&pixel, u64::from(surface.seed), wo, &arrivals).fluctuation().as_vec3()
            }
        }
    }
}
