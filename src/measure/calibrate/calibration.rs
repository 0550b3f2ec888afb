//! The calibration of a dome: geometry, responses, and pictures made linear with them.

use super::decoder::Decoder;
use super::geometry::{GeometryCalibration, LeftOut, calibrate_geometry, departure};
use super::hdr::{HdrPicture, merge_exposures};
use super::response::{CameraResponse, quantum};
use super::white::white_scale;
use crate::error::{Error, Result};
use crate::file::check_kind;
use crate::math::projection::Projection;
use crate::measure::{Images, Picture, Rig};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Kind of the JSON.
const KIND: &str = "calibration";
/// Version of the layout.
const VERSION: u64 = 1;

/// All that is measured of a dome before the paint is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Places and lenses. Cameras without a response are left out, too.
    pub geometry: GeometryCalibration,
    /// Response and noise of every camera that has one.
    pub responses: Vec<Option<CameraResponse>>,
}

/// Calibrates the dome of `images`: the response of every camera first, which makes the pictures of the diodes linear.
/// `tick` is called [`Calibration::ticks`] times. Once there are pictures of the sample, [`Calibration::leave_out_exchanged`] looks
/// for what diodes do not tell.
///
/// The same bits for any number of threads, each of which has one picture in memory.
///
/// # Errors
/// A rig that is not legal; fewer than two cameras that can be calibrated.
pub fn calibrate(images: &dyn Images, tick: &(dyn Fn() + Sync)) -> Result<Calibration> {
    images.rig().validate()?;
    let step = quantum(images.rig());
    let one = |camera: usize| {
        let measured = CameraResponse::measure(images, camera);
        tick();
        measured.and_then(|response| Ok((Decoder::new(&response, step)?, response)))
    };
    let measured: Vec<Result<(Decoder, CameraResponse)>> =
        (0..images.rig().cameras.len()).into_par_iter().map(one).collect();
    let to_light = |camera: usize, picture: &Picture| match &measured[camera] {
        Ok((decoder, _)) => decoder.mean_light(picture),
        Err(_) => (picture.pixels.iter().map(|p| p.iter().sum::<f32>() / 3.0).collect(), 1.0),
    };
    let mut geometry = calibrate_geometry(images, &to_light, tick)?;
    for (camera, measured) in measured.iter().enumerate() {
        if let Err(e) = measured {
            geometry.leave_out(LeftOut { camera, reason: e.to_string() });
        }
    }
    for camera in 0..images.rig().cameras.len() {
        let pose = geometry.cameras[camera].map(|c| c.pose);
        if let Some(Err(e)) = pose.map(|pose| images.rig().flash.check_above(&pose)) {
            geometry.leave_out(LeftOut { camera, reason: e.to_string() });
        }
    }
    let responses = measured.into_iter().map(|m| m.ok().map(|(_, response)| response)).collect();
    geometry.check_enough("at least 2 with a response")?;
    Ok(Calibration { geometry, responses })
}

impl Calibration {
    /// How often [`calibrate`] calls its `tick` at most.
    pub fn ticks(rig: &Rig) -> usize {
        3 * rig.cameras.len()
    }

    /// A camera that was calibrated.
    ///
    /// # Errors
    /// It was left out: the reason.
    pub fn camera(&self, camera: usize) -> Result<&Projection> {
        self.geometry.cameras.get(camera).and_then(Option::as_ref).ok_or_else(|| {
            let reason = self.geometry.left_out.iter().find(|l| l.camera == camera).map(|l| l.reason.clone());
            let found = reason.unwrap_or_else(|| "no such camera".to_owned());
            Error::invalid("calibration", format!("camera {camera}"), found, "one that was calibrated")
        })
    }

    /// The picture of a pair, linear and in white balance: radiance per intensity of the flash, 1/mm^2. All its exposures are in
    /// memory meanwhile.
    ///
    /// # Errors
    /// Camera or light was not calibrated; no exposure can be read; white targets that cannot be read or contradict each other.
    pub fn merge(&self, images: &dyn Images, camera: usize, light: usize) -> Result<HdrPicture> {
        let (eye, flash) = (self.camera(camera)?, self.camera(light)?);
        let picture = self.linear(images, camera, light)?;
        let white = white_scale(&picture, eye, &flash.pose, images.rig())?;
        Ok(picture.balanced(white))
    }

    /// The same before white balance.
    ///
    /// # Errors
    /// The camera has no response; no exposure can be read.
    pub(super) fn linear(&self, images: &dyn Images, camera: usize, light: usize) -> Result<HdrPicture> {
        let response = self.responses.get(camera).and_then(Option::as_ref);
        let response = response.ok_or_else(|| {
            Error::invalid("calibration", format!("response of camera {camera}"), "none", "a measured one")
        })?;
        let decoder = Decoder::new(response, quantum(images.rig()))?;
        merge_exposures(images, response, &decoder, camera, light)
    }

