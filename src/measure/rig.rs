//! What is known of a camera dome before it is calibrated.
//!
//! N cameras, each with its flash, look at a planar sample in the plane z = 0, about the origin; its film side is z > 0. White
//! targets lie beside the sample in the same plane. For calibration a plate of light-emitting diodes lies there instead.

use crate::check::range;
use crate::error::{Error, Result};
use crate::math::projection::Pose;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// A camera dome as designed: nominal numbers, which calibration replaces by measured ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// Columns and rows of every picture, 16 to 8192.
    pub image_px: [usize; 2],
    /// What a saturated pixel says; pictures hold 0 to this.
    pub white_level: f64,
    /// Where the cameras were meant to stand, 2 to 1000; correct to some degrees.
    pub cameras: Vec<Pose>,
    /// Nominal focal length without zoom, pixels.
    pub focal_wide_px: f64,
    /// Nominal focal length at the zoom of the measurement, pixels.
    pub focal_zoom_px: f64,
    /// The flash of every camera.
    pub flash: Flash,
    /// The exposures of every pair of camera and light, 1 to 16.
    pub exposures: Vec<Exposure>,
    /// Relative exposure times of the response series, ascending; pictures of an evenly lit gray field.
    pub response_series: Vec<f64>,
    /// White reflectance standards beside the sample, 1 to 64.
    pub white_targets: Vec<WhiteTarget>,
    /// Places of the diodes in the plane z = 0, millimetres, 4 to 10,000; row after row.
    pub leds_mm: Vec<[f64; 2]>,
    /// Width (x) and height (y) of the sample, millimetres.
    pub sample_mm: [f64; 2],
}

/// The window of a flash in the frame of its camera (x to the right, y down, z forward), facing forward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flash {
    /// Middle of the window from the center of projection, millimetres.
    pub offset_mm: [f64; 2],
    /// Width and height, millimetres.
    pub size_mm: [f64; 2],
    /// Points along width and height that stand for it (Rump et al. 2008: 90 in all); 1 to 100 each.
    pub points: [usize; 2],
}

/// One of the exposures of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exposure {
    /// Setting of the flash (Rump et al. 2008: FQ).
    pub flash_quantity: u32,
    /// Sensitivity of the sensor.
    pub iso: u32,
    /// Nominal light collected by the sensor times its gain, relative to the other exposures.
    pub relative: f64,
}

/// A square of known diffuse reflectance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhiteTarget {
    /// Its middle, millimetres.
    pub center_mm: [f64; 2],
    /// Its side, millimetres.
    pub side_mm: f64,
    /// Its reflectance, 0.001 to 1.
    pub reflectance: f64,
}

impl Flash {
    /// The points of the window of a camera in this pose, world coordinates, millimetres: cell centers, row after row.
    pub fn points_mm(&self, pose: &Pose) -> Vec<DVec3> {
        let [columns, rows] = self.points;
        let at = |k: usize, axis: usize| {
            let share = (k as f64 + 0.5) / self.points[axis] as f64 - 0.5;
            self.offset_mm[axis] + share * self.size_mm[axis]
        };
        (0..columns * rows)
            .map(|k| pose.world(DVec3::new(at(k % columns, 0), at(k / columns, 1), 0.0)))
            .collect()
    }

    /// The corners of the window of a camera in this pose, in turn, world coordinates, millimetres.
    pub fn corners_mm(&self, pose: &Pose) -> [DVec3; 4] {
        [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|share| {
            let local = DVec2::from(self.offset_mm) + DVec2::from(share) * DVec2::from(self.size_mm);
            pose.world(local.extend(0.0))
        })
    }

    /// Checks that the whole window of a camera in this pose shines on the film side of the sample.
    ///
    /// # Errors
    /// A corner that is not above the sample.
    pub fn check_above(&self, pose: &Pose) -> Result<()> {
        let lowest = self.corners_mm(pose).iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        if lowest > 0.0 {
            return Ok(());
        }
        let found = format!("one {lowest:.1} mm above the sample");
        Err(Error::invalid(
            "",
            "lowest corner of the flash",
            found,
            "all above it (flash: offset_mm, size_mm)",
        ))
    }

    /// The middle of the window of a camera in this pose, world coordinates, millimetres.
    pub fn middle_mm(&self, pose: &Pose) -> DVec3 {
        pose.world(DVec2::from(self.offset_mm).extend(0.0))
    }
}

impl Rig {
    /// Largest side of a picture, pixels.
    pub const MAX_SIDE: usize = 8192;

    /// Checks every number.
    ///
    /// # Errors
    /// A number outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        for side in self.image_px {
            if !(16..=Self::MAX_SIDE).contains(&side) {
                return Err(Error::invalid("rig", "image_px", side, "16 to 8192"));
            }
        }
        range("rig", "number of cameras", self.cameras.len(), 2..=1000)?;
        range("rig", "number of exposures", self.exposures.len(), 1..=16)?;
        range("rig", "number of response_series", self.response_series.len(), 3..=64)?;
        range("rig", "number of white_targets", self.white_targets.len(), 1..=64)?;
        range("rig", "number of leds_mm", self.leds_mm.len(), 4..=10_000)?;
        for axis in 0..2 {
            range("rig", "flash: points", self.flash.points[axis], 1..=100)?;
            range("rig", "flash: offset_mm", self.flash.offset_mm[axis], -1e4..=1e4)?;
            range("rig", "flash: size_mm", self.flash.size_mm[axis], 1e-3..=1e4)?;
            range("rig", "sample_mm", self.sample_mm[axis], 1e-3..=1e4)?;
        }
        range("rig", "white_level", self.white_level, 1.0..=1e9)?;
        range("rig", "focal_wide_px", self.focal_wide_px, 1.0..=1e7)?;
        range("rig", "focal_zoom_px", self.focal_zoom_px, 1.0..=1e7)?;
        for (k, pose) in self.cameras.iter().enumerate() {
            let away = pose.position_mm.length() <= 1e7 && pose.position_mm.z >= 1.0;
            let place = format!("rig: cameras[{k}]");
            if !away || (pose.rotation.length() - 1.0).abs() > 1e-6 {
                let legal = "at least 1 mm above the sample, with a unit quaternion";
                return Err(Error::invalid(place, "pose", format!("{pose:?}"), legal));
            }
            self.flash.check_above(pose).map_err(|e| e.within(place))?;
        }
        self.exposures
            .iter()
            .try_for_each(|e| range("rig", "exposures: relative", e.relative, 1e-12..=1e12))?;
        self.response_series.iter().try_for_each(|t| range("rig", "response_series", *t, 1e-12..=1e12))?;
        if self.response_series.windows(2).any(|pair| pair[0] >= pair[1]) {
            let found = format!("{:?}", self.response_series);
            return Err(Error::invalid("rig", "response_series", found, "ascending times"));
        }
        for target in &self.white_targets {
            target
                .center_mm
                .iter()
                .try_for_each(|x| range("rig", "white_targets: center_mm", *x, -1e4..=1e4))?;
            range("rig", "white_targets: side_mm", target.side_mm, 1e-3..=1e4)?;
            range("rig", "white_targets: reflectance", target.reflectance, 1e-3..=1.0)?;
        }
        self.leds_mm.iter().flatten().try_for_each(|x| range("rig", "leds_mm", *x, -1e4..=1e4))
    }
}
