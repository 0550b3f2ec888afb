//! A camera and the flash of another: directions and irradiance at every place of the sample, all distances finite.

use super::Flash;
use crate::brdf::LightPoint;
use crate::math::half_difference::HalfDifference;
use crate::math::projection::{Pose, Projection};
use glam::{DVec2, DVec3};

/// Where eye and light of a pair are, millimetres, the sample in the plane z = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct PairGeometry {
    /// The camera.
    pub camera: Projection,
    /// Middle of the flash window.
    pub light_mm: DVec3,
    /// Points of the window, each of the same intensity in all directions.
    pub points_mm: Vec<DVec3>,
    /// Corners of the window, in turn.
    pub corners_mm: [DVec3; 4],
}

impl PairGeometry {
    /// A camera, and the flash of a camera in another pose (or its own).
    pub fn new(camera: Projection, flash: &Flash, light: &Pose) -> Self {
        Self {
            camera,
            light_mm: flash.middle_mm(light),
            points_mm: flash.points_mm(light),
            corners_mm: flash.corners_mm(light),
        }
    }

    /// Center of projection of the camera.
    pub fn eye_mm(&self) -> DVec3 {
        self.camera.pose.position_mm
    }

    /// Unit directions to the middle of the light and to the eye from a place of the sample.
    pub fn rays(&self, place_mm: DVec2) -> (DVec3, DVec3) {
        let p = place_mm.extend(0.0);
        ((self.light_mm - p).normalize(), (self.eye_mm() - p).normalize())
    }

    /// Half and difference angle at a place.
    pub fn angles(&self, place_mm: DVec2) -> HalfDifference {
        let (wi, wo) = self.rays(place_mm);
        HalfDifference::of(wi, wo)
    }

    /// Irradiance by a flash of unit intensity, 1/mm^2: `mean_l f(wi_l) cos(theta_l) / r_l^2` over the points of the window, with
    /// `f = 1`; with another f, what a surface that reflects by it sends out.
    pub fn irradiance(&self, place_mm: DVec2, f: impl Fn(DVec3) -> f64) -> f64 {
        let sum: f64 = self.points_mm.iter().map(|point| shine(*point, place_mm, &f)).sum();
        sum / self.points_mm.len() as f64
    }

    /// The points of the flash as seen from a place, with their shares of the irradiance.
    pub fn lights(&self, place_mm: DVec2) -> Vec<LightPoint> {
        let total = self.irradiance(place_mm, |_| 1.0) * self.points_mm.len() as f64;
        let light = |point: &DVec3| LightPoint {
            direction: (*point - place_mm.extend(0.0)).normalize(),
            share: shine(*point, place_mm, &|_| 1.0) / total,
        };
        self.points_mm.iter().map(light).collect()
    }

    /// Where the eye sees a point of the light mirrored by the sample.
    pub fn mirrored_place(&self, point_mm: DVec3) -> DVec2 {
        let eye = self.eye_mm();
        let share = eye.z / (eye.z + point_mm.z);
        eye.truncate().lerp(point_mm.truncate(), share)
    }
}

/// `f cos / r^2` of one point.
fn shine(point: DVec3, place_mm: DVec2, f: &impl Fn(DVec3) -> f64) -> f64 {
    let to = point - place_mm.extend(0.0);
    let r2 = to.length_squared();
    let wi = to / r2.sqrt();
    f(wi) * wi.z / r2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::projection::Intrinsics;

    fn pair() -> PairGeometry {
        let flash = Flash { offset_mm: [20.0, 0.0], size_mm: [10.0, 6.0], points: [5, 3] };
        let at = |x: f64| Pose::looking_at(DVec3::new(x, 30.0, 500.0), DVec3::ZERO, DVec3::Y);
        let intrinsics = Intrinsics::pinhole(2000.0, [200, 200]);
        PairGeometry::new(Projection { intrinsics, pose: at(-300.0) }, &flash, &at(250.0))
    }

    #[test]
    fn the_mirrored_light_is_where_half_vectors_stand_upright() {
        let pair = pair();
        for point in &pair.points_mm {
            let place = pair.mirrored_place(*point);
            let (_, wo) = pair.rays(place);
            let wi = (*point - place.extend(0.0)).normalize();
            // A few roundings of unit vectors.
            assert!((wi + wo).truncate().length() < 1e-14);
        }
    }

    #[test]
    fn shares_are_those_of_the_irradiance() {
        let pair = pair();
        let place = DVec2::new(5.0, -3.0);
        let lights = pair.lights(place);
        assert!((lights.iter().map(|l| l.share).sum::<f64>() - 1.0).abs() < 1e-14);
        let f = |w: DVec3| w.x + 2.0 * w.y;
        let mean: f64 = lights.iter().map(|l| l.share * f(l.direction)).sum();
        let ratio = pair.irradiance(place, f) / pair.irradiance(place, |_| 1.0);
        assert!((mean - ratio).abs() < 1e-14);
        // A window of 10 mm at half a meter: the point in its middle is off by (0.01)^2.
        let (wi, _) = pair.rays(place);
        let middle = wi.z / (pair.light_mm - place.extend(0.0)).length_squared();
        assert!((pair.irradiance(place, |_| 1.0) / middle - 1.0).abs() < 3e-4);
    }
}
