//! Small lights, which make sparkles: parallel, point and spot. Others light a paint evenly.
//!
//! 1999 takes the direction of a spot light's axis for that of its rays; here every light but the parallel one sends its rays
//! from where it is.

use glam::{DMat3, DVec3};

/// A small light. Colors are linear RGB; positions and lengths in one unit of the caller's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// So far away that its rays are parallel: the sun.
    Parallel {
        /// Unit direction towards the light.
        direction: DVec3,
        /// Irradiance across the rays.
        irradiance: DVec3,
        /// Angular radius, radians; the sun's is 0.00465.
        radius: f64,
    },
    /// A small sphere that shines alike everywhere.
    Point {
        /// Center.
        position: DVec3,
        /// Intensity, power per solid angle.
        intensity: DVec3,
        /// Radius, a length.
        radius: f64,
    },
    /// A small sphere that shines into a cone: `intensity cos^falloff` of the angle to the axis, nothing outside.
    Spot {
        /// Center.
        position: DVec3,
        /// Unit direction in which it shines.
        axis: DVec3,
        /// Intensity on the axis.
        intensity: DVec3,
        /// Radius, a length.
        radius: f64,
        /// Half angle of the cone, radians, up to pi/2.
        cone: f64,
        /// Exponent, 0 for an even cone.
        falloff: f64,
    },
}

/// What fills the space between lights, paint and eye.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Medium {
    /// Extinction coefficient, 1 over the caller's unit of length; 0 for vacuum.
    pub extinction: DVec3,
}

/// Light as it arrives at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// Unit direction towards the light.
    pub direction: DVec3,
    /// Irradiance across the rays.
    pub irradiance: DVec3,
    /// Angular radius, radians.
    pub radius: f64,
}

impl Medium {
    /// The share of light that gets through a length of it.
    pub fn transmittance(&self, length: f64) -> DVec3 {
        (-self.extinction * length).exp()
    }
}

impl Light {
    /// What arrives at `place` through `medium`; `None` outside a spot's cone and inside a light. A parallel light's irradiance
    /// is that at the paint: no medium dims it.
    pub fn at(&self, place: DVec3, medium: &Medium) -> Option<Arrival> {
        let (position, intensity, radius) = match *self {
            Self::Parallel { direction, irradiance, radius } => {
                return Some(Arrival { direction, irradiance, radius });
            }
            Self::Point { position, intensity, radius } => (position, intensity, radius),
            Self::Spot { position, axis, intensity, radius, cone, falloff } => {
                let cos = (place - position).normalize_or_zero().dot(axis);
                if cos < cone.cos() || cos <= 0.0 {
                    return None;
                }
                (position, intensity * cos.powf(falloff), radius)
            }
        };
        let way = position - place;
        let distance = way.length();
        (distance > radius && distance > 0.0).then(|| Arrival {
            direction: way / distance,
            irradiance: intensity * medium.transmittance(distance) / (distance * distance),
            radius: (radius / distance).asin(),
        })
    }
}

impl Arrival {
    /// The same in a frame whose axes are the columns of `frame`, orthonormal; the last is the surface normal.
    #[must_use]
    pub fn in_frame(self, frame: &DMat3) -> Self {
        Self { direction: frame.transpose() * self.direction, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VACUUM: Medium = Medium { extinction: DVec3::ZERO };

    #[test]
    fn points_fall_off_with_the_square_of_the_distance() {
        let light = Light::Point { position: DVec3::Z * 10.0, intensity: DVec3::splat(200.0), radius: 0.1 };
        let (near, far) =
            (light.at(DVec3::ZERO, &VACUUM).unwrap(), light.at(-DVec3::Z * 10.0, &VACUUM).unwrap());
        assert_eq!(near.direction, DVec3::Z);
        assert!((near.irradiance - DVec3::splat(2.0)).length() < 1e-15);
        assert!((near.irradiance / far.irradiance - DVec3::splat(4.0)).length() < 1e-14);
        // Half the size from twice the distance, to the third order of a hundredth.
        assert!((near.radius / far.radius - 2.0).abs() < 1e-4);
        assert!(light.at(DVec3::new(0.05, 0.0, 10.0), &VACUUM).is_none());
        let haze = Medium { extinction: DVec3::new(0.0, 0.1, 0.2) };
        let dimmed = light.at(DVec3::ZERO, &haze).unwrap().irradiance / near.irradiance;
        assert!((dimmed - DVec3::new(1.0, (-1f64).exp(), (-2f64).exp())).length() < 1e-15);
    }

    #[test]
    fn a_spot_shines_into_its_cone() {
        let spot = |falloff| Light::Spot {
            position: DVec3::Z * 2.0,
            axis: -DVec3::Z,
            intensity: DVec3::ONE,
            radius: 0.01,
            cone: 0.5,
            falloff,
        };
        let at = |light: Light, angle: f64| {
            light.at(DVec3::Z * 2.0 + 2.0 * DVec3::new(angle.sin(), 0.0, -angle.cos()), &VACUUM)
        };
        assert!(at(spot(0.0), 0.51).is_none() && at(spot(0.0), 3.0).is_none());
        let edge = at(spot(0.0), 0.49).unwrap().irradiance;
        assert!((edge - DVec3::splat(0.25)).length() < 1e-15);
        let soft = at(spot(4.0), 0.49).unwrap().irradiance;
        assert!((soft / edge - DVec3::splat(0.49f64.cos().powi(4))).length() < 1e-14);
        // On the axis a spot is a point.
        let point = Light::Point { position: DVec3::Z * 2.0, intensity: DVec3::ONE, radius: 0.01 };
        assert_eq!(at(spot(4.0), 0.0), at(point, 0.0));
    }
}
