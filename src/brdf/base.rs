//! What lies under the coat: the color table times diffuse and lobes (Golla & Klein 2018, section 3.1).

use super::cook_torrance::brightness;
use super::{ColorTable, Lobe, LobeGeometry};
use crate::math::half_difference::HalfDifference;
use glam::DVec3;

/// BRDF under the coat, `chi(theta_h, theta_i) (a/pi + sum CT)`, for unit directions under the coat, linear Rec.709, 1/sr. 0 below
/// the horizon.
pub fn base(colors: &ColorTable, diffuse: f64, lobes: &[Lobe], wi: DVec3, wo: DVec3) -> DVec3 {
    let angles = HalfDifference::of(wi, wo);
    let chi = colors.sample(angles.theta_h as f32, angles.theta_i as f32).map(f64::from);
    DVec3::from(chi) * brightness(diffuse, lobes, &LobeGeometry::of(wi, wo))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use std::f64::consts::PI;

    #[test]
    fn a_white_table_over_a_diffuse_base_is_lambert() {
        let (wi, wo) = (spherical(0.3, 1.0), spherical(0.9, -2.0));
        // f32 weights of the table.
        assert!((base(&ColorTable::white(), 0.5, &[], wi, wo) - DVec3::splat(0.5 / PI)).length() < 1e-7);
        assert_eq!(base(&ColorTable::white(), 0.5, &[], wi, -wo), DVec3::ZERO);
    }
}
