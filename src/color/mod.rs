//! Color: linear Rec.709, signed Lab, color differences, spectra under an illuminant.
//!
//! One white point throughout: D65 as x = 0.3127, y = 0.3290, so that linear RGB (1, 1, 1), Lab (100, 0, 0) and the
//! perfect diffuser are the same color. Colors are [`glam::DVec3`]; the name of a function says which space.

mod difference;
mod emission;
mod gamut;
mod lab;
mod lab_f32;
mod observer;
mod response_curve;
mod rgb;
mod spectrum;
mod upsampling;
mod wavelengths;

pub use difference::{delta_e_76, delta_e_94, delta_e_2000};
pub use emission::{parse_emission, read_emission};
pub use gamut::into_gamut;
pub use lab::{lab_from_rgb, lab_from_xyz, rgb_from_lab, xyz_from_lab};
pub use lab_f32::{lab_from_rgb_f32, lab_planes_f32, rgb_from_lab_f32};
pub use observer::{BANDS, wavelength_nm};
pub use response_curve::ResponseCurve;
pub use rgb::{WHITE_XYZ, luminance, rgb_from_xyz, srgb_encode, xyz_from_rgb};
pub(crate) use spectrum::rgb_weights;
pub use spectrum::{Illuminant, Spectrum, bradford};
pub use upsampling::reflectance_of_rgb;
pub use wavelengths::Wavelengths;
