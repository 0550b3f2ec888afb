//! A capture as a folder: `capture.json` for the [`Rig`], and one plain RGB OpenEXR file a picture.

use super::{Images, Picture, Rig, Shot};
use crate::error::{Error, Result};
use crate::file::{check_kind, read_picture, read_text};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Kind of the JSON.
const KIND: &str = "capture";
/// Version of the layout.
const VERSION: u64 = 1;
/// Longest `capture.json`: a thousand cameras and ten thousand diodes are a megabyte.
const MAX_BYTES: u64 = 1 << 24;

/// An open capture folder; pictures come from their files when they are asked for.
#[derive(Debug, Clone)]
pub struct CaptureFolder {
    path: PathBuf,
    rig: Rig,
}

impl CaptureFolder {
    /// Opens a folder.
    ///
    /// # Errors
    /// No `capture.json`, another kind or a newer version, unknown or missing keys, numbers that [`Rig::validate`] refuses.
    pub fn open(path: &Path) -> Result<Self> {
        let file = Self::json_path(path);
        let rig = Self::parse(&read_text(&file, MAX_BYTES)?).map_err(|e| e.in_file(&file))?;
        Ok(Self { path: path.to_owned(), rig })
    }

    fn parse(text: &str) -> Result<Rig> {
        let wrong = |e: &dyn std::fmt::Display| Error::invalid("", "capture", e, "the keys of this version");
        let mut value: Value = serde_json::from_str(text).map_err(|e| wrong(&e))?;
        check_kind(&value, KIND, VERSION)?;
        let rig = value.get_mut("rig").map(Value::take).unwrap_or_default();
        let rig: Rig = serde_path_to_error::deserialize(rig).map_err(|e| wrong(&e).within("rig"))?;
        rig.validate()?;
        Ok(rig)
    }

    /// The text of `capture.json`.
    pub fn describe(rig: &Rig) -> String {
        format!("{:#}\n", json!({ "kind": KIND, "version": VERSION, "rig": rig }))
    }

    /// Where the description of a capture is.
    pub fn json_path(folder: &Path) -> PathBuf {
        folder.join("capture.json")
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Where a picture of a capture is, in its folder.
pub fn picture_path(folder: &Path, shot: Shot) -> PathBuf {
    folder.join(match shot {
        Shot::LedsWide { camera } => format!("leds/c{camera:03}_wide.exr"),
        Shot::LedsZoom { camera } => format!("leds/c{camera:03}_zoom.exr"),
        Shot::Response { camera, step } => format!("response/c{camera:03}_s{step:02}.exr"),
        Shot::Pair { camera, light, exposure } => format!("pairs/c{camera:03}/l{light:03}_e{exposure}.exr"),
    })
}

impl Images for CaptureFolder {
    fn rig(&self) -> &Rig {
        &self.rig
    }

    fn picture(&self, shot: Shot) -> Result<Picture> {
        let path = picture_path(&self.path, shot);
        let (size, mut pixels) = read_picture(&path)?;
        if size != self.rig.image_px {
            let legal = format!("{:?} (capture.json)", self.rig.image_px);
            return Err(Error::invalid("picture", "size", format!("{size:?}"), legal).in_file(&path));
        }
        let white = self.rig.white_level as f32;
        for (k, pixel) in pixels.iter_mut().enumerate() {
            if pixel.iter().any(|c| !(0.0..=white).contains(c)) {
                let place = format!("pixel ({}, {})", k % size[0], k / size[0]);
                let found = format!("{pixel:?}");
                return Err(Error::invalid(place, "value", found, format!("0 to {white}")).in_file(&path));
            }
            *pixel = pixel.map(|c| c / white);
        }
        Ok(Picture { size, pixels })
    }
}
