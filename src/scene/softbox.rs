//! Far rectangular lamps with soft edges.

use super::check;
use crate::error::Result;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Largest half angle of a lamp, radians: short of a right angle, where its plane ends.
const LIMIT: f32 = 1.5;

/// What lies beyond the tangents by less than this is a sample on the very rim that was rounded: were its density 0, the paint's
/// own proposal would have to make up for it, and a pixel would show it.
const RIM: f32 = 1.0 + 1e-5;

/// A far rectangular lamp with soft edges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Softbox {
    /// Towards its middle; any length.
    pub direction: [f64; 3],
    /// Full width and height as seen from the object, degrees, 1 to 170, at half the radiance.
    pub size_deg: [f64; 2],
    /// Width of the edge, over which the radiance falls to 0, degrees, 0.5 to 90.
    pub edge_deg: f64,
    /// Radiance of the middle.
    pub radiance: [f64; 3],
}

impl Softbox {
    pub(super) fn validate(&self, place: &str) -> Result<()> {
        check::direction(place, "direction", self.direction)?;
        check::range(place, "width (size_deg)", self.size_deg[0], 1.0..=170.0)?;
        check::range(place, "height (size_deg)", self.size_deg[1], 1.0..=170.0)?;
        check::range(place, "edge_deg", self.edge_deg, 0.5..=90.0)?;
        check::radiance(place, "radiance", self.radiance)
    }
}

/// A [`Softbox`] ready for rays.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lamp {
    /// Right, up, middle: unit vectors.
    pub axes: [Vec3; 3],
    /// Half width and half height, radians.
    pub half: [f32; 2],
    /// Half the width of the edge, radians.
    pub edge: f32,
    /// Tangents of half the angles that the lamp covers, its edge included.
    pub tangents: [f32; 2],
    /// Cosine of the angle between middle and farthest corner, edge included, at least 0.
    pub reach: f32,
    pub radiance: Vec3,
    /// Share of the power of all soft boxes.
    share: f32,
}

impl Lamp {
    /// All soft boxes of a scene.
    pub fn all(softboxes: &[Softbox]) -> Vec<Self> {
        let mut lamps: Vec<_> = softboxes.iter().map(Self::new).collect();
        // The constant keeps dark boxes from dividing 0 by 0.
        let power = |lamp: &Self| lamp.radiance.element_sum() * lamp.half[0] * lamp.half[1] + 1e-6;
        let total: f32 = lamps.iter().map(power).sum();
        for lamp in &mut lamps {
            lamp.share = power(lamp) / total;
        }
        lamps
    }

    fn new(softbox: &Softbox) -> Self {
        let middle = DVec3::from(softbox.direction).normalize();
        let upright = if middle.z.abs() < 0.999 { DVec3::Z } else { DVec3::Y };
        let right = middle.cross(upright).normalize();
        let half = softbox.size_deg.map(|d| (d / 2.0).to_radians() as f32);
        let edge = (softbox.edge_deg / 2.0).to_radians() as f32;
        let tangents = half.map(|h| (h + edge).min(LIMIT).tan());
        Self {
            axes: [right, right.cross(middle), middle].map(|v| v.as_vec3()),
            half,
            edge,
            tangents,
            reach: 1.0 / (1.0 + tangents[0] * tangents[0] + tangents[1] * tangents[1]).sqrt(),
            radiance: color(softbox.radiance),
            share: 0.0,
        }
    }

    /// Share of the power of all soft boxes.
    pub fn share(&self) -> f32 {
        self.share
    }

