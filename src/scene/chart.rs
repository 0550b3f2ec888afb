//! The six charts of closed surfaces, one around each half of each axis: which one a place belongs to, and its axes.

use glam::{DMat3, DVec3};

/// Charts that a shape may have.
pub(super) const COUNT: u32 = 16;

/// The chart around the axis that a vector is closest to.
pub(super) fn sphere_chart(v: DVec3) -> u32 {
    let n = v.to_array();
    let axis = (0..3).fold(0, |best, k| if n[k].abs() > n[best].abs() { k } else { best });
    2 * axis as u32 + u32::from(n[axis] < 0.0)
}

/// A vector along the axes of a chart: two across, and the one around which it lies.
pub(super) fn in_chart(chart: u32, v: DVec3) -> DVec3 {
    let (p, q, w) = match chart / 2 {
        0 => (v.y, v.z, v.x),
        1 => (v.z, v.x, v.y),
        _ => (v.x, v.y, v.z),
    };
    DVec3::new(p, q, if chart.is_multiple_of(2) { w } else { -w })
}

/// The direction in which a chart's first coordinate grows.
pub(super) fn first_axis(chart: u32) -> DVec3 {
    [DVec3::Y, DVec3::Z, DVec3::X][chart as usize / 2 % 3]
}

/// The direction in which its second coordinate grows.
pub(super) fn second_axis(chart: u32) -> DVec3 {
    [DVec3::Z, DVec3::X, DVec3::Y][chart as usize / 2 % 3]
}

/// Columns tangent (near where a chart's first coordinate grows), bitangent, `normal` (a unit vector).
pub(super) fn surface_frame(chart: u32, normal: DVec3) -> DMat3 {
    let along = first_axis(chart);
    let tangent = along.reject_from_normalized(normal).normalize_or(normal.any_orthonormal_vector());
    DMat3::from_cols(tangent, normal.cross(tangent), normal)
}
