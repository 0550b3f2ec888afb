//! Closed-form start of the calibration: one lens for all cameras from their homographies to the plate, then a pose each
//! (Zhang 2000, section 3.1), with square pixels and no skew.

use crate::math::projection::{Intrinsics, Pose};
use glam::{DMat3, DQuat, DVec3};
use nalgebra::{SMatrix, SVector, SymmetricEigen};

/// The focal length may differ from the nominal one by this factor; beyond, the homographies do not determine it.
const MAX_FOCAL_RATIO: f64 = 2.0;

/// The common lens of cameras whose homographies take the plate (millimetres) to pixels; `nominal` where they do not determine
/// one (all cameras nearly face the plate).
pub fn common_lens(homographies: &[DMat3], nominal: Intrinsics) -> Intrinsics {
    closed_form(homographies, nominal).unwrap_or(nominal)
}

/// The image of the absolute conic w = [1, 0, -u; 0, 1, -v; -u, -v, u^2 + v^2 + f^2], two equations a homography.
fn closed_form(homographies: &[DMat3], nominal: Intrinsics) -> Option<Intrinsics> {
    let [u, v] = nominal.center_px;
    // Pixels of about unit size, for the condition of the equations.
    let units = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -u, -v, nominal.focal_px])
        * (1.0 / nominal.focal_px);
    let mut normal = SMatrix::<f64, 4, 4>::zeros();
    for h in homographies {
        let h = units * *h;
        let scale = 2.0 / (h.x_axis.length_squared() + h.y_axis.length_squared());
        let row = |a: DVec3, b: DVec3| {
            SVector::<f64, 4>::new(
                a.x * b.x + a.y * b.y,
                a.x * b.z + a.z * b.x,
                a.y * b.z + a.z * b.y,
                a.z * b.z,
            )
        };
        for row in [row(h.x_axis, h.y_axis), row(h.x_axis, h.x_axis) - row(h.y_axis, h.y_axis)] {
            let row = row * scale;
            normal += row * row.transpose();
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let least = eigen.eigenvalues.imin();
    let w = eigen.eigenvectors.column(least);
    let center = [-w[1] / w[0], -w[2] / w[0]];
    let focal = (w[3] / w[0] - center[0] * center[0] - center[1] * center[1]).sqrt();
    let legal = (1.0 / MAX_FOCAL_RATIO..=MAX_FOCAL_RATIO).contains(&focal)
        && center.iter().all(|c| (c * nominal.focal_px).abs() <= 0.5 * (u + v));
    legal.then(|| Intrinsics {
        focal_px: focal * nominal.focal_px,
        center_px: [0, 1].map(|k| nominal.center_px[k] + center[k] * nominal.focal_px),
        distortion: [0.0; 2],
    })
}

/// The pose of a camera of known lens (its distortion neglected) from its homography; `None` unless it stands above the plate.
pub fn pose(homography: DMat3, lens: &Intrinsics) -> Option<Pose> {
    let [u, v] = lens.center_px;
    let f = lens.focal_px;
    let to_plane = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -u, -v, f]) * (1.0 / f);
    let h = to_plane * homography;
    // The plate lies in front: z > 0 of its middle.
    let scale = (2.0 / (h.x_axis.length() + h.y_axis.length())).copysign(h.z_axis.z);
    let [x, y, offset] = [h.x_axis, h.y_axis, h.z_axis].map(|column| column * scale);
    let rotation = nearest_rotation(DMat3::from_cols(x, y, x.cross(y)))?;
    let position_mm = -(rotation.transpose() * offset);
    let legal = position_mm.is_finite() && position_mm.z > 0.0;
    legal.then(|| Pose { position_mm, rotation: DQuat::from_mat3(&rotation).normalize() })
}

/// The rotation nearest to a matrix: U V^T of its singular value decomposition.
fn nearest_rotation(matrix: DMat3) -> Option<DMat3> {
    let svd = SMatrix::<f64, 3, 3>::from_column_slice(&matrix.to_cols_array()).try_svd(
        true,
        true,
        f64::EPSILON,
        1000,
    )?;
    let product = svd.u? * svd.v_t?;
    let rotation = DMat3::from_cols_slice(product.as_slice());
    (rotation.determinant() > 0.0).then_some(rotation)
}
