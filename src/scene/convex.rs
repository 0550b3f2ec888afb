//! Bodies given by formulas: intersection with rays and surface coordinates in millimetres.
//!
//! Flakes are addressed by a chart (a number) and coordinates in millimetres on it. Cylinder and panel are developable:
//! their charts keep lengths. A sphere has six charts, one around each axis, each Lambert's azimuthal equal-area map: area,
//! hence flakes per area, is exact, and lengths are off by at most 13 % at the rim (cos of half of 54.7 degrees).

use super::chart::{in_chart, sphere_chart, surface_frame};
use super::print::PrintPlace;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// A body without dents, ready for rays, around the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Convex {
    /// A cylinder along z with hemispherical ends: radius, and half the height of the cylinder.
    Capsule { radius: f64, half: f64 },
    /// A ball.
    Sphere { radius: f64 },
    /// A flat rectangle: right, up, normal, and its size.
    Panel { axes: [DVec3; 3], size: [f64; 2] },
}

/// Where a ray meets a shape, in the shape's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contact {
    /// Distance from the ray's origin, millimetres, above 0.
    pub distance: f64,
    /// The point, millimetres.
    pub point: DVec3,
    /// Outward unit normal; turned away from a ray that comes from inside.
    pub normal: DVec3,
    /// Chart of the surface coordinates, below [`super::chart::COUNT`].
    pub chart: u32,
    /// Number of the triangle of a mesh, and the weights of its second and third vertex.
    pub primitive: u32,
    pub weights: [f64; 2],
}

const CYLINDER: u32 = 6;
const PANEL: u32 = 7;

impl Convex {
    /// First point where the ray from `origin` along the unit vector `direction` meets the object.
    pub(super) fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<Contact> {
        let distance = match self.entry(origin, direction)? {
            entry if entry > 0.0 => entry,
            // From inside: a convex body is left where the reversed ray enters it.
            _ => -self.entry(origin, -direction)?,
        };
        if !(distance > 0.0 && distance.is_finite()) {
            return None;
        }
        let point = origin + direction * distance;
        let chart = self.chart(point);
        Some(Contact {
            distance,
            point,
            normal: self.normal(chart, point),
            chart,
            primitive: 0,
            weights: [0.0; 2],
        })
    }

    /// Signed distance at which the whole line enters the body; for a panel, where it crosses it.
    fn entry(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        match *self {
            Self::Sphere { radius } => sphere_entry(origin, direction, radius),
            Self::Capsule { radius, half } => capsule_entry(origin, direction, radius, half),
            Self::Panel { axes: [right, up, normal], size } => {
                let distance = -origin.dot(normal) / direction.dot(normal);
                let point = origin + direction * distance;
                let inside = 2.0 * point.dot(right).abs() <= size[0] && 2.0 * point.dot(up).abs() <= size[1];
                (distance.is_finite() && inside).then_some(distance)
            }
        }
    }

    /// Right, up and normal of a panel, unit vectors; any frame for other bodies.
    pub fn axes(&self) -> [DVec3; 3] {
        match *self {
            Self::Panel { axes, .. } => axes,
            _ => DMat3::IDENTITY.to_cols_array_2d().map(DVec3::from),
        }
    }

    /// Center of curvature of the spherical part that `point` belongs to, and its radius.
    fn ball(&self, point: DVec3) -> (DVec3, f64) {
        match *self {
            Self::Capsule { radius, half } => (DVec3::Z * half.copysign(point.z), radius),
            Self::Sphere { radius } => (DVec3::ZERO, radius),
            Self::Panel { .. } => (DVec3::ZERO, 1.0),
        }
    }

    fn chart(&self, point: DVec3) -> u32 {
        match *self {
            Self::Panel { .. } => PANEL,
            Self::Capsule { half, .. } if point.z.abs() <= half => CYLINDER,
            _ => sphere_chart(point - self.ball(point).0),
        }
    }

    /// Outward unit normal at a point on or near the surface, the chart given.
    pub fn normal(&self, chart: u32, point: DVec3) -> DVec3 {
        match chart {
            PANEL => self.axes()[2],
            CYLINDER => point.with_z(0.0).normalize_or(DVec3::X),
            _ => (point - self.ball(point).0).normalize_or(DVec3::Z),
        }
    }

