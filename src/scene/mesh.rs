//! Triangles with smooth normals, ready for rays.
//!
//! Both sides are painted: files do not agree on which is the outside. Surface coordinates are those of the six charts of
//! [`super::chart`], each triangle in the one that its plane is closest to, projected along the chart's axis: places are
//! stretched by up to sqrt(3), but footprints are measured on the surface itself, so that a pixel averages as many flakes as
//! its true area holds.

use super::chart::{in_chart, second_axis, sphere_chart, surface_frame};
use super::convex::Contact;
use super::hierarchy::{self, Node, Slabs};
use super::print::PrintPlace;
use super::triangle::{Crossing, Sheared};
use crate::file::Triangles;
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::collections::HashMap;

/// A mesh around the origin, millimetres.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Mesh {
    /// Places and unit normals.
    pub vertices: Vec<(Vec3, Vec3)>,
    /// Places of the vertices in a picture; empty if they have none.
    pub uvs: Vec<Vec2>,
    /// Vertices, and the chart.
    pub triangles: Vec<([u32; 3], u32)>,
    /// Boxes around them.
    pub nodes: Vec<Node>,
    /// Length of the diagonal of the box around all.
    pub size: f32,
}

/// Least cosine between a normal and the way to the eye: smooth normals that would look away are bent to it.
const LEAST_COSINE: f64 = 0.02;
/// How far from itself a mesh shades itself, as a share of its size: nearer, its facets would shade their smooth normals.
const SHADE_GAP: f64 = 2e-3;

impl Mesh {
    /// A mesh of a file's triangles, turned so that z is up, the middle of its box moved to the origin, and scaled so that the
    /// longest side is `length_mm`, or by `unit_mm` without.
    pub fn new(file: &Triangles, is_z_up: bool, length_mm: Option<f64>, unit_mm: f64) -> Self {
        let turned = |[x, y, z]: [f32; 3]| if is_z_up { Vec3::new(x, y, z) } else { Vec3::new(x, -z, y) };
        let mut places: Vec<Vec3> = file.positions.iter().map(|p| turned(*p)).collect();
        let used = || file.triangles.iter().flatten().map(|k| turned(file.positions[*k as usize]));
        let (low, high) = used().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let longest = (high - low).max_element();
        // A point has no length.
        let scale = length_mm.map_or(unit_mm, |mm| if longest > 0.0 { mm / longest } else { 1.0 });
        let middle = 0.5 * (low + high);
        places.iter_mut().for_each(|p| *p = ((p.as_dvec3() - middle) * scale).as_vec3());
        let plain = area_normals(&places, &file.triangles);
        let given = |k: usize| file.normals.get(k).map(|n| turned(*n));
        let normal =
            |k: usize| given(k).and_then(|n| n.as_dvec3().try_normalize()).map_or(plain[k], |n| n.as_vec3());
        let vertices = places.iter().enumerate().map(|(k, p)| (*p, normal(k))).collect();
        // A triangle without area has no plane.
        let has_area =
            |t: &&[u32; 3]| across(&t.map(|k| places[k as usize].as_dvec3())).length_squared() > 0.0;
        let kept: Vec<[u32; 3]> = file.triangles.iter().filter(has_area).copied().collect();
        let corners: Vec<[Vec3; 3]> = kept.iter().map(|t| t.map(|k| places[k as usize])).collect();
        let (nodes, order) = hierarchy::build(&corners);
        let chart = |k: usize| sphere_chart(across(&corners[k].map(|p| p.as_dvec3())));
        let triangles = order.iter().map(|k| (kept[*k], chart(*k))).collect();
        let uvs = file.uvs.iter().map(|uv| Vec2::from(*uv)).collect();
        Self { vertices, uvs, triangles, nodes, size: ((high - low).length() * scale) as f32 }
    }

    /// First point where the ray from `origin` along the unit vector `direction` meets the mesh.
    pub(super) fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<Contact> {
        let (triangle, Crossing { distance, weights }) = self.first(origin, direction)?;
        let point = origin + direction * distance;
        let normal = self.facing(triangle, weights, direction);
        let chart = self.triangles[triangle].1;
        Some(Contact { distance, point, normal, chart, primitive: triangle as u32, weights })
    }

    /// Distance at which a ray from the surface meets the mesh again.
    pub fn meets_itself(&self, point: DVec3, normal: DVec3, direction: DVec3) -> Option<f64> {
        let start = point + normal * (SHADE_GAP * f64::from(self.size));
        self.first(start, direction).map(|(_, crossing)| crossing.distance)
    }

