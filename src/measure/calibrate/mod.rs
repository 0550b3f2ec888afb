//! Calibration of a camera dome (Rump et al. 2008, sections 4.1 to 4.3).

mod bundle;
pub mod geometry;
mod homography;
mod identify;
mod leds;
#[cfg(test)]
mod synthetic;
mod zhang;
mod zoom;

pub use geometry::{CameraQuality, GeometryCalibration, LeftOut, calibrate_geometry};
