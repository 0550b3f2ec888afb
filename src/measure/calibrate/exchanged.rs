//! Cameras and flashes that are not where they are thought to be, found from pictures of the sample.
//!
//! A plate of diodes that looks the same turned by a quarter does not tell cameras apart that are swapped within a ring by a quarter
//! of it. White targets do: where a living camera finds none that agree, it is another one. No camera sees its own flash; but light
//! takes the same way back (Helmholtz): what camera i sees of the sample under flash j, camera j sees under flash i. Where most of
//! the sample says otherwise, one of the two flashes stands elsewhere. Paints that reflect alike in all directions do not tell.
//!
//! Every camera is compared with up to six others, so that the work grows with the cameras, not with their pairs.

use super::calibration::Calibration;
use super::geometry::LeftOut;
use super::hdr::{HdrPicture, PixelState};
use super::white::{read_targets, scale_of, white_scale};
use crate::color::luminance;
use crate::error::Result;
use crate::math::projection::{Pose, Projection};
use crate::measure::{Images, PairGeometry, Rig, Sheet};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Others on either side with which a camera is compared.
const PARTNERS: usize = 3;
/// Least share of the pixels of a living camera's picture that are neither black nor saturated.
const ALIVE: f64 = 0.1;
/// Texels along the side of the sample whose median is compared, so that the mirrored flash does not count.
const TEXELS: f64 = 10.0;
/// How far both ways may differ: a flash stands a degree beside its camera, where glitter falls off by a fifth.
const MAX_RATIO: f64 = 1.5;
/// Darker than a thousandth of the perfect diffuser is taken for as dark, 1/sr: noise has any ratio.
const DARK: f64 = 1e-3 / PI;
/// With fewer than so many others that contradict it, a flash is not blamed.
const MIN_CONTRADICTIONS: usize = 2;

/// What a picture of the sample says.
enum Seen {
    /// It cannot be read, is dark or saturated all over, or too small to show white targets.
    Nothing,
    /// White targets are not where they should be.
    NoWhite(String),
    /// They are; the median BRDF, if most of the sample is known.
    Sample(Option<f64>),
}

impl Calibration {
    /// How often [`Calibration::leave_out_exchanged`] calls its `tick`.
    pub fn looks(rig: &Rig) -> usize {
        looks(rig.cameras.len()).len()
    }

    /// Leaves out cameras whose pictures of the sample contradict where they or their flashes stand; what cannot be read says nothing.
    /// `tick` is called [`Calibration::looks`] times. The same for any number of threads, each of which has one pair in memory.
    ///
    /// # Errors
    /// Fewer than two cameras are left.
    pub fn leave_out_exchanged(&mut self, images: &dyn Images, tick: &(dyn Fn() + Sync)) -> Result<()> {
        let looks = looks(images.rig().cameras.len());
        let look = |[camera, light]: &[usize; 2]| {
            let seen = look(self, images, *camera, *light);
            tick();
            seen
        };
        let seen: Vec<Seen> = looks.par_iter().map(look).collect();
        let cameras = exchanged_cameras(self, images, &looks, &seen);
        let is_out = |k: usize| cameras.iter().any(|out| out.camera == k);
        let contradiction = |(looks, seen): (&[[usize; 2]], &[Seen])| match seen {
            [Seen::Sample(Some(a)), Seen::Sample(Some(b))] => {
                Some(Contradiction { pair: looks[0], ratio: a / b })
            }
            _ => None,
        };
        let both = looks.chunks_exact(2).zip(seen.chunks_exact(2)).filter_map(contradiction);
        let is_wrong =
            |c: &Contradiction| c.ratio.ln().abs() > MAX_RATIO.ln() && !c.pair.iter().any(|k| is_out(*k));
        let flashes = exchanged_flashes(both.filter(is_wrong).collect());
        cameras.into_iter().chain(flashes).for_each(|out| self.geometry.leave_out(out));
        self.geometry.check_enough("at least 2 that pictures of the sample do not contradict")
    }
}