    /// First triangle on a ray.
    fn first(&self, origin: DVec3, direction: DVec3) -> Option<(usize, Crossing)> {
        let (slabs, ray) = (Slabs::new(origin, direction), Sheared::new(origin, direction));
        let mut first: Option<(usize, Crossing)> = None;
        let mut k = 0;
        while let Some(node) = self.nodes.get(k) {
            if !slabs.meets(node, first.map_or(f64::INFINITY, |(_, c)| c.distance)) {
                k = node.next as usize;
                continue;
            }
            for triangle in node.triangles() {
                let Some(crossing) = ray.crossing(&self.corners(triangle)) else { continue };
                if crossing.distance > 0.0 && first.is_none_or(|(_, c)| crossing.distance < c.distance) {
                    first = Some((triangle, crossing));
                }
            }
            k += 1;
        }
        first
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].0.map(|k| self.vertices[k as usize].0.as_dvec3())
    }

    /// The smooth unit normal of a triangle where its second and third vertex have these weights.
    fn smooth(&self, triangle: usize, [v, w]: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.triangles[triangle].0.map(|k| self.vertices[k as usize].1.as_dvec3());
        let sum = a + (b - a) * v + (c - a) * w;
        // Opposite normals cancel.
        if sum.length_squared() > 1e-12 {
            sum.normalize()
        } else {
            across(&self.corners(triangle)).normalize()
        }
    }

    /// The smooth unit normal on the side that a ray comes from, bent where it would look away.
    fn facing(&self, triangle: usize, weights: [f64; 2], direction: DVec3) -> DVec3 {
        let across = across(&self.corners(triangle));
        let side = if across.dot(direction) > 0.0 { -across } else { across };
        let smooth = self.smooth(triangle, weights);
        let normal = if smooth.dot(side) < 0.0 { -smooth } else { smooth };
        let missing = LEAST_COSINE + normal.dot(direction);
        if missing <= 0.0 { normal } else { (normal - direction * missing).normalize() }
    }

    /// Place in a picture of a patch about a contact whose normal is given, and the steps along the sides of the patch; none on the back
    /// of a triangle or without texture coordinates.
    pub fn print_place(
        &self,
        triangle: u32,
        weights: [f64; 2],
        normal: DVec3,
        steps: [DVec3; 2],
    ) -> Option<PrintPlace> {
        let (vertices, _) = self.triangles[triangle as usize];
        let [a, b, c] = vertices.map(|k| self.uvs.get(k as usize).map(|uv| uv.as_dvec2()));
        let (a, b, c) = (a?, b?, c?);
        let along = |[second, third]: [f64; 2]| (b - a) * second + (c - a) * third;
        let corners = self.corners(triangle as usize);
        let uv = a + along(weights);
        let sides = steps.map(|step| along(weights_step(&corners, step)));
        (across(&corners).dot(normal) > 0.0 && uv.is_finite()).then(|| PrintPlace::new(uv, sides))
    }

    /// Unit normal at a step along the surface from a contact, whose normal is given.
    pub fn normal_near(&self, triangle: u32, weights: [f64; 2], normal: DVec3, step: DVec3) -> DVec3 {
        let triangle = triangle as usize;
        let [second, third] = weights_step(&self.corners(triangle), step);
        let here = self.smooth(triangle, weights);
        let there = self.smooth(triangle, [weights[0] + second, weights[1] + third]);
        let step = if here.dot(normal) < 0.0 { here - there } else { there - here };
        (normal + step).normalize_or(normal)
    }

    /// Surface coordinates on a chart.
    pub fn uv_mm(chart: u32, point: DVec3) -> DVec2 {
        in_chart(chart, point).truncate()
    }

    /// Change of the surface coordinates on a step along the surface, its true length kept.
    pub fn uv_step_mm(chart: u32, normal: DVec3, step: DVec3) -> DVec2 {
        let frame = surface_frame(chart, normal);
        // The frame is right-handed seen from outside, the chart only on one side of the body.
        let sign = 1f64.copysign(frame.y_axis.dot(second_axis(chart)));
        DVec2::new(step.dot(frame.x_axis), step.dot(frame.y_axis) * sign)
    }
}

