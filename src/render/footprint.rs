//! What a pixel sample covers: its place on the surface, its area there, and the spread of directions it mirrors.

use super::cells::Random;
use crate::scene::{Bodies, Hit, View};
use glam::{DVec3, Vec2};

/// A patch of painted surface under a pixel sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Chart of the surface coordinates, below 2^24.
    pub chart: u32,
    /// Surface coordinates of the middle, millimetres.
    pub uv_mm: Vec2,
    /// The two sides of the patch, millimetres: where the sides of the pixel sample fall.
    pub footprint: [Vec2; 2],
    /// Seed of the flakes.
    pub seed: u32,
    /// Where their random numbers come from.
    pub random: Random,
}

/// A ray that met the object, with its two neighbours one pixel sample to the right and below (ray differentials, Igehy
/// 1999).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Footprint {
    /// The patch.
    pub surface: Surface,
    /// Its middle, millimetres.
    pub point: DVec3,
    /// Its sides, millimetres on the tangent plane.
    pub sides: [DVec3; 2],
    /// Unit direction of the mirrored ray.
    pub mirrored: DVec3,
    /// Change of the mirrored direction from one side of the patch to the other.
    pub mirrored_sides: [DVec3; 2],
}

impl Footprint {
    /// The footprint of the sample of `side` pixels around (x, y), whose ray made `hit`; `seed` and
    /// `random` are those of the flakes.
    pub fn new(
        bodies: &Bodies,
        view: &View,
        hit: &Hit,
        [x, y]: [f64; 2],
        side: f64,
        (seed, random): (u32, Random),
    ) -> Self {
        let direction = view.direction(x, y);
        let mirrored = mirror(direction, hit.normal);
        let neighbours = [view.direction(x + side, y), view.direction(x, y + side)];
        let sides = neighbours.map(|d| step_on_plane(view.origin, d, hit));
        let [right, below] = [0, 1].map(|k| {
            let there = hit.point + sides[k];
            mirror(neighbours[k], bodies.normal_near(hit, there)) - mirrored
        });
        let surface = Surface {
            chart: hit.chart,
            uv_mm: bodies.uv_mm(hit).as_vec2(),
            footprint: sides.map(|side| bodies.uv_step_mm(hit, hit.point + side).as_vec2()),
            seed,
            random,
        };
        Self { surface, point: hit.point, sides, mirrored, mirrored_sides: [right, below] }
    }
}

/// From the hit to where a neighbouring ray meets the tangent plane. At the silhouette that is anywhere: no farther than a
/// tenth of the distance, and never behind the eye.
fn step_on_plane(origin: DVec3, direction: DVec3, hit: &Hit) -> DVec3 {
    let limit = 0.1 * hit.distance;
    let distance = (hit.point - origin).dot(hit.normal) / direction.dot(hit.normal);
    let distance = if distance > 0.0 { distance.min(2.0 * hit.distance) } else { 2.0 * hit.distance };
    (origin + direction * distance - hit.point).clamp_length_max(limit)
}

fn mirror(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}
