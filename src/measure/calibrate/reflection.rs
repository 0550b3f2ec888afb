//! The check of a calibration by the highlight (Rump et al. 2008, section 5.1.1, figure 7): where the flash should be seen
//! mirrored in the sample, and where it is.

use super::hdr::HdrPicture;
use crate::math::projection::{Pose, Projection};
use crate::measure::highlight::{Highlight, Mirrored, find_mirrored};
use crate::measure::samples::area;
use crate::measure::{PairGeometry, Rig};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Reach of a cross and of a dot, pixels of the picture.
const ARM: f64 = 2.5;
const DOT: f64 = 0.25;
/// The darkest thing around the highlight that the overlay tells from black, as a share of its median light.
const DARK: f64 = 0.1;
/// Colors of the overlay: where the flash should be, and where it is.
const EXPECTED: [u8; 3] = [255, 40, 40];
const FOUND: [u8; 3] = [60, 255, 60];

/// Where the mirror image of a flash is seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reflection {
    /// Its points, pixels; row after row as those of the flash.
    pub points_px: Vec<[f64; 2]>,
    /// The mean of those that lie on the sample.
    pub center_px: [f64; 2],
    /// Area of the part that lies on the sample, square pixels.
    pub area_px: f64,
}

/// The mirror image of a flash in the plane z = 0; `None` unless it touches the sample and the middle of what does is in the picture.
pub fn reflection(camera: &Projection, light: &Pose, rig: &Rig) -> Option<Reflection> {
    let pair = PairGeometry::new(*camera, &rig.flash, light);
    let half = 0.5 * DVec2::from(rig.sample_mm);
    let places: Vec<DVec2> = pair.points_mm.iter().map(|p| pair.mirrored_place(*p)).collect();
    let pixel = |place: DVec2| camera.pixel(place.extend(0.0));
    let points: Vec<DVec2> = places.iter().map(|p| pixel(*p)).collect::<Option<_>>()?;
    let corners = pair.corners_mm.map(|corner| pair.mirrored_place(corner));
    let corners: Vec<DVec2> = corners.into_iter().map(pixel).collect::<Option<_>>()?;
    let on_sample = |(place, _): &(&DVec2, &DVec2)| place.abs().cmple(half).all();
    let inside: Vec<DVec2> = places.iter().zip(&points).filter(on_sample).map(|(_, pixel)| *pixel).collect();
    let center = inside.iter().sum::<DVec2>() / inside.len() as f64;
    let size = DVec2::new(rig.image_px[0] as f64, rig.image_px[1] as f64);
    // No number, and not in the picture, where no point is on the sample.
    let is_seen = center.cmpge(DVec2::ZERO).all() && center.cmplt(size).all();
    is_seen.then(|| Reflection {
        points_px: points.iter().map(|p| p.to_array()).collect(),
        center_px: center.to_array(),
        area_px: area(&corners) * inside.len() as f64 / places.len() as f64,
    })
}

impl Reflection {
    /// Distance of a highlight from where it should be, pixels.
    pub fn distance_px(&self, found_px: DVec2) -> f64 {
        found_px.distance(DVec2::from(self.center_px))
    }

    /// The highlight that a picture shows, wherever it is.
    pub fn find(&self, picture: &HdrPicture) -> Mirrored {
        find_mirrored(&picture.known(), picture.size, self.area_px)
    }

    /// The picture as eight-bit sRGB, every pixel `zoom` times as wide (1 to 16): the points of the reflection as red dots and
    /// its middle as a red cross, the rim of the highlight that was found and its middle in green. Row-major, top row first; light is
    /// shown by its logarithm, since a mirrored flash is some thousand times as bright as what is around it.
    pub fn overlay(&self, picture: &HdrPicture, found: Option<&Highlight>, zoom: usize) -> Vec<[u8; 3]> {
        let mut canvas = Canvas::new(picture, zoom.clamp(1, 16));
        if let Some(highlight) = found {
            canvas.rim(highlight);
        }
        self.points_px.iter().for_each(|p| canvas.cross((*p).into(), DOT, EXPECTED));
        canvas.cross(self.center_px.into(), ARM, EXPECTED);
        found.into_iter().for_each(|h| canvas.cross(h.center_px, ARM, FOUND));
        canvas.pixels
    }
}

/// A picture that is drawn upon.
struct Canvas {
    /// Of the picture.
    size: [usize; 2],
    zoom: usize,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    fn new(picture: &HdrPicture, zoom: usize) -> Self {
        let shown = tone_mapped(picture);
        let [width, height] = picture.size;
        let at = |k: usize| shown[k / (width * zoom) / zoom * width + k % (width * zoom) / zoom];
        let pixels = (0..width * height * zoom * zoom).map(at).collect();
        Self { size: picture.size, zoom, pixels }
    }

    fn set(&mut self, x: i64, y: i64, color: [u8; 3]) {
        let [width, height] = self.size.map(|n| (n * self.zoom) as i64);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            self.pixels[(y * width + x) as usize] = color;
        }
    }

    /// A cross of a reach about a place, both in pixels of the picture.
    fn cross(&mut self, place: DVec2, reach: f64, color: [u8; 3]) {
        let [x, y] = (place * self.zoom as f64).floor().to_array().map(|c| c as i64);
        let reach = (reach * self.zoom as f64).round() as i64;
        for k in -reach..=reach {
            self.set(x + k, y, color);
            self.set(x, y + k, color);
        }
    }

    /// The sides of a highlight's pixels behind which it ends.
    fn rim(&mut self, highlight: &Highlight) {
        let [width, zoom] = [self.size[0] as i64, self.zoom as i64];
        let is_in = |x: i64, y: i64| {
            (0..width).contains(&x)
                && y >= 0
                && highlight.pixels.binary_search(&((y * width + x) as u32)).is_ok()
        };
        for k in &highlight.pixels {
            let (x, y) = (i64::from(*k) % width, i64::from(*k) / width);
            let last = zoom - 1;
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                if !is_in(x + dx, y + dy) {
                    let side = |d: i64, t: i64| if d == 0 { t } else { d.max(0) * last };
                    (0..zoom).for_each(|t| self.set(x * zoom + side(dx, t), y * zoom + side(dy, t), FOUND));
                }
            }
        }
    }
}

/// Gray to colored by the logarithm of the light, from a share of the median to the most.
fn tone_mapped(picture: &HdrPicture) -> Vec<[u8; 3]> {
    let mut lit: Vec<f32> =
        picture.pixels.iter().flatten().copied().filter(|v| v.is_finite() && *v > 0.0).collect();
    if lit.is_empty() {
        return vec![[0; 3]; picture.pixels.len()];
    }
    lit.sort_unstable_by(f32::total_cmp);
    let dark = DARK * f64::from(lit[lit.len() / 2]);
    let range = (f64::from(lit[lit.len() - 1]) / dark).ln();
    let encode =
        |v: f32| (255.0 * (f64::from(v) / dark).max(1.0).ln() / range).clamp(0.0, 255.0).round() as u8;
    picture.pixels.iter().map(|p| p.map(encode)).collect()
}
