//! Where the cameras stand, and their lenses, from pictures of a plate of diodes (Rump et al. 2008, section 4.1).
//!
//! A planar target does not give pose and lens of a single camera: facing it, a longer lens is a larger distance. So, in two
//! steps: without zoom all cameras share one lens, which the tilted ones determine, and every pose follows; with zoom the poses
//! stand and every camera gets its own lens. The plate is the world: poses are absolute.

use super::bundle::{Bundle, View};
use super::homography::homography;
use super::identify::{MIN_DIODES, Named, Plate};
use super::leds::{Spots, find_spots};
use super::zhang;
use super::zoom::{SIGNIFICANT, fit_lens};
use crate::error::{Error, Result};
use crate::math::projection::{Intrinsics, Pose, Projection};
use crate::measure::{Images, Picture, Rig, Shot};
use glam::{DMat3, DVec2};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How far a camera may stand from its nominal place, as a share of its distance, and be turned, radians: 3 degrees.
const MAX_DEPARTURE: f64 = 0.05;
/// Least standard deviation of a pixel coordinate, so that exact data have finite weights.
const MIN_SIGMA_PX: f64 = 1e-3;
/// Rounds of weights and outliers.
const ROUNDS: usize = 3;
/// So many cameras' reasons are given where too few are left.
const REASONS: usize = 3;
/// A picture with zoom that fits the pose found without worse than this, pixels, and than this many times the picture without zoom,
/// is not seen from there: a diode was taken for another, or the camera was moved. Exact poses miss by less than .1.
const MAX_ZOOM_RMS_PX: f64 = 0.5;
const MAX_ZOOM_RMS: f64 = 10.0;
/// Largest relative standard error of the common focal length.
const MAX_FOCAL_ERROR: f64 = 0.05;

/// The calibrated dome.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GeometryCalibration {
    /// The lens of all cameras without zoom.
    pub wide: Intrinsics,
    /// Lens at the zoom of the measurement and pose of every camera; `None` for those left out.
    pub cameras: Vec<Option<Projection>>,
    /// How well each is known.
    pub quality: Vec<Option<CameraQuality>>,
    /// The others.
    pub left_out: Vec<LeftOut>,
}

/// How well a camera is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraQuality {
    /// Diodes used, without and with zoom.
    pub diodes: [usize; 2],
    /// Root mean square reprojection error, without and with zoom, pixels.
    pub rms_px: [f64; 2],
    /// Standard error of the position, all three directions together, millimetres.
    pub position_error_mm: f64,
    /// Standard error of the orientation, all three axes together, degrees.
    pub rotation_error_deg: f64,
    /// Standard error of the focal length at zoom, pixels, for this pose.
    pub focal_error_px: f64,
}

/// A camera without calibration.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// The camera.
    pub camera: usize,
    /// What is wrong with it.
    pub reason: String,
}

impl GeometryCalibration {
    /// Takes a camera out, unless it is out.
    pub fn leave_out(&mut self, left_out: LeftOut) {
        let camera = left_out.camera;
        if self.cameras.get(camera).is_some_and(Option::is_some) {
            (self.cameras[camera], self.quality[camera]) = (None, None);
            self.left_out.push(left_out);
            self.left_out.sort_by_key(|l| l.camera);
        }
    }

    /// Checks that at least two cameras are left.
    ///
    /// # Errors
    /// Fewer are: why the others are not there.
    pub(super) fn check_enough(&self, legal: &str) -> Result<()> {
        match self.cameras.iter().flatten().count() {
            0 | 1 => Err(too_few(&self.left_out, legal)),
            _ => Ok(()),
        }
    }
}

/// Too few cameras could be calibrated: of the first, why not.
fn too_few(left_out: &[LeftOut], legal: &str) -> Error {
    let reasons: Vec<String> =
        left_out.iter().take(REASONS).map(|l| format!("camera {}: {}", l.camera, l.reason)).collect();
    let more = left_out.len().saturating_sub(REASONS);
    let rest = if more > 0 { format!("; and {more} more") } else { String::new() };
    Error::invalid("calibration", "cameras", reasons.join("; ") + &rest, legal)
}

/// Linear light of the pixels of a camera's picture, and that of a saturated pixel.
pub type ToLight<'a> = &'a (dyn Fn(usize, &Picture) -> (Vec<f32>, f32) + Sync);

