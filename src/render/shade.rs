//! The BRDF of a paint at a point, f32, as the shader computes it.
//!
//! `f = (1 - F(wi)) (1 - F(wo)) [ chi (a/pi + sum CT) + Xi ] + gloss` (see [`crate::paint`]); directions are local,
//! z = normal, and point away from the surface. The ideal mirror of a coat is no function: light loops add it.

use super::draws::FlakeDraws;
use super::paint::{RenderCoat, RenderPaint};
use crate::brdf::cook_torrance::brightness;
use crate::brdf::fresnel::{dielectric, refracted_cosine, transmitted};
use crate::brdf::{Lobe, LobeGeometry, projected_half};
use glam::Vec3;

/// The angles of a pair of directions that lobes, color table and flakes depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// What the lobes take.
    pub lobe: LobeGeometry<f32>,
    /// Angle between half vector and normal, radians.
    pub theta_h: f32,
    /// Angle between half vector and either direction, radians.
    pub theta_i: f32,
}

impl Geometry {
    /// Geometry of unit directions. Angles by `atan2`: an f32 cosine near 1 has lost them.
    pub fn of(wi: Vec3, wo: Vec3) -> Self {
        let sum = wi + wo;
        Self {
            lobe: lobe_geometry(wi, wo),
            theta_h: sum.truncate().length().atan2(sum.z),
            theta_i: (wi - wo).length().atan2(sum.length()),
        }
    }
}

/// What the lobes take. The tangent by division, for the same reason.
pub(super) fn lobe_geometry(wi: Vec3, wo: Vec3) -> LobeGeometry<f32> {
    let sum = wi + wo;
    let length = sum.length();
    LobeGeometry {
        tan2_h: sum.truncate().length_squared() / (sum.z * sum.z),
        cos_h: sum.z / length,
        cos_i: wi.z,
        cos_o: wo.z,
        cos_d: 0.5 * length,
    }
}

impl RenderCoat {
    /// Reflectance of the surface at an outer cosine.
    pub fn reflectance(&self, cosine: f32) -> f32 {
        dielectric(cosine, self.ior)
    }

    /// The direction that the base sees.
    pub fn inner(&self, outer: Vec3) -> Vec3 {
        if !self.refracts {
            return outer;
        }
        (outer.truncate() / self.ior).extend(refracted_cosine(outer.z, self.ior))
    }

    /// The gloss lobe, 1/sr, its squared roughness enlarged by `widening` (see [`gloss_widening`]).
    pub fn gloss(&self, wi: Vec3, wo: Vec3, widening: f32) -> f32 {
        self.gloss.map_or(0.0, |lobe| widened(lobe, widening).eval(&lobe_geometry(wi, wo)))
    }
}

/// What blurs the gloss lobe, as an addition to its squared roughness.
///
/// Beckmann's distribution of roughness alpha has the variance alpha^2 / 2 of slopes along each axis. A disc of angular
/// radius r moves the half vector by a variance of r^2 / 16 along each axis; mirrored directions that a pixel sample spreads
/// by d move it by d^2 / 48. The distribution keeps its integral as it widens, so energy is kept.
pub fn gloss_widening(angular_radius: f32, mirrored_spread: [f32; 2]) -> f32 {
    let [x, y] = mirrored_spread;
    angular_radius * angular_radius / 8.0 + (x * x + y * y) / 48.0
}

/// BRDF without the ideal mirror, linear Rec.709, 1/sr, no cosine; 0 below the horizon.
///
/// `flakes`: what the flakes of this point draw, `None` for none; the local frame must then be fixed to the surface. `widening`: see [`gloss_widening`], 0 for a point lit by a
/// point.
pub fn shade(paint: &RenderPaint, flakes: Option<&FlakeDraws>, wi: Vec3, wo: Vec3, widening: f32) -> Vec3 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let g = Geometry::of(paint.coat.inner(wi), paint.coat.inner(wo));
    let xi = match (&paint.flakes, flakes) {
        (Some(statistics), Some(draws)) => statistics.xi(draws, g.theta_h, g.theta_i, projected_half(wi, wo)),
        _ => Vec3::ZERO,
    };
    base(paint, &g, 0.0, xi) * transmittance(&paint.coat, wi.z, wo.z) + paint.coat.gloss(wi, wo, widening)
}

/// BRDF under many directions at once, where flakes count with their mean; gloss left out.
pub fn shade_mean(paint: &RenderPaint, wi: Vec3, wo: Vec3) -> Vec3 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let g = Geometry::of(paint.coat.inner(wi), paint.coat.inner(wo));
    let xi = paint.flakes.as_ref().map_or(Vec3::ZERO, |f| f.mean(g.theta_h, g.theta_i));
    base(paint, &g, 0.0, xi) * transmittance(&paint.coat, wi.z, wo.z)
}

/// `chi (a/pi + sum CT) + Xi`, the squared roughness of the lobes enlarged by `widening`.
pub(super) fn base(paint: &RenderPaint, g: &Geometry, widening: f32, xi: Vec3) -> Vec3 {
    let chi = Vec3::from(paint.colors.sample(g.theta_h, g.theta_i));
    let smooth = paint.lobes.iter().fold(brightness(paint.diffuse, &[], &g.lobe), |sum, lobe| {
        sum + widened(*lobe, widening).eval(&g.lobe)
    });
    chi * smooth + xi
}

/// A lobe, its squared roughness enlarged by `widening`.
fn widened(lobe: Lobe<f32>, widening: f32) -> Lobe<f32> {
    if widening == 0.0 {
        return lobe;
    }
    Lobe { roughness: (lobe.roughness * lobe.roughness + widening).sqrt(), ..lobe }
}

/// `(1 - F(wi)) (1 - F(wo))`, for outer cosines.
pub(super) fn transmittance(coat: &RenderCoat, cos_i: f32, cos_o: f32) -> f32 {
    transmitted(cos_i, coat.ior) * transmitted(cos_o, coat.ior)
}
