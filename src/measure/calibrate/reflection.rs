//! The check of a calibration by the highlight (Rump et al. 2008, section 5.1.1, figure 7): where the flash should be seen
//! mirrored in the sample, and where it is.

use super::hdr::HdrPicture;
use crate::color::srgb_encode;
use crate::math::projection::{Pose, Projection};
use crate::measure::{PairGeometry, Rig};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Share of the pixels that the overlay shows at full white or above.
const CLIPPED: f64 = 0.005;
/// Half the arm of a cross, pixels.
const ARM: i64 = 4;

/// Where the mirror image of a flash is seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reflection {
    /// Its points, pixels; row after row as those of the flash.
    pub points_px: Vec<[f64; 2]>,
    /// Their mean.
    pub center_px: [f64; 2],
}

/// The mirror image of a flash in the plane z = 0; `None` unless its middle is seen on the sample and in the picture.
pub fn reflection(camera: &Projection, light: &Pose, rig: &Rig) -> Option<Reflection> {
    let pair = PairGeometry::new(*camera, &rig.flash, light);
    let mirrored = pair.points_mm.iter().map(|p| camera.pixel(pair.mirrored_place(*p).extend(0.0)));
    let points: Vec<DVec2> = mirrored.collect::<Option<_>>()?;
    let center = points.iter().sum::<DVec2>() / points.len() as f64;
    let size = DVec2::new(rig.image_px[0] as f64, rig.image_px[1] as f64);
    let on_sample = camera.on_plane(center, 0.0)?.truncate().abs();
    let is_seen = center.cmpge(DVec2::ZERO).all() && center.cmplt(size).all();
    (is_seen && on_sample.cmple(0.5 * DVec2::from(rig.sample_mm)).all()).then(|| Reflection {
        points_px: points.iter().map(|p| p.to_array()).collect(),
        center_px: center.to_array(),
    })
}

impl Reflection {
    /// Distance of a highlight from where it should be, pixels.
    pub fn distance_px(&self, found_px: DVec2) -> f64 {
        found_px.distance(DVec2::from(self.center_px))
    }

    /// The picture as eight-bit sRGB with the points of the reflection in green, its middle as a green cross and the highlight
    /// that was found as a red one. Row-major, top row first.
    pub fn overlay(&self, picture: &HdrPicture, found_px: Option<DVec2>) -> Vec<[u8; 3]> {
        let mut drawn = tone_mapped(picture);
        let mut draw = |place: DVec2, color: [u8; 3], arm: i64| {
            let [x, y] = [place.x.floor() as i64, place.y.floor() as i64];
            for (u, v) in (-arm..=arm).flat_map(|k| [(x + k, y), (x, y + k)]) {
                let [width, height] = picture.size.map(|n| n as i64);
                if (0..width).contains(&u) && (0..height).contains(&v) {
                    drawn[(v * width + u) as usize] = color;
                }
            }
        };
        self.points_px.iter().for_each(|p| draw((*p).into(), [0, 160, 0], 0));
        draw(self.center_px.into(), [0, 255, 0], ARM);
        found_px.into_iter().for_each(|p| draw(p, [255, 0, 0], ARM));
        drawn
    }
}

fn tone_mapped(picture: &HdrPicture) -> Vec<[u8; 3]> {
    let mut bright: Vec<f32> = picture.pixels.iter().map(|p| p.iter().copied().fold(0.0, f32::max)).collect();
    let place = ((1.0 - CLIPPED) * (bright.len().saturating_sub(1)) as f64) as usize;
    let white = bright.select_nth_unstable_by(place, f32::total_cmp).1.max(f32::MIN_POSITIVE);
    let encode = |v: f32| (255.0 * srgb_encode(f64::from(v / white)).clamp(0.0, 1.0)).round() as u8;
    picture.pixels.iter().map(|p| p.map(encode)).collect()
}
