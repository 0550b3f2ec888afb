//! The half vector between directions inside a lacquer, projected onto the surface.

use super::fresnel::refracted_cosine;
use glam::{Vec2, Vec3};

/// Index of refraction inside of which half vectors are taken: that of the lacquers of car paints, 1.45 to 1.6. It belongs to
/// no paint, so that paints can be blended.
pub const LACQUER_INDEX: f32 = 1.5;

/// `p = h.xy sqrt(2 / (1 + h.z))`, h the half vector of two unit directions refracted into a lacquer: Lambert's equal-area map
/// of the hemisphere to the disc of radius sqrt 2, near the normal the angle in radians.
///
/// Flakes light up where h meets their normals: inside the lacquer, so that a turn of the outer half vector counts with what
/// refraction leaves of it, 2/3 straight on and a fourth at theta_i = 75 degrees.
///
/// Both directions above the horizon; they may be given in the base's frame or any other with z along the normal.
pub fn projected_half(wi: Vec3, wo: Vec3) -> Vec2 {
    let half = (inside(wi) + inside(wo)).normalize();
    half.truncate() * (2.0 / (1.0 + half.z)).sqrt()
}

/// Area of projected half vectors over the solid angle of the directions `wi` that they belong to, `wo` held.
///
/// `n^2 cos(theta') dw' = cos(theta) dw` for a refracted `w'`, and a mirrored direction turns by twice as much as the mirror:
/// `dw' = 4 (h . w') dh`, of which the projection keeps the area.
pub fn half_stretch(wi: Vec3, wo: Vec3) -> f32 {
    let (from, to) = (inside(wi), inside(wo));
    // h . w' is half the length of the sum.
    wi.z / (LACQUER_INDEX * LACQUER_INDEX * from.z * 2.0 * (from + to).length())
}

fn inside(w: Vec3) -> Vec3 {
    (w.truncate() / LACQUER_INDEX).extend(refracted_cosine(w.z, LACQUER_INDEX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::directions;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn the_stretch_is_the_area_of_a_small_square() {
        for (wi, wo) in [(0.1f32, 0.2f32), (0.7, 0.3), (1.2, 1.1), (0.4, 1.5)] {
            let (wi, wo) = (Vec3::new(wi.sin(), 0.0, wi.cos()), Vec3::new(0.0, wo.sin(), wo.cos()));
            let step = 0.01;
            let side = |axis: Vec3| {
                let at = |sign: f32| projected_half((wi + axis * (sign * step)).normalize(), wo);
                (at(1.0) - at(-1.0)) / (2.0 * step)
            };
            let area = side(wi.cross(Vec3::Y)).perp_dot(side(Vec3::Y)).abs();
            let stretch = half_stretch(wi, wo);
            // Central differences of a hundredth: its square, and a thousandth where the light grazes.
            assert!((area / stretch - 1.0).abs() < 1e-3, "{wi} {wo}: {area} {stretch}");
        }
    }

    #[test]
    fn half_vectors_turn_less_inside() {
        let at = |theta_h: f64, theta_i: f64| {
            let (wi, wo) = directions(theta_h.to_radians(), theta_i.to_radians(), FRAC_PI_2);
            projected_half(wi.as_vec3(), wo.as_vec3())
        };
        assert!(at(0.0, 40.0).length() < 1e-6);
        for theta_i in [0.0f64, 30.0, 75.0] {
            // d tan(theta_h') / d theta_h = cos(theta_i) / sqrt(n^2 - 1 + cos^2(theta_i)).
            let cosine = theta_i.to_radians().cos();
            let exact = 0.2f64.to_radians() * cosine / (1.25 + cosine * cosine).sqrt();
            let seen = f64::from(at(0.2, theta_i).length());
            // The next order, a few times a fifth of a degree squared.
            assert!((seen / exact - 1.0).abs() < 4e-5, "{theta_i}: {seen} {exact}");
        }
        // |p| = 2 sin(t / 2) for an inner angle t.
        let p = 2.0 * (0.5 * (50f32.to_radians().sin() / LACQUER_INDEX).asin()).sin();
        assert!((at(50.0, 0.0).length() - p).abs() < 1e-6);
    }
}
