//! White balance of one pair of camera and flash from the white targets beside the sample (Rump et al. 2008, section 4.3).
//!
//! A target of reflectance rho sends `rho / pi E`, E being [`PairGeometry::irradiance`] by a flash of unit intensity. What the camera says over that is the scale of the picture, a channel each: gain of the camera, color and energy of
//! the flash. Divided by it, pixels are radiance per intensity, and the BRDF is `pixel / E`.

use super::hdr::{HdrPicture, PixelState};
use crate::error::{Error, Result};
use crate::math::projection::{Pose, Projection};
use crate::measure::{PairGeometry, Rig, WhiteTarget};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The inner part of a target's side that is read: rims are blurred.
const INNER: f64 = 0.7;
/// Fewest pixels of a target.
const MIN_PIXELS: usize = 12;
/// Pixels further than this from the median, standard deviations, are scratches.
const CUT: f64 = 4.0;
/// Largest share of a target's pixels that may be scratched, saturated or black.
const MAX_LOST: f64 = 0.5;
/// How much a target may vary: it is even.
const MAX_SPREAD: f64 = 0.1;
/// How far the scale of a target may be from that of others.
const MAX_DEPARTURE: f64 = 0.05;
/// Standards are known to this share.
const STANDARD_ERROR: f64 = 0.003;

/// Scale of a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhiteScale {
    /// Pixel over radiance per intensity, red, green, blue; square millimetres.
    pub scale: [f64; 3],
    /// Relative standard errors.
    pub error: [f64; 3],
    /// What every target said.
    pub targets: Vec<TargetReading>,
}

/// What one target said, or why it was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetReading {
    /// Its scale and relative standard error; 0 where it has none.
    pub scale: [f64; 3],
    /// Relative standard errors, that of the standard included.
    pub error: [f64; 3],
    /// Whether it lies in the picture and is large enough to be read, whatever it shows.
    pub seen: bool,
    /// Why it does not count.
    pub left_out: Option<String>,
}

/// Reads the targets of a picture.
///
/// # Errors
/// No target can be read, or they contradict each other: no more than half of them agree (is it another camera?).
pub fn white_scale(picture: &HdrPicture, camera: &Projection, light: &Pose, rig: &Rig) -> Result<WhiteScale> {
    scale_of(read_targets(picture, camera, light, rig))
}

/// What every target says; those that contradict the one with which most agree are left out.
pub fn read_targets(
    picture: &HdrPicture,
    camera: &Projection,
    light: &Pose,
    rig: &Rig,
) -> Vec<TargetReading> {
    let pair = PairGeometry::new(*camera, &rig.flash, light);
    let mut targets: Vec<TargetReading> =
        rig.white_targets.iter().map(|target| read(picture, &pair, target)).collect();
    agree(&mut targets);
    targets
}

/// The scale that targets agree upon.
///
/// # Errors
/// As [`white_scale`].
pub fn scale_of(targets: Vec<TargetReading>) -> Result<WhiteScale> {
    let good = || targets.iter().filter(|t| t.left_out.is_none());
    let (kept, contradicting) = (good().count(), targets.iter().filter(|t| t.scale[0] > 0.0).count());
    if kept == 0 || (contradicting > 1 && 2 * kept <= contradicting) {
        let say =
            |(k, t): (usize, &TargetReading)| t.left_out.as_ref().map(|why| format!("target {k} {why}"));
        let found: Vec<String> = targets.iter().enumerate().filter_map(say).collect();
        return Err(Error::invalid("white balance", "targets", found.join("; "), "most in agreement"));
    }
    let mut white = WhiteScale { scale: [0.0; 3], error: [0.0; 3], targets: Vec::new() };
    for c in 0..3 {
        // Of relative errors: of a scale of 1 an absolute one.
        let weight = |t: &TargetReading| t.error[c].powi(-2);
        let weights = good().map(weight).sum::<f64>();
        white.scale[c] = (good().map(|t| weight(t) * t.scale[c].ln()).sum::<f64>() / weights).exp();
        white.error[c] = weights.sqrt().recip();
    }
    white.targets = targets;
    Ok(white)
}

/// Leaves out targets that contradict the one with which most agree.
fn agree(targets: &mut [TargetReading]) {
    let off = |a: &TargetReading, b: &TargetReading| {
        let channels = (0..3).map(|c| {
            let departure = (b.scale[c] / a.scale[c]).ln().abs();
            departure - MAX_DEPARTURE.max(CUT * a.error[c].hypot(b.error[c]))
        });
        channels.fold(f64::NEG_INFINITY, f64::max) > 0.0
    };
    let usable = |t: &&TargetReading| t.left_out.is_none();
    let friends = |a: &TargetReading| targets.iter().filter(usable).filter(|b| !off(a, b)).count();
    // The first of equals.
    let best = targets.iter().filter(usable).fold(None, |best: Option<(usize, &TargetReading)>, t| {
        let count = friends(t);
        if best.is_some_and(|(most, _)| most >= count) { best } else { Some((count, t)) }
    });
    let Some(reference) = best.map(|(_, t)| t.clone()) else { return };
    for target in targets.iter_mut().filter(|t| t.left_out.is_none()) {
        if off(&reference, target) {
            let ratios = [0, 1, 2].map(|c| format!("{:.3}", target.scale[c] / reference.scale[c]));
            target.left_out = Some(format!("is off the others: {}", ratios.join(", ")));
        }
    }
}

