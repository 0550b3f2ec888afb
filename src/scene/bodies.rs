//! The objects of a scene, ready for rays.

use super::chart;
use super::convex::{Contact, Convex};
use super::mesh::Mesh;
use super::object::{Object, Placement};
use super::print::PrintPlace;
use super::shape::{Shape, Up};
use super::{Incidence, Scene};
use super::{sheet, speed_shape};
use crate::error::Result;
use glam::{DMat3, DVec2, DVec3};
use std::path::Path;
use std::sync::Arc;

/// All objects of a scene, ready for rays: the shape alone, wearing paint 0, where the scene lists no objects.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bodies {
    bodies: Vec<Body>,
}

/// Where a ray meets an object, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin, millimetres, above 0.
    pub distance: f64,
    /// The point, millimetres.
    pub point: DVec3,
    /// Outward unit normal; turned away from a ray that comes from inside, unless both sides are painted.
    pub normal: DVec3,
    /// Chart of the surface coordinates; no two objects share one.
    pub chart: u32,
    /// Number of the object.
    pub object: usize,
    /// Number of the triangle of a mesh, 0 for other shapes.
    pub primitive: u32,
    /// Weights of the triangle's second and third vertex.
    pub weights: [f64; 2],
}

/// One object.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Body {
    shape: Shape,
    pub form: Form,
    pub placement: Placement,
    /// Number of the paint that it wears.
    pub paint: usize,
}

/// What a shape is for rays.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// A body given by a formula.
    Convex(Convex),
    /// Triangles.
    Mesh(Arc<Mesh>),
}

impl Form {
    fn new(shape: &Shape) -> Result<Self> {
        if let Some(convex) = shape.convex() {
            return Ok(Self::Convex(convex));
        }
        let mesh = match shape {
            Shape::Mesh { path, length_mm, up } => mesh(path, *length_mm, *up)?,
            Shape::SpeedShape { length_mm } => {
                Mesh::new(&speed_shape::triangles(), true, Some(*length_mm), 1.0)
            }
            Shape::Sheet { size_mm, radius_mm } => {
                Mesh::new(&sheet::triangles(*size_mm, *radius_mm), true, None, 1.0)
            }
            Shape::Capsule { .. } | Shape::Sphere { .. } | Shape::Panel { .. } => Mesh::default(),
        };
        Ok(Self::Mesh(Arc::new(mesh)))
    }

    fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<Contact> {
        match self {
            Self::Convex(convex) => convex.intersect(origin, direction),
            Self::Mesh(mesh) => mesh.intersect(origin, direction),
        }
    }
}

#[cfg(feature = "files")]
fn mesh(path: &Path, length_mm: Option<f64>, up: Up) -> Result<Mesh> {
    let is_obj = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    // glTF counts in meters; OBJ says nothing, and most that speak of millimetres mean it.
    let unit_mm = if is_obj { 1.0 } else { 1000.0 };
    Ok(Mesh::new(&crate::file::read_mesh(path)?, up == Up::Z, length_mm, unit_mm))
}

#[cfg(not(feature = "files"))]
fn mesh(path: &Path, _: Option<f64>, _: Up) -> Result<Mesh> {
    let place = path.display().to_string();
    let legal = "a shape without: built without the feature files";
    Err(crate::error::Error::unsupported(place, "mesh", "a file", legal))
}

impl Body {
    fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<Contact> {
        self.form.intersect(self.placement.local(origin), self.placement.local_direction(direction))
    }
}

impl Bodies {
    /// The objects of a valid scene.
    ///
    /// # Errors
    /// Those of reading a mesh.
    pub fn new(scene: &Scene) -> Result<Self> {
        Self::default().changed(scene)
    }

    /// The objects of a valid scene, shapes that are among these already taken from here: a file is not read again.
    ///
    /// # Errors
    /// Those of reading a mesh.
    pub fn changed(&self, scene: &Scene) -> Result<Self> {
        let mut bodies: Vec<Body> = Vec::new();
        let alone = [Object { shape: scene.shape.clone(), ..Object::default() }];
        let objects = if scene.objects.is_empty() { &alone[..] } else { &scene.objects };
        let place = |k: usize| match scene.objects.len() {
            0 => "scene: shape".to_owned(),
            _ => format!("scene: object {k}: shape"),
        };
        for (k, object) in objects.iter().enumerate() {
            let mut there = self.bodies.iter().chain(&bodies);
            let form = match there.find(|body| body.shape == object.shape) {
                Some(body) => body.form.clone(),
                None => Form::new(&object.shape).map_err(|e| e.within(place(k)))?,
            };
            let (shape, placement) = (object.shape.clone(), object.placement());
            bodies.push(Body { shape, form, placement, paint: object.paint });
        }
        Ok(Self { bodies })
    }