    /// Local frame of the surface, fixed to it: columns tangent (near where u grows), bitangent, `normal` (a unit vector).
    pub fn frame(&self, chart: u32, normal: DVec3) -> DMat3 {
        let along = match chart {
            PANEL => self.axes()[0],
            CYLINDER => DVec3::Z.cross(normal),
            // Never parallel: a chart of the sphere ends at 54.7 degrees from an axis at right angles to it.
            _ => return surface_frame(chart, normal),
        };
        let tangent = along.reject_from_normalized(normal).normalize_or(normal.any_orthonormal_vector());
        DMat3::from_cols(tangent, normal.cross(tangent), normal)
    }

    /// Surface coordinates on a chart, millimetres, of a point on or near the surface.
    pub fn uv_mm(&self, chart: u32, point: DVec3) -> DVec2 {
        match chart {
            PANEL => {
                let [right, up, _] = self.axes();
                DVec2::new(point.dot(right), point.dot(up))
            }
            // The seam is at the back, seen from the default camera.
            CYLINDER => DVec2::new(self.ball(point).1 * point.x.atan2(-point.y), point.z),
            _ => {
                let DVec3 { x: p, y: q, z: above } = in_chart(chart, self.normal(chart, point));
                // Radius 2 R sin(theta/2); the far pole, where the map ends, is never in its own chart.
                DVec2::new(p, q) * (self.ball(point).1 * (2.0 / (1.0 + above).max(1e-3)).sqrt())
            }
        }
    }

    /// Place in a picture of a patch about a point on the surface, the steps along its sides given: as
    /// [`super::Bodies::print_place`].
    pub fn print_place(&self, point: DVec3, steps: [DVec3; 2]) -> Option<PrintPlace> {
        // At a pole any turn will do, but for the half behind that a negative 0 stands for.
        let turned = DVec2::new(0.0 - point.y, point.x);
        let around = turned.y.atan2(turned.x) / PI + 0.5;
        let from_axis = turned.length().max(f64::MIN_POSITIVE);
        let across = |step: DVec3| turned.dot(step.truncate()) / from_axis / (from_axis * PI);
        let (uv, sides) = match *self {
            Self::Panel { axes: [right, up, _], size } => {
                let along = |v: DVec3| DVec2::new(v.dot(right) / size[0], -v.dot(up) / size[1]);
                (along(point) + 0.5, steps.map(along))
            }
            Self::Capsule { radius, half } => {
                let down = |z: f64| -0.5 * z / (half + radius);
                let sides = steps.map(|step| DVec2::new(across(step), down(step.z)));
                (DVec2::new(around, 0.5 + down(point.z)), sides)
            }
            Self::Sphere { radius } => {
                let latitude = (-point.z / radius).clamp(-1.0, 1.0).asin();
                let sides = steps.map(|step| DVec2::new(across(step), -step.z / (from_axis * PI)));
                (DVec2::new(around, latitude / PI + 0.5), sides)
            }
        };
        let is_printed = matches!(self, Self::Panel { .. }) || (0.0..=1.0).contains(&around);
        is_printed.then(|| PrintPlace::new(uv, sides))
    }

    /// Change of the surface coordinates from a point to one near it on the same chart, also across the seam of a cylinder.
    pub fn uv_step_mm(&self, chart: u32, from: DVec3, to: DVec3) -> DVec2 {
        let mut step = self.uv_mm(chart, to) - self.uv_mm(chart, from);
        if chart == CYLINDER {
            let around = std::f64::consts::TAU * self.ball(from).1;
            step.x -= around * (step.x / around).round();
        }
        step
    }
}

fn sphere_entry(origin: DVec3, direction: DVec3, radius: f64) -> Option<f64> {
    let along = origin.dot(direction);
    // By the point nearest to the center: b^2 - 4ac would cancel for a small sphere far away.
    let square = radius * radius - (origin - direction * along).length_squared();
    (square >= 0.0).then(|| -along - square.sqrt())
}

