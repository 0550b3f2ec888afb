//! A capture with its calibration: pictures as the sampling wants them.

use super::calibrate::Calibration;
use super::{Images, PairGeometry, Pairs};
use crate::error::Result;

/// Pictures, made linear and put in their place by a calibration.
pub struct Calibrated<'a> {
    images: &'a dyn Images,
    calibration: &'a Calibration,
}

impl<'a> Calibrated<'a> {
    /// The pictures of a dome with its calibration.
    pub fn new(images: &'a dyn Images, calibration: &'a Calibration) -> Self {
        Self { images, calibration }
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
        Ok(self.calibration.merge(self.images, camera, light)?.known())
    }
}
