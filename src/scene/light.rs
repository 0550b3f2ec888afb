//! Lamps: parallel light from afar, and lamps that stand somewhere, in all directions or in a cone.

use super::check;
use crate::error::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A lamp, seen as a disc of uniform radiance. In a scene file the key `kind` says which: `directional`, the default, `point`
/// or `spot`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub enum Light {
    /// Parallel light.
    Directional(DirectionalLight),
    /// A ball that shines alike in all directions.
    Point(PointLight),
    /// A ball that shines in a cone.
    Spot(SpotLight),
}

/// A lamp so far away that its light is parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Towards the lamp; any length.
    pub direction: [f64; 3],
    /// Irradiance on a surface that faces the lamp, linear Rec.709, 0 to 1e6: (pi, pi, pi) shows a white diffuser as 1.
    pub irradiance: [f64; 3],
    /// Angular radius of the disc, degrees, 0.25 (the sun: 0.27) to 10.
    pub angular_radius_deg: f64,
}

/// A ball that shines alike in all directions: irradiance falls with the square of the distance from its center.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// Center, millimetres, at least 1 from the origin.
    pub position_mm: [f64; 3],
    /// Irradiance on a surface at the origin that faces the lamp, linear Rec.709, 0 to 1e6.
    pub irradiance: [f64; 3],
    /// Radius, millimetres, 0.0044 (0.25 degrees, as seen from the origin) to 0.5 of the distance from the origin.
    pub radius_mm: f64,
}

/// A [`PointLight`] whose light is a cone: full within `cone_deg - edge_deg` of its axis, none beyond `cone_deg`, smooth
/// between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    /// Where it stands, and the irradiance at the origin were that on the axis.
    pub lamp: PointLight,
    /// The point that the axis goes through, millimetres; not the lamp's own.
    pub target_mm: [f64; 3],
    /// Half of the opening angle, degrees, 0.1 to 90.
    pub cone_deg: f64,
    /// Width of the soft edge inside the cone, degrees, 0 to `cone_deg`.
    pub edge_deg: f64,
}

/// A lamp as a point sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Incidence {
    /// Unit vector towards its center.
    pub direction: DVec3,
    /// Irradiance on a surface that faces it, linear Rec.709.
    pub irradiance: DVec3,
    /// Radians, 0 to pi/2.
    pub angular_radius: f64,
    /// Distance of its center, millimetres; infinite from afar.
    pub distance: f64,
}

impl Default for DirectionalLight {
    fn default() -> Self {
        Self { direction: [-0.62, -0.78, 0.3], irradiance: [3.0, 2.95, 2.85], angular_radius_deg: 1.0 }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::Directional(DirectionalLight::default())
    }
}

impl From<DirectionalLight> for Light {
    fn from(light: DirectionalLight) -> Self {
        Self::Directional(light)
    }
}

impl Light {
    /// The lamp as `point`, millimetres, sees it.
    pub fn at(&self, point: DVec3) -> Incidence {
        match self {
            Self::Directional(light) => Incidence {
                direction: DVec3::from(light.direction).normalize(),
                irradiance: light.irradiance.into(),
                angular_radius: light.angular_radius_deg.to_radians(),
                distance: f64::INFINITY,
            },
            Self::Point(light) => light.at(point),
            Self::Spot(light) => light.at(point),
        }
    }

    pub(super) fn validate(&self) -> Result<()> {
        match self {
            Self::Directional(light) => {
                check::direction("", "direction", light.direction)?;
                check::radiance("", "irradiance", light.irradiance)?;
                check::range("", "angular_radius_deg", light.angular_radius_deg, 0.25..=10.0)
            }
            Self::Point(light) => light.validate(),
            Self::Spot(light) => light.validate(),
        }
    }
}

impl PointLight {
    fn at(&self, point: DVec3) -> Incidence {
        let center = DVec3::from(self.position_mm);
        let way = center - point;
        // A point inside the ball sees it as from its surface.
        let distance = way.length().max(self.radius_mm);
        Incidence {
            direction: way.try_normalize().unwrap_or(DVec3::Z),
            irradiance: DVec3::from(self.irradiance) * (center.length_squared() / (distance * distance)),
            angular_radius: (self.radius_mm / distance).asin(),
            distance: way.length(),
        }
    }

    fn validate(&self) -> Result<()> {
        check::position("", "position_mm", self.position_mm)?;
        check::radiance("", "irradiance", self.irradiance)?;
        let distance = DVec3::from(self.position_mm).length();
        check::range("", "distance of position_mm from the origin", distance, 1.0..=2e7)?;
        check::range("", "radius_mm", self.radius_mm, 0.0044 * distance..=0.5 * distance)
    }
}