fn read(picture: &HdrPicture, pair: &PairGeometry, target: &WhiteTarget) -> TargetReading {
    let nothing = || TargetReading { scale: [0.0; 3], error: [0.0; 3], seen: false, left_out: None };
    let ratios = match ratios(picture, pair, target) {
        Ok(ratios) => ratios,
        Err(why) => return TargetReading { left_out: Some(why), ..nothing() },
    };
    let why = |why| TargetReading { seen: true, left_out: Some(why), ..nothing() };
    scale(&ratios).map_or_else(why, |(scale, error)| TargetReading {
        scale,
        error,
        seen: true,
        left_out: None,
    })
}

/// Per pixel that shows the inner part of a target.
struct Ratios {
    /// Channels over what they would be at a scale of 1, and variances of these.
    known: Vec<[f64; 6]>,
    /// Pixels without.
    lost: usize,
}

/// The pixels of a target, or why there are none to speak of.
fn ratios(
    picture: &HdrPicture,
    pair: &PairGeometry,
    target: &WhiteTarget,
) -> std::result::Result<Ratios, String> {
    let (camera, center) = (&pair.camera, DVec2::from(target.center_mm));
    let reach = 0.5 * INNER * target.side_mm;
    let corners =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|s| center + reach * DVec2::from(s));
    let corners: Option<Vec<DVec2>> = corners.iter().map(|p| camera.pixel(p.extend(0.0))).collect();
    let corners = corners.ok_or("is behind the camera")?;
    let (low, high) = corners.iter().fold((corners[0], corners[0]), |(a, b), p| (a.min(*p), b.max(*p)));
    let [width, height] = picture.size;
    if !(low.min_element() >= 0.0 && high.x <= width as f64 && high.y <= height as f64) {
        return Err("is not wholly in the picture".to_owned());
    }
    let mut ratios = Ratios { known: Vec::new(), lost: 0 };
    for row in low.y as usize..(high.y.ceil() as usize).min(height) {
        for column in low.x as usize..(high.x.ceil() as usize).min(width) {
            let pixel = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            let Some(at) = camera.on_plane(pixel, 0.0).map(|p| p.truncate()) else { continue };
            if (at - center).abs().max_element() > reach {
                continue;
            }
            let k = row * width + column;
            if picture.mask[k] != PixelState::Valid {
                ratios.lost += 1;
                continue;
            }
            let radiance = target.reflectance / PI * pair.irradiance(at, |_| 1.0);
            let [r, g, b] = picture.pixels[k].map(|v| f64::from(v) / radiance);
            let [x, y, z] = picture.variance[k].map(|v| f64::from(v) / (radiance * radiance));
            ratios.known.push([r, g, b, x, y, z]);
        }
    }
    let all = ratios.known.len() + ratios.lost;
    if all < MIN_PIXELS { Err(format!("covers {all} pixels")) } else { Ok(ratios) }
}

/// The scale of a target and its relative standard error.
fn scale(Ratios { known, lost }: &Ratios) -> std::result::Result<([f64; 3], [f64; 3]), String> {
    let all = known.len() + lost;
    if *lost as f64 > MAX_LOST * all as f64 {
        return Err(format!("is saturated, black or broken in {lost} of {all} pixels"));
    }
    let (mut scale, mut errors) = ([0.0; 3], [0.0; 3]);
    for c in 0..3 {
        let (mean, error, spread) = center_of(known, c);
        if mean.is_nan() || mean <= 0.0 {
            return Err("is black".to_owned());
        }
        if spread > MAX_SPREAD * mean {
            return Err(format!("varies by {:.0} % beyond its noise", 100.0 * spread / mean));
        }
        (scale[c], errors[c]) = (mean, (error / mean).hypot(STANDARD_ERROR));
    }
    Ok((scale, errors))
}

/// Mean of a channel's ratios without those far from the median, its standard error, and how much they vary beyond their noise.
fn center_of(ratios: &[[f64; 6]], c: usize) -> (f64, f64, f64) {
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let middle = median(ratios.iter().map(|r| r[c]).collect());
    // Of normal deviates half lie within 0.6745 standard deviations; less than the noise of a pixel it cannot be.
    let spread = median(ratios.iter().map(|r| (r[c] - middle).abs()).collect()) / 0.6745;
    let noise = median(ratios.iter().map(|r| r[c + 3]).collect()).sqrt();
    let beyond = (spread * spread - noise * noise).max(0.0).sqrt();
    let spread = spread.max(noise);
    let near = || ratios.iter().filter(|r| (r[c] - middle).abs() <= CUT * spread);
    let count = near().count().max(1) as f64;
    (near().map(|r| r[c]).sum::<f64>() / count, spread / count.sqrt(), beyond)
}

