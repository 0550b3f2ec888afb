//! Linear Rec.709 (the primaries of sRGB) and CIE XYZ.

use glam::{DMat3, DVec3};

/// XYZ of the white x = 0.3127, y = 0.3290 at Y = 1.
pub const WHITE_XYZ: DVec3 = DVec3::new(0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290);

/// XYZ of unit red, green and blue (columns): Rec.709 primaries scaled to [`WHITE_XYZ`].
pub(super) const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_390_799_265_959_5, 0.212_639_005_871_510_36, 0.019_330_818_715_591_85),
    DVec3::new(0.357_584_339_383_877_96, 0.715_168_678_767_755_9, 0.119_194_779_794_625_99),
    DVec3::new(0.180_480_788_401_834_3, 0.072_192_315_360_733_71, 0.950_532_152_249_660_6),
);

/// Inverse of [`XYZ_FROM_RGB`].
pub(super) const RGB_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(3.240_969_941_904_522_6, -0.969_243_636_280_879_6, 0.055_630_079_696_993_66),
    DVec3::new(-1.537_383_177_570_094, 1.875_967_501_507_720_2, -0.203_976_958_888_976_52),
    DVec3::new(-0.498_610_760_293_003_4, 0.041_555_057_407_175_59, 1.056_971_514_242_878_6),
);

/// XYZ (white Y = 1) of a linear Rec.709 color. Any finite value.
pub fn xyz_from_rgb(rgb: DVec3) -> DVec3 {
    XYZ_FROM_RGB * rgb
}

/// Linear Rec.709 of XYZ; outside the gamut components are negative or above 1, and stay so.
pub fn rgb_from_xyz(xyz: DVec3) -> DVec3 {
    RGB_FROM_XYZ * xyz
}

/// Y of a linear Rec.709 color.
pub fn luminance(rgb: DVec3) -> f64 {
    XYZ_FROM_RGB.row(1).dot(rgb)
}

/// The sRGB transfer curve (IEC 61966-2-1), odd about 0; maps [0, 1] onto [0, 1].
pub fn srgb_encode(linear: f64) -> f64 {
    let x = linear.abs();
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white() {
        assert!((xyz_from_rgb(DVec3::ONE) - WHITE_XYZ).abs().max_element() < 1e-15);
        assert!((luminance(DVec3::ONE) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_two_matrices_are_inverse() {
        for c in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(-3.0, 40.0, 1e-5)] {
            // Two products with entries near 1.
            assert!((rgb_from_xyz(xyz_from_rgb(c)) - c).abs().max_element() < 4e-15 * c.length());
        }
    }
}
