//! Sparkles counted one flake at a time, by exact refraction of every mirrored ray: what the formulas are the limit of.

use crate::brdf::fresnel::refracted_cosine;
use crate::simulate::optics::orientation::Orientation;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::PI;

/// A light of finite radius over flakes in a binder, and a distant eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BruteForce {
    wi: DVec3,
    eye_inside: DVec3,
    index: f64,
    light_radius: f64,
    half: DVec3,
    /// `1 - cos` of a cap about the half vector that holds every normal that mirrors the light into the eye.
    cap: f64,
}

impl BruteForce {
    /// For unit directions away from the surface, above the horizon, an index of 1 or more and a light of angular radius
    /// `light_radius`, radians, above 0.
    pub fn new(wi: DVec3, wo: DVec3, index: f64, light_radius: f64) -> Self {
        let inside = |w: DVec3| (w.truncate() / index).extend(refracted_cosine(w.z, index));
        let (light, eye) = (inside(wi), inside(wo));
        let half = (light + eye).normalize();
        // Refraction into the binder shrinks angles by the index at least; mirrors turn half as far as their image, or
        // 1 / (2 cos alpha) across the plane of incidence.
        let alpha = half.dot(eye).min(1.0).acos();
        let farthest = (alpha + light_radius / index).min(0.5 * PI - 1e-3);
        let radius = (light_radius / (2.0 * index * farthest.cos())).min(PI);
        Self { wi, eye_inside: eye, index, light_radius, half, cap: 2.0 * (0.5 * radius).sin().powi(2) }
    }

    /// Solid angle of the cap that [`BruteForce::normal`] draws from.
    pub fn cap_solid_angle(&self) -> f64 {
        2.0 * PI * self.cap
    }

    /// A unit normal uniformly distributed over the cap.
    pub fn normal(&self, rng: &mut impl rand::Rng) -> DVec3 {
        let rise = self.cap * rng.random::<f64>();
        let (sin_a, cos_a) = (2.0 * PI * rng.random::<f64>()).sin_cos();
        let (u, v) = self.half.any_orthonormal_pair();
        self.half * (1.0 - rise) + (u * cos_a + v * sin_a) * (rise * (2.0 - rise)).sqrt()
    }

    /// Whether a flake of this normal mirrors the eye ray into the light.
    pub fn mirrors(&self, normal: DVec3) -> bool {
        let mirrored = normal * (2.0 * normal.dot(self.eye_inside)) - self.eye_inside;
        let outside = mirrored.truncate() * self.index;
        let left = 1.0 - outside.length_squared();
        // Downwards, or beyond the critical angle: it does not get out.
        if mirrored.z <= 0.0 || left <= 0.0 {
            return false;
        }
        (outside.extend(left.sqrt()) - self.wi).length() < 2.0 * (0.5 * self.light_radius).sin()
    }

    /// Cosine between eye ray and flake, inside.
    pub fn cos_alpha(&self, normal: DVec3) -> f64 {
        normal.dot(self.eye_inside).abs()
    }

    /// Probability that a flake sparkles, and its standard error, from `samples` normals of the cap.
    pub fn probability(&self, orientation: &Orientation, samples: u32, seed: u64) -> (f64, f64) {
        let mut rng = Pcg64::seed_from_u64(seed);
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..samples {
            let normal = self.normal(&mut rng);
            if self.mirrors(normal) {
                let density = orientation.density(normal.truncate().length().atan2(normal.z.abs()));
                sum += density;
                square += density * density;
            }
        }
        let n = f64::from(samples);
        let (mean, cap) = (sum / n, self.cap_solid_angle());
        (cap * mean, cap * ((square / n - mean * mean) / n).sqrt())
    }
}
