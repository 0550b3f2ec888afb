//! A picture: linear radiance, and how it becomes eight bits.

use super::tone_map::ToneMap;
use crate::color::luminance;
#[cfg(feature = "files")]
use crate::{error::Result, file};
use glam::DVec3;
use rayon::prelude::*;
#[cfg(feature = "files")]
use std::path::Path;

/// Linear Rec.709 radiance, any finite value.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Pixels, row-major, top row first.
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// Share of a print's picture that is white where nobody says how it is exposed, see [`Picture::exposure`].
    pub const WHITE_SHARE: f64 = 0.005;

    /// The picture in eight bits: radiance times 2^`exposure_stops`, as `tone_map` codes it.
    pub fn encode(&self, exposure_stops: f64, tone_map: &ToneMap) -> Vec<[u8; 3]> {
        let scale = exposure_stops.exp2();
        let code = |p: &[f32; 3]| tone_map.code(p.map(|c| f64::from(c) * scale));
        self.pixels.par_iter().map(|p| code(p).map(|c| (c * 255.0).round() as u8)).collect()
    }

    /// Exposure, stops, -64 to 64, at which `share` of the pixels, 0 to 1, are as bright as white or brighter; 0 where too few shine.
    pub fn exposure(&self, share: f64) -> f64 {
        let rgb = |p: &[f32; 3]| DVec3::from(p.map(f64::from));
        let mut light: Vec<f64> = self.pixels.par_iter().map(|p| luminance(rgb(p))).collect();
        let brighter = (share * light.len() as f64) as usize;
        let Some(place) = light.len().checked_sub(brighter.saturating_add(1)) else { return 0.0 };
        // Not sorted: a window asks this of every picture.
        let (_, white, _) = light.select_nth_unstable_by(place, f64::total_cmp);
        if *white > 0.0 { (-white.log2()).clamp(-64.0, 64.0) } else { 0.0 }
    }

    /// Share of the pixels that sRGB ([`ToneMap::Srgb`]) clips: a component below 0 or above 1.
    pub fn clipped(&self, exposure_stops: f64) -> f64 {
        let scale = exposure_stops.exp2();
        let clips = |p: &&[f32; 3]| p.iter().any(|c| !(0.0..=1.0).contains(&(f64::from(*c) * scale)));
        self.pixels.iter().filter(clips).count() as f64 / self.pixels.len().max(1) as f64
    }

    /// Writes the picture, whole or not at all: `.png` is [`Picture::encode`], `.exr` is linear, f32, as rendered, no exposure
    /// applied.
    ///
    /// # Errors
    /// Another extension, those of the file system.
    #[cfg(feature = "files")]
    pub fn write(&self, path: &Path, exposure_stops: f64, tone_map: &ToneMap) -> Result<()> {
        match file::PictureFormat::of(path)? {
            file::PictureFormat::Png => {
                file::write_png(path, self.size, &self.encode(exposure_stops, tone_map))
            }
            file::PictureFormat::Exr => file::write_picture_exr(path, self.size, &self.pixels),
        }
    }

    /// Reads a PNG (decoded to linear) or an EXR picture.
    ///
    /// # Errors
    /// As [`file::read_picture`].
    #[cfg(feature = "files")]
    pub fn read(path: &Path) -> Result<Self> {
        let (size, pixels) = file::read_picture(path)?;
        Ok(Self { size, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_and_clipping() {
        let picture = Picture {
            size: [2, 2],
            pixels: vec![[0.0, 0.5, 1.0], [0.25; 3], [-0.1, 0.2, 0.2], [2.0, 0.0, 0.0]],
        };
        assert_eq!(picture.encode(0.0, &ToneMap::Srgb)[..2], [[0, 188, 255], [137; 3]]);
        assert_eq!(picture.encode(1.0, &ToneMap::Srgb)[0], [0, 255, 255]);
        assert_eq!(picture.clipped(0.0), 0.5);
        assert_eq!(picture.clipped(-1.0), 0.25);
        // Two of the four are at least as bright as that of 0.25.
        assert!((picture.exposure(0.5) - 2.0).abs() < 1e-6, "{}", picture.exposure(0.5));
        assert_eq!(Picture { size: [1, 1], pixels: vec![[0.0; 3]] }.exposure(0.1), 0.0);
    }
}