    /// Checks that this is a calibration of a dome, as far as nominal numbers say.
    ///
    /// # Errors
    /// Another number of cameras; a camera far from its nominal place; a flash that is not above the sample.
    pub fn check_rig(&self, rig: &Rig) -> Result<()> {
        let (found, cameras) = (self.geometry.cameras.len(), rig.cameras.len());
        if found != cameras {
            return Err(Error::invalid("calibration", "cameras", found, format!("{cameras} (capture.json)")));
        }
        for (k, (camera, nominal)) in self.geometry.cameras.iter().zip(&rig.cameras).enumerate() {
            let Some(camera) = camera else { continue };
            let place = format!("calibration: cameras[{k}]");
            if let Some(found) = departure(&camera.pose, nominal) {
                return Err(Error::invalid(place, "pose", found, "that of this capture's dome"));
            }
            rig.flash.check_above(&camera.pose).map_err(|e| e.within(place))?;
        }
        Ok(())
    }

    /// As JSON.
    pub fn to_json(&self) -> String {
        format!("{}\n", json!({ "kind": KIND, "version": VERSION, "calibration": self }))
    }

    /// From JSON.
    ///
    /// # Errors
    /// Not JSON, another kind or a newer version, unknown or missing keys, responses that are no curves, lists of different lengths.
    pub fn from_json(text: &str) -> Result<Self> {
        let wrong =
            |e: &dyn std::fmt::Display| Error::invalid("", "calibration", e, "the keys of this version");
        let mut value: Value = serde_json::from_str(text).map_err(|e| wrong(&e))?;
        check_kind(&value, KIND, VERSION)?;
        let inner = value.get_mut("calibration").map(Value::take).unwrap_or_default();
        let calibration: Self =
            serde_path_to_error::deserialize(inner).map_err(|e| wrong(&e).within("calibration"))?;
        calibration.validate()?;
        Ok(calibration)
    }

    fn validate(&self) -> Result<()> {
        let number = self.geometry.cameras.len();
        if [self.responses.len(), self.geometry.quality.len()].iter().any(|n| *n != number) {
            let found = format!("{} and {}", self.responses.len(), self.geometry.quality.len());
            return Err(Error::invalid(
                "calibration",
                "responses and qualities",
                found,
                format!("{number} each"),
            ));
        }
        for (k, camera) in self.geometry.cameras.iter().enumerate() {
            let is_legal = camera.is_none_or(|c| {
                c.intrinsics.focal_px > 0.0 && c.pose.position_mm.z > 0.0 && c.pose.rotation.is_normalized()
            });
            if !is_legal {
                let place = format!("calibration: cameras[{k}]");
                return Err(Error::invalid(place, "camera", format!("{camera:?}"), "one above the sample"));
            }
        }
        let check = |(k, response): (usize, &CameraResponse)| {
            response.validate().map_err(|e| e.within(format!("responses[{k}]")))
        };
        self.responses.iter().enumerate().filter_map(|(k, r)| r.as_ref().map(|r| (k, r))).try_for_each(check)
    }
}

#[cfg(test)]
mod tests {
    use super::super::factors::factorize;
    use super::super::reflection::reflection;
    use super::super::synthetic::SyntheticDome;
    use super::super::truth::CalibrationTruth;
    use super::*;
    use crate::measure::Shot;
    use crate::measure::highlight::Highlight;
    use glam::DVec2;
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn dome() -> SyntheticDome {
        SyntheticDome { read: 1e-4, electrons: 40_000.0, levels: 4095.0, ..SyntheticDome::new(5) }
    }

