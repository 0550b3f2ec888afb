//! Where the eye is: a camera that turns about a point, and comes near by narrowing its field of view.
//!
//! Angles are counted as a designer turns a sample in the hand: azimuth 0 is the front (-y), growing to the right; elevation 0
//! is the horizon. Nearness narrows the field and leaves the eye where it is, as a loupe does: the angles under which flakes
//! are lit and seen stay, down to where a pixel is a small part of a texel.

use crate::scene::Camera;
use glam::{DVec2, DVec3};
use std::ops::RangeInclusive;

/// A camera about a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// What is in the middle of the picture, millimetres.
    pub target: DVec3,
    /// Radians.
    pub azimuth: f64,
    /// Radians, short of the poles.
    pub elevation: f64,
    /// From the target to the eye, millimetres.
    pub distance: f64,
    /// Full vertical field of view, degrees.
    pub fov_deg: f64,
}

/// Unit vector at an azimuth and an elevation, radians.
pub fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (sin_a, cos_a) = azimuth.sin_cos();
    let (sin_e, cos_e) = elevation.sin_cos();
    DVec3::new(sin_a * cos_e, -cos_a * cos_e, sin_e)
}

/// Azimuth and elevation of a vector that is not 0, radians.
pub fn angles(v: DVec3) -> (f64, f64) {
    (v.x.atan2(-v.y), v.z.atan2(v.truncate().length()))
}

/// Farthest elevation: straight along z a camera has no upright.
const STEEPEST: f64 = 1.55;
/// Radians a pixel of a drag.
const TURN: f64 = 0.007;
/// Fields lower than this, millimetres, turn slower: a flake lives 6 to 7 degrees.
const SLOW_FIELD_MM: f64 = 25.0;

impl Orbit {
    /// Legal fields of view, degrees: from a pixel of some 50 nm on the default object to a wide angle.
    pub const FOV_DEG: RangeInclusive<f64> = 0.01..=75.0;

    /// The orbit of a camera; its `up` is taken for upright.
    pub fn of(camera: &Camera) -> Self {
        let target = DVec3::from(camera.target_mm);
        let away = DVec3::from(camera.position_mm) - target;
        let (azimuth, elevation) = angles(away);
        Self {
            target,
            azimuth,
            elevation: elevation.clamp(-STEEPEST, STEEPEST),
            distance: away.length(),
            fov_deg: camera.vertical_fov_deg.clamp(*Self::FOV_DEG.start(), *Self::FOV_DEG.end()),
        }
    }

    /// The camera there.
    pub fn camera(&self) -> Camera {
        Camera {
            position_mm: self.eye().to_array(),
            target_mm: self.target.to_array(),
            up: [0.0, 0.0, 1.0],
            vertical_fov_deg: self.fov_deg,
        }
    }

    fn eye(&self) -> DVec3 {
        self.target + direction(self.azimuth, self.elevation) * self.distance
    }

    /// Height of what is seen at the target, millimetres.
    pub fn field_mm(&self) -> f64 {
        2.0 * self.distance * (self.fov_deg.to_radians() / 2.0).tan()
    }

    /// Turns by a drag of so many pixels, right and down: the object follows the pointer.
    pub fn orbit(&mut self, drag: DVec2) {
        let turn = TURN * (self.field_mm() / SLOW_FIELD_MM).clamp(0.02, 1.0);
        self.azimuth = (self.azimuth - drag.x * turn).rem_euclid(std::f64::consts::TAU);
        self.elevation = (self.elevation + drag.y * turn).clamp(-STEEPEST, STEEPEST);
    }

    /// Moves along the picture by a drag of so many heights of it, right and down: the object follows the pointer.
    pub fn pan(&mut self, drag: DVec2) {
        let [right, up] = self.axes();
        self.target += (up * drag.y - right * drag.x) * self.field_mm();
    }

    /// Shrinks the field by `factor` (above 1: comes nearer); what is at the point `at` (heights of the picture from its middle,
    /// right and down) stays there.
    pub fn zoom(&mut self, factor: f64, at: DVec2) {
        let before = self.field_mm();
        let half = (self.fov_deg.to_radians() / 2.0).tan() / factor;
        self.fov_deg = (2.0 * half.atan()).to_degrees().clamp(*Self::FOV_DEG.start(), *Self::FOV_DEG.end());
        let [right, up] = self.axes();
        self.target += (right * at.x - up * at.y) * (before - self.field_mm());
    }

    /// Takes a point straight ahead, so many millimetres from the eye, for the one to turn about; what is seen stays.
    pub fn pivot(&mut self, distance: f64) {
        self.target = self.eye() - direction(self.azimuth, self.elevation) * distance;
        self.distance = distance;
    }

