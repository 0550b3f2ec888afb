//! The samples of a fit as its objective reads them: number after number, all that no parameter changes taken out.
//!
//! A lobe at a point of a light is `A(1 - m) + S m` (Schlick, `m = (1 - h.o)^5`, `A = s F0`, `S = s`) times
//! `exp(-tan^2 / alpha^2) / alpha^2` times a factor that holds shadowing, cosines, the point's share of the light and the coat.

use crate::brdf::cook_torrance::v_cavity;
use crate::brdf::{Lobe, LobeGeometry};
use std::f64::consts::PI;

/// Samples of intensity, each under one or more points of light.
#[derive(Debug, Clone, Default)]
pub(super) struct Points {
    /// The small constant of eq. 7.
    pub epsilon: f64,
    /// `ln(max(Psi, 0) + eps)` of every sample.
    pub measured: Vec<f64>,
    /// Part of the model that stays fixed.
    pub rest: Vec<f64>,
    /// What a diffuse intensity is multiplied by.
    pub diffuse: Vec<f64>,
    /// Where each sample's points of light end.
    pub ends: Vec<usize>,
    /// Every point of light.
    pub lights: Vec<Facet>,
}

/// A sample at one point of its light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// Squared tangent of the half-vector angle.
    pub tan2_h: f64,
    /// `(1 - h.o)^5`.
    pub grazing: f64,
    /// Everything else that multiplies a lobe.
    pub factor: f64,
}

impl Points {
    /// No samples yet.
    pub fn new(epsilon: f64) -> Self {
        Self { epsilon, ..Self::default() }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.measured.len()
    }

    /// Adds a sample of an intensity, of which `rest` is explained already. `lights` are the geometries of its points of light
    /// and what the model counts at each: share times transmittance.
    pub fn push(&mut self, intensity: f64, rest: f64, lights: impl IntoIterator<Item = (LobeGeometry, f64)>) {
        let mut diffuse = 0.0;
        for (g, weight) in lights {
            // Below the horizon the model is 0.
            if g.cos_i <= 0.0 || g.cos_o <= 0.0 {
                continue;
            }
            diffuse += weight / PI;
            let factor = weight * v_cavity(&g) / (PI * g.cos_i * g.cos_o * g.cos_h.powi(4));
            self.lights.push(Facet { tan2_h: g.tan2_h, grazing: (1.0 - g.cos_d).max(0.0).powi(5), factor });
        }
        self.measured.push((intensity.max(0.0) + self.epsilon).ln());
        self.rest.push(rest);
        self.diffuse.push(diffuse);
        self.ends.push(self.lights.len());
    }

    /// The points of light of sample `k`.
    pub fn lights(&self, k: usize) -> &[Facet] {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        &self.lights[start..self.ends[k]]
    }

    /// Measured intensity of sample `k`, zero where it was negative.
    pub fn intensity(&self, k: usize) -> f64 {
        self.measured[k].exp() - self.epsilon
    }
}

impl Facet {
    /// A lobe's value, and its derivatives by the logarithm of roughness and by F0.
    pub fn lobe(&self, lobe: &Lobe) -> [f64; 3] {
        let steep = 1.0 / (lobe.roughness * lobe.roughness);
        let slope = self.tan2_h * steep;
        let bare = lobe.coefficient * self.factor * steep * (-slope).exp();
        let value = bare * (lobe.f0 + (1.0 - lobe.f0) * self.grazing);
        [value, value * 2.0 * (slope - 1.0), bare * (1.0 - self.grazing)]
    }
}