/// Calibrates the dome of `images`; `tick` is called twice a camera.
///
/// # Errors
/// Fewer than two cameras could be calibrated (their reasons are given); all face the plate, so that nothing determines the
/// common focal length.
pub fn calibrate_geometry(
    images: &dyn Images,
    to_light: ToLight<'_>,
    tick: &(dyn Fn() + Sync),
) -> Result<GeometryCalibration> {
    let rig = images.rig();
    rig.validate()?;
    let session = Session { images, rig, to_light, plate: Plate::new(&rig.leds_mm), tick };
    let (mut cameras, mut left_out) = session.wide_views();
    let bundle = session.common_lens(&mut cameras, &mut left_out)?;
    session.zoom(&cameras, bundle, left_out)
}

struct Session<'a> {
    images: &'a dyn Images,
    rig: &'a Rig,
    to_light: ToLight<'a>,
    plate: Plate,
    tick: &'a (dyn Fn() + Sync),
}

impl Session<'_> {
    /// What every camera sees of the plate without zoom, and who sees nothing or something else.
    fn wide_views(&self) -> (Vec<(usize, View)>, Vec<LeftOut>) {
        let spots: Vec<Result<Spots>> = (0..self.rig.cameras.len())
            .into_par_iter()
            .map(|camera| self.spots(camera, Shot::LedsWide { camera }))
            .collect();
        let named: Vec<Option<Named>> = spots
            .par_iter()
            .enumerate()
            .map(|(camera, spots)| self.plate.name(&spots.as_ref().ok()?.centers_px, &self.nominal(camera)))
            .collect();
        let view = |(camera, named): (usize, &Option<Named>)| {
            let seen = self.seen(named.as_ref()?);
            Some((camera, View { seen, pose: self.rig.cameras[camera], weight: 1.0 }))
        };
        let views = named.iter().enumerate().filter_map(view).collect();
        let strangers: Vec<usize> = (0..named.len()).filter(|camera| named[*camera].is_none()).collect();
        let reason = |camera: &usize| {
            let reason = match &spots[*camera] {
                Err(e) => e.to_string(),
                Ok(spots) if spots.centers_px.len() < MIN_DIODES => {
                    let (n, all) = (spots.centers_px.len(), self.plate.leds_mm.len());
                    format!("sees {n} of {all} diodes, too few ({} were rejected)", spots.rejected)
                }
                Ok(spots) => self.whose(*camera, spots, &strangers),
            };
            LeftOut { camera: *camera, reason }
        };
        (views, strangers.iter().map(reason).collect())
    }

    /// Whose nominal place fits a picture that does not fit that of its own camera.
    fn whose(&self, camera: usize, spots: &Spots, strangers: &[usize]) -> String {
        let others: Vec<usize> = (0..self.rig.cameras.len()).filter(|other| *other != camera).collect();
        let fits = |other: &usize| {
            let named = self.plate.name(&spots.centers_px, &self.nominal(*other))?;
            // Of places that a symmetric plate does not tell apart, rather one whose own picture does not fit it, either.
            Some((strangers.contains(other), named.len(), std::cmp::Reverse(*other)))
        };
        let best = others.par_iter().filter_map(fits).max();
        let (n, rejected) = (spots.centers_px.len(), spots.rejected);
        best.map_or(
            format!("its {n} spots fit no nominal place ({rejected} were rejected)"),
            |(_, n, other)| {
                format!("its picture fits the nominal place of camera {} instead ({n} diodes)", other.0)
            },
        )
    }

    fn nominal(&self, camera: usize) -> Projection {
        let intrinsics = Intrinsics::pinhole(self.rig.focal_wide_px, self.rig.image_px);
        Projection { intrinsics, pose: self.rig.cameras[camera] }
    }

    fn spots(&self, camera: usize, shot: Shot) -> Result<Spots> {
        let picture = self.images.picture(shot);
        (self.tick)();
        let picture = picture?;
        let (light, saturation) = (self.to_light)(camera, &picture);
        Ok(find_spots(&light, picture.size, saturation))
    }

    fn seen(&self, named: &Named) -> Vec<(DVec2, DVec2)> {
        named.iter().map(|(led, pixel)| (self.plate.leds_mm[*led], *pixel)).collect()
    }

    /// Step I: cameras that end far from where they should be are left out.
    fn common_lens(&self, cameras: &mut Vec<(usize, View)>, left_out: &mut Vec<LeftOut>) -> Result<Bundle> {
        let nominal = Intrinsics::pinhole(self.rig.focal_wide_px, self.rig.image_px);
        let homographies: Vec<DMat3> =
            cameras.iter().filter_map(|(_, view)| homography(&view.seen)).collect();
        let lens = zhang::common_lens(&homographies, nominal);
        for (_, view) in cameras.iter_mut() {
            let pose = homography(&view.seen).and_then(|h| zhang::pose(h, &lens));
            view.pose = pose.unwrap_or(view.pose);
        }
        let mut bundle = self.fit_common(lens, cameras, left_out)?;
        let mut departed = Vec::new();
        for ((camera, _), view) in cameras.iter().zip(&bundle.views) {
            departed.extend(
                departure(&view.pose, &self.rig.cameras[*camera])
                    .map(|reason| LeftOut { camera: *camera, reason }),
            );
        }
        if !departed.is_empty() {
            cameras.retain(|(camera, _)| departed.iter().all(|d| d.camera != *camera));
            left_out.extend(departed);
            bundle = self.fit_common(bundle.lens, cameras, left_out)?;
        }
        Ok(bundle)
    }

    fn fit_common(
        &self,
        lens: Intrinsics,
        cameras: &[(usize, View)],
        left_out: &[LeftOut],
    ) -> Result<Bundle> {
        if cameras.len() < 2 {
            return Err(too_few(left_out, "at least 2 that see the plate"));
        }
        let views = cameras.iter().map(|(_, view)| view.clone()).collect();
        let mut bundle = Bundle { lens, views, lens_numbers: 3 };
        bundle.descend();
        for _ in 0..ROUNDS {
            for view in &mut bundle.views {
                view.drop_outliers(&bundle.lens);
                view.weight = 1.0 / view.variance(&bundle.lens, 6).max(MIN_SIGMA_PX * MIN_SIGMA_PX);
            }
            bundle.descend();
            bundle = with_distortion(bundle);
        }
        let error =
            bundle.covariance().map_or(f64::INFINITY, |c| c.lens[(0, 0)].sqrt() / bundle.lens.focal_px);
        if error > MAX_FOCAL_ERROR {
            let found = format!("known to {:.0} %", 100.0 * error);
            return Err(Error::not_converged(
                "calibration",
                "common focal length",
                found,
                "to 5 %: tilted cameras",
            ));
        }
        Ok(bundle)
    }

    /// Step II.
    fn zoom(
        &self,
        cameras: &[(usize, View)],
        bundle: Bundle,
        mut left_out: Vec<LeftOut>,
    ) -> Result<GeometryCalibration> {
        let covariance = bundle.covariance();
        let one = |k: usize| {
            let (camera, view) = (cameras[k].0, &bundle.views[k]);
            let (projection, view_zoom, focal_error_px) = self.zoom_lens(camera, &bundle.lens, view.pose)?;
            // The root of the sum of variances: turn first, then position.
            let error = |from: usize| {
                let variance =
                    |c: &super::bundle::Covariance| (from..from + 3).map(|j| c.poses[k][(j, j)]).sum::<f64>();
                covariance.as_ref().map_or(f64::INFINITY, variance).sqrt()
            };
            let quality = CameraQuality {
                diodes: [view.seen.len(), view_zoom.seen.len()],
                rms_px: [view.rms_px(&bundle.lens), view_zoom.rms_px(&projection.intrinsics)],
                position_error_mm: error(3),
                rotation_error_deg: error(0).to_degrees(),
                focal_error_px,
            };
            let [wide, zoom] = quality.rms_px;
            if zoom > MAX_ZOOM_RMS_PX.max(MAX_ZOOM_RMS * wide) {
                return Err(format!("its diodes lie {zoom:.1} pixels off those expected at its pose"));
            }
            Ok((projection, quality))
        };
        let found: Vec<std::result::Result<_, String>> =
            (0..cameras.len()).into_par_iter().map(one).collect();
        let number = self.rig.cameras.len();
        let mut calibration = GeometryCalibration {
            wide: bundle.lens,
            cameras: vec![None; number],
            quality: vec![None; number],
            left_out: Vec::new(),
        };
        for ((camera, _), found) in cameras.iter().zip(found) {
            match found {
                Ok((projection, quality)) => {
                    (calibration.cameras[*camera], calibration.quality[*camera]) =
                        (Some(projection), Some(quality));
                }
                Err(reason) => {
                    left_out.push(LeftOut { camera: *camera, reason: format!("with zoom: {reason}") })
                }
            }
        }
        left_out.sort_by_key(|l| l.camera);
        calibration.left_out = left_out;
        Ok(calibration)
    }

    fn zoom_lens(
        &self,
        camera: usize,
        wide: &Intrinsics,
        pose: Pose,
    ) -> std::result::Result<(Projection, View, f64), String> {
        let spots = self.spots(camera, Shot::LedsZoom { camera }).map_err(|e| e.to_string())?;
        let factor = self.rig.focal_zoom_px / self.rig.focal_wide_px;
        let start = Intrinsics { focal_px: wide.focal_px * factor, distortion: [0.0; 2], ..*wide };
        let named = self.plate.name(&spots.centers_px, &Projection { intrinsics: start, pose });
        let named = named.ok_or_else(|| {
            let n = spots.centers_px.len();
            format!(
                "its {n} spots are not the diodes expected at its pose ({} were rejected)",
                spots.rejected
            )
        })?;
        let mut view = View { seen: self.seen(&named), pose, weight: 1.0 };
        let undetermined = || "its diodes do not determine its lens".to_owned();
        let mut fit = fit_lens(&view, start).ok_or_else(undetermined)?;
        for _ in 0..ROUNDS {
            view.drop_outliers(&fit.lens);
            fit = fit_lens(&view, fit.lens).ok_or_else(undetermined)?;
        }
        Ok((Projection { intrinsics: fit.lens, pose }, view, fit.focal_error_px))
    }
}