impl SpotLight {
    fn at(&self, point: DVec3) -> Incidence {
        let seen = self.lamp.at(point);
        let axis = DVec3::from(self.target_mm) - DVec3::from(self.lamp.position_mm);
        let angle = axis.angle_between(-seen.direction).to_degrees();
        let inside = self.cone_deg - angle;
        let x = if inside < self.edge_deg { (inside / self.edge_deg).max(0.0) } else { 1.0 };
        Incidence { irradiance: seen.irradiance * (x * x * (3.0 - 2.0 * x)), ..seen }
    }

    fn validate(&self) -> Result<()> {
        self.lamp.validate()?;
        check::position("", "target_mm", self.target_mm)?;
        let axis = (DVec3::from(self.target_mm) - DVec3::from(self.lamp.position_mm)).length();
        check::range("", "distance of target_mm from position_mm", axis, 1e-3..=1e8)?;
        check::range("", "cone_deg", self.cone_deg, 0.1..=90.0)?;
        check::range("", "edge_deg", self.edge_deg, 0.0..=self.cone_deg)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    #[default]
    Directional,
    Point,
    Spot,
}

/// The keys of all kinds: which of them belong together is checked after reading, so that a file without `kind` is parallel
/// light.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Keys {
    kind: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    irradiance: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    angular_radius_deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_mm: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    target_mm: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cone_deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    edge_deg: Option<f64>,
}

impl TryFrom<Keys> for Light {
    type Error = Error;

    fn try_from(keys: Keys) -> Result<Self> {
        let default = DirectionalLight::default();
        let irradiance = keys.irradiance.unwrap_or(default.irradiance);
        let lamp = || PointLight {
            position_mm: keys.position_mm.unwrap_or([-150.0, -190.0, 75.0]),
            irradiance,
            radius_mm: keys.radius_mm.unwrap_or(4.0),
        };
        let places = [("position_mm", keys.position_mm.is_some()), ("radius_mm", keys.radius_mm.is_some())];
        let cones = [
            ("target_mm", keys.target_mm.is_some()),
            ("cone_deg", keys.cone_deg.is_some()),
            ("edge_deg", keys.edge_deg.is_some()),
        ];
        let discs = [
            ("direction", keys.direction.is_some()),
            ("angular_radius_deg", keys.angular_radius_deg.is_some()),
        ];
        let none_of = |wrong: &[(&str, bool)], legal: &str| match wrong.iter().find(|key| key.1) {
            Some((key, _)) => Err(Error::invalid("", "key", key, legal)),
            None => Ok(()),
        };
        match keys.kind {
            Kind::Directional => {
                none_of(&places, "direction, irradiance, angular_radius_deg for kind directional")?;
                none_of(&cones, "direction, irradiance, angular_radius_deg for kind directional")?;
                Ok(Self::Directional(DirectionalLight {
                    direction: keys.direction.unwrap_or(default.direction),
                    irradiance,
                    angular_radius_deg: keys.angular_radius_deg.unwrap_or(default.angular_radius_deg),
                }))
            }
            Kind::Point => {
                none_of(&discs, "position_mm, irradiance, radius_mm for kind point")?;
                none_of(&cones, "position_mm, irradiance, radius_mm for kind point")?;
                Ok(Self::Point(lamp()))
            }
            Kind::Spot => {
                let legal = "position_mm, irradiance, radius_mm, target_mm, cone_deg, edge_deg for kind spot";
                none_of(&discs, legal)?;
                let cone_deg = keys.cone_deg.unwrap_or(20.0);
                Ok(Self::Spot(SpotLight {
                    lamp: lamp(),
                    target_mm: keys.target_mm.unwrap_or([0.0; 3]),
                    cone_deg,
                    edge_deg: keys.edge_deg.unwrap_or(0.25 * cone_deg),
                }))
            }
        }
    }
}

