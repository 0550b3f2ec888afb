//! What a renderer draws of the flakes alone.

use crate::brdf::{ClearCoat, projected_half};
use crate::color::luminance;
use crate::error::Result;
use crate::math::half_difference::directions;
use crate::paint::Flakes;
use crate::render::{FlakeDraws, Random, RenderFlakes, Surface};
use glam::Vec2;
use std::borrow::Borrow;
use std::f64::consts::FRAC_PI_2;

/// Flakes under their coat.
pub(super) struct Drawn {
    coat: ClearCoat,
    flakes: RenderFlakes,
}

impl Drawn {
    pub fn new(coat: ClearCoat, flakes: &Flakes) -> Result<Self> {
        Ok(Self { coat, flakes: RenderFlakes::new(flakes)? })
    }

    /// The random numbers of places `apart` millimetres from each other, for a footprint, millimetres.
    pub fn places(
        &self,
        count: usize,
        apart: f32,
        footprint: [Vec2; 2],
        seed: u32,
    ) -> impl Iterator<Item = FlakeDraws> {
        (0..count).map(move |k| {
            let uv_mm = Vec2::new((k % 256) as f32, (k / 256) as f32) * apart;
            self.flakes.draws(&Surface { chart: 0, uv_mm, footprint, seed, random: Random::Hash })
        })
    }

    /// Luminances of places at outer angles, radians, seen through the coat.
    pub fn luminances(
        &self,
        places: impl IntoIterator<Item = impl Borrow<FlakeDraws>>,
        (theta_h, theta_i): (f64, f64),
    ) -> Vec<f32> {
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let half = projected_half(wi.as_vec3(), wo.as_vec3());
        let passed = self.coat.transmittance(wi.z, wo.z);
        let value = |draws: &FlakeDraws| self.flakes.xi(draws, theta_h as f32, theta_i as f32, half);
        let seen = |draws: &FlakeDraws| (passed * luminance(value(draws).as_dvec3())) as f32;
        places.into_iter().map(|draws| seen(draws.borrow())).collect()
    }

    /// Luminance of the mean over the surface, as [`Drawn::luminances`].
    pub fn mean(&self, (theta_h, theta_i): (f64, f64)) -> f64 {
        let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
        let mean = self.flakes.mean(theta_h as f32, theta_i as f32).as_dvec3();
        self.coat.transmittance(wi.z, wo.z) * luminance(mean)
    }
}