/// Across a triangle, twice its area long, to the side from which it is counterclockwise.
fn across([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Change of the weights of the second and third corner on a step along a triangle.
fn weights_step(corners: &[DVec3; 3], step: DVec3) -> [f64; 2] {
    let across = across(corners);
    [corners[0] - corners[2], corners[1] - corners[0]]
        .map(|edge| edge.cross(step).dot(across) / across.length_squared())
}

/// Unit normals of vertices: means of their triangles', by area. Vertices at one place are one.
fn area_normals(places: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let key = |k: u32| places[k as usize].to_array().map(|c| (c + 0.0).to_bits());
    let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
    for triangle in triangles {
        let across = across(&triangle.map(|k| places[k as usize].as_dvec3()));
        triangle.iter().for_each(|k| *sums.entry(key(*k)).or_default() += across);
    }
    let normal = |k: u32| sums.get(&key(k)).and_then(|n| n.try_normalize()).unwrap_or(DVec3::Z).as_vec3();
    (0..places.len() as u32).map(normal).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use crate::math::hash::{pcg4d, unit};
    use std::f64::consts::{PI, TAU};

    /// A ball of radius 1 in `n` rings of 2n points, without the poles' points twice.
    fn ball(n: usize) -> Triangles {
        let point = |k: usize, j: usize| spherical(PI * k as f64 / n as f64, TAU * j as f64 / (2 * n) as f64);
        let at = |k: usize, j: usize| match k {
            0 => 0,
            k if k == n => 1,
            k => (2 + (k - 1) * 2 * n + j % (2 * n)) as u32,
        };
        let rings = (1..n).flat_map(|k| (0..2 * n).map(move |j| (k, j)));
        let places = [(0, 0), (n, 0)].into_iter().chain(rings);
        let quads = (0..n).flat_map(|k| (0..2 * n).map(move |j| (k, j)));
        let triangles = quads.flat_map(|(k, j)| {
            [[at(k, j), at(k + 1, j), at(k + 1, j + 1)], [at(k, j), at(k + 1, j + 1), at(k, j + 1)]]
        });
        Triangles {
            positions: places.map(|(k, j)| point(k, j).as_vec3().to_array()).collect(),
            triangles: triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect(),
            ..Triangles::default()
        }
    }

    /// Triangles strewn at random, some of them needles.
    fn strewn(count: u32) -> Triangles {
        let number = |k: u32, j: u32| pcg4d([k, j, 5, 6]).map(|bits| unit(bits) - 0.5);
        let corner = |k: u32| {
            let [x, y, z, _] = number(k / 3, 0);
            let [a, b, c, _] = number(k, 1);
            let needle = if (k / 3).is_multiple_of(7) { 1e-4 } else { 0.3 };
            [x + 0.3 * a, y + needle * b, z + 0.1 * c]
        };
        Triangles {
            positions: (0..3 * count).map(corner).collect(),
            triangles: (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            ..Triangles::default()
        }
    }

    fn rays(count: u32) -> impl Iterator<Item = (DVec3, DVec3)> {
        (0..count).map(|k| {
            let [a, b, c, d] = pcg4d([k, 1, 1, 1]).map(|bits| f64::from(unit(bits)));
            let origin = spherical(PI * a, TAU * b) * if k % 5 == 0 { 0.1 } else { 300.0 };
            let aim = spherical(PI * c, TAU * d) * 20.0 * a;
            // Some along the axes, where slabs have no width.
            let direction = if k % 11 == 0 { DVec3::AXES[k as usize % 3] } else { aim - origin };
            (origin, direction.normalize())
        })
    }

    #[test]
    fn boxes_lose_no_triangle() {
        for file in [strewn(3000), ball(20)] {
            let mesh = Mesh::new(&file, true, Some(50.0), 1.0);
            assert_eq!(mesh.triangles.len(), file.triangles.len());
            let mut met = 0;
            for (origin, direction) in rays(2000) {
                let ray = Sheared::new(origin, direction);
                let all = (0..mesh.triangles.len()).filter_map(|t| ray.crossing(&mesh.corners(t)));
                let nearest = all.map(|c| c.distance).filter(|d| *d > 0.0).min_by(f64::total_cmp);
                let found = mesh.intersect(origin, direction).map(|c| c.distance);
                assert_eq!(found, nearest, "{origin} {direction}");
                met += u32::from(found.is_some());
            }
            assert!((300..2000).contains(&met), "{met}");
        }
    }

    #[test]
    fn no_ray_slips_through_edges_and_corners() {
        let mesh = Mesh::new(&ball(16), true, Some(100.0), 1.0);
        let eye = DVec3::new(300.0, 20.0, -40.0);
        for ([a, b, _], _) in &mesh.triangles {
            let [a, b] = [a, b].map(|k| mesh.vertices[*k as usize].0.as_dvec3());
            for share in [0.0, 0.25, 0.5, 1.0 / 3.0] {
                let aim = a.lerp(b, share);
                let hit = mesh.intersect(eye, (aim - eye).normalize());
                // What is seen end on may be missed: there the silhouette is.
                if aim.normalize().dot((eye - aim).normalize()) > 0.2 {
                    let hit = hit.unwrap_or_else(|| unreachable!("{aim} was missed"));
                    assert!((hit.distance - eye.distance(aim)).abs() < 1e-9);
                }
            }
            // From within there is no way out.
            assert!(mesh.intersect(DVec3::ZERO, a.normalize()).is_some());
        }
    }

    #[test]
    fn a_ball_of_triangles_is_nearly_a_ball() {
        let n = 64;
        let mesh = Mesh::new(&ball(n), true, Some(2.0 * 22.0), 1.0);
        let ball = super::super::convex::Convex::Sphere { radius: 22.0 };
        // A chord of 1/64 of a half turn is 3e-4 of the radius below its arc.
        let sagitta = 22.0 * (1.0 - (PI / n as f64 / 2.0).cos());
        for (origin, direction) in rays(3000).filter(|(origin, _)| origin.length() > 100.0) {
            let (Some(a), Some(b)) = (ball.intersect(origin, direction), mesh.intersect(origin, direction))
            else {
                continue;
            };
            let cosine = -direction.dot(a.normal);
            // Nor near the poles: triangles around a vertex are unlike there, and their mean by area leans.
            if cosine < 0.3 || a.normal.z.abs() > 0.95 {
                continue;
            }
            assert!((0.0..2.0 * sagitta / cosine + 1e-4).contains(&(b.distance - a.distance + 1e-4)));
            // Interpolated normals are off by the square of half an edge's angle, about.
            assert!(a.normal.angle_between(b.normal) < 5e-3, "{a:?} {b:?}");
            let step = a.normal.any_orthonormal_vector() * 0.01;
            let [c, d] = [
                ball.normal(a.chart, a.point + step) - a.normal,
                mesh.normal_near(b.primitive, b.weights, b.normal, step) - b.normal,
            ];
            // A facet bends its normals by what lies between its corners, not between here and there.
            assert!(c.distance(d) < 0.1 * c.length(), "{c} {d}");
            // On the same chart places are stretched, lengths are not.
            let length = Mesh::uv_step_mm(b.chart, b.normal, step).length();
            assert!((length / 0.01 - 1.0).abs() < 0.01, "{length}");
        }
    }

    #[test]
    fn normals_face_the_eye_even_where_they_are_nonsense() {
        let mut file = strewn(1000);
        let nonsense = |k: u32| match k % 5 {
            0 => [f32::NAN; 3],
            1 => [0.0; 3],
            2 => [f32::INFINITY, 0.0, 0.0],
            _ => pcg4d([k, 2, 2, 2]).map(|bits| unit(bits) - 0.5)[..3].try_into().unwrap(),
        };
        file.normals = (0..file.positions.len() as u32).map(nonsense).collect();
        let mesh = Mesh::new(&file, false, Some(50.0), 1.0);
        for (origin, direction) in rays(2000) {
            let Some(hit) = mesh.intersect(origin, direction) else { continue };
            assert!((hit.normal.length() - 1.0).abs() < 1e-9);
            // Bent by the cosine that is missing, and made a unit vector again.
            assert!(hit.normal.dot(direction) < -0.5 * LEAST_COSINE, "{hit:?}");
            let near = mesh.normal_near(hit.primitive, hit.weights, hit.normal, DVec3::splat(3.0));
            assert!((near.length() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn meshes_stand_upright_in_their_size_around_the_origin() {
        let file = Triangles {
            positions: vec![[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 6.0, 3.0], [1.0, 2.0, 5.0]],
            // The last has no area.
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 1, 1]],
            ..Triangles::default()
        };
        let mesh = Mesh::new(&file, false, Some(40.0), 1.0);
        assert_eq!(mesh.triangles.len(), 2);
        // What was up (y) is z, the front (z) is -y, and the longest side 40.
        assert_eq!(mesh.vertices[2].0, Vec3::new(-5.0, 10.0, 20.0));
        assert_eq!(mesh.vertices[3].0, Vec3::new(-5.0, -10.0, -20.0));
        let plain = Mesh::new(&file, true, None, 1000.0);
        assert_eq!(plain.vertices[1].0, Vec3::new(500.0, -2000.0, -1000.0));
    }
}