/// A capsule along z, its cylinder between -`half` and `half`. The cylinder's hit decides which part is met, so that no ray
/// slips through the joints.
fn capsule_entry(origin: DVec3, direction: DVec3, radius: f64, half: f64) -> Option<f64> {
    let (o, d) = (origin.truncate(), direction.truncate());
    let a = d.length_squared();
    let flat = o.perp_dot(d);
    let square = radius * radius * a - flat * flat;
    if square < 0.0 || (a == 0.0 && o.length_squared() > radius * radius) {
        return None;
    }
    let distance = (-o.dot(d) - square.sqrt()) / a;
    // Along the axis the cylinder is entered at minus infinity.
    let z = if a > 0.0 { origin.z + distance * direction.z } else { -direction.z * f64::INFINITY };
    if z.abs() <= half {
        return Some(distance);
    }
    let center = DVec3::Z * half.copysign(z);
    sphere_entry(origin - center, direction, radius)
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::*;
    use crate::math::half_difference::spherical;

    const SHAPES: [Convex; 3] = [
        Convex::Capsule { radius: 10.0, half: 15.0 },
        Convex::Sphere { radius: 25.0 },
        Convex::Capsule { radius: 10.0, half: 0.0 },
    ];

    fn panel(size_mm: [f64; 2], normal: [f64; 3]) -> Convex {
        Shape::Panel { size_mm, normal }.convex().unwrap()
    }

    /// Distance from the surface, negative inside.
    fn signed_distance(shape: &Convex, p: DVec3) -> f64 {
        match *shape {
            Convex::Sphere { radius } => p.length() - radius,
            Convex::Capsule { radius, half } => p.distance(DVec3::Z * p.z.clamp(-half, half)) - radius,
            Convex::Panel { .. } => 0.0,
        }
    }

    /// A patch's sides are what its picture moves by, on every shape: across and down, near the poles, too.
    #[test]
    fn print_places_move_as_their_sides_say() {
        let panel = panel([30.0, 20.0], [0.3, -1.0, 0.2]);
        let [right, up, _] = panel.axes();
        let on_panel = (0..9).map(|k| right * f64::from(k % 3) * 4.0 - up * f64::from(k / 3) * 3.0);
        let around = |radius: f64, half: f64| {
            (0..400).filter_map(move |k| {
                let n = spherical(0.01 + 0.0077 * f64::from(k), -1.57 * (1.0 + (f64::from(k) * 0.7).sin()));
                (n.y < -1e-3).then_some(n * radius + DVec3::Z * half.copysign(n.z))
            })
        };
        let places = (on_panel.map(|point| (panel, point)))
            .chain(around(25.0, 0.0).map(|point| (SHAPES[1], point)))
            .chain(around(10.0, 15.0).map(|point| (SHAPES[0], point)));
        for (shape, point) in places {
            let frame = shape.frame(shape.chart(point), shape.normal(shape.chart(point), point));
            for (x, y) in [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)] {
                let step = (frame.x_axis * x + frame.y_axis * y) * 1e-6;
                let at = |point: DVec3| shape.print_place(point, [step, DVec3::ZERO]);
                let (Some(here), Some(there)) = (at(point), at(point + step)) else { continue };
                let moved = (there.uv - here.uv).abs();
                // A step of 1e-6 is off by its square over the distance to the axis, .25 mm at least, and by roundings of places.
                assert!(here.sides.distance(moved) < 1e-4 * moved.length() + 1e-14, "{shape:?} {point}");
            }
        }
        let pole = SHAPES[1].print_place(DVec3::Z * 25.0, [DVec3::X, DVec3::Y]).unwrap();
        assert!(!pole.sides.is_nan() && pole.uv == DVec2::new(0.5, 0.0), "{pole:?}");
    }

    #[test]
    fn rays_hit_the_surface_from_outside_and_inside() {
        for shape in SHAPES {
            for k in 0..2000 {
                let k = f64::from(k);
                let aim = spherical(k * 0.37, k * 1.3) * 8.0 + DVec3::Z * (k % 31.0 - 15.0) * 0.5;
                for origin in [spherical(k * 0.71, k * 2.9) * 300.0, DVec3::new(0.1, -0.2, 0.3)] {
                    let direction = (aim - origin).normalize();
                    let Some(hit) = shape.intersect(origin, direction) else {
                        assert!(signed_distance(&shape, aim) > 0.0, "a ray through the body missed it");
                        continue;
                    };
                    // 300 mm times a few roundings.
                    assert!(signed_distance(&shape, hit.point).abs() < 1e-11, "{shape:?} {hit:?}");
                    assert!((hit.normal.length() - 1.0).abs() < 1e-14);
                    let inside = origin.length() < 1.0;
                    assert_eq!(hit.normal.dot(direction) > 0.0, inside);
                }
            }
        }
    }

    #[test]
    fn no_ray_slips_through_the_joints_or_along_the_axis() {
        let shape = SHAPES[0];
        for k in -40..=40 {
            // Around z = 15, where cylinder and hemisphere meet, by less than rounding.
            let z = 15.0 + f64::from(k) * 1e-15;
            let hit = shape.intersect(DVec3::new(0.0, -100.0, z), DVec3::Y).unwrap();
            assert!((hit.distance - 90.0).abs() < 1e-12);
        }
        for direction in [DVec3::Z, DVec3::NEG_Z] {
            let hit = shape.intersect(direction * -100.0, direction).unwrap();
            assert!((hit.distance - 75.0).abs() < 1e-12);
            assert!(shape.intersect(DVec3::new(10.1, 0.0, -100.0), direction).is_none());
        }
        assert!(shape.intersect(DVec3::new(0.0, -100.0, 0.0), DVec3::NEG_Y).is_none(), "behind the eye");
    }

    #[test]
    fn grazing_rays_hit_or_miss_and_never_return_nonsense() {
        for shape in SHAPES {
            for k in -50..=50 {
                let offset = f64::from(k) * 1e-13;
                let radius = shape.ball(DVec3::ZERO).1;
                if let Some(hit) = shape.intersect(DVec3::new(radius + offset, -100.0, 0.0), DVec3::Y) {
                    assert!(signed_distance(&shape, hit.point).abs() < 1e-10);
                    assert!(hit.normal.is_finite());
                }
            }
        }
    }

    #[test]
    fn charts_keep_area() {
        for shape in SHAPES {
            for k in 0..500 {
                let k = f64::from(k);
                let hit = shape
                    .intersect(spherical(k * 0.37, k * 1.9) * 200.0, -spherical(k * 0.37, k * 1.9))
                    .unwrap();
                let (a, b) = hit.normal.any_orthonormal_pair();
                let h = 1e-4;
                let step =
                    |v: DVec3| shape.uv_step_mm(hit.chart, hit.point - v * h, hit.point + v * h) / (2.0 * h);
                let (u, v) = (step(a), step(b));
                // Central differences of step h = 1e-4: curvature squared times h^2, and rounding 1e-15 * 50 / h.
                assert!((u.perp_dot(v).abs() - 1.0).abs() < 1e-8, "{shape:?} {hit:?}");
                assert!(u.length() < 1.13 && v.length() < 1.13);
            }
        }
    }

    #[test]
    fn frames_are_orthonormal_and_follow_u() {
        let panel = panel([20.0, 10.0], [0.3, -2.0, 0.4]);
        for shape in SHAPES.into_iter().chain([panel]) {
            for k in 0..300 {
                let away = spherical(f64::from(k) * 0.37, f64::from(k) * 1.9);
                let Some(hit) = shape.intersect(away * 200.0, -away) else { continue };
                let frame = shape.frame(hit.chart, hit.normal);
                assert!((frame.transpose() * frame - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-14));
                assert!(frame.determinant() > 0.0 && frame.z_axis == hit.normal);
                let step = shape.uv_step_mm(hit.chart, hit.point, hit.point + frame.x_axis * 1e-4) / 1e-4;
                // Towards the corners of a chart its lines are no longer at right angles.
                assert!(step.x > 0.8 && step.y.abs() < 0.5, "{shape:?} {hit:?} {step}");
            }
        }
    }

    #[test]
    fn the_panel_is_a_rectangle() {
        let shape = panel([20.0, 10.0], [0.0, -2.0, 0.0]);
        let at = |x: f64, z: f64| shape.intersect(DVec3::new(x, -50.0, z), DVec3::Y);
        let hit = at(9.9, 4.9).unwrap();
        assert_eq!(hit.normal, DVec3::NEG_Y);
        assert!((shape.uv_mm(hit.chart, hit.point) - DVec2::new(9.9, 4.9)).length() < 1e-14);
        assert!(at(10.1, 0.0).is_none());
        assert!(at(0.0, 5.1).is_none());
        assert!(shape.intersect(DVec3::new(0.0, -50.0, 0.0), DVec3::X).is_none(), "along the plane");
    }
}
