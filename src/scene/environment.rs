//! Surroundings given by formulas: what a ray that misses everything sees.

use super::check;
use super::softbox::{Lamp, Softbox, color, smoothstep};
use crate::error::{Error, Result};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Light from everywhere, radiance in linear Rec.709.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Environment {
    /// The same radiance from everywhere.
    Constant {
        /// Radiance.
        radiance: [f64; 3],
    },
    /// A vertical gradient with soft boxes: a studio with lamps, a sky without.
    Studio {
        /// Radiance from straight below.
        ground: [f64; 3],
        /// Radiance from the horizon.
        horizon: [f64; 3],
        /// Radiance from straight above.
        zenith: [f64; 3],
        /// Lamps with a front of uniform radiance, added to the gradient.
        #[serde(default)]
        softbox: Vec<Softbox>,
    },
}

impl Default for Environment {
    fn default() -> Self {
        let softbox = |direction, size_deg, edge_deg, radiance: [f64; 3]| Softbox {
            direction,
            size_deg,
            edge_deg,
            radiance,
        };
        Self::Studio {
            ground: [0.04, 0.04, 0.045],
            horizon: [0.16, 0.165, 0.175],
            zenith: [0.30, 0.31, 0.33],
            softbox: vec![
                softbox([1.0, -0.35, 0.2], [20.0, 90.0], 8.0, [2.4, 2.5, 2.7]),
                softbox([-1.0, 0.25, 0.2], [16.0, 100.0], 8.0, [1.2, 1.2, 1.2]),
                softbox([0.1, 0.1, 1.0], [70.0, 40.0], 12.0, [1.5, 1.5, 1.5]),
            ],
        }
    }
}

impl Environment {
    /// Most soft boxes.
    pub const MAX_SOFTBOXES: usize = 64;

    pub(super) fn validate(&self) -> Result<()> {
        match self {
            Self::Constant { radiance } => check::radiance("", "radiance", *radiance),
            Self::Studio { ground, horizon, zenith, softbox } => {
                check::radiance("", "ground", *ground)?;
                check::radiance("", "horizon", *horizon)?;
                check::radiance("", "zenith", *zenith)?;
                if softbox.len() > Self::MAX_SOFTBOXES {
                    return Err(Error::invalid("", "softboxes", softbox.len(), "up to 64"));
                }
                softbox.iter().enumerate().try_for_each(|(k, lamp)| lamp.validate(&format!("softbox {k}")))
            }
        }
    }

    /// The surroundings ready for rays.
    pub fn surroundings(&self) -> Surroundings {
        match self {
            Self::Constant { radiance } => {
                Surroundings { gradient: [color(*radiance); 3], lamps: Vec::new() }
            }
            Self::Studio { ground, horizon, zenith, softbox } => {
                Surroundings { gradient: [*ground, *horizon, *zenith].map(color), lamps: Lamp::all(softbox) }
            }
        }
    }
}

/// An [`Environment`] ready for rays, f32.
#[derive(Debug, Clone, PartialEq)]
pub struct Surroundings {
    /// Ground, horizon, zenith.
    pub(crate) gradient: [Vec3; 3],
    pub(crate) lamps: Vec<Lamp>,
}

impl Surroundings {
    /// Radiance from the unit vector `direction`, linear Rec.709.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [ground, horizon, zenith] = self.gradient;
        let gradient = if direction.z < 0.0 {
            horizon.lerp(ground, smoothstep(0.0, 1.0, -direction.z))
        } else {
            horizon.lerp(zenith, smoothstep(0.0, 1.0, direction.z))
        };
        self.lamps.iter().fold(gradient, |sum, lamp| sum + lamp.radiance(direction))
    }

    /// Whether there are bright parts worth looking at by themselves.
    pub fn has_lamps(&self) -> bool {
        !self.lamps.is_empty()
    }

    /// A direction towards one of the soft boxes, chosen by their power, from two numbers in (0, 1).
    pub fn sample_lamp(&self, [mut choice, across]: [f32; 2]) -> Vec3 {
        for lamp in &self.lamps {
            if choice < lamp.share() {
                return lamp.sample([choice / lamp.share(), across]);
            }
            choice -= lamp.share();
        }
        // The shares sum to 1 up to rounding.
        self.lamps.last().map_or(Vec3::Z, |lamp| lamp.sample([1.0, across]))
    }

    /// Density of [`Surroundings::sample_lamp`] at a unit vector, 1/sr.
    pub fn lamp_density(&self, direction: Vec3) -> f32 {
        self.lamps.iter().map(|lamp| lamp.share() * lamp.density(direction)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_continuous_at_the_horizon() {
        let surroundings = Environment::default().surroundings();
        let at = |z: f32| surroundings.radiance(Vec3::new(0.0, (1.0 - z * z).sqrt(), z));
        assert!((at(1e-6) - at(-1e-6)).length() < 1e-6);
    }
}
