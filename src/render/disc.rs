//! A lamp's disc, and what a paint scatters of its light.
//!
//! `L = E / (pi sin^2 r) * integral of f(wi, wo) cos(theta) dw` over a disc of angular radius r and even radiance, that lights a
//! surface facing it with E. Projected along its axis the disc is even, too: directions are taken at points spread evenly over
//! the unit disc, each for a patch of the same projected area. A sun needs one, which is then the lamp's middle; a wider lamp
//! has more, so that what varies within a patch is little: how the flakes' light, the lobes and the cosine change.
//!
//! One direction has the sparkle of a point; how much of it a patch of light has left says [`super::light_patches`]. The lobes of
//! the base are as much wider as a patch is, like the gloss lobe under the whole disc ([`super::gloss_widening`]); under a single
//! patch they stay as they are.

use super::draws::FlakeDraws;
use super::light_patches::{LightPatch, kept};
use super::paint::RenderPaint;
use super::shade::{Geometry, base, transmittance};
use crate::brdf::{half_stretch, projected_half};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Sines of the angular radii from which on a disc has 4 and 16 patches: 1.3 and 5.5 degrees. A usual flake's lobe is 7 to 10
/// degrees wide outside the lacquer, and light turns half vectors by half its angle.
const WIDE: [f32; 2] = [0.0227, 0.0958];

/// Distances from the middle of a disc of 16 points, one in the middle, rings of 5 and 10: the second is the root mean square
/// of its share of the area, the third gives all of them the disc's own, 1/2.
const RINGS: [f32; 2] = [0.467_707, 0.831_039];

/// A lamp's disc in the local frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Unit vector to its middle.
    pub direction: Vec3,
    /// Sine of its angular radius, 0 to 1.
    pub sine: f32,
}

/// A direction to a patch of a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiscTap {
    /// Unit vector.
    pub wi: Vec3,
    /// Irradiance by this patch over that by the disc of a surface that faces it.
    pub weight: f32,
    /// Solid angle of the patch.
    pub solid_angle: f32,
}

impl Disc {
    /// Most patches.
    pub const MAX_TAPS: usize = 16;

    /// How many patches it has.
    pub(crate) fn tap_count(&self) -> usize {
        match self.sine {
            s if s > WIDE[1] => 16,
            s if s > WIDE[0] => 4,
            _ => 1,
        }
    }

    /// What blurs the lobes of the base, as an addition to their squared roughness.
    fn patch_widening(&self) -> f32 {
        match self.tap_count() {
            1 => 0.0,
            count => self.sine * self.sine / (8.0 * count as f32),
        }
    }

    /// Directions to its patches, and to its middle, which is all of it to frames from rows.
    pub(super) fn directions(self) -> impl Iterator<Item = Vec3> {
        let middle = (self.tap_count() == 4).then_some(self.direction);
        self.taps().map(|tap| tap.wi).chain(middle)
    }

    /// Its patches; some may be below the horizon.
    pub(super) fn taps(self) -> impl Iterator<Item = DiscTap> {
        let (axis, count) = (self.direction, self.tap_count());
        // Fixed to the surface, and smooth over it but where the lamp is seen along its first axis, at the horizon.
        let across = Vec2::new(axis.z, -axis.y).normalize_or(Vec2::X);
        let across = Vec3::new(0.0, across.x, across.y);
        let up = axis.cross(across);
        (0..count).map(move |k| {
            let at = disc_point(k, count) * self.sine;
            let along = (1.0 - at.length_squared()).max(0.0).sqrt();
            // The disc of a hemisphere has no solid angle left at its rim; no tap is there.
            let share = 1.0 / (count as f32 * along);
            let wi = if count == 1 { axis } else { across * at.x + up * at.y + axis * along };
            DiscTap { wi, weight: wi.z * share, solid_angle: PI * self.sine * self.sine * share }
        })
    }
}

/// Point `k` of 1, 4 or 16 spread evenly over the unit disc.
pub(super) fn disc_point(k: usize, count: usize) -> Vec2 {
    match count {
        1 => Vec2::ZERO,
        4 => FRAC_1_SQRT_2 * Vec2::from_angle(TAU * ((k as f32 + 0.5) / 4.0)),
        _ => match k {
            0 => Vec2::ZERO,
            1..6 => RINGS[0] * Vec2::from_angle(TAU * ((k as f32 - 1.0) / 5.0)),
            _ => RINGS[1] * Vec2::from_angle(TAU * ((k as f32 - 5.75) / 10.0)),
        },
    }
}

/// Radiance towards `wo` over the irradiance of a surface that faces the disc, linear Rec.709; the ideal mirror left out.
///
/// `flakes`: what the flakes of this point draw, `None` for none; the local frame must then be fixed to the surface.
/// `widening`: that of the gloss lobe, see [`super::gloss_widening`].
pub fn disc_radiance(
    paint: &RenderPaint,
    flakes: Option<&FlakeDraws>,
    disc: &Disc,
    wo: Vec3,
    widening: f32,
) -> Vec3 {
    if wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let axis = disc.direction;
    let gloss = if axis.z > 0.0 { paint.coat.gloss(axis, wo, widening) * axis.z } else { 0.0 };
    let (mut sum, mut fluctuation) = (Vec3::splat(gloss), Vec3::ZERO);
    let mut patches = [LightPatch::default(); Disc::MAX_TAPS];
    let drawn = paint.flakes.as_ref().zip(flakes);
    let of_patch = disc.patch_widening();
    for (tap, patch) in disc.taps().zip(&mut patches).filter(|(tap, _)| tap.wi.z > 0.0) {
        let g = Geometry::of(paint.coat.inner(tap.wi), paint.coat.inner(wo));
        let weight = transmittance(&paint.coat, tap.wi.z, wo.z) * tap.weight;
        let mut mean = Vec3::ZERO;
        if let Some((statistics, draws)) = drawn {
            mean = statistics.mean(g.theta_h, g.theta_i);
            let half = projected_half(tap.wi, wo);
            fluctuation += (statistics.xi(draws, g.theta_h, g.theta_i, half) - mean) * weight;
            let area = tap.solid_angle * half_stretch(tap.wi, wo);
            *patch = statistics.patch(draws, &g, half, area, weight);
        }
        sum += base(paint, &g, of_patch, mean) * weight;
    }
    sum + fluctuation * kept(&patches[..disc.tap_count()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_of_patches_and_the_middle() {
        let direction = Vec3::new(0.3, -0.2, 0.9).normalize();
        for (sine, count) in [(0.01, 1), (0.05, 5), (0.5, 16)] {
            let disc = Disc { direction, sine };
            let directions: Vec<_> = disc.directions().collect();
            assert_eq!(directions.len(), count);
            assert!(disc.taps().all(|tap| directions.contains(&tap.wi)));
            // Sixteen have one there, up to the rounding of its place.
            assert!(directions.iter().any(|d| (*d - direction).length() < 1e-6), "{sine}");
        }
    }
}
