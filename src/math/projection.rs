//! The perspective camera of calibration: intrinsics with radial distortion, and a pose (Zhang 2000).
//!
//! A point p in front of the camera is seen at `c + f d(r^2) (x/z, y/z)`, `(x, y, z) = R (p - o)` in the camera's frame (x to
//! the right, y down, z forward), `d = 1 + k1 r^2 + k2 r^4` over `r^2 = (x^2 + y^2) / z^2`. Pixel (0, 0) spans [0, 1) x [0, 1).

use glam::{DMat3, DQuat, DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// Steps of the inversion of the distortion; each gains two digits or more where `k1 r^2` is below a few per cent.
const INVERSION_STEPS: usize = 20;

/// What a camera does to directions in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intrinsics {
    /// Focal length, pixels, > 0.
    pub focal_px: f64,
    /// Principal point, pixels.
    pub center_px: [f64; 2],
    /// Radial distortion k1, k2; 0 for a pinhole.
    pub distortion: [f64; 2],
}

/// Where a camera stands and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Center of projection, millimetres.
    pub position_mm: DVec3,
    /// Turns world directions into the camera's frame; a unit quaternion (x, y, z, w).
    pub rotation: DQuat,
}

/// A calibrated camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Projection {
    /// Its lens.
    pub intrinsics: Intrinsics,
    /// Its place.
    pub pose: Pose,
}

impl Intrinsics {
    /// A pinhole whose principal point is the middle of a picture of `size` pixels.
    pub fn pinhole(focal_px: f64, size: [usize; 2]) -> Self {
        Self { focal_px, center_px: size.map(|n| 0.5 * n as f64), distortion: [0.0; 2] }
    }

    /// Where a point of the camera's frame is seen, pixels; `None` unless it lies in front.
    pub fn pixel(&self, point: DVec3) -> Option<DVec2> {
        if point.z <= 0.0 {
            return None;
        }
        let plane = point.truncate() / point.z;
        Some(DVec2::from(self.center_px) + self.focal_px * self.stretch(plane.length_squared()) * plane)
    }

    /// Unit direction in the camera's frame that is seen at a pixel.
    pub fn direction(&self, pixel: DVec2) -> DVec3 {
        let seen = (pixel - DVec2::from(self.center_px)) / self.focal_px;
        let mut plane = seen;
        for _ in 0..INVERSION_STEPS {
            plane = seen / self.stretch(plane.length_squared());
        }
        plane.extend(1.0).normalize()
    }

    fn stretch(&self, r2: f64) -> f64 {
        1.0 + r2 * (self.distortion[0] + r2 * self.distortion[1])
    }
}

impl Pose {
    /// A camera at `position_mm` that looks at `target_mm`, with `up` upwards in the picture (not along the line of sight).
    pub fn looking_at(position_mm: DVec3, target_mm: DVec3, up: DVec3) -> Self {
        let forward = (target_mm - position_mm).normalize();
        let right = forward.cross(up).normalize();
        let axes = DMat3::from_cols(right, forward.cross(right), forward);
        Self { position_mm, rotation: DQuat::from_mat3(&axes.transpose()) }
    }

    /// A world point in the camera's frame.
    pub fn local(&self, point: DVec3) -> DVec3 {
        self.rotation * (point - self.position_mm)
    }

    /// A point of the camera's frame in the world.
    pub fn world(&self, local: DVec3) -> DVec3 {
        self.position_mm + self.rotation.inverse() * local
    }
}

impl Projection {
    /// Where a world point is seen, pixels; `None` unless it lies in front.
    pub fn pixel(&self, point: DVec3) -> Option<DVec2> {
        self.intrinsics.pixel(self.pose.local(point))
    }

    /// Unit world direction seen at a pixel.
    pub fn direction(&self, pixel: DVec2) -> DVec3 {
        self.pose.rotation.inverse() * self.intrinsics.direction(pixel)
    }

    /// The point of the plane z = `height_mm` seen at a pixel, unless the ray goes away from it.
    pub fn on_plane(&self, pixel: DVec2, height_mm: f64) -> Option<DVec3> {
        let direction = self.direction(pixel);
        let distance = (height_mm - self.pose.position_mm.z) / direction.z;
        (distance > 0.0 && distance.is_finite()).then(|| self.pose.position_mm + direction * distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Projection {
        let intrinsics = Intrinsics { focal_px: 900.0, center_px: [130.0, 120.0], distortion: [-0.12, 0.05] };
        let pose = Pose::looking_at(DVec3::new(200.0, -300.0, 500.0), DVec3::new(3.0, 2.0, 0.0), DVec3::Y);
        Projection { intrinsics, pose }
    }

    #[test]
    fn pixels_and_points_are_each_others_inverse() {
        let camera = camera();
        for pixel in [DVec2::new(0.5, 0.5), DVec2::new(130.0, 120.0), DVec2::new(255.0, 10.0)] {
            let point = camera.on_plane(pixel, 0.0).unwrap();
            assert!(point.z.abs() < 1e-12);
            // The inversion of the distortion converges far below rounding of 1e3 pixels.
            assert!((camera.pixel(point).unwrap() - pixel).length() < 1e-10, "{pixel}");
        }
        let local = DVec3::new(1.0, -2.0, 3.0);
        assert!((camera.pose.local(camera.pose.world(local)) - local).length() < 1e-12);
    }

    #[test]
    fn the_picture_is_upright() {
        let camera = camera();
        let seen = |p: [f64; 3]| camera.pixel(p.into()).unwrap();
        let middle = seen([3.0, 2.0, 0.0]);
        assert!((middle - DVec2::new(130.0, 120.0)).length() < 1e-10);
        assert!(seen([3.0, 5.0, 0.0]).y < middle.y, "up is up, and rows fall");
        let behind = camera.pose.world(DVec3::new(0.0, 0.0, -1.0));
        assert_eq!(camera.pixel(behind), None);
        assert_eq!(camera.on_plane(DVec2::new(130.0, 120.0), 600.0), None);
    }
}