impl From<Light> for Keys {
    fn from(light: Light) -> Self {
        let lamp = |kind: Kind, lamp: PointLight| Self {
            kind,
            position_mm: Some(lamp.position_mm),
            irradiance: Some(lamp.irradiance),
            radius_mm: Some(lamp.radius_mm),
            ..Self::default()
        };
        match light {
            Light::Directional(light) => Self {
                direction: Some(light.direction),
                irradiance: Some(light.irradiance),
                angular_radius_deg: Some(light.angular_radius_deg),
                ..Self::default()
            },
            Light::Point(light) => lamp(Kind::Point, light),
            Light::Spot(light) => Self {
                target_mm: Some(light.target_mm),
                cone_deg: Some(light.cone_deg),
                edge_deg: Some(light.edge_deg),
                ..lamp(Kind::Spot, light.lamp)
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot() -> SpotLight {
        SpotLight {
            lamp: PointLight { position_mm: [0.0, 0.0, 100.0], irradiance: [2.0, 1.0, 0.5], radius_mm: 3.0 },
            target_mm: [0.0; 3],
            cone_deg: 10.0,
            edge_deg: 4.0,
        }
    }

    #[test]
    fn a_far_lamp_is_parallel_light() {
        let light = DirectionalLight { direction: [0.0, 0.6, 0.8], ..DirectionalLight::default() };
        let far = 1e6;
        let lamp = PointLight {
            position_mm: [0.0, 0.6 * far, 0.8 * far],
            irradiance: light.irradiance,
            radius_mm: far * light.angular_radius_deg.to_radians().sin(),
        };
        let point = DVec3::new(3.0, -20.0, 11.0);
        let (a, b) = (Light::from(light).at(point), Light::Point(lamp).at(point));
        // The point is 2e-5 of the distance away.
        assert!((a.direction - b.direction).length() < 3e-5);
        assert!((a.irradiance - b.irradiance).length() < 1e-4 * a.irradiance.length());
        assert!((a.angular_radius - b.angular_radius).abs() < 1e-4 * a.angular_radius);
    }

    #[test]
    fn irradiance_falls_with_the_square_of_the_distance() {
        let lamp = Light::Point(spot().lamp);
        let at = |z: f64| lamp.at(DVec3::Z * z);
        assert_eq!(at(0.0).irradiance, DVec3::new(2.0, 1.0, 0.5));
        assert!((at(50.0).irradiance.x - 8.0).abs() < 1e-12);
        assert!((at(-100.0).irradiance.x - 0.5).abs() < 1e-12);
        // Inside the ball and in its center everything stays finite.
        for z in [98.0, 100.0] {
            let seen = at(z);
            assert!(seen.irradiance.is_finite() && seen.direction.is_normalized());
            assert!(seen.angular_radius <= std::f64::consts::FRAC_PI_2);
        }
    }

    #[test]
    fn cones_have_an_edge() {
        let light = Light::Spot(spot());
        let share = |degrees: f64| {
            let point = DVec3::X * (100.0 * degrees.to_radians().tan());
            light.at(point).irradiance.x / Light::Point(spot().lamp).at(point).irradiance.x
        };
        assert_eq!([share(0.0), share(5.9), share(10.1), share(60.0)], [1.0, 1.0, 0.0, 0.0]);
        assert!((share(8.0) - 0.5).abs() < 1e-9);
        let hard = Light::Spot(SpotLight { edge_deg: 0.0, ..spot() });
        assert!(hard.at(DVec3::X * 17.0).irradiance.x > 0.0);
        assert_eq!(hard.at(DVec3::X * 18.0).irradiance.x, 0.0);
    }

    #[test]
    fn lamps_are_read_as_they_are_written() {
        for light in [Light::default(), Light::Point(spot().lamp), Light::Spot(spot())] {
            let text = toml::to_string(&light).unwrap();
            assert_eq!(toml::from_str::<Light>(&text).unwrap(), light, "{text}");
        }
        let error = |text: &str| toml::from_str::<Light>(text).unwrap_err().to_string();
        assert!(error("kind = \"point\"\ndirection = [0.0, 0.0, 1.0]").contains("key: found direction"));
        assert!(error("position_mm = [0.0, 0.0, 1.0]").contains("kind directional"));
        assert!(error("kind = \"laser\"").contains("directional"));
        for bad in [
            SpotLight { lamp: PointLight { radius_mm: 0.4, ..spot().lamp }, ..spot() },
            SpotLight { cone_deg: 91.0, ..spot() },
            SpotLight { edge_deg: 11.0, ..spot() },
            SpotLight { edge_deg: f64::NAN, ..spot() },
            SpotLight { target_mm: [0.0, 0.0, 100.0], ..spot() },
            SpotLight { lamp: PointLight { radius_mm: 51.0, ..spot().lamp }, ..spot() },
            SpotLight { lamp: PointLight { position_mm: [0.0; 3], ..spot().lamp }, ..spot() },
        ] {
            assert!(Light::Spot(bad).validate().is_err(), "{bad:?}");
        }
        Light::Spot(spot()).validate().unwrap();
    }
}
