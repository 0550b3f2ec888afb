//! A capture with its calibration: pictures as the sampling wants them.

use super::calibrate::Calibration;
use super::{Images, PairGeometry, Pairs};
use crate::error::Result;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Pictures, made linear and put in their place by a calibration.
pub struct Calibrated<'a> {
    images: &'a dyn Images,
    calibration: &'a Calibration,
    /// What was left out of each pair that was asked for.
    warnings: Mutex<BTreeMap<[usize; 2], Vec<String>>>,
}

impl<'a> Calibrated<'a> {
    /// The pictures of a dome with its calibration.
    pub fn new(images: &'a dyn Images, calibration: &'a Calibration) -> Self {
        Self { images, calibration, warnings: Mutex::default() }
    }

    /// Exposures that were left out of the pictures asked for so far, and why, in the order of camera and light.
    pub fn warnings(&self) -> Vec<String> {
        let warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        let one = |([camera, light], why): (&[usize; 2], &Vec<String>)| {
            format!("camera {camera}, light {light}: {}", why.join("; "))
        };
        warnings.iter().map(one).collect()
    }
}

impl Pairs for Calibrated<'_> {
    fn cameras(&self) -> usize {
        self.calibration.geometry.cameras.len()
    }

    fn geometry(&self, camera: usize, light: usize) -> Option<PairGeometry> {
        let cameras = &self.calibration.geometry.cameras;
        let (eye, flash) = ((*cameras.get(camera)?)?, (*cameras.get(light)?)?);
        Some(PairGeometry::new(eye, &self.images.rig().flash, &flash.pose))
    }

    fn size(&self) -> [usize; 2] {
        self.images.rig().image_px
    }

    fn radiance(&self, camera: usize, light: usize) -> Result<Vec<[f32; 3]>> {
        let picture = self.calibration.merge(self.images, camera, light)?;
        let known = picture.known();
        if !picture.warnings.is_empty() {
            let mut warnings = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
            warnings.insert([camera, light], picture.warnings);
        }
        Ok(known)
    }
}
