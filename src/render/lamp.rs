//! Lamps: the BRDF times their irradiance, and their disc mirrored by the coat.

use super::disc::{Disc, disc_radiance};
use super::draws::FlakeDraws;
use super::footprint::Footprint;
use super::paint::RenderPaint;
use super::shade::gloss_widening;
use crate::scene::Incidence;
use glam::{DMat3, DVec3, Vec3};

/// A lamp as a patch of paint sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lamp {
    direction: DVec3,
    irradiance: Vec3,
    angular_radius: f64,
}

/// Rows and columns of the points by which a sample's mirrored directions are tried against a lamp's disc.
const DISC_GRID: usize = 4;

impl Lamp {
    pub fn new(seen: Incidence) -> Self {
        Self {
            direction: seen.direction,
            irradiance: seen.irradiance.as_vec3(),
            angular_radius: seen.angular_radius,
        }
    }

    /// Its disc in the local frame `to_local`.
    pub fn disc(&self, to_local: &DMat3) -> Disc {
        Disc { direction: (*to_local * self.direction).as_vec3(), sine: self.angular_radius.sin() as f32 }
    }

    /// Radiance towards the eye, `wo` in the local frame `to_local`, which is fixed to the surface.
    pub fn radiance(
        &self,
        paint: &RenderPaint,
        flakes: Option<&FlakeDraws>,
        footprint: &Footprint,
        to_local: &DMat3,
        wo: Vec3,
    ) -> Vec3 {
        let spread = footprint.mirrored_sides.map(|side| side.length() as f32);
        let widening = gloss_widening(self.angular_radius as f32, spread);
        let scattered = disc_radiance(paint, flakes, &self.disc(to_local), wo, widening) * self.irradiance;
        let reflectance = paint.coat.mirror * paint.coat.reflectance(wo.z);
        if reflectance == 0.0 {
            return scattered;
        }
        scattered + self.mirrored(footprint) * reflectance
    }

    /// Mean radiance of the disc over the mirrored directions of a sample: E / (pi sin^2 r) where they fall on it.
    fn mirrored(&self, footprint: &Footprint) -> Vec3 {
        let sides = footprint.mirrored_sides;
        let reach = self.angular_radius + sides[0].length() + sides[1].length();
        if self.angle(footprint.mirrored) > reach {
            return Vec3::ZERO;
        }
        // The edge is as soft as the grid is coarse, at most as the disc is wide.
        let spacing = sides[0].length().max(sides[1].length()) / DISC_GRID as f64;
        let soft = (0.5 * spacing).min(self.angular_radius);
        let offset = |k: usize| (k as f64 + 0.5) / DISC_GRID as f64 - 0.5;
        let mut sum = 0.0;
        for k in 0..DISC_GRID * DISC_GRID {
            let (a, b) = (offset(k % DISC_GRID), offset(k / DISC_GRID));
            let excess = self.angle(footprint.mirrored + sides[0] * a + sides[1] * b) - self.angular_radius;
            sum += if soft > 0.0 {
                (0.5 - 0.5 * excess / soft).clamp(0.0, 1.0)
            } else {
                f64::from(excess < 0.0)
            };
        }
        let sine = self.angular_radius.sin();
        let share = sum / (DISC_GRID * DISC_GRID) as f64;
        self.irradiance * (share / (std::f64::consts::PI * sine * sine)) as f32
    }

    /// Angle between the lamp's middle and a direction of any length, exact for small angles.
    fn angle(&self, direction: DVec3) -> f64 {
        self.direction.cross(direction).length().atan2(self.direction.dot(direction))
    }
}