    /// First point where the ray from `origin` along the unit vector `direction` meets an object.
    pub fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let contacts = self.bodies.iter().enumerate();
        let contacts = contacts.filter_map(|(k, body)| Some((k, body.intersect(origin, direction)?)));
        let (object, first) = contacts.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance))?;
        Some(Hit {
            distance: first.distance,
            point: origin + direction * first.distance,
            normal: self.bodies[object].placement.axes * first.normal,
            chart: object as u32 * chart::COUNT + first.chart,
            object,
            primitive: first.primitive,
            weights: first.weights,
        })
    }

    /// Whether something stands between a hit and the middle of a lamp: another object, or a mesh itself. Convex bodies do not
    /// shade themselves.
    pub fn is_shaded(&self, hit: &Hit, lamp: &Incidence) -> bool {
        self.bodies.iter().enumerate().any(|(k, body)| {
            let distance = match (&body.form, k == hit.object) {
                (Form::Convex(_), true) => None,
                (Form::Mesh(mesh), true) => {
                    let Placement { axes, .. } = body.placement;
                    let [normal, direction] = [hit.normal, lamp.direction].map(|v| axes.transpose() * v);
                    mesh.meets_itself(body.placement.local(hit.point), normal, direction)
                }
                _ => body.intersect(hit.point, lamp.direction).map(|contact| contact.distance),
            };
            distance.is_some_and(|distance| distance < lamp.distance)
        })
    }

    /// Number of the paint that an object wears.
    pub fn paint(&self, object: usize) -> usize {
        self.bodies[object].paint
    }

    /// Local frame of the surface, fixed to it: columns tangent (near where u grows), bitangent, normal.
    pub fn frame(&self, hit: &Hit) -> DMat3 {
        let Body { form, placement, .. } = &self.bodies[hit.object];
        let (chart, normal) = (hit.chart % chart::COUNT, placement.local_direction(hit.normal));
        placement.axes
            * match form {
                Form::Convex(convex) => convex.frame(chart, normal),
                Form::Mesh(_) => chart::surface_frame(chart, normal),
            }
    }

    /// Surface coordinates of a hit on its chart, millimetres.
    pub fn uv_mm(&self, hit: &Hit) -> DVec2 {
        let Body { form, placement, .. } = &self.bodies[hit.object];
        let (chart, point) = (hit.chart % chart::COUNT, placement.local(hit.point));
        match form {
            Form::Convex(convex) => convex.uv_mm(chart, point),
            Form::Mesh(_) => Mesh::uv_mm(chart, point),
        }
    }

    /// Where the patch about a hit lies in the picture that its object is printed with, the steps along its two sides given,
    /// millimetres on the tangent plane. A panel is filled; on capsules and spheres the picture goes around the half that faces the
    /// front (-y); meshes have texture coordinates. None where nothing is printed.
    pub fn print_place(&self, hit: &Hit, steps_mm: [DVec3; 2]) -> Option<PrintPlace> {
        let Body { form, placement, .. } = &self.bodies[hit.object];
        let steps = steps_mm.map(|step| placement.local_direction(step));
        match form {
            Form::Convex(convex) => convex.print_place(placement.local(hit.point), steps),
            Form::Mesh(mesh) => {
                let normal = placement.local_direction(hit.normal);
                mesh.print_place(hit.primitive, hit.weights, normal, steps)
            }
        }
    }

    /// Whether any object can be printed: all but meshes without texture coordinates.
    pub(crate) fn can_be_printed(&self) -> bool {
        self.bodies.iter().any(|body| match &body.form {
            Form::Convex(_) => true,
            Form::Mesh(mesh) => !mesh.uvs.is_empty(),
        })
    }

    /// Change of the surface coordinates from a hit to a point near it, about on its tangent plane.
    pub fn uv_step_mm(&self, hit: &Hit, there: DVec3) -> DVec2 {
        let Body { form, placement, .. } = &self.bodies[hit.object];
        let (chart, here, there) =
            (hit.chart % chart::COUNT, placement.local(hit.point), placement.local(there));
        match form {
            Form::Convex(convex) => convex.uv_step_mm(chart, here, there),
            Form::Mesh(_) => Mesh::uv_step_mm(chart, placement.local_direction(hit.normal), there - here),
        }
    }

    /// Unit normal of the surface at a point near a hit, about on its tangent plane.
    pub fn normal_near(&self, hit: &Hit, there: DVec3) -> DVec3 {
        let Body { form, placement, .. } = &self.bodies[hit.object];
        let local = match form {
            Form::Convex(convex) => convex.normal(hit.chart % chart::COUNT, placement.local(there)),
            Form::Mesh(mesh) => {
                let normal = placement.local_direction(hit.normal);
                let step = placement.local_direction(there - hit.point);
                mesh.normal_near(hit.primitive, hit.weights, normal, step)
            }
        };
        placement.axes * local
    }

    #[cfg(feature = "gpu")]
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;

    fn scene(objects: Vec<Object>) -> Scene {
        Scene { objects, ..Scene::default() }
    }

    fn object() -> Object {
        Object {
            position_mm: [30.0, -12.0, 7.0],
            tilt_deg: [20.0, -35.0],
            turn_deg: 140.0,
            ..Object::default()
        }
    }

    #[test]
    fn objects_are_met_where_they_stand() {
        let alone = Bodies::new(&scene(vec![])).unwrap();
        let moved = Bodies::new(&scene(vec![object()])).unwrap();
        let Placement { axes, position } = object().placement();
        for k in 0..500 {
            let k = f64::from(k);
            let (origin, aim) = (spherical(k * 0.71, k * 2.9) * 300.0, spherical(k * 0.37, k * 1.3) * 10.0);
            let direction = (aim - origin).normalize();
            let here = alone.intersect(origin, direction).unwrap();
            let there = moved.intersect(axes * origin + position, axes * direction).unwrap();
            // Roundings of 300 mm.
            assert!((here.distance - there.distance).abs() < 1e-11);
            assert!((axes * here.point + position).distance(there.point) < 1e-11);
            assert!((axes * here.normal).distance(there.normal) < 1e-11);
            assert!(alone.uv_mm(&here).distance(moved.uv_mm(&there)) < 1e-11);
            assert!((axes * alone.frame(&here)).abs_diff_eq(moved.frame(&there), 1e-11));
            let step = alone.frame(&here).x_axis * 0.1;
            let steps = [
                alone.uv_step_mm(&here, here.point + step),
                moved.uv_step_mm(&there, there.point + axes * step),
            ];
            assert!(steps[0].distance(steps[1]) < 1e-11);
        }
    }

    #[test]
    fn the_nearest_object_is_seen_and_shades_the_others() {
        let ball = |y: f64, paint: usize| Object {
            shape: Shape::Sphere { radius_mm: 5.0 },
            position_mm: [0.0, y, 0.0],
            paint,
            ..Object::default()
        };
        let bodies = Bodies::new(&scene(vec![ball(20.0, 4), ball(-20.0, 2), ball(0.0, 3)])).unwrap();
        let hit = bodies.intersect(DVec3::Y * -100.0, DVec3::Y).unwrap();
        assert_eq!((hit.object, bodies.paint(hit.object), hit.distance), (1, 2, 75.0));
        let hit = bodies.intersect(DVec3::Y * 100.0, DVec3::NEG_Y).unwrap();
        assert_eq!((hit.object, hit.chart / chart::COUNT), (0, 0));
        let lamp = |direction, distance| Incidence {
            direction,
            irradiance: DVec3::ONE,
            angular_radius: 0.01,
            distance,
        };
        let front = bodies.intersect(DVec3::Y * 10.0, DVec3::Y).unwrap();
        assert!(bodies.is_shaded(&front, &lamp(DVec3::NEG_Y, f64::INFINITY)));
        assert!(!bodies.is_shaded(&front, &lamp(DVec3::NEG_Y, 5.0)), "a lamp before the other ball");
        assert!(!bodies.is_shaded(&front, &lamp(DVec3::Y, f64::INFINITY)), "no object shades itself");
        assert!(!bodies.is_shaded(&front, &lamp(DVec3::X, f64::INFINITY)));
    }
}