/// The bundle with as much distortion as the views determine.
fn with_distortion(plain: Bundle) -> Bundle {
    let mut kept =
        Bundle { lens: Intrinsics { distortion: [0.0; 2], ..plain.lens }, lens_numbers: 3, ..plain };
    kept.descend();
    for (k, lens_numbers) in [(0, 4), (1, 5)] {
        let mut bent = Bundle { lens_numbers, ..kept.clone() };
        bent.descend();
        let error = bent.covariance().map_or(f64::INFINITY, |c| c.lens[(3 + k, 3 + k)].sqrt());
        if bent.lens.distortion[k].abs() <= SIGNIFICANT * error {
            break;
        }
        kept = bent;
    }
    kept
}

/// How a camera departs from its nominal pose, if that is too much.
pub(super) fn departure(pose: &Pose, nominal: &Pose) -> Option<String> {
    let moved = pose.position_mm.distance(nominal.position_mm);
    let turned = pose.rotation.angle_between(nominal.rotation);
    let share = (moved / nominal.position_mm.length()).max(turned);
    let is_far = share.is_nan() || share > MAX_DEPARTURE;
    is_far.then(|| format!("{moved:.1} mm and {:.2} degrees from its nominal pose", turned.to_degrees()))
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::SyntheticDome;
    use super::*;

    /// About linear: the square of the mean.
    fn linear(_: usize, picture: &Picture) -> (Vec<f32>, f32) {
        (picture.pixels.iter().map(|p| (p.iter().sum::<f32>() / 3.0).powi(2)).collect(), 1.0)
    }

    fn calibrated(dome: &SyntheticDome) -> GeometryCalibration {
        calibrate_geometry(dome, &linear, &|| ()).unwrap()
    }

    /// Noise of some percent of a diode's peak.
    fn noisy(number: usize) -> SyntheticDome {
        SyntheticDome { read: 0.002, electrons: 10_000.0, levels: 4095.0, ..SyntheticDome::new(number) }
    }

    #[test]
    fn cameras_are_found_within_their_errors() {
        let dome = noisy(9);
        let found = calibrated(&dome);
        assert_eq!(found.left_out, []);
        for (k, truth) in dome.cameras.iter().enumerate() {
            let (camera, quality) = (found.cameras[k].unwrap(), found.quality[k].unwrap());
            let moved = camera.pose.position_mm.distance(truth.pose.position_mm);
            let turned = camera.pose.rotation.angle_between(truth.pose.rotation).to_degrees();
            // Three directions together, and what all cameras share: four standard errors are one in thousands.
            assert!(
                moved < 4.0 * quality.position_error_mm && turned < 4.0 * quality.rotation_error_deg,
                "{k}"
            );
            // Some hundredths of a pixel is what centroids of this noise can do.
            assert!(quality.rms_px.iter().all(|rms| *rms < 0.03), "{quality:?}");
            // A few are cut as outliers.
            assert!(quality.diodes[0] >= 112 && quality.diodes[1] >= 16, "{quality:?}");
            // What the sample needs: errors of lens and pose that hide each other do not count. Pixels of the sample's corners.
            for corner in [[-8.5, -7.5], [8.5, -7.5], [8.5, 7.5]].map(DVec2::from) {
                let [found, truth] = [camera, *truth].map(|c| c.pixel(corner.extend(0.0)).unwrap());
                assert!(found.distance(truth) < 0.1, "{k}: {found} {truth}");
            }
        }
    }

    #[test]
    fn the_same_bits_for_any_number_of_threads() {
        let dome = noisy(5);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| calibrated(&dome))
        };
        assert_eq!(run(1), run(3));
    }

    #[test]
    fn dead_swapped_and_missing_cameras_are_left_out_with_the_reason() {
        let mut dome = noisy(12);
        dome.instead = |dome, shot| match shot {
            Shot::LedsWide { camera: 2 } => {
                Some(Ok(Picture { size: [256; 2], pixels: vec![[0.001; 3]; 65_536] }))
            }
            Shot::LedsWide { camera: 3 } => Some(dome.honest(Shot::LedsWide { camera: 8 })),
            Shot::LedsWide { camera: 8 } => Some(dome.honest(Shot::LedsWide { camera: 3 })),
            Shot::LedsZoom { camera: 5 } => Some(Err(Error::invalid("", "file", "none", "a picture"))),
            Shot::LedsZoom { camera: 7 } => {
                Some(Ok(Picture { size: [256; 2], pixels: vec![[f32::NAN; 3]; 65_536] }))
            }
            _ => None,
        };
        let found = calibrated(&dome);
        let reason = |camera: usize| &found.left_out.iter().find(|l| l.camera == camera).unwrap().reason;
        assert!(reason(2).contains("sees 0 of 121 diodes"));
        assert!(reason(3).contains("fits the nominal place of camera 8"), "{}", reason(3));
        assert!(reason(8).contains("fits the nominal place of camera 3"), "{}", reason(8));
        assert!(reason(5).contains("with zoom: file: found none"), "{}", reason(5));
        assert!(reason(7).contains("with zoom: its 0 spots"), "{}", reason(7));
        assert_eq!(found.left_out.len(), 5);
        assert!(found.cameras.iter().zip(&found.quality).enumerate().all(|(k, (camera, quality))| {
            let is_out = [2, 3, 5, 7, 8].contains(&k);
            camera.is_none() == is_out && quality.is_none() == is_out
        }));
    }

    /// A camera that is pushed between its two pictures.
    #[test]
    fn a_camera_that_moved_is_left_out() {
        let mut dome = noisy(9);
        dome.instead = |dome, shot| match shot {
            Shot::LedsZoom { camera: 6 } => {
                let mut cameras = dome.cameras.clone();
                cameras[6].pose.position_mm += DVec2::new(40.0, -30.0).extend(0.0);
                let place = cameras[6].pose.position_mm;
                cameras[6].pose = Pose::looking_at(place, glam::DVec3::ZERO, glam::DVec3::Z);
                let pushed = SyntheticDome { cameras, ..noisy(9) };
                Some(pushed.picture(shot))
            }
            _ => None,
        };
        let found = calibrated(&dome);
        assert_eq!(found.left_out.len(), 1, "{:?}", found.left_out);
        assert!(found.left_out[0].reason.contains("pixels off those expected"), "{:?}", found.left_out);
    }

    #[test]
    fn hot_pixels_dead_diodes_and_glare_do_no_harm() {
        let mut dome = noisy(6);
        dome.instead = |dome, shot| {
            let mut picture = dome.honest(shot).unwrap();
            for k in 0..100u32 {
                let at = crate::math::hash::pcg4d([k, 3, 1, 4])[0] as usize % picture.pixels.len();
                picture.pixels[at] = [1.0; 3];
            }
            // A reflection of a window over a corner of the plate.
            for k in 0..900 {
                picture.pixels[(90 + k / 30) * 256 + 90 + k % 30] = [1.0; 3];
            }
            Some(Ok(picture))
        };
        let found = calibrated(&dome);
        assert_eq!(found.left_out, []);
        for (k, truth) in dome.cameras.iter().enumerate() {
            let moved = found.cameras[k].unwrap().pose.position_mm.distance(truth.pose.position_mm);
            let quality = found.quality[k].unwrap();
            // A hot pixel beside a diode that is not cut off shifts it by less than the cut: twice the noise of clean pictures.
            assert!(
                moved < 8.0 * quality.position_error_mm && quality.rms_px[0] < 0.05,
                "{k} {moved} {quality:?}"
            );
        }
    }

    #[test]
    fn a_dome_without_cameras_is_refused() {
        let mut dome = noisy(3);
        dome.instead = |_, _| Some(Err(Error::invalid("", "file", "none", "a picture")));
        let message = calibrate_geometry(&dome, &linear, &|| ()).unwrap_err().to_string();
        assert!(message.contains("camera 2: file") && message.contains("at least 2"), "{message}");
    }
}
