//! The pinhole camera.

use super::check;
#[cfg(feature = "gpu")]
use super::object::Placement;
use crate::error::{Error, Result};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// The pinhole, millimetres.
    pub position_mm: [f64; 3],
    /// What is in the middle of the picture, millimetres.
    pub target_mm: [f64; 3],
    /// What is upright in the picture; any length, not along the line of sight.
    pub up: [f64; 3],
    /// Full vertical field of view, degrees, 0.01 to 170.
    pub vertical_fov_deg: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            position_mm: [0.0, -220.0, 30.0],
            target_mm: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            vertical_fov_deg: 14.8,
        }
    }
}

impl Camera {
    pub(super) fn validate(&self) -> Result<()> {
        check::position("", "position_mm", self.position_mm)?;
        check::position("", "target_mm", self.target_mm)?;
        check::direction("", "up", self.up)?;
        check::range("", "vertical_fov_deg", self.vertical_fov_deg, 0.01..=170.0)?;
        let sight = DVec3::from(self.target_mm) - DVec3::from(self.position_mm);
        // Below this the axes of the picture would be rounding noise.
        let turn = sight.normalize_or_zero().cross(DVec3::from(self.up).normalize());
        if turn.length() < 1e-6 {
            let found = format!("{:?} seen from {:?}", self.target_mm, self.position_mm);
            return Err(Error::invalid("", "line of sight", found, "another point, not straight along up"));
        }
        Ok(())
    }

    /// The camera of a picture of `size` pixels.
    pub fn view(&self, size: [usize; 2]) -> View {
        let origin = DVec3::from(self.position_mm);
        let forward = (DVec3::from(self.target_mm) - origin).normalize();
        let right = forward.cross(DVec3::from(self.up)).normalize();
        let pixel = 2.0 * (self.vertical_fov_deg.to_radians() / 2.0).tan() / size[1] as f64;
        let middle = [size[0] as f64 / 2.0, size[1] as f64 / 2.0];
        View { origin, forward, right: right * pixel, down: forward.cross(right) * pixel, middle }
    }
}

/// A camera ready to make rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Start of all rays, millimetres.
    pub origin: DVec3,
    pub(crate) forward: DVec3,
    /// A pixel at a distance of 1.
    pub(crate) right: DVec3,
    pub(crate) down: DVec3,
    /// Of the picture, pixels.
    pub(crate) middle: [f64; 2],
}

impl View {
    /// Local frame of a surface: columns tangent, bitangent, `normal` (a unit vector). It is the camera's frame (right, up,
    /// towards the eye) turned the short way, so it varies smoothly over all that the camera can see.
    pub fn frame(&self, normal: DVec3) -> DMat3 {
        let turn = DQuat::from_rotation_arc(-self.forward, normal);
        DMat3::from_cols(turn * self.right.normalize(), turn * -self.down.normalize(), normal)
    }

    /// The same camera in the frame of an object that stands so.
    #[cfg(feature = "gpu")]
    pub(crate) fn seen_from(&self, placement: &Placement) -> Self {
        let [forward, right, down] =
            [self.forward, self.right, self.down].map(|v| placement.local_direction(v));
        Self { origin: placement.local(self.origin), forward, right, down, ..*self }
    }

    /// Unit direction through the point (x, y) of the picture, in pixels from its top left corner.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        (self.forward + self.right * (x - self.middle[0]) + self.down * (y - self.middle[1])).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_upright_and_spans_its_field_of_view() {
        let camera = Camera {
            position_mm: [0.0, -10.0, 0.0],
            target_mm: [0.0; 3],
            up: [0.0, 0.0, 2.0],
            vertical_fov_deg: 90.0,
        };
        camera.validate().unwrap();
        let view = camera.view([200, 100]);
        // Two roundings of unit vectors.
        assert!((view.direction(100.0, 50.0) - DVec3::Y).length() < 1e-15);
        let top = view.direction(100.0, 0.0);
        assert!((top - DVec3::new(0.0, 0.5f64.sqrt(), 0.5f64.sqrt())).length() < 1e-15, "{top}");
        assert!(view.direction(200.0, 50.0).x > 0.0, "x grows to the right");
    }

    #[test]
    fn local_frames_are_orthonormal() {
        let view = Camera::default().view([30, 20]);
        for normal in [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, -0.64, -0.48)] {
            let frame = view.frame(normal);
            // Roundings of a quaternion's products.
            assert!((frame.transpose() * frame).abs_diff_eq(DMat3::IDENTITY, 1e-14), "{frame}");
            assert!((frame.determinant() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_camera_that_looks_along_up_is_refused() {
        let camera = Camera { up: [0.0, 220.0, -30.0], ..Camera::default() };
        assert!(camera.validate().is_err());
        let camera = Camera { target_mm: Camera::default().position_mm, ..Camera::default() };
        assert!(camera.validate().is_err());
    }
}