    /// Radiance from the unit vector `direction`.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        if z < 0.999 * self.reach {
            return Vec3::ZERO;
        }
        let inside = |offset: f32, half: f32| {
            1.0 - smoothstep(half - self.edge, half + self.edge, offset.atan2(z).abs())
        };
        self.radiance * (inside(x, self.half[0]) * inside(y, self.half[1]))
    }

    /// A direction within the lamp's edges, uniform in the two angles, from two numbers in (0, 1).
    pub fn sample(&self, at: [f32; 2]) -> Vec3 {
        let [x, y] = [0, 1].map(|k| (self.extent(k) * (2.0 * at[k] - 1.0)).tan());
        (self.axes[0] * x + self.axes[1] * y + self.axes[2]).normalize()
    }

    /// Density of [`Lamp::sample`] at a unit vector, 1/sr.
    pub fn density(&self, direction: Vec3) -> f32 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        if z < 0.999 * self.reach || z <= 0.0 {
            return 0.0;
        }
        let (x, y) = (x / z, y / z);
        if x.abs() > RIM * self.tangents[0] || y.abs() > RIM * self.tangents[1] {
            return 0.0;
        }
        // Angles to the tangent plane, and the plane to solid angle: 1 / z^3 = (1 + x^2 + y^2)^(3/2).
        let angles = 4.0 * self.extent(0) * self.extent(1);
        1.0 / (angles * (1.0 + x * x) * (1.0 + y * y) * z * z * z)
    }

    /// Half the angle that the lamp covers along an axis, its edge included, radians.
    pub fn extent(&self, axis: usize) -> f32 {
        (self.half[axis] + self.edge).min(LIMIT)
    }
}

/// A color of a scene file in f32.
pub(super) fn color(rgb: [f64; 3]) -> Vec3 {
    DVec3::from(rgb).as_vec3()
}

/// 0 below `low`, 1 above `high`, a cubic between.
pub(super) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_softbox_has_its_size_and_radiance() {
        let lamp = Softbox {
            direction: [0.0, -3.0, 0.0],
            size_deg: [40.0, 20.0],
            edge_deg: 4.0,
            radiance: [5.0, 6.0, 7.0],
        };
        let lamp = &Lamp::all(&[lamp])[0];
        let at = |right: f32, up: f32| {
            let (right, up) = (right.to_radians().tan(), up.to_radians().tan());
            lamp.radiance(Vec3::new(right, -1.0, up).normalize())
        };
        assert_eq!(at(0.0, 0.0), Vec3::new(5.0, 6.0, 7.0));
        assert_eq!(at(17.9, 7.9), Vec3::new(5.0, 6.0, 7.0));
        // Half the radiance at the nominal edge; f32 angles.
        assert!((at(20.0, 0.0).x - 2.5).abs() < 1e-4);
        assert!((at(0.0, -10.0).x - 2.5).abs() < 1e-4);
        assert_eq!(at(22.1, 0.0), Vec3::ZERO);
        assert_eq!(lamp.radiance(Vec3::Y), Vec3::ZERO, "nothing behind");
    }

    #[test]
    fn samples_of_a_softbox_have_the_density_stated() {
        let lamp = Softbox {
            direction: [1.0, 0.5, 0.4],
            size_deg: [70.0, 130.0],
            edge_deg: 20.0,
            radiance: [1.0; 3],
        };
        let lamp = &Lamp::all(&[lamp])[0];
        let n = 400;
        let at = |k: usize| (k as f32 + 0.5) / n as f32;
        let mut solid_angle = 0.0;
        for k in 0..n * n {
            let direction = lamp.sample([at(k % n), at(k / n)]);
            assert!((direction.length() - 1.0).abs() < 1e-6);
            solid_angle += 1.0 / f64::from(lamp.density(direction)) / (n * n) as f64;
        }
        // A rectangle seen from its axis, half angles a and b: 4 asin(sin a' sin b') in its usual form.
        let [a, b] = [45f64, 75.0].map(|d| d.to_radians().tan());
        let exact = 4.0 * (a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt()).asin();
        // Midpoint rule of 400^2 points; f32.
        assert!((solid_angle / exact - 1.0).abs() < 1e-4, "{solid_angle} {exact}");
    }
}
