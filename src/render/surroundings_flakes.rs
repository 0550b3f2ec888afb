//! Flakes under the surroundings: what sparkle light from everywhere leaves.
//!
//! The mean of the flakes is part of the surroundings' integral over the base ([`super::surroundings`]); their fluctuation is
//! that over `L cos (Xi - mean)`. It is taken at directions that are chosen where flakes shine and where light comes
//! from, each for the solid angle that the density of all of them leaves it, and scaled as [`super::light_patches`] says.
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
use crate::scene::Surroundings;
use glam::{Mat3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Directions where flakes shine, mirrored by half vectors of a lobe, and its roughness: the normals of flakes spread by 5 to 8
/// degrees inside the lacquer, half as much again outside, and deviations go with the root of their number.
const SHINING: usize = 24;
const ROUGHNESS: f32 = 0.27;
/// Directions by the cosine law: they bound what one of the others stands for.
const COSINE: usize = 4;
/// Directions towards the lamps of the surroundings.
const LAMPS: usize = 12;
const MOST: usize = SHINING + COSINE + LAMPS;

/// Weights of the luminance of linear Rec.709.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// A direction in the local frame, and what it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SurroundingsTap {
    /// Unit vector above the horizon.
    pub wi: Vec3,
    /// Radiance from there, not black.
    pub light: Vec3,
    /// Solid angle.
    pub solid_angle: f32,
}

/// The directions from which flakes seen from `wo` are lit. `to_world`: columns are the local axes.
pub(super) fn taps(
    surroundings: &Surroundings,
    to_world: Mat3,
    wo: Vec3,
) -> impl Iterator<Item = SurroundingsTap> {
    let lamps = if surroundings.has_lamps() { LAMPS } else { 0 };
    (0..SHINING + COSINE + lamps).filter_map(move |k| {
        let wi = match k {
            0..SHINING => mirrored(wo, shining(k)),
            _ if k < SHINING + COSINE => {
                let at = disc_point(k - SHINING, COSINE);
                at.extend((1.0 - at.length_squared()).sqrt())
            }
            _ => to_world.transpose() * surroundings.sample(lamp_point(k - SHINING - COSINE)),
        };
        let world = to_world * wi;
        let light = surroundings.radiance(world);
        if wi.z <= 0.0 || light == Vec3::ZERO {
            return None;
        }
        let g = lobe_geometry(wi, wo);
        let density = SHINING as f32 * half_vector_density(g.tan2_h, g.cos_h, g.cos_d, ROUGHNESS)
            + COSINE as f32 * FRAC_1_PI * wi.z
            + lamps as f32 * surroundings.density(world);
        Some(SurroundingsTap { wi, light, solid_angle: 1.0 / density })
    })
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

/// Point of Fibonacci's lattice.
fn lamp_point(k: usize) -> [f32; 2] {
    [(k as f32 + 0.5) / LAMPS as f32, golden(k)]
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
        let weight = transmittance(&paint.coat, tap.wi.z, wo.z) * tap.wi.z * tap.solid_angle;
        let half = projected_half(turn * tap.wi, seen_from);
        let xi = statistics.xi(flakes, g.theta_h, g.theta_i, half) - statistics.mean(g.theta_h, g.theta_i);
        fluctuation += tap.light * xi * weight;
        let area = tap.solid_angle * half_stretch(tap.wi, wo);
        *patch = statistics.patch(flakes, &g, half, area, weight * tap.light.dot(LUMINANCE));
        count += 1;
    }
    fluctuation * kept(&patches[..count])
}