    fn calibrated() -> &'static Calibration {
        static CALIBRATED: OnceLock<Calibration> = OnceLock::new();
        CALIBRATED.get_or_init(|| calibrate(&dome(), &|| ()).unwrap())
    }

    #[test]
    fn a_dome_is_calibrated_and_its_pictures_say_brdfs() {
        let mut dome = dome();
        dome.instead = |dome, shot| match shot {
            // A camera without response.
            Shot::Response { camera: 4, .. } => {
                dome.honest(Shot::Response { camera: 4, step: 13 }).map(Ok).ok()
            }
            _ => None,
        };
        let ticks = AtomicUsize::new(0);
        let found = calibrate(&dome, &|| _ = ticks.fetch_add(1, Ordering::Relaxed)).unwrap();
        assert_eq!(ticks.into_inner(), Calibration::ticks(&dome.rig));
        assert_eq!(Calibration::from_json(&found.to_json()).unwrap(), found);

        let response = |camera: usize, c: usize, light: f64| dome.response(camera, c, light);
        let truth = CalibrationTruth {
            wide: dome.wide,
            cameras: &dome.cameras,
            response: &response,
            saturation: &|_, _| 1.0,
        };
        let errors = found.errors_against(&truth, &dome.rig);
        assert_eq!(errors.cameras.len(), 4);
        for camera in &errors.cameras {
            // The bounds of `geometry` and `response`: four standard errors, a tenth of a pixel, parts of a thousand.
            assert!(camera.over_expected.iter().all(|z| *z < 4.0) && camera.sample_px < 0.1, "{camera:?}");
            assert!(camera.response.iter().all(|r| *r < 3e-3), "{camera:?}");
        }
        let mut scales = Vec::new();
        for (camera, light) in [(0, 1), (0, 2), (1, 2), (2, 1), (3, 0)] {
            let picture = found.merge(&dome, camera, light).unwrap();
            scales.push((camera, light, picture.white.as_ref().unwrap().scale));
            for (x, y) in [(-6.0, 3.0), (-1.0, -5.0), (6.0, 0.0)] {
                let pixel = dome.cameras[camera].pixel(DVec2::new(x, y).extend(0.0)).unwrap();
                let k = pixel.y as usize * 256 + pixel.x as usize;
                let center = DVec2::new(pixel.x.floor() + 0.5, pixel.y.floor() + 0.5);
                for c in 0..3 {
                    let off = f64::from(picture.pixels[k][c]) / dome.radiance(camera, light, center)[c] - 1.0;
                    let sigma = f64::from(picture.variance[k][c]).sqrt() / f64::from(picture.pixels[k][c]);
                    // A pixel's noise, and a percent of response and standards.
                    assert!(off.abs() < 4.5 * sigma + 0.01, "{camera} {light} {c}: {off} {sigma}");
                }
            }
        }
        let factors = factorize(&scales, 5);
        // Energies are 2 % off, unlike for every exposure.
        assert!(factors.outliers.is_empty() && factors.rms.iter().all(|r| *r < 0.02), "{:?}", factors.rms);
        let message = found.merge(&dome, 4, 0).unwrap_err().to_string();
        assert!(message.contains("camera 4: found") && message.contains("gray fields"), "{message}");
    }

    #[test]
    fn broken_files_are_refused() {
        let found = calibrated().clone();
        let text = found.to_json();
        let message = |text: &str| Calibration::from_json(text).unwrap_err().to_string();
        assert!(message("{").contains("calibration"));
        assert!(
            message(&text.replace("\"calibration\",", "\"paint\",")).contains("kind of file: found paint")
        );
        assert!(message(&text.replacen("\"shot\":[", "\"shot\":[-1,", 1)).contains("shot"));
        assert!(message(&text.replacen("\"geometry\"", "\"geometri\"", 1)).contains("geometri"));
        let mut other = found.clone();
        other.responses.pop();
        assert!(message(&other.to_json()).contains("found 4 and 5"));
        let mut other = found;
        other.responses[2].as_mut().unwrap().says[9] = [0.9; 3];
        assert!(message(&other.to_json()).contains("responses[2]: knot 10"));
    }

    #[test]
    fn the_mirrored_flash_is_where_light_is_reflected() {
        // Camera 0 above and the flash of a camera mirrored about it: the middle of the sample.
        let dome = dome();
        let eye = dome.cameras[1];
        let mut flash = eye.pose;
        // Turned about the normal by half a circle, the flash stands where the eye looks when mirrored.
        flash.position_mm =
            glam::DVec3::new(-eye.pose.position_mm.x, -eye.pose.position_mm.y, eye.pose.position_mm.z);
        flash.rotation = eye.pose.rotation * glam::DQuat::from_rotation_z(std::f64::consts::PI);
        let rig = Rig {
            flash: crate::measure::Flash { offset_mm: [0.0; 2], ..dome.rig.flash },
            ..dome.rig.clone()
        };
        let seen = reflection(&eye, &flash, &rig).unwrap();
        // The window is centered on the center of projection, which is mirrored at the origin; perspective moves the mean.
        let origin = eye.pixel(glam::DVec3::ZERO).unwrap();
        assert!(seen.distance_px(origin) < 3.0, "{:?} {origin}", seen.center_px);
        assert_eq!(seen.points_px.len(), 8);
        assert_eq!(reflection(&eye, &dome.cameras[1].pose, &rig), None, "its own flash lies elsewhere");
        let picture = calibrated().merge(&dome, 1, 2).unwrap();
        // A highlight of 3 x 3 pixels elsewhere, three times as large.
        let corner = (origin + 20.0).floor();
        let pixels = (0..9).map(|k| (corner.y as u32 + k / 3) * 256 + corner.x as u32 + k % 3).collect();
        let found = Highlight { center_px: corner + 1.5, area_px: 9, pixels };
        let drawn = seen.overlay(&picture, Some(&found), 3);
        assert_eq!(drawn.len(), 9 * 65_536);
        let at = |p: DVec2| drawn[(3.0 * p.y) as usize * 768 + (3.0 * p.x) as usize];
        assert_eq!(at(seen.center_px.into()), [255, 40, 40]);
        assert!(seen.points_px.iter().all(|p| at((*p).into()) == [255, 40, 40]));
        assert_eq!([at(found.center_px), at(corner), at(corner + 2.9)], [[60, 255, 60]; 3]);
        let inside = corner + 1.1;
        assert_ne!(at(inside), [60, 255, 60], "the rim is a line, the highlight is seen within it");
    }
}
