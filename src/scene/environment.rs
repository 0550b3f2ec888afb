//! Surroundings: what a ray that misses everything sees.

use super::check;
use super::lamp_points::LampPoints;
use super::panorama::Panorama;
use super::sky::sky;
use super::softbox::{Lamp, Softbox, color, smoothstep};
use crate::error::{Error, Result};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

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
    /// A clear sky without the disc of its sun: give it a lamp of the same direction.
    Sky {
        /// Towards the sun; any length, not below the horizon.
        sun: [f64; 3],
        /// Radiance of the zenith in linear Rec.709.
        zenith: [f64; 3],
        /// Share of the sky's irradiance that the ground reflects, 0 to 1.
        ground: [f64; 3],
    },
    /// An equirectangular picture, OpenEXR or Radiance: its middle column is ahead of the default camera (+y), the zenith on top.
    Image {
        /// The file; in a scene file relative to that.
        path: PathBuf,
        /// Rotation about z, counterclockwise from above, degrees, -360 to 360.
        #[serde(default)]
        turn_deg: f64,
        /// What radiance is multiplied by, 0 to 1e6.
        #[serde(default = "one")]
        scale: f64,
    },
}

fn one() -> f64 {
    1.0
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
            Self::Sky { sun, zenith, ground } => {
                check::direction("", "sun", *sun)?;
                check::range("", "height of the sun", sun[2], 0.0..=1e6)?;
                check::radiance("", "zenith", *zenith)?;
                ground.iter().try_for_each(|share| check::range("", "ground", *share, 0.0..=1.0))
            }
            Self::Image { turn_deg, scale, .. } => {
                check::range("", "turn_deg", *turn_deg, -360.0..=360.0)?;
                check::range("", "scale", *scale, 0.0..=1e6)
            }
        }
    }

    /// Paths of files become relative to the working folder instead of `folder`.
    pub(super) fn resolve(&mut self, folder: &Path) {
        if let Self::Image { path, .. } = self {
            *path = folder.join(&path);
        }
    }

    /// The file of a picture.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        if let Self::Image { path, .. } = self { Some(path) } else { None }
    }

    /// The surroundings ready for rays.
    ///
    /// # Errors
    /// Those of reading a picture; radiance that is clearly negative, or above 1e30 (its pixel named).
    pub fn surroundings(&self) -> Result<Surroundings> {
        let dark = Surroundings {
            gradient: [Vec3::ZERO; 3],
            lamps: Vec::new(),
            panorama: None,
            points: Arc::default(),
        };
        Ok(match self {
            Self::Constant { radiance } => Surroundings { gradient: [color(*radiance); 3], ..dark },
            Self::Studio { ground, horizon, zenith, softbox } => Surroundings {
                gradient: [*ground, *horizon, *zenith].map(color),
                lamps: Lamp::all(softbox),
                ..dark
            },
            Self::Sky { sun, zenith, ground } => {
                let panorama = sky(DVec3::from(*sun), DVec3::from(*zenith), DVec3::from(*ground))?;
                Surroundings { panorama: Some(Arc::new(panorama)), ..dark }
            }
            Self::Image { path, turn_deg, scale } => {
                let panorama = image(path, *turn_deg, *scale)?;
                Surroundings { panorama: Some(Arc::new(panorama)), ..dark }
            }
        })
    }
}

#[cfg(feature = "files")]
fn image(path: &Path, turn_deg: f64, scale: f64) -> Result<Panorama> {
    let (size, pixels) = crate::file::read_panorama(path)?;
    Panorama::new(size, pixels, scale as f32, turn_deg.to_radians()).map_err(|e| e.in_file(path))
}

#[cfg(not(feature = "files"))]
fn image(path: &Path, _: f64, _: f64) -> Result<Panorama> {
    let place = path.display().to_string();
    Err(Error::unsupported(
        place,
        "panorama",
        "a file",
        "surroundings without: built without the feature files",
    ))
}

/// An [`Environment`] ready for rays, f32.
#[derive(Debug, Clone)]
pub struct Surroundings {
    /// Ground, horizon, zenith.
    pub(crate) gradient: [Vec3; 3],
    pub(crate) lamps: Vec<Lamp>,
    /// Instead of gradient and lamps.
    pub(crate) panorama: Option<Arc<Panorama>>,
    /// Found when they are first asked for, once for all clones.
    points: Arc<OnceLock<LampPoints>>,
}

impl Surroundings {
    /// Radiance from the unit vector `direction`, linear Rec.709.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        if let Some(panorama) = &self.panorama {
            return panorama.radiance(direction);
        }
        let [ground, horizon, zenith] = self.gradient;
        let gradient = if direction.z < 0.0 {
            horizon.lerp(ground, smoothstep(0.0, 1.0, -direction.z))
        } else {
            horizon.lerp(zenith, smoothstep(0.0, 1.0, direction.z))
        };
        self.lamps.iter().fold(gradient, |sum, lamp| sum + lamp.radiance(direction))
    }

    /// What is small and bright, as points and in groups.
    pub(crate) fn lamp_points(&self) -> &LampPoints {
        self.points.get_or_init(|| LampPoints::of(self))
    }

    /// Whether there are bright parts worth looking at by themselves.
    pub fn has_lamps(&self) -> bool {
        self.panorama.as_ref().map_or(!self.lamps.is_empty(), |panorama| panorama.is_bright())
    }

    /// A direction towards one of the bright parts, chosen by their power, from two numbers in (0, 1).
    pub fn sample(&self, [mut choice, across]: [f32; 2]) -> Vec3 {
        if let Some(panorama) = &self.panorama {
            return panorama.sample([choice, across]);
        }
        for lamp in &self.lamps {
            if choice < lamp.share() {
                return lamp.sample([choice / lamp.share(), across]);
            }
            choice -= lamp.share();
        }
        // The shares sum to 1 up to rounding.
        self.lamps.last().map_or(Vec3::Z, |lamp| lamp.sample([1.0, across]))
    }

    /// Density of [`Surroundings::sample`] at a unit vector, 1/sr.
    pub fn density(&self, direction: Vec3) -> f32 {
        if let Some(panorama) = &self.panorama {
            return panorama.density(direction);
        }
        self.lamps.iter().map(|lamp| lamp.share() * lamp.density(direction)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_continuous_at_the_horizon() {
        let surroundings = Environment::default().surroundings().unwrap();
        let at = |z: f32| surroundings.radiance(Vec3::new(0.0, (1.0 - z * z).sqrt(), z));
        assert!((at(1e-6) - at(-1e-6)).length() < 1e-6);
    }
}
