//! A point where a path meets paint.

use super::directions::Directions;
use super::numbers::Numbers;
use crate::render::draws::FlakeDraws;
use crate::render::image::Patch;
use crate::render::paint::RenderPaint;
use crate::render::shade::{shade, shade_mean};
use crate::scene::{Bodies, Hit};
use glam::{DMat3, DVec3, Vec2, Vec3};

/// Where a path meets paint.
pub(super) struct Vertex<'a> {
    /// Millimetres.
    pub point: DVec3,
    normal: DVec3,
    /// Rows are the axes of the frame that is fixed to the surface.
    to_local: DMat3,
    /// Towards where the path comes from, in that frame.
    wo: Vec3,
    paint: &'a RenderPaint,
    directions: &'a Directions,
    /// What the flakes draw here; none: they count with their mean.
    flakes: Option<FlakeDraws>,
}

/// A way on.
pub(super) struct Bounce {
    /// In the world.
    pub direction: DVec3,
    /// BRDF times cosine over density.
    pub weight: Vec3,
    /// Density of the direction, 1/sr; none: the mirrored one.
    pub density: Option<f32>,
}

impl<'a> Vertex<'a> {
    /// The first vertex, whose flakes sparkle if they may.
    pub fn first(patch: &Patch, paint: &'a RenderPaint, directions: &'a Directions, sparkles: bool) -> Self {
        let flakes = paint.flakes.as_ref().filter(|_| sparkles);
        Self {
            point: patch.hit.point,
            normal: patch.hit.normal,
            to_local: patch.to_surface,
            wo: patch.seen_from,
            paint,
            directions,
            flakes: flakes.map(|f| f.draws(&patch.footprint.surface)),
        }
    }

    /// A later vertex, met along `direction`.
    pub fn later(
        bodies: &Bodies,
        hit: &Hit,
        direction: DVec3,
        paint: &'a RenderPaint,
        directions: &'a Directions,
    ) -> Self {
        let to_local = bodies.frame(hit).transpose();
        let wo = (to_local * -direction).as_vec3();
        Self { point: hit.point, normal: hit.normal, to_local, wo, paint, directions, flakes: None }
    }

    /// Where rays from here begin: just above the surface.
    pub fn origin(&self) -> DVec3 {
        // A thousand roundings of the point.
        self.point + self.normal * (1e-9 + 1e-12 * self.point.length())
    }

    /// A direction of the world in the frame of the surface.
    pub fn local(&self, direction: DVec3) -> Vec3 {
        (self.to_local * direction).as_vec3()
    }

    /// The BRDF without the ideal mirror, 1/sr.
    pub fn reflected(&self, wi: Vec3) -> Vec3 {
        match &self.flakes {
            Some(draws) => shade(self.paint, Some(draws), wi, self.wo, 0.0),
            None if wi.z > 0.0 && self.wo.z > 0.0 => {
                shade_mean(self.paint, wi, self.wo) + self.paint.coat.gloss(wi, self.wo, 0.0)
            }
            None => Vec3::ZERO,
        }
    }

    /// Density of the directions of [`Vertex::scatter`] but the mirrored one, 1/sr.
    pub fn density(&self, wi: Vec3) -> f32 {
        (1.0 - self.mirror_chance()) * self.directions.density(wi, self.wo)
    }

    /// A way on; none: it would go into the surface.
    pub fn scatter(&self, numbers: &mut Numbers) -> Option<Bounce> {
        let chance = self.mirror_chance();
        let choice = numbers.next();
        let draws = [numbers.next(), numbers.next(), numbers.next()];
        if choice < chance {
            let wi = Vec2::ZERO.extend(2.0 * self.wo.z) - self.wo;
            let weight = Vec3::splat(self.mirror_reflectance() / chance);
            return Some(Bounce { direction: self.world(wi), weight, density: None });
        }
        let wi = self.directions.sample(self.wo, draws);
        let density = self.density(wi);
        if wi.z <= 0.0 || density <= 0.0 {
            return None;
        }
        let weight = self.reflected(wi) * (wi.z / density);
        Some(Bounce { direction: self.world(wi), weight, density: Some(density) })
    }

    fn world(&self, wi: Vec3) -> DVec3 {
        (self.to_local.transpose() * wi.as_dvec3()).normalize()
    }

    fn mirror_reflectance(&self) -> f32 {
        self.paint.coat.mirror * self.paint.coat.reflectance(self.wo.z)
    }

    /// Chance to follow the mirrored direction: more often than it reflects, since it shows sharp images.
    fn mirror_chance(&self) -> f32 {
        self.mirror_reflectance().sqrt().min(0.9)
    }
}