/// The pairs that are looked at, camera and light, each followed by its reverse.
fn looks(cameras: usize) -> Vec<[usize; 2]> {
    let step = (cameras / (2 * PARTNERS + 1)).max(1);
    let partners = |k: usize| (1..=PARTNERS).map(move |n| [k, (k + n * step) % cameras]);
    let mut pairs: Vec<[usize; 2]> =
        (0..cameras).flat_map(partners).filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]).collect()
}

fn look(calibration: &Calibration, images: &dyn Images, camera: usize, light: usize) -> Seen {
    let rig = images.rig();
    let both = calibration.camera(camera).ok().zip(calibration.camera(light).ok());
    let Some((eye, flash)) = both else { return Seen::Nothing };
    let Some(picture) = alive(calibration, images, camera, light) else { return Seen::Nothing };
    let targets = read_targets(&picture, eye, &flash.pose, rig);
    let is_seen = targets.iter().any(|target| target.seen);
    match scale_of(targets) {
        Err(_) if !is_seen => Seen::Nothing,
        Ok(white) => {
            let pair = PairGeometry::new(*eye, &rig.flash, &flash.pose);
            Seen::Sample(median_brdf(&picture.balanced(white), &pair, rig))
        }
        Err(e) => Seen::NoWhite(e.to_string()),
    }
}

/// The linear picture of a pair, if there is one that shows something.
fn alive(calibration: &Calibration, images: &dyn Images, camera: usize, light: usize) -> Option<HdrPicture> {
    let picture = calibration.linear(images, camera, light).ok()?;
    let valid = picture.mask.iter().filter(|state| **state == PixelState::Valid).count();
    (valid as f64 > ALIVE * picture.mask.len() as f64).then_some(picture)
}

fn median_brdf(picture: &HdrPicture, pair: &PairGeometry, rig: &Rig) -> Option<f64> {
    let sheet = Sheet::new(rig.sample_mm, rig.sample_mm[0].min(rig.sample_mm[1]) / TEXELS);
    let texels = sheet.rectify(&picture.known(), picture.size, pair);
    let mut light: Vec<f64> = texels.iter().map(|rgb| luminance(DVec3::from(rgb.map(f64::from)))).collect();
    light.retain(|l| l.is_finite());
    light.sort_by(f64::total_cmp);
    (2 * light.len() > texels.len()).then(|| light[light.len() / 2].max(DARK))
}

/// Cameras none of whose pictures shows the white targets in their places.
fn exchanged_cameras(
    calibration: &Calibration,
    images: &dyn Images,
    looks: &[[usize; 2]],
    seen: &[Seen],
) -> Vec<LeftOut> {
    let one = |camera: usize| {
        let own = || looks.iter().zip(seen).filter(|(look, _)| look[0] == camera);
        let no_white = |(look, seen): (&[usize; 2], &Seen)| match seen {
            Seen::NoWhite(why) => Some((look[1], why.clone())),
            _ => None,
        };
        let (light, why) = own().find_map(no_white)?;
        if own().any(|(_, seen)| matches!(seen, Seen::Sample(_))) {
            return None;
        }
        let reason = whose(calibration, images, camera, light).unwrap_or(why);
        Some(LeftOut { camera, reason })
    };
    (0..images.rig().cameras.len()).into_par_iter().filter_map(one).collect()
}

