//! Light from the surroundings: mirrored by the coat, blurred by its gloss lobe, and integrated over the base.

use super::paint::RenderPaint;
use super::proposal::{half_vector, half_vector_density, mirrored};
use super::shade::{lobe_geometry, shade_mean};
use crate::math::hash::unit;
use crate::scene::Surroundings;
use glam::{Mat3, Vec2, Vec3};

/// Directions for the gloss lobe a pixel sample: it is narrow, the surroundings are soft.
const GLOSS_DIRECTIONS: u32 = 4;

/// The share of a pixel sample in the points of Fibonacci's lattice: all samples of a pixel together use each point once, and
/// all pixels the same points. What error is left varies as smoothly over the object as the directions do, where random
/// directions would leave grain that looks like flakes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Share {
    /// Number of the pixel sample.
    pub sample: u32,
    /// Number of samples of the pixel.
    pub samples: u32,
}

impl Share {
    /// The `count` points of this sample in the open unit square.
    fn points(self, count: u32) -> impl Iterator<Item = [f32; 2]> {
        let total = (count * self.samples) as f32;
        (0..count).map(move |k| {
            let point = k * self.samples + self.sample;
            // 2^32 over the golden ratio.
            [(point as f32 + 0.5) / total, unit(point.wrapping_mul(2_654_435_769))]
        })
    }
}

/// Radiance of the surroundings towards the eye, all of paint and coat. `to_world`: columns are the local axes.
pub(super) fn radiance(
    paint: &RenderPaint,
    surroundings: &Surroundings,
    to_world: &Mat3,
    wo: Vec3,
    widening: f32,
    directions: u32,
    share: Share,
) -> Vec3 {
    let light = |wi: Vec3| surroundings.radiance(*to_world * wi);
    // Half of the directions go to the soft boxes: their edges would show as ghosts, once a direction of the paint's.
    let towards_lamps = if surroundings.has_lamps() { 0.5 } else { 0.0 };
    let mut sum = Vec3::ZERO;
    for [choice, turn] in share.points(directions) {
        let wi = if choice < towards_lamps {
            to_world.transpose() * surroundings.sample([choice / towards_lamps, turn])
        } else {
            paint.proposal.sample(wo, [(choice - towards_lamps) / (1.0 - towards_lamps), turn])
        };
        let density = towards_lamps * surroundings.density(*to_world * wi)
            + (1.0 - towards_lamps) * paint.proposal.density(wi, wo);
        if wi.z > 0.0 && density > 0.0 {
            sum += shade_mean(paint, wi, wo) * light(wi) * (wi.z / density);
        }
    }
    sum /= directions as f32;
    let reflectance = paint.coat.mirror * paint.coat.reflectance(wo.z);
    if reflectance > 0.0 {
        sum += light(Vec2::ZERO.extend(2.0 * wo.z) - wo) * reflectance;
    }
    if let Some(gloss) = &paint.coat.gloss {
        let roughness = (gloss.roughness * gloss.roughness + widening).sqrt();
        for point in share.points(GLOSS_DIRECTIONS) {
            let wi = mirrored(wo, half_vector(roughness, point));
            let g = lobe_geometry(wi, wo);
            let density = half_vector_density(g.tan2_h, g.cos_h, g.cos_d, roughness);
            if wi.z > 0.0 && density > 0.0 {
                let weight = paint.coat.gloss(wi, wo, widening) * wi.z / density;
                sum += light(wi) * (weight / GLOSS_DIRECTIONS as f32);
            }
        }
    }
    sum
}
