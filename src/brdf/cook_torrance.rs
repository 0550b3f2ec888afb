//! The multi-lobe Cook-Torrance brightness of the AxF-style car paint.
//!
//! Golla & Klein 2018, eqs 1-6 (Rump et al. 2008, eq. 1):
//! `CT = s/pi * D F G / (i_z o_z)`, `D = exp((h_z^2 - 1)/(h_z^2 alpha^2)) / (alpha^2 h_z^4)`, Schlick's F,
//! `G = min(1, 2 h_z o_z / h.o, 2 h_z i_z / h.o)`.
//! D is Beckmann's distribution without 1/pi, and the factor 1/4 of the energy-normalised Torrance-Sparrow model is
//! absent: this convention is four times the usual one, and it is kept inside the whole program.

use super::fresnel::schlick;
use num_traits::Float;
use serde::{Deserialize, Serialize};

/// One lobe. `F` is f64 for fits, f32 in the renderer and its shader twin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lobe<F = f64> {
    /// Specular coefficient s, >= 0; typically 0.01-0.3.
    pub coefficient: F,
    /// Roughness alpha (root-mean-square slope times sqrt 2), > 0; gloss 0.002-0.03, metallic lobes 0.1-1.3.
    pub roughness: F,
    /// Reflectance at normal incidence F0, in [0, 1].
    pub f0: F,
}

/// The angles a lobe depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LobeGeometry<F = f64> {
    /// Squared tangent of the half-vector angle: given by the caller, who has it without the cancellation of
    /// 1 - cos^2 (an f32 cosine has lost a gloss lobe of roughness 0.003 entirely).
    pub tan2_h: F,
    /// Cosine of the half-vector angle.
    pub cos_h: F,
    /// Cosine of the light's polar angle.
    pub cos_i: F,
    /// Cosine of the eye's polar angle.
    pub cos_o: F,
    /// h . wo, which is h . wi.
    pub cos_d: F,
}

impl LobeGeometry<f64> {
    /// Geometry of unit directions, z = normal.
    pub fn of(wi: glam::DVec3, wo: glam::DVec3) -> Self {
        let sum = wi + wo;
        let length = sum.length();
        Self {
            tan2_h: sum.truncate().length_squared() / (sum.z * sum.z),
            cos_h: sum.z / length,
            cos_i: wi.z,
            cos_o: wo.z,
            cos_d: 0.5 * length,
        }
    }
}

/// Beckmann's distribution without 1/pi (eq. 2). 0 where the exponential underflows, never NaN.
pub fn beckmann<F: Float>(tan2_h: F, cos_h: F, roughness: F) -> F {
    let a2 = roughness * roughness;
    let c2 = cos_h * cos_h;
    let e = (-tan2_h / a2).exp();
    if e > F::zero() { e / (a2 * c2 * c2) } else { F::zero() }
}

/// The V-cavity shadowing term (eq. 5).
pub fn v_cavity<F: Float>(g: &LobeGeometry<F>) -> F {
    let twice = (F::one() + F::one()) * g.cos_h / g.cos_d;
    F::one().min(twice * g.cos_o).min(twice * g.cos_i)
}

impl<F: Float> Lobe<F> {
    /// BRDF of the lobe, 1/sr (eq. 1); 0 when either direction is at or below the horizon.
    pub fn eval(&self, g: &LobeGeometry<F>) -> F {
        if g.cos_i <= F::zero() || g.cos_o <= F::zero() || g.cos_h <= F::zero() {
            return F::zero();
        }
        let pi = F::from(std::f64::consts::PI).unwrap_or_else(F::one);
        let d = beckmann(g.tan2_h, g.cos_h, self.roughness);
        self.coefficient / pi * d * schlick(self.f0, g.cos_d) * v_cavity(g) / (g.cos_i * g.cos_o)
    }
}

/// Diffuse plus lobes, the bracket of eq. 7: `a/pi + sum CT`. 0 below the horizon.
pub fn brightness<F: Float>(diffuse: F, lobes: &[Lobe<F>], g: &LobeGeometry<F>) -> F {
    if g.cos_i <= F::zero() || g.cos_o <= F::zero() {
        return F::zero();
    }
    let pi = F::from(std::f64::consts::PI).unwrap_or_else(F::one);
    lobes.iter().fold(diffuse / pi, |sum, lobe| sum + lobe.eval(g))
}
