//! A calibration held against the truth, where that is known.

use super::calibration::Calibration;
use crate::math::projection::{Intrinsics, Projection};
use crate::measure::Rig;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Light at which responses are compared, shares of saturation: black to bright, evenly in its logarithm.
const LIGHTS: [f64; 2] = [1e-3, 0.9];
const STEPS: usize = 40;

/// The true dome.
pub struct CalibrationTruth<'a> {
    /// Lens of all cameras without zoom.
    pub wide: Intrinsics,
    /// The cameras at the zoom of the measurement.
    pub cameras: &'a [Projection],
    /// What a camera says of light in a channel; the unit of light is free.
    pub response: &'a dyn Fn(usize, usize, f64) -> f64,
    /// Light at which it says 1.
    pub saturation: &'a dyn Fn(usize, usize) -> f64,
}

/// Errors of one camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraErrors {
    /// The camera.
    pub camera: usize,
    /// Of its position, millimetres.
    pub position_mm: f64,
    /// Of its orientation, degrees.
    pub rotation_deg: f64,
    /// Position and orientation over their standard errors.
    pub over_expected: [f64; 2],
    /// Largest distance of corners and middle of the sample from where they are seen, pixels at zoom.
    pub sample_px: f64,
    /// Root mean square relative error of light through the response, 1e-3 to 0.9 of saturation, its unit fitted; a channel each.
    pub response: [f64; 3],
}

/// Errors of a calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibrationErrors {
    /// Of the common focal length, relative.
    pub wide_focal: f64,
    /// Of the calibrated cameras.
    pub cameras: Vec<CameraErrors>,
    /// Root mean squares over the cameras: position (mm), orientation (degrees), sample (pixels).
    pub rms: [f64; 3],
}

impl Calibration {
    /// Errors of the calibrated cameras; those without a truth are skipped.
    pub fn errors_against(&self, truth: &CalibrationTruth<'_>, rig: &Rig) -> CalibrationErrors {
        let cameras: Vec<CameraErrors> =
            (0..self.geometry.cameras.len()).filter_map(|k| self.camera_errors(k, truth, rig)).collect();
        let count = cameras.len().max(1) as f64;
        let rms = |of: fn(&CameraErrors) -> f64| {
            (cameras.iter().map(|c| of(c).powi(2)).sum::<f64>() / count).sqrt()
        };
        CalibrationErrors {
            wide_focal: self.geometry.wide.focal_px / truth.wide.focal_px - 1.0,
            rms: [rms(|c| c.position_mm), rms(|c| c.rotation_deg), rms(|c| c.sample_px)],
            cameras,
        }
    }

    fn camera_errors(&self, k: usize, truth: &CalibrationTruth<'_>, rig: &Rig) -> Option<CameraErrors> {
        let (found, quality, real) =
            (self.geometry.cameras[k]?, self.geometry.quality[k]?, truth.cameras.get(k)?);
        let position_mm = found.pose.position_mm.distance(real.pose.position_mm);
        let rotation_deg = found.pose.rotation.angle_between(real.pose.rotation).to_degrees();
        let half = 0.5 * DVec2::from(rig.sample_mm);
        let places = [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let apart = places.map(|s| {
            let place = (half * DVec2::from(s)).extend(0.0);
            found.pixel(place).zip(real.pixel(place)).map_or(f64::INFINITY, |(a, b)| a.distance(b))
        });
        Some(CameraErrors {
            camera: k,
            position_mm,
            rotation_deg,
            over_expected: [
                position_mm / quality.position_error_mm,
                rotation_deg / quality.rotation_error_deg,
            ],
            sample_px: apart.into_iter().fold(0.0, f64::max),
            response: [0, 1, 2].map(|c| self.response_error(k, c, truth)),
        })
    }

    fn response_error(&self, camera: usize, c: usize, truth: &CalibrationTruth<'_>) -> f64 {
        let response = self.responses[camera].as_ref();
        let Some(curve) = response.and_then(|r| r.curve().ok()) else { return f64::INFINITY };
        let [from, to] = LIGHTS.map(|share| (share * (truth.saturation)(camera, c)).ln());
        let logs: Vec<f64> = (0..STEPS)
            .map(|k| {
                let light = (from + (to - from) * k as f64 / (STEPS - 1) as f64).exp();
                (curve.exposure((truth.response)(camera, c, light), c) / light).ln()
            })
            .collect();
        let mean = logs.iter().sum::<f64>() / STEPS as f64;
        (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / STEPS as f64).sqrt()
    }
}
