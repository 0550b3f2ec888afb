//! The demonstration of Golla & Klein 2018 (Fig. 7): a capsule in each paint that stands still, one that is moved among them, and
//! a body, both in the blend; weights go by the distances of the movable capsule to the others.

use super::weights::corner;
use crate::mix::distance_weights;
use crate::scene::{Bodies, Camera, Object, Scene, Shape};
use glam::{DVec2, DVec3};

/// Capsules of the scene.
const CAPSULE: Shape = Shape::Capsule { radius_mm: 8.0, height_mm: 40.0 };
/// Wears the blend, too.
const BODY: Shape = Shape::SpeedShape { length_mm: 110.0 };
/// From the middle to the capsules that stand still, millimetres.
const RING_MM: DVec2 = DVec2::new(66.0, 46.0);
/// The movable one stays within so much of that ring.
const REACH: f64 = 1.4;
/// Where the body stands, millimetres: in front of the others.
const BODY_MM: [f64; 3] = [-2.0, -78.0, -10.0];

/// Where the movable capsule stands at first, millimetres.
pub const START: DVec2 = DVec2::new(14.0, 4.0);

/// Where capsule `k` of `n` stands, millimetres: the first one behind.
fn place(k: usize, n: usize) -> DVec2 {
    let corner = corner(k, n);
    DVec2::new(corner.x, -corner.y) * RING_MM
}

/// The objects of `n` paints: paint 0 is the blend, paint k + 1 the k-th.
pub fn objects(n: usize, movable: DVec2) -> Vec<Object> {
    let capsule = |at: DVec2, paint: usize| Object {
        shape: CAPSULE,
        position_mm: at.extend(0.0).to_array(),
        paint,
        ..Object::default()
    };
    let body = Object { shape: BODY, position_mm: BODY_MM, turn_deg: -24.0, ..Object::default() };
    let still = (0..n).map(|k| capsule(place(k, n), k + 1));
    still.chain([capsule(movable, 0), body]).collect()
}

/// The camera that sees all of it.
pub fn camera() -> Camera {
    Camera {
        position_mm: [0.0, -420.0, 150.0],
        target_mm: [0.0, -8.0, -4.0],
        vertical_fov_deg: 22.0,
        ..Camera::default()
    }
}

/// Weights of `n` paints where the movable capsule stands.
pub fn weights(n: usize, movable: DVec2) -> Vec<f64> {
    let distances: Vec<f64> = (0..n).map(|k| place(k, n).distance(movable)).collect();
    // Distances of finite places are legal.
    distance_weights(&distances).unwrap_or_else(|_| super::weights::equal(n))
}

/// A place within reach.
pub fn within(movable: DVec2) -> DVec2 {
    movable.clamp(-REACH * RING_MM, REACH * RING_MM)
}

/// The pixel that shows a place of the ground, if it is before the eye.
pub fn seen_at(scene: &Scene, place: DVec2) -> Option<[f64; 2]> {
    let camera = &scene.camera;
    let eye = DVec3::from(camera.position_mm);
    let forward = (DVec3::from(camera.target_mm) - eye).normalize();
    let right = forward.cross(DVec3::from(camera.up)).normalize();
    let offset = place.extend(0.0) - eye;
    let depth = offset.dot(forward);
    let [width, height] = scene.size.map(|n| n as f64);
    let pixels = height / (2.0 * (camera.vertical_fov_deg.to_radians() / 2.0).tan());
    let at = |axis: DVec3| offset.dot(axis) / depth * pixels;
    (depth > 0.0).then(|| [width / 2.0 + at(right), height / 2.0 + at(forward.cross(right))])
}

/// How the movable capsule is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grip {
    /// Height of the point that is held, millimetres.
    height: f64,
    /// From that point to the capsule's middle, millimetres.
    offset: DVec2,
}

impl Grip {
    /// Takes hold of the movable capsule of `n` paints at a pixel, if that shows it.
    pub fn take(scene: &Scene, bodies: &Bodies, n: usize, [x, y]: [f64; 2], movable: DVec2) -> Option<Self> {
        let view = scene.camera.view(scene.size);
        let hit = bodies.intersect(view.origin, view.direction(x, y))?;
        // After those that stand still.
        (scene.objects.len() > n && hit.object == n)
            .then(|| Self { height: hit.point.z, offset: movable - hit.point.truncate() })
    }

    /// Where the capsule goes when the hand is at a pixel: along the ground. None: the ray does not come down to it.
    pub fn drag(&self, scene: &Scene, [x, y]: [f64; 2]) -> Option<DVec2> {
        let view = scene.camera.view(scene.size);
        let direction: DVec3 = view.direction(x, y);
        let distance = (self.height - view.origin.z) / direction.z;
        (distance > 0.0 && distance.is_finite())
            .then(|| within((view.origin + direction * distance).truncate() + self.offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(n: usize, movable: DVec2) -> Scene {
        Scene { objects: objects(n, movable), camera: camera(), size: [640, 480], ..Scene::default() }
    }

    #[test]
    fn scenes_are_legal_and_the_weights_those_of_the_distances() {
        for n in 2..=8 {
            let scene = scene(n, START);
            scene.validate().unwrap();
            scene.check_paints(n + 1).unwrap();
            assert!(scene.check_paints(n).is_err(), "every paint is worn");
            for k in 0..n {
                let there = weights(n, place(k, n));
                assert_eq!(there[k], 1.0, "at a capsule its paint alone");
            }
        }
    }

    /// Finds a pixel that shows the movable capsule.
    fn pixel(scene: &Scene, n: usize, movable: DVec2) -> ([f64; 2], Grip) {
        let pixels = (0..scene.size[1]).flat_map(|y| (0..scene.size[0]).map(move |x| [x as f64, y as f64]));
        let bodies = Bodies::new(scene).unwrap();
        pixels.step_by(7).find_map(|at| Some((at, Grip::take(scene, &bodies, n, at, movable)?))).unwrap()
    }

    #[test]
    fn the_capsule_follows_the_hand_along_the_ground() {
        let scene = scene(3, START);
        let bodies = Bodies::new(&scene).unwrap();
        let seen = seen_at(&scene, START).unwrap();
        assert!(Grip::take(&scene, &bodies, 3, seen, START).is_some(), "its middle shows it: {seen:?}");
        let (at, grip) = pixel(&scene, 3, START);
        // A ray through the same pixel comes back to where it was taken; 450 mm, a few roundings.
        assert!(grip.drag(&scene, at).unwrap().distance(START) < 1e-9);
        let moved = grip.drag(&scene, [at[0] + 40.0, at[1]]).unwrap();
        assert!(moved.x > START.x + 1.0 && (moved.y - START.y).abs() < 1e-9, "to the right: {moved}");
        assert!(grip.drag(&scene, [at[0], at[1] + 20.0]).unwrap().y < START.y, "nearer");
        assert!(grip.drag(&scene, [at[0], -1e4]).is_none(), "above the horizon");
        let far = grip.drag(&scene, [at[0] + 1e4, at[1]]).unwrap();
        assert_eq!(far, within(far));
        assert!(Grip::take(&scene, &bodies, 3, [1.0, 1.0], START).is_none(), "nothing there");
    }
}
