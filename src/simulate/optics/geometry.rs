//! A pair of directions outside the paint, seen from inside the binder.

use crate::brdf::fresnel::{refracted_cosine, transmitted};
use glam::DVec3;

/// What the model needs to know of a pair of directions. Angles in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// Cosines outside: incident, outgoing (theta', theta of Ershov 2001).
    pub cos_outside: [f64; 2],
    /// Cosines inside the binder (eq. 24), above 0.
    pub cos_inside: [f64; 2],
    /// Polar angles inside the binder.
    pub theta_inside: [f64; 2],
    /// `[1 - r(theta')] [1 - r(theta)]`: what passes the surface both ways.
    pub transmission: f64,
    /// Half vector inside the binder: the normal of a flake that mirrors one direction into the other.
    pub half: DVec3,
    /// Cosine of the angle between half vector and either direction (corrected eq. 14, alpha_R).
    pub cos_alpha: f64,
    /// Angle between half vector and paint normal (corrected eq. 14, beta_R).
    pub beta: f64,
}

impl Geometry {
    /// Geometry of unit directions `wi`, `wo` away from the surface, for a smooth surface of relative index `index`; `None`
    /// unless both are above the horizon.
    pub fn new(wi: DVec3, wo: DVec3, index: f64) -> Option<Self> {
        if !(wi.z > 0.0 && wo.z > 0.0) {
            return None;
        }
        let inside = |w: DVec3| (w.truncate() / index).extend(refracted_cosine(w.z, index));
        let theta = |w: DVec3| w.truncate().length().atan2(w.z);
        let (ti, to) = (inside(wi), inside(wo));
        let sum = ti + to;
        Some(Self {
            cos_outside: [wi.z, wo.z],
            cos_inside: [ti.z, to.z],
            theta_inside: [theta(ti), theta(to)],
            transmission: transmitted(wi.z, index) * transmitted(wo.z, index),
            half: sum.normalize(),
            cos_alpha: 0.5 * sum.length(),
            beta: theta(sum),
        })
    }
}
