//! One triangle against a ray, watertight (Woop, Benthin & Wald 2013): of two triangles that share an edge, a ray through it meets
//! at least one.

use glam::DVec3;

/// A ray in a frame in which it goes along z.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sheared {
    origin: DVec3,
    /// Numbers of the axes: two across, and the one that the ray is closest to.
    axes: [usize; 3],
    shear: DVec3,
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// In lengths of the direction.
    pub distance: f64,
    /// Weights of the second and the third vertex.
    pub weights: [f64; 2],
}

impl Sheared {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let z = if size.x > size.y && size.x > size.z { 0 } else { 1 + usize::from(size.z >= size.y) };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let [x, y, z] = axes.map(|axis| direction[axis]);
        Self { origin, axes, shear: DVec3::new(x / z, y / z, 1.0 / z) }
    }

    /// Where the whole line crosses a triangle, if it does, from either side.
    pub fn crossing(&self, triangle: &[DVec3; 3]) -> Option<Crossing> {
        let [a, b, c] = triangle.map(|p| {
            let q = p - self.origin;
            let [x, y, z] = self.axes.map(|axis| q[axis]);
            DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
        });
        // Twice the areas of the parts: a shared edge gives the same number with the other sign.
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        let total = u + v + w;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) || total == 0.0 {
            return None;
        }
        let distance = (u * a.z + v * b.z + w * c.z) / total;
        Some(Crossing { distance, weights: [v / total, w / total] })
    }
}
