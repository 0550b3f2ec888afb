//! The lamp that a designer turns, and the surroundings to choose from.

use super::orbit;
use crate::scene::{DirectionalLight, Environment, Light};
use glam::{DVec2, DVec3};
use std::path::PathBuf;

/// One far lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Whether it shines.
    pub is_on: bool,
    /// Where it stands, degrees, 0 in front, growing to the right.
    pub azimuth_deg: f64,
    /// Above the horizon, degrees, -90 to 90.
    pub elevation_deg: f64,
    /// Angular radius of its disc, degrees.
    pub angular_radius_deg: f64,
    /// Its usual irradiance on a surface that faces it, linear Rec.709.
    pub irradiance: [f64; 3],
    /// Brightness over the usual one, stops.
    pub stops: f64,
}

impl Lamp {
    /// Legal angular radii, degrees.
    pub const RADIUS_DEG: std::ops::RangeInclusive<f64> = 0.25..=10.0;
    /// Legal brightness, stops.
    pub const STOPS: std::ops::RangeInclusive<f64> = -6.0..=6.0;
    /// Degrees a pixel of a drag.
    const TURN_DEG: f64 = 0.35;

    /// Largest irradiance that is legal.
    const MOST: f64 = 1e6;

    /// The lamp of a directional light.
    pub fn of(light: &DirectionalLight) -> Self {
        let (azimuth, elevation) = orbit::angles(DVec3::from(light.direction));
        Self {
            is_on: true,
            azimuth_deg: azimuth.to_degrees(),
            elevation_deg: elevation.to_degrees(),
            angular_radius_deg: light.angular_radius_deg,
            irradiance: light.irradiance,
            stops: 0.0,
        }
    }

    /// Unit vector towards the lamp.
    pub fn direction(&self) -> DVec3 {
        orbit::direction(self.azimuth_deg.to_radians(), self.elevation_deg.to_radians())
    }

    /// The lamps of the picture: this one, or none.
    pub fn lights(&self) -> Vec<Light> {
        let irradiance = self.irradiance.map(|c| (c * self.stops.exp2()).min(Self::MOST));
        let light = DirectionalLight {
            direction: self.direction().to_array(),
            irradiance,
            angular_radius_deg: self.angular_radius_deg,
        };
        if self.is_on { vec![light.into()] } else { Vec::new() }
    }

    /// Moves the lamp by a drag of so many pixels, right and down.
    pub fn turn(&mut self, drag: DVec2) {
        self.azimuth_deg += drag.x * Self::TURN_DEG;
        self.azimuth_deg -= 360.0 * (self.azimuth_deg / 360.0).round();
        self.elevation_deg = (self.elevation_deg - drag.y * Self::TURN_DEG).clamp(-90.0, 90.0);
    }
}

impl Default for Lamp {
    fn default() -> Self {
        Self::of(&DirectionalLight::default())
    }
}

/// Sine of the sun's least height in the sky.
const LOWEST_SUN: f64 = 0.02;

/// Surroundings from a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panorama {
    /// OpenEXR or Radiance; empty: none was opened.
    pub path: PathBuf,
    /// Rotation about z, counterclockwise from above, degrees.
    pub turn_deg: f64,
    /// Brightness, stops.
    pub stops: f64,
}

/// Surroundings to choose from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Surroundings {
    /// A room with three soft boxes.
    #[default]
    Studio,
    /// A clear sky over a gray ground.
    Sky,
    /// The same light from everywhere.
    Uniform,
    /// No light but the lamp's.
    Dark,
    /// An equirectangular picture from a file.
    Picture,
    /// Those of the scene that was opened.
    Scene,
}

impl Surroundings {
    /// Every choice without a file.
    pub const BUILT_IN: [Self; 4] = [Self::Studio, Self::Sky, Self::Uniform, Self::Dark];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Sky => "sky",
            Self::Uniform => "uniform",
            Self::Dark => "dark",
            Self::Picture => "picture",
            Self::Scene => "scene",
        }
    }

    /// As the renderer takes them; the sky's sun stands where the lamp does, or above the horizon there. `scene`: those of the scene
    /// that was opened.
    pub fn environment(self, lamp: &Lamp, picture: &Panorama, scene: Option<&Environment>) -> Environment {
        match self {
            Self::Studio => Environment::default(),
            Self::Sky => {
                let sun = lamp.direction();
                Environment::Sky {
                    sun: sun.with_z(sun.z.max(LOWEST_SUN)).to_array(),
                    zenith: [0.10, 0.19, 0.42],
                    ground: [0.20, 0.19, 0.17],
                }
            }
            Self::Picture => Environment::Image {
                path: picture.path.clone(),
                turn_deg: picture.turn_deg,
                scale: picture.stops.exp2(),
            },
            Self::Scene => scene.cloned().unwrap_or_default(),
            Self::Uniform => Environment::Constant { radiance: [0.4; 3] },
            Self::Dark => Environment::Constant { radiance: [0.0; 3] },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn the_default_lamp_is_the_default_light() {
        let [Light::Directional(light)] = Lamp::default().lights()[..] else { panic!("one far light") };
        let usual = DirectionalLight::default();
        let expected = DVec3::from(usual.direction).normalize();
        assert!(DVec3::from(light.direction).distance(expected) < 1e-14, "{light:?}");
        assert_eq!(light.irradiance, usual.irradiance);
        assert!(Lamp { is_on: false, ..Lamp::default() }.lights().is_empty());
    }

    #[test]
    fn the_lamp_turns_and_stays_legal() {
        let mut lamp = Lamp { azimuth_deg: 170.0, elevation_deg: 80.0, ..Lamp::default() };
        lamp.turn(DVec2::new(100.0, -100.0));
        assert_eq!((lamp.azimuth_deg, lamp.elevation_deg), (-155.0, 90.0));
        Scene { lights: lamp.lights(), ..Scene::default() }.validate().unwrap();
    }

    #[test]
    fn every_choice_of_surroundings_is_legal_wherever_the_lamp_stands() {
        for elevation_deg in [-90.0, -10.0, 0.0, 40.0, 90.0] {
            let lamp = Lamp { elevation_deg, ..Lamp::default() };
            for surroundings in Surroundings::BUILT_IN {
                let environment = surroundings.environment(&lamp, &Panorama::default(), None);
                environment.surroundings().unwrap();
                Scene { environment, ..Scene::default() }.validate().unwrap();
            }
        }
    }
}
