//! Directions in which to look for light: a mixture of the cosine law and the half-vector distributions of the lobes.
//!
//! Each direction is weighted by the density of the whole mixture (one-sample balance heuristic), so that no lobe's tail
//! makes a firefly where another lobe, or the cosine law, would have looked as well.

use super::paint::RenderCoat;
use super::shade::lobe_geometry;
use crate::brdf::Lobe;
use crate::brdf::cook_torrance::beckmann;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// The mixture that belongs to a paint's base.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Proposal {
    /// Probability and roughness of each half-vector technique.
    pub lobes: Vec<(f32, f32)>,
    /// Probability of the cosine law.
    pub cosine: f32,
}

impl Proposal {
    /// Techniques in proportion to what they reflect, roughly: albedos of 4 s F0 and a.
    pub fn new(coat: &RenderCoat, diffuse: f32, lobes: &[Lobe<f32>]) -> Self {
        // Refracted half vectors spread about ior times wider outside.
        let stretch = if coat.refracts { coat.ior } else { 1.0 };
        let weights: Vec<f32> = lobes.iter().map(|l| 4.0 * l.coefficient.abs() * (l.f0 + 0.05)).collect();
        // The cosine law always has a share: it bounds the weight of every direction.
        let cosine = diffuse.abs() + 0.2 * weights.iter().sum::<f32>() + 1e-3;
        let total = cosine + weights.iter().sum::<f32>();
        let lobes = weights.iter().zip(lobes).map(|(w, l)| (w / total, l.roughness * stretch)).collect();
        Self { lobes, cosine: cosine / total }
    }

    /// Direction for two numbers in (0, 1); it may lie below the horizon, where nothing comes from.
    pub fn sample(&self, wo: Vec3, [mut choice, turn]: [f32; 2]) -> Vec3 {
        for (probability, roughness) in &self.lobes {
            if choice < *probability {
                return mirrored(wo, half_vector(*roughness, [choice / probability, turn]));
            }
            choice -= probability;
        }
        // Malley's method: a uniform disc, lifted.
        let square = (choice / self.cosine).min(1.0);
        let (sin, cos) = (TAU * turn).sin_cos();
        Vec3::new(square.sqrt() * cos, square.sqrt() * sin, (1.0 - square).sqrt())
    }

    /// Density of [`Proposal::sample`] at `wi`, 1/sr.
    pub fn density(&self, wi: Vec3, wo: Vec3) -> f32 {
        let g = lobe_geometry(wi, wo);
        self.lobes.iter().fold(self.cosine * wi.z * FRAC_1_PI, |sum, (probability, roughness)| {
            sum + probability * half_vector_density(g.tan2_h, g.cos_h, g.cos_d, *roughness)
        })
    }
}

/// Half vector distributed as Beckmann's D times its cosine.
pub(super) fn half_vector(roughness: f32, [square, turn]: [f32; 2]) -> Vec3 {
    let tangent = roughness * (-(1.0 - square).max(1e-7).ln()).sqrt();
    let (sin, cos) = (TAU * turn).sin_cos();
    Vec3::new(tangent * cos, tangent * sin, 1.0).normalize()
}

/// Density of the direction that [`half_vector`] mirrors `wo` to, 1/sr.
pub(super) fn half_vector_density(tan2_h: f32, cos_h: f32, cos_d: f32, roughness: f32) -> f32 {
    FRAC_1_PI * beckmann(tan2_h, cos_h, roughness) * cos_h / (4.0 * cos_d)
}

/// `w` mirrored about `half`.
pub(super) fn mirrored(w: Vec3, half: Vec3) -> Vec3 {
    (half * (2.0 * w.dot(half)) - w).normalize()
}
