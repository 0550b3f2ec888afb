//! CIE L*a*b*, extended to negative light.
//!
//! A flake BTF is a signed residual: between flakes it is darker than the mean, hence below zero. Standard Lab ends at
//! zero, and its linear extension sends a residual of -0.15 to L* = -135. Here the companding function is continued odd
//! about its value at zero, `f(-t) = 8/29 - f(t)`: Lab(-c) = -Lab(c), smooth and invertible everywhere, and the textbook
//! Lab for every real color.

use super::rgb::{WHITE_XYZ, rgb_from_xyz, xyz_from_rgb};
use glam::DVec3;

const DELTA: f64 = 6.0 / 29.0;
/// f(0).
const ZERO: f64 = 4.0 / 29.0;

/// The companding function of Lab less its value at zero; odd. With that value added, light below 1e-16 would be lost in it.
fn compand(t: f64) -> f64 {
    let x = t.abs();
    let above = if x > DELTA * DELTA * DELTA { x.cbrt() - ZERO } else { x / (3.0 * DELTA * DELTA) };
    above.copysign(t)
}

/// Inverse of [`compand`].
fn expand(f: f64) -> f64 {
    let above = f.abs();
    let x = if above > DELTA - ZERO { (above + ZERO).powi(3) } else { above * 3.0 * DELTA * DELTA };
    x.copysign(f)
}

/// Signed Lab of XYZ relative to the white `white`.
pub fn lab_from_xyz(xyz: DVec3, white: DVec3) -> DVec3 {
    let [x, y, z] = (xyz / white).to_array().map(compand);
    DVec3::new(116.0 * y, 500.0 * (x - y), 200.0 * (y - z))
}

/// Inverse of [`lab_from_xyz`].
pub fn xyz_from_lab(lab: DVec3, white: DVec3) -> DVec3 {
    let y = lab.x / 116.0;
    DVec3::new(expand(y + lab.y / 500.0), expand(y), expand(y - lab.z / 200.0)) * white
}

/// Signed Lab (D65) of a linear Rec.709 color; (1, 1, 1) is L* = 100.
pub fn lab_from_rgb(rgb: DVec3) -> DVec3 {
    lab_from_xyz(xyz_from_rgb(rgb), WHITE_XYZ)
}

/// Inverse of [`lab_from_rgb`].
pub fn rgb_from_lab(lab: DVec3) -> DVec3 {
    rgb_from_xyz(xyz_from_lab(lab, WHITE_XYZ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn color() -> impl Strategy<Value = DVec3> {
        (-40.0..40.0f64, -40.0..40.0f64, -40.0..40.0f64).prop_map(|(r, g, b)| DVec3::new(r, g, b))
    }

    proptest! {
        #[test]
        fn lab_is_inverted(c in color()) {
            // Rounding through a cube root and two matrices whose rows sum to 1 with terms up to 3.
            prop_assert!((rgb_from_lab(lab_from_rgb(c)) - c).abs().max_element() < 1e-13 * (1.0 + c.length()));
        }

        #[test]
        fn lab_is_odd(c in color()) {
            prop_assert!((lab_from_rgb(-c) + lab_from_rgb(c)).abs().max_element() < 1e-12);
        }
    }

    #[test]
    fn real_colors_are_textbook_lab() {
        use palette::white_point::D65;
        use palette::{IntoColor, Lab, Xyz};
        for k in 0..1000u32 {
            let [r, g, b] = [k % 10, k / 10 % 10, k / 100].map(|d| f64::from(d) / 9.0);
            let xyz = xyz_from_rgb(DVec3::new(r, g, b));
            let theirs: Lab<D65, f64> = Xyz::<D65, f64>::new(xyz.x, xyz.y, xyz.z).into_color();
            // palette's white is (0.95047, 1, 1.08883): the same function of another white.
            let ours = lab_from_xyz(xyz, DVec3::new(0.95047, 1.0, 1.08883));
            assert!((ours - DVec3::new(theirs.l, theirs.a, theirs.b)).abs().max_element() < 1e-11);
        }
    }

    #[test]
    fn slope_is_continuous_at_zero_and_at_the_joint() {
        for t in [0.0, DELTA.powi(3)] {
            let h = 1e-7;
            let left = (compand(t) - compand(t - h)) / h;
            let right = (compand(t + h) - compand(t)) / h;
            // One-sided differences: curvature times h.
            assert!((left - right).abs() < 1e-4, "{t}: {left} {right}");
        }
    }
}
