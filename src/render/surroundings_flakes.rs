//! Flakes under the surroundings: what sparkle light from everywhere leaves.
//!
//! The mean of the flakes is part of the surroundings' integral over the base ([`super::surroundings`]); their fluctuation is
//! that over `L cos (Xi - mean)`. It is taken at directions that are chosen where flakes shine, each for the solid angle that the
//! density of all of them leaves it, and at groups of lamps, each for the patch of light that it is. Lamps' light is parted
//! between both by the balance heuristic (Veach and Guibas 1995): what is dim beside other lamps is seen where flakes shine. How much
//! patches leave of the fluctuation says [`super::light_patches`].
//! The directions hang on the frame of a sample and on the light alone: they are the same for all samples of a pixel, which see
//! the same flakes, and pass smoothly from pixel to pixel, so that no noise is added to what the flakes themselves show. No paint
//! moves them: which slices a picture draws from is known before its paint is.

use super::disc::disc_point;
use super::draws::FlakeDraws;
use super::light_patches::{LightPatch, kept};
use super::paint::RenderPaint;
use super::proposal::{half_vector, half_vector_density, mirrored};
use super::shade::{Geometry, lobe_geometry, transmittance};
use crate::brdf::{half_stretch, projected_half};
use crate::math::hash::unit;
use crate::scene::{LampGroup, LampPoints, Surroundings};
use glam::{Mat3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Directions where flakes shine, mirrored by half vectors of a lobe, and its roughness: the normals of flakes spread by 5 to 8
/// degrees inside the lacquer, half as much again outside, and deviations go with the root of their number.
const SHINING: usize = 24;
const ROUGHNESS: f32 = 0.27;
/// Directions by the cosine law: they bound what one of the others stands for.
const COSINE: usize = 4;
/// As how many directions, spread over lamps by their power, groups count in the balance. Of 6, 24, 96, 400 and without end the one
/// that leaves contrasts nearest to those of thousands of directions, under nine surroundings: 8 % off, root mean square; 16, 13, 10 and
/// 11 % by the others.
const GROUP_LOOKS: f32 = 400.0;
const MOST: usize = SHINING + COSINE + LampGroup::MOST;

/// Weights of the luminance of linear Rec.709.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// A patch of light in the local frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SurroundingsTap {
    /// Unit vector above the horizon.
    pub wi: Vec3,
    /// Radiance times solid angle, not black.
    pub light: Vec3,
    /// Over which it is spread.
    pub solid_angle: f32,
    /// See [`LampGroup`]; 0 and 1 where the light is even.
    pub alone: f32,
    pub own: f32,
}

/// The patches by which flakes seen from `wo` are lit. `to_world`: columns are the local axes.
pub(super) fn taps(
    surroundings: &Surroundings,
    to_world: Mat3,
    wo: Vec3,
) -> impl Iterator<Item = SurroundingsTap> {
    let lamps = surroundings.lamp_points();
    let chosen = (0..SHINING + COSINE).map(move |k| {
        let wi = if k < SHINING {
            mirrored(wo, shining(k))
        } else {
            let at = disc_point(k - SHINING, COSINE);
            at.extend((1.0 - at.length_squared()).sqrt())
        };
        chosen_tap(surroundings, lamps, to_world, wo, wi)
    });
    let groups = lamps.groups.iter().map(move |group| group_tap(lamps, group, to_world, wo));
    chosen.chain(groups).flatten()
}

/// The direction `wi` where flakes shine.
fn chosen_tap(
    surroundings: &Surroundings,
    lamps: &LampPoints,
    to_world: Mat3,
    wo: Vec3,
    wi: Vec3,
) -> Option<SurroundingsTap> {
    if wi.z <= 0.0 {
        return None;
    }
    let density = density(wi, wo);
    let all = surroundings.radiance(to_world * wi);
    let luminance = all.dot(LUMINANCE);
    let dim = lamps.dim_share(luminance);
    let kept = 1.0 - (1.0 - dim) * groups_share(lamps, luminance * (1.0 - dim), density);
    let solid_angle = 1.0 / density;
    let light = all * (kept * solid_angle);
    (light != Vec3::ZERO).then_some(SurroundingsTap { wi, light, solid_angle, alone: 0.0, own: 1.0 })
}

/// A group of lamps.
fn group_tap(lamps: &LampPoints, group: &LampGroup, to_world: Mat3, wo: Vec3) -> Option<SurroundingsTap> {
    let LampGroup { direction, luminance, light, solid_angle, alone, own } = *group;
    let wi = to_world.transpose() * direction;
    if wi.z <= 0.0 {
        return None;
    }
    let light = light * groups_share(lamps, luminance, density(wi, wo));
    Some(SurroundingsTap { wi, light, solid_angle, alone, own })
}

/// Of the directions where flakes shine, 1/sr.
fn density(wi: Vec3, wo: Vec3) -> f32 {
    let g = lobe_geometry(wi, wo);
    SHINING as f32 * half_vector_density(g.tan2_h, g.cos_h, g.cos_d, ROUGHNESS)
        + COSINE as f32 * FRAC_1_PI * wi.z
}

/// The share of light of lamps, of this luminance, that their groups bring where the others have this density.
fn groups_share(lamps: &LampPoints, luminance: f32, density: f32) -> f32 {
    if luminance <= 0.0 {
        return 0.0;
    }
    let groups = GROUP_LOOKS * luminance / lamps.power;
    groups / (groups + density)
}

/// Half vector `k` of those that find flakes: on Vogel's spiral, which has a radius of its own for each.
fn shining(k: usize) -> Vec3 {
    half_vector(ROUGHNESS, [(k as f32 + 0.5) / SHINING as f32, golden(k)])
}

/// Multiples of the golden ratio's fractional part.
fn golden(k: usize) -> f32 {
    // 2^32 over the golden ratio.
    unit((k as u32).wrapping_mul(2_654_435_769))
}

/// Radiance that the flakes of a point, which draw `flakes`, add to their mean towards `wo` under the surroundings; linear
/// Rec.709, its mean over the surface 0.
///
/// `to_world`: columns are the local axes, in which `wo` is given. `to_surface`: from the world to the frame that is fixed to the
/// surface.
pub fn surroundings_sparkle(
    paint: &RenderPaint,
    flakes: &FlakeDraws,
    surroundings: &Surroundings,
    [to_world, to_surface]: [&Mat3; 2],
    wo: Vec3,
) -> Vec3 {
    let Some(statistics) = paint.flakes.as_ref().filter(|_| wo.z > 0.0) else { return Vec3::ZERO };
    let turn = *to_surface * *to_world;
    let seen_from = turn * wo;
    let mut fluctuation = Vec3::ZERO;
    let mut patches = [LightPatch::default(); MOST];
    let mut count = 0;
    for (tap, patch) in taps(surroundings, *to_world, wo).zip(&mut patches) {
        let g = Geometry::of(paint.coat.inner(tap.wi), paint.coat.inner(wo));
        let weight = transmittance(&paint.coat, tap.wi.z, wo.z) * tap.wi.z;
        let half = projected_half(turn * tap.wi, seen_from);
        let xi = statistics.xi(flakes, g.theta_h, g.theta_i, half) - statistics.mean(g.theta_h, g.theta_i);
        fluctuation += tap.light * xi * weight;
        let area = tap.solid_angle * half_stretch(tap.wi, wo);
        let even = statistics.patch(flakes, &g, half, area, weight * tap.light.dot(LUMINANCE));
        *patch = even.in_parts(tap.alone, tap.own);
        count += 1;
    }
    fluctuation * kept(&patches[..count])
}
