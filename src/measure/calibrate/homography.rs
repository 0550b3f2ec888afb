//! The homography between two planes from pairs of points: the direct linear transform with Hartley's normalization.

use glam::{DMat3, DVec2, DVec3};
use nalgebra::{SMatrix, SVector, SymmetricEigen};

/// The homography H that takes the first point of each pair to the second, `h33 = 1`; `None` from fewer than four pairs or
/// from pairs that do not determine one.
pub fn homography(pairs: &[(DVec2, DVec2)]) -> Option<DMat3> {
    if pairs.len() < 4 {
        return None;
    }
    let from = normalizing(pairs.iter().map(|p| p.0))?;
    let to = normalizing(pairs.iter().map(|p| p.1))?;
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in pairs {
        let (a, b) = (from * a.extend(1.0), apply(to, *b)?);
        let rows = [
            [-a.x, -a.y, -a.z, 0.0, 0.0, 0.0, b.x * a.x, b.x * a.y, b.x * a.z],
            [0.0, 0.0, 0.0, -a.x, -a.y, -a.z, b.y * a.x, b.y * a.y, b.y * a.z],
        ];
        for row in rows {
            let row = SVector::<f64, 9>::from(row);
            normal += row * row.transpose();
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let mut order: [usize; 9] = std::array::from_fn(|k| k);
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    // Two vanishing eigenvalues: points on a line, or all but one.
    let [second, last] = [order[1], order[8]].map(|k| eigen.eigenvalues[k]);
    if second.is_nan() || second <= 1e-10 * last {
        return None;
    }
    let h: Vec<f64> = eigen.eigenvectors.column(order[0]).iter().copied().collect();
    let rows = DMat3::from_cols_array(&[h[0], h[3], h[6], h[1], h[4], h[7], h[2], h[5], h[8]]);
    let full = to.inverse() * rows * from;
    let scaled = full * (1.0 / full.z_axis.z);
    scaled.is_finite().then_some(scaled)
}

/// Where a homography takes a point; `None` at infinity.
pub fn apply(h: DMat3, point: DVec2) -> Option<DVec2> {
    let DVec3 { x, y, z } = h * point.extend(1.0);
    let image = DVec2::new(x, y) / z;
    image.is_finite().then_some(image)
}

/// The similarity that brings points to mean 0 and mean square distance 2.
fn normalizing(points: impl Iterator<Item = DVec2> + Clone) -> Option<DMat3> {
    let count = points.clone().count() as f64;
    let mean = points.clone().sum::<DVec2>() / count;
    let square = points.map(|p| (p - mean).length_squared()).sum::<f64>() / count;
    let scale = (2.0 / square).sqrt();
    scale.is_finite().then(|| DMat3::from_scale(DVec2::splat(scale)) * DMat3::from_translation(-mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_give_back_their_homography() {
        let truth = DMat3::from_cols_array(&[2.0, 0.3, 1e-3, -0.2, 1.5, 4e-4, 130.0, 90.0, 1.0]);
        let points =
            [[-25.0, -25.0], [25.0, -20.0], [24.0, 25.0], [-25.0, 21.0], [3.0, 4.0]].map(DVec2::from);
        let pairs: Vec<_> = points.iter().map(|p| (*p, apply(truth, *p).unwrap())).collect();
        let found = homography(&pairs).unwrap();
        for p in points {
            // Rounding of a 9 x 9 eigenproblem over a gap of some 1e-3.
            assert!((apply(found, p).unwrap() - apply(truth, p).unwrap()).length() < 1e-8);
        }
        let on_a_line: Vec<_> =
            (0..9).map(|k| (DVec2::splat(f64::from(k)), DVec2::X * f64::from(k))).collect();
        assert_eq!(homography(&on_a_line), None);
        assert_eq!(homography(&pairs[..3]), None);
        assert_eq!(homography(&[pairs[0]; 9]), None);
    }
}
