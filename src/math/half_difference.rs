//! Half and difference angles of a pair of directions (Rusinkiewicz).
//!
//! Directions point away from the surface, local frame, z = normal.
//! `h = normalize(wi + wo)`, `theta_h = acos(h.z)`, `theta_i = acos(h . wi) = acos(h . wo)`; Golla & Klein 2018,
//! section 3.1, write theta_i for what others call the difference angle. `phi_d` is the azimuth of the
//! difference vector about h; 0 and pi lie in the plane of h and the normal.

use glam::DVec3;

/// The pair of angles that address a color table or a flake slice, radians, each in [0, pi/2].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfDifference {
    /// Angle between half vector and normal.
    pub theta_h: f64,
    /// Angle between half vector and either direction.
    pub theta_i: f64,
}

impl HalfDifference {
    /// Angles of unit directions `wi` and `wo`, by `atan2`, so that small angles keep all their digits.
    pub fn of(wi: DVec3, wo: DVec3) -> Self {
        let sum = wi + wo;
        Self {
            theta_h: sum.truncate().length().atan2(sum.z),
            theta_i: (wi - wo).length().atan2(sum.length()),
        }
    }
}

/// Unit directions `(wi, wo)` with half vector at `theta_h` (azimuth 0), at `theta_i` from it, turned by `phi_d`
/// about it. Radians. `wi.z` or `wo.z` may come out negative: the cell is then partly below the horizon.
pub fn directions(theta_h: f64, theta_i: f64, phi_d: f64) -> (DVec3, DVec3) {
    let (sin_h, cos_h) = theta_h.sin_cos();
    let (sin_i, cos_i) = theta_i.sin_cos();
    let (sin_p, cos_p) = phi_d.sin_cos();
    let h = DVec3::new(sin_h, 0.0, cos_h);
    let difference = (DVec3::new(cos_h, 0.0, -sin_h) * cos_p + DVec3::Y * sin_p) * sin_i;
    (h * cos_i + difference, h * cos_i - difference)
}

/// Unit direction at polar angle `theta` and azimuth `phi`, radians.
pub fn spherical(theta: f64, phi: f64) -> DVec3 {
    let (sin_t, cos_t) = theta.sin_cos();
    let (sin_p, cos_p) = phi.sin_cos();
    DVec3::new(sin_t * cos_p, sin_t * sin_p, cos_t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_survive_the_round_trip() {
        for theta_h in [0.0, 1e-9, 0.3, 1.2] {
            for theta_i in [0.0, 1e-9, 0.2, 1.5] {
                for phi in [0.0, 0.7, 1.6, 3.0] {
                    let (wi, wo) = directions(theta_h, theta_i, phi);
                    let back = HalfDifference::of(wi, wo);
                    // A few roundings of unit vectors; acos would be off by 1e-8 near zero.
                    assert!((back.theta_h - theta_h).abs() < 1e-15 + 4e-16 / theta_i.cos());
                    assert!((back.theta_i - theta_i).abs() < 1e-15);
                    assert!((wi.length() - 1.0).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn at_phi_d_90_both_polar_angles_are_equal() {
        let (wi, wo) = directions(0.8, 0.6, std::f64::consts::FRAC_PI_2);
        assert!((wi.z - wo.z).abs() < 1e-15);
        assert!((wi.z - 0.8f64.cos() * 0.6f64.cos()).abs() < 1e-15);
    }
}
