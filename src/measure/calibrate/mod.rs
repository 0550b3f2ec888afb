//! Calibration of a camera dome (Rump et al. 2008, sections 4.1 to 4.3).
//!
//! | step | what | where |
//! |---|---|---|
//! | [`CameraResponse`] | curve of every channel, noise, broken pixels, from gray fields | [`response`] |
//! | [`calibrate_geometry`] | diodes found and named; one lens for all without zoom, all poses; then each its own lens | [`geometry`] |
//! | [`merge_exposures`] | the exposures of a pair as one linear picture with its variance; those that contradict left out | [`hdr`] |
//! | [`white_scale`], [`factorize`] | radiance per flash intensity by the white targets; gains and lights as the check | [`white`], [`factors`] |
//! | [`reflection`](reflection()) | where the flash should be seen mirrored, drawn over the picture | [`mod@reflection`] |
//! | [`calibrate`], [`Calibration::merge`] | all of it | `calibration` |
//!
//! A plate that looks the same turned by a quarter does not tell cameras apart that are swapped within a ring by a quarter of it:
//! the white targets do, and reciprocity tells flashes that are swapped (`exchanged`).

mod bundle;
mod calibration;
mod decoder;
mod exchanged;
mod exposures;
pub mod factors;
mod field;
pub mod geometry;
pub mod hdr;
mod homography;
mod identify;
mod leds;
pub mod reflection;
pub mod response;
mod smooth_curve;
#[cfg(test)]
mod synthetic;
pub mod truth;
pub mod white;
mod zhang;
mod zoom;

pub use calibration::{Calibration, calibrate};
pub use decoder::Decoder;
pub use factors::{WhiteFactors, factorize};
pub use geometry::{CameraQuality, GeometryCalibration, LeftOut, calibrate_geometry};
pub use hdr::{HdrPicture, PixelState, merge_exposures};
pub use reflection::{Reflection, reflection};
pub use response::{CameraResponse, SensorNoise};
pub use truth::{CalibrationErrors, CalibrationTruth, CameraErrors};
pub use white::{TargetReading, WhiteScale, white_scale};