/// Whose picture it is, if the white targets say so after some quarter turns of the plate.
fn whose(calibration: &Calibration, images: &dyn Images, camera: usize, light: usize) -> Option<String> {
    let rig = images.rig();
    let (eye, flash) = (calibration.camera(camera).ok()?, calibration.camera(light).ok()?);
    let picture = alive(calibration, images, camera, light)?;
    let turned = |quarters: &i32| {
        let pose = turned(&eye.pose, f64::from(*quarters) * FRAC_PI_2);
        let turned = Projection { pose, ..*eye };
        white_scale(&picture, &turned, &flash.pose, rig).is_ok().then_some(pose)
    };
    let pose = (1..=3).collect::<Vec<_>>().iter().find_map(turned)?;
    let distance = |k: &usize| rig.cameras[*k].position_mm.distance(pose.position_mm);
    let owner = (0..rig.cameras.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    Some(if owner == camera {
        "its white targets fit it turned about the sample".to_owned()
    } else {
        format!("its white targets fit the place of camera {owner} instead")
    })
}

/// A camera turned about the normal of the sample.
fn turned(pose: &Pose, angle: f64) -> Pose {
    let turn = DQuat::from_rotation_z(angle);
    Pose { position_mm: turn * pose.position_mm, rotation: (pose.rotation * turn.inverse()).normalize() }
}

/// Two cameras that see different light under each other's flash: that of the first over that of the second.
struct Contradiction {
    pair: [usize; 2],
    ratio: f64,
}

/// The flashes that explain contradictions, the most contradicted first, equals together.
fn exchanged_flashes(mut contradictions: Vec<Contradiction>) -> Vec<LeftOut> {
    let mut out = Vec::new();
    loop {
        let count = |k: usize| contradictions.iter().filter(|c| c.pair.contains(&k)).count();
        let most = contradictions.iter().flat_map(|c| c.pair).map(count).max().unwrap_or(0);
        if most < MIN_CONTRADICTIONS {
            return out;
        }
        let mut worst: Vec<usize> =
            contradictions.iter().flat_map(|c| c.pair).filter(|k| count(*k) == most).collect();
        worst.sort_unstable();
        worst.dedup();
        out.extend(worst.iter().map(|k| LeftOut { camera: *k, reason: blame(*k, &contradictions) }));
        contradictions.retain(|c| !c.pair.iter().any(|k| worst.contains(k)));
    }
}

fn blame(camera: usize, contradictions: &[Contradiction]) -> String {
    let others: Vec<String> = contradictions
        .iter()
        .filter(|c| c.pair.contains(&camera))
        .map(|c| match c.pair {
            [a, other] if a == camera => format!("{other} ({:.2})", c.ratio.recip()),
            [other, _] => format!("{other} ({:.2})", c.ratio),
        })
        .collect();
    format!(
        "light takes the same way back, but the sample is not as bright under its flash, seen by camera {} times as bright, as it \
         sees it under theirs: are flashes swapped?",
        others.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_camera_is_looked_at_from_others_both_ways() {
        for cameras in [2, 3, 7, 21, 151] {
            let looks = looks(cameras);
            assert!(looks.chunks_exact(2).all(|both| both[0][0] == both[1][1] && both[0][1] == both[1][0]));
            let expected = (2 * PARTNERS).min(cameras - 1);
            for k in 0..cameras {
                assert_eq!(looks.iter().filter(|look| look[0] == k).count(), expected, "{k} of {cameras}");
            }
        }
    }

    #[test]
    fn a_camera_turned_about_the_sample_sees_it_turned() {
        let pose = Pose::looking_at(DVec3::new(200.0, -300.0, 500.0), DVec3::ZERO, DVec3::Z);
        let place = DVec3::new(3.0, -7.0, 0.0);
        let moved = DQuat::from_rotation_z(0.7) * place;
        // Rounding of 600 mm.
        assert!((turned(&pose, 0.7).local(moved) - pose.local(place)).length() < 1e-12);
    }

    #[test]
    fn the_flashes_that_explain_most_are_blamed() {
        let blamed = |pairs: &[[usize; 2]]| {
            let contradictions = pairs.iter().map(|pair| Contradiction { pair: *pair, ratio: 2.0 }).collect();
            exchanged_flashes(contradictions).into_iter().map(|out| out.camera).collect::<Vec<_>>()
        };
        // One picture that is wrong blames nobody; flashes 1 and 4 contradict three others and four.
        assert!(blamed(&[[2, 3]]).is_empty());
        assert_eq!(blamed(&[[0, 1], [1, 2], [1, 3], [0, 4], [2, 4], [3, 4], [4, 5]]), [4, 1]);
        // Symmetric places do not tell 0 and 1 swapped from 2 and 3 swapped.
        assert_eq!(blamed(&[[0, 2], [0, 3], [1, 2], [1, 3]]), [0, 1, 2, 3]);
        let contradictions =
            vec![Contradiction { pair: [1, 7], ratio: 4.0 }, Contradiction { pair: [3, 7], ratio: 4.0 }];
        assert!(blame(7, &contradictions).contains("camera 1 (4.00), 3 (4.00) times"));
        assert!(blame(1, &contradictions).contains("camera 7 (0.25) times"));
    }
}
