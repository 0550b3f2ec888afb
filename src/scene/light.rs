//! Distant lamps.

use super::check;
use crate::error::Result;
use serde::{Deserialize, Serialize};

/// A lamp so far away that its light is parallel, seen as a disc of uniform radiance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DirectionalLight {
    /// Towards the lamp; any length.
    pub direction: [f64; 3],
    /// Irradiance on a surface that faces the lamp, linear Rec.709: (pi, pi, pi) shows a white diffuser as 1.
    pub irradiance: [f64; 3],
    /// Angular radius of the disc, degrees, 0.25 (the sun: 0.27) to 10.
    pub angular_radius_deg: f64,
}

impl Default for DirectionalLight {
    fn default() -> Self {
        Self { direction: [-0.62, -0.78, 0.3], irradiance: [3.0, 2.95, 2.85], angular_radius_deg: 1.0 }
    }
}

impl DirectionalLight {
    pub(super) fn validate(&self) -> Result<()> {
        check::direction("", "direction", self.direction)?;
        check::radiance("", "irradiance", self.irradiance)?;
        check::range("", "angular_radius_deg", self.angular_radius_deg, 0.25..=10.0)
    }
}