#[cfg(test)]
mod tests {
    use super::super::hdr::PixelState;
    use super::super::synthetic::SyntheticDome;
    use super::*;

    /// The picture of camera 1 under flash 2 as it is, with a hundredth of its light as noise.
    fn picture(dome: &SyntheticDome, change: impl Fn(DVec2) -> f64) -> HdrPicture {
        let size = dome.rig.image_px;
        let number = size[0] * size[1];
        let pixel = |k: usize| DVec2::new((k % size[0]) as f64 + 0.5, (k / size[0]) as f64 + 0.5);
        let light = |k: usize, c: usize| {
            let noise = 1.0 + 0.01 * super::super::synthetic::normal([k as u32, c as u32, 4, 5]);
            dome.scale(1, 2, c) * dome.radiance(1, 2, pixel(k))[c] * noise * change(pixel(k))
        };
        let pixels: Vec<[f32; 3]> = (0..number).map(|k| [0, 1, 2].map(|c| light(k, c) as f32)).collect();
        let variance = pixels.iter().map(|p| p.map(|v| (0.01 * v).powi(2))).collect();
        let mask = vec![PixelState::Valid; number];
        HdrPicture {
            size,
            pixels,
            variance,
            mask,
            relative: vec![],
            range_db: [0.0; 2],
            white: None,
            warnings: vec![],
        }
    }

    fn scale(dome: &SyntheticDome, picture: &HdrPicture) -> Result<WhiteScale> {
        white_scale(picture, &dome.cameras[1], &dome.cameras[2].pose, &dome.rig)
    }

    #[test]
    fn scales_are_those_of_camera_and_flash() {
        let dome = SyntheticDome::new(4);
        let clean = picture(&dome, |_| 1.0);
        let white = scale(&dome, &clean).unwrap();
        assert!(white.targets.iter().all(|t| t.left_out.is_none()), "{:?}", white.targets);
        for c in 0..3 {
            // A percent over four hundred pixels and four targets, and exact standards: 3e-4.
            assert!((white.scale[c] / dome.scale(1, 2, c) - 1.0).abs() < 1.5e-3, "{:?}", white.scale);
            assert!((0.0005..0.003).contains(&white.error[c]), "{:?}", white.error);
        }
        let balanced = clean.clone().balanced(white);
        let middle = 128 * 256 + 50;
        let real = dome.radiance(1, 2, DVec2::new(50.5, 128.5))[1];
        assert!((f64::from(balanced.pixels[middle][1]) / real - 1.0).abs() < 0.06);
        let share = |p: &HdrPicture| p.variance[middle][1] / p.pixels[middle][1].powi(2);
        // Three roundings of f32.
        assert!((share(&balanced) / share(&clean) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn scratched_hidden_and_saturated_targets_do_no_harm() {
        let dome = SyntheticDome::new(4);
        let camera = dome.cameras[1];
        let at =
            |k: usize| camera.pixel(DVec2::from(dome.rig.white_targets[k].center_mm).extend(0.0)).unwrap();
        // A scratch three pixels wide, twice as bright; a target in shadow.
        let mut spoiled = picture(&dome, |p| {
            let scratch = if (p.x - at(2).x).abs() < 1.5 { 2.0 } else { 1.0 };
            scratch * if p.distance(at(0)) < 25.0 { 0.4 } else { 1.0 }
        });
        for k in 0..spoiled.mask.len() {
            let pixel = DVec2::new((k % 256) as f64, (k / 256) as f64);
            if pixel.distance(at(3)) < 25.0 {
                spoiled.mask[k] = PixelState::Saturated;
            }
        }
        let white = scale(&dome, &spoiled).unwrap();
        let why = |k: usize| white.targets[k].left_out.clone().unwrap_or_default();
        assert!(
            why(0).contains("off the others: 0.4") && why(3).contains("is saturated"),
            "{} {}",
            why(0),
            why(3)
        );
        assert!(why(1).is_empty() && why(2).is_empty());
        for c in 0..3 {
            assert!((white.scale[c] / dome.scale(1, 2, c) - 1.0).abs() < 3e-3, "{:?}", white.scale);
        }
    }

    #[test]
    fn targets_elsewhere_or_in_contradiction_are_refused() {
        let mut dome = SyntheticDome::new(4);
        let good = picture(&dome, |_| 1.0);
        let dark = picture(&dome, |_| 0.0);
        assert!(scale(&dome, &dark).unwrap_err().to_string().contains("target 1 is black"));
        // Another camera than the one that was calibrated: its targets lie in other places.
        let other =
            white_scale(&good, &dome.cameras[3], &dome.cameras[2].pose, &dome.rig).unwrap_err().to_string();
        assert!(other.contains("most in agreement"), "{other}");
        dome.rig.white_targets.iter_mut().for_each(|t| t.center_mm[0] += 40.0);
        let away = scale(&dome, &good).unwrap_err().to_string();
        assert!(away.contains("target 0 is not wholly in the picture"), "{away}");
    }
}
