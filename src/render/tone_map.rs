//! From linear light to what a screen is told.

use crate::color::{ResponseCurve, into_gamut, srgb_encode};
use glam::DVec3;

/// How linear Rec.709 becomes codes of 0 to 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ToneMap {
    /// Clipped to [0, 1] and encoded as sRGB: what is seen is the light itself.
    #[default]
    Srgb,
    /// Brought into the gamut of sRGB by [`into_gamut`], hue and luminance kept, and encoded.
    InGamut,
    /// What a camera of this response would have written (Rump et al. 2008, section 6).
    Camera(ResponseCurve),
}

impl ToneMap {
    /// The codes, 0 to 1, of linear light.
    pub fn code(&self, light: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Srgb => light.map(|c| srgb_encode(c.clamp(0.0, 1.0))),
            Self::InGamut => into_gamut(DVec3::from(light)).to_array().map(srgb_encode),
            Self::Camera(curve) => [0, 1, 2].map(|c| curve.response(light[c], c)),
        }
    }
}
