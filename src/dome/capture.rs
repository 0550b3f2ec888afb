//! All pictures of a dome in a capture folder: one file each, whole or not at all, so that an interrupted capture goes on where
//! it was.

use super::{Dome, DomeOptions, Truth};
use crate::error::{Error, Result};
use crate::file::{check_output_folder, read_text, write_picture_exr, write_text};
use crate::measure::{CaptureFolder, Images, Picture, Shot, picture_path};
use crate::parallel::TryMap;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Longest description of an earlier capture.
const MAX_BYTES: u64 = 1 << 26;

/// What became of a capture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Written {
    /// Pictures written.
    pub pictures: usize,
    /// Pictures that were there from an earlier run.
    pub kept: usize,
}

/// The shots that are made and written together.
#[derive(Clone, Copy)]
enum Group {
    One(Shot),
    Pair { camera: usize, light: usize },
}

impl Dome<'_> {
    /// How often [`Dome::write`] calls its `tick`.
    pub fn ticks(&self) -> usize {
        self.groups().len()
    }

    /// Writes all pictures, `capture.json` and `truth.json` (what calibration and fit have to find) into a folder, which is made.
    /// Pictures that are there are kept, if they are of the same panel in the same dome.
    ///
    /// # Errors
    /// Those of the file system; a folder that holds another capture.
    pub fn write(&self, folder: &Path, tick: &(dyn Fn() + Sync)) -> Result<Written> {
        let groups = self.groups();
        self.claim(folder)?;
        let written = groups.into_par_iter().try_map(|group| {
            let done = self.write_group(folder, group)?;
            tick();
            Ok(done)
        })?;
        Ok(written.into_iter().fold(Written::default(), |sum, w| Written {
            pictures: sum.pictures + w.pictures,
            kept: sum.kept + w.kept,
        }))
    }

    fn groups(&self) -> Vec<Group> {
        let rig = self.rig();
        let cameras = 0..rig.cameras.len();
        let calibration = cameras.clone().flat_map(|camera| {
            let series = (0..rig.response_series.len()).map(move |step| Shot::Response { camera, step });
            [Shot::LedsWide { camera }, Shot::LedsZoom { camera }].into_iter().chain(series)
        });
        let pairs = cameras
            .clone()
            .flat_map(|camera| cameras.clone().map(move |light| Group::Pair { camera, light }));
        calibration.map(Group::One).chain(pairs).collect()
    }

    /// Makes the folders, and says whose pictures they hold.
    fn claim(&self, folder: &Path) -> Result<()> {
        check_output_folder(folder)?;
        let truth = format!("{:#}\n", self.describe_truth());
        let capture = CaptureFolder::describe(self.rig());
        let files = [(CaptureFolder::json_path(folder), capture), (truth_path(folder), truth)];
        for (path, text) in &files {
            if path.exists() && read_text(path, MAX_BYTES)? != *text {
                let legal = "an empty folder, or one with the same paint, dome and seed to go on with";
                return Err(Error::invalid(path.display().to_string(), "capture", "another one", legal));
            }
        }
        let cameras = (0..self.rig().cameras.len())
            .map(|camera| picture_path(folder, Shot::Pair { camera, light: 0, exposure: 0 }));
        let others = [Shot::LedsWide { camera: 0 }, Shot::Response { camera: 0, step: 0 }]
            .map(|shot| picture_path(folder, shot));
        for path in cameras.chain(others) {
            let parent = path.parent().unwrap_or(folder);
            std::fs::create_dir_all(parent).map_err(|e| Error::io(parent, e))?;
        }
        files.iter().filter(|(path, _)| !path.exists()).try_for_each(|(path, text)| write_text(path, text))
    }

    /// What calibration and fit have to find.
    fn describe_truth(&self) -> Value {
        json!({
            "kind": "truth of a capture",
            "version": 1,
            "truth": self.truth(),
            "dome": self.options(),
            "composition": self.model().composition(),
            "model": self.model().kind(),
        })
    }

    fn write_group(&self, folder: &Path, group: Group) -> Result<Written> {
        match group {
            Group::One(shot) => self.write_missing(folder, &[shot], || Ok(vec![self.picture(shot)?])),
            Group::Pair { camera, light } => {
                let shots: Vec<Shot> = (0..self.rig().exposures.len())
                    .map(|exposure| Shot::Pair { camera, light, exposure })
                    .collect();
                self.write_missing(folder, &shots, || Ok(self.pair(camera, light)))
            }
        }
    }

    /// Writes those of the shots that are not there; `make` makes all of them.
    fn write_missing(
        &self,
        folder: &Path,
        shots: &[Shot],
        make: impl FnOnce() -> Result<Vec<Picture>>,
    ) -> Result<Written> {
        let paths: Vec<PathBuf> = shots.iter().map(|shot| picture_path(folder, *shot)).collect();
        let kept = paths.iter().filter(|path| path.exists()).count();
        if kept == paths.len() {
            return Ok(Written { pictures: 0, kept });
        }
        let white = self.rig().white_level as f32;
        for (path, picture) in paths.iter().zip(make()?).filter(|(path, _)| !path.exists()) {
            let counts: Vec<[f32; 3]> =
                picture.pixels.iter().map(|pixel| pixel.map(|c| (c * white).round())).collect();
            write_picture_exr(path, picture.size, &counts)?;
        }
        Ok(Written { pictures: paths.len() - kept, kept })
    }
}

/// Where the truth of a virtual capture is.
pub fn truth_path(folder: &Path) -> PathBuf {
    folder.join("truth.json")
}

/// What a virtual capture was made of.
#[derive(Debug, Clone, PartialEq)]
pub struct MadeOf {
    /// What calibration has to find.
    pub truth: Truth,
    /// The dome.
    pub dome: DomeOptions,
    /// The paint's composition as JSON: read back, spectra may differ in their last bit.
    pub composition: Value,
}

impl MadeOf {
    /// Reads the truth of a virtual capture.
    ///
    /// # Errors
    /// Those of the file system; not such a file.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = truth_path(folder);
        let wrong = |e: &dyn std::fmt::Display| {
            Error::invalid(path.display().to_string(), "truth", e, "the truth of a virtual capture")
        };
        let mut value: Value = serde_json::from_str(&read_text(&path, MAX_BYTES)?).map_err(|e| wrong(&e))?;
        let mut take = |key: &str| value.get_mut(key).map(Value::take).unwrap_or_default();
        Ok(Self {
            truth: serde_json::from_value(take("truth")).map_err(|e| wrong(&e))?,
            dome: serde_json::from_value(take("dome")).map_err(|e| wrong(&e))?,
            composition: take("composition"),
        })
    }
}
