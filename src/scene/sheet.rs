//! A sheet of paper, bent like a label on a bottle.

use crate::file::Triangles;

/// Strips across the bend: at a half turn each bends by less than half a degree.
const STRIPS: usize = 384;

/// The sheet of this width and height, millimetres, its outer side towards -y, z up, with its picture.
pub(super) fn triangles([width, height]: [f64; 2], radius: f64) -> Triangles {
    let edge = |k: usize| {
        let along = k as f64 / STRIPS as f64;
        let (sin, cos) = ((along - 0.5) * width / radius).sin_cos();
        [0.0, 1.0].map(|down| {
            let place = [radius * sin, -radius * cos, (0.5 - down) * height];
            (place.map(|c| c as f32), [sin as f32, -cos as f32, 0.0], [along as f32, down as f32])
        })
    };
    let vertices: Vec<_> = (0..=STRIPS).flat_map(edge).collect();
    let strip = |k: usize| {
        let k = 2 * k as u32;
        [[k, k + 1, k + 2], [k + 1, k + 3, k + 2]]
    };
    Triangles {
        positions: vertices.iter().map(|v| v.0).collect(),
        normals: vertices.iter().map(|v| v.1).collect(),
        uvs: vertices.iter().map(|v| v.2).collect(),
        triangles: (0..STRIPS).flat_map(strip).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::Mesh;
    use super::*;
    use glam::{DVec2, DVec3};

    #[test]
    fn the_picture_lies_upright_on_the_outside() {
        let mesh = Mesh::new(&triangles([60.0, 45.0], 22.0), true, None, 1.0);
        let from = |x: f64, z: f64, side: f64| {
            let hit = mesh.intersect(DVec3::new(x, side * 500.0, z), DVec3::NEG_Y * side).unwrap();
            mesh.print_place(hit.primitive, hit.weights, hit.normal, [DVec3::X * 0.1, DVec3::Z * 0.2])
        };
        let middle = from(0.0, 0.0, -1.0).unwrap();
        assert!(middle.uv.distance(DVec2::splat(0.5)) < 1e-6, "{middle:?}");
        // A chord of half a degree is shorter than its arc by a millionth; places are f32.
        assert!(middle.sides.distance(DVec2::new(0.1 / 60.0, 0.2 / 45.0)) < 1e-7, "{middle:?}");
        let corner = from(22.0 * 0.8f64.sin(), 22.0, -1.0).unwrap().uv;
        assert!(corner.distance(DVec2::new(0.5 + 0.8 * 22.0 / 60.0, 0.5 - 22.0 / 45.0)) < 1e-4, "{corner}");
        assert!(from(0.0, 0.0, 1.0).is_none(), "the back is bare");
    }
}
