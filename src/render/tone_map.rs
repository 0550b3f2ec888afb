//! From linear light to what a screen is told.

use crate::color::{ResponseCurve, srgb_encode};

/// How linear Rec.709 becomes codes of 0 to 1.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ToneMap {
    /// Clipped to [0, 1] and encoded as sRGB: what is seen is the light itself.
    #[default]
    Srgb,
    /// What a camera of this response would have written (Rump et al. 2008, section 6).
    Camera(ResponseCurve),
}

impl ToneMap {
    /// The code, 0 to 1, of linear light in channel 0 to 2.
    pub fn code(&self, light: f64, channel: usize) -> f64 {
        match self {
            Self::Srgb => srgb_encode(light.clamp(0.0, 1.0)),
            Self::Camera(curve) => curve.response(light, channel),
        }
    }
}
