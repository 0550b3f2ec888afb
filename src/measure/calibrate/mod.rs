//! Calibration of a camera dome (Rump et al. 2008, sections 4.1 to 4.3).

mod bundle;
mod calibration;
mod decoder;
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