    /// Right and up in the picture, unit vectors.
    fn axes(&self) -> [DVec3; 2] {
        let back = direction(self.azimuth, self.elevation);
        let right = DVec3::Z.cross(back).normalize();
        [right, back.cross(right)]
    }
}

impl Default for Orbit {
    fn default() -> Self {
        Self::of(&Camera::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a point of the picture lies on the plane through the target, millimetres.
    fn point(orbit: &Orbit, at: DVec2) -> DVec3 {
        let view = orbit.camera().view([1000, 1000]);
        let direction = view.direction(500.0 + 1000.0 * at.x, 500.0 + 1000.0 * at.y);
        let back = (view.origin - orbit.target).normalize();
        view.origin + direction * ((orbit.target - view.origin).dot(back) / direction.dot(back))
    }

    #[test]
    fn the_orbit_of_a_camera_is_the_camera() {
        let camera = Camera::default();
        let back = Orbit::of(&camera).camera();
        // Sines of arc tangents at 222 mm.
        assert!(DVec3::from(back.position_mm).distance(DVec3::from(camera.position_mm)) < 1e-12);
        assert_eq!(back.target_mm, camera.target_mm);
        assert!((back.vertical_fov_deg - camera.vertical_fov_deg).abs() < 1e-14);
    }

    #[test]
    fn angles_are_those_of_the_direction() {
        for (azimuth, elevation) in [(0.0, 0.0), (0.5, 1.2), (-2.0, -0.7), (3.0, 0.1)] {
            let (a, e) = angles(direction(azimuth, elevation) * 7.0);
            assert!((a - azimuth).abs() < 1e-14 && (e - elevation).abs() < 1e-14);
        }
        assert_eq!(direction(0.0, 0.0), DVec3::NEG_Y);
        assert!(direction(0.3, 0.0).x > 0.0, "azimuth grows to the right");
    }

    #[test]
    fn the_object_follows_the_pointer() {
        let mut orbit = Orbit::default();
        // The front of the object, before and after.
        let front = DVec3::new(0.0, -12.0, 0.0);
        let across = |orbit: &Orbit| {
            let [right, up] = orbit.axes();
            DVec2::new((front - orbit.target).dot(right), -(front - orbit.target).dot(up))
        };
        let before = across(&orbit);
        orbit.orbit(DVec2::new(30.0, 0.0));
        assert!(across(&orbit).x > before.x, "to the right");
        orbit = Orbit::default();
        orbit.orbit(DVec2::new(0.0, 30.0));
        assert!(across(&orbit).y > before.y, "down");
        orbit.orbit(DVec2::new(0.0, 1e6));
        orbit.camera().view([4, 4]);
        assert!(orbit.elevation < std::f64::consts::FRAC_PI_2, "short of the pole");
        let mut panned = Orbit::default();
        let grabbed = point(&panned, DVec2::new(0.1, 0.2));
        panned.pan(DVec2::new(0.25, -0.125));
        assert!(point(&panned, DVec2::new(0.35, 0.075)).distance(grabbed) < 1e-9);
    }

    #[test]
    fn what_is_under_the_pointer_stays_when_zooming() {
        let at = DVec2::new(-0.31, 0.22);
        let mut orbit = Orbit::default();
        let fixed = point(&orbit, at);
        for factor in [1.3, 2.0, 10.0, 0.5] {
            orbit.zoom(factor, at);
            // 222 mm, a few roundings.
            assert!(point(&orbit, at).distance(fixed) < 1e-9, "{factor}");
        }
        let field = orbit.field_mm();
        orbit.zoom(2.0, DVec2::ZERO);
        assert!((orbit.field_mm() / field - 0.5).abs() < 1e-12);
    }

    #[test]
    fn it_comes_near_enough_for_a_pixel_far_below_a_texel() {
        let mut orbit = Orbit::default();
        orbit.zoom(1e9, DVec2::ZERO);
        // 800 pixels; the finest texels in use are some 5 micrometres wide.
        assert!(orbit.field_mm() / 800.0 < 1e-4);
        orbit.zoom(1e-9, DVec2::ZERO);
        assert_eq!(orbit.fov_deg, *Orbit::FOV_DEG.end());
    }

    #[test]
    fn a_new_pivot_changes_nothing_seen() {
        let mut orbit = Orbit::default();
        orbit.orbit(DVec2::new(40.0, -20.0));
        let (eye, field) = (orbit.eye(), orbit.fov_deg);
        orbit.pivot(100.0);
        assert!(orbit.eye().distance(eye) < 1e-12);
        assert_eq!((orbit.distance, orbit.fov_deg), (100.0, field));
    }
}
