//! Saving pictures of a print, rendered anew by the reference renderer.

use super::super::job::Progress;
use super::super::save::{Saved, joined};
use super::made::Maker;
use super::request::Request;
use crate::error::{Error, Result};
use crate::file::{PictureFormat, check_output};
use crate::render::{Options, ToneMap, render_print, tick_count};
use std::path::PathBuf;

/// A picture to save.
#[derive(Debug, Clone)]
pub struct Save {
    /// One or two pictures of one size.
    pub requests: Vec<Request>,
    /// Exposure, stops.
    pub stops: f64,
    /// Where two share one picture, share of the width; none: side by side.
    pub split: Option<f64>,
    /// File to write.
    pub path: PathBuf,
    /// Rays a pixel.
    pub samples: usize,
}

impl Save {
    /// Renders and writes.
    ///
    /// # Errors
    /// Those of rendering and of the file system; another extension than those of pictures.
    pub fn run(&self, progress: &Progress) -> Result<Saved> {
        PictureFormat::of(&self.path)?;
        check_output(&self.path)?;
        let (mut maker, mut pictures) = (Maker::default(), Vec::new());
        let options = Options { samples: self.samples, ..Options::default() };
        for request in &self.requests {
            let tick = progress.begin("rendering", tick_count(&request.scene));
            let made = maker.make(request)?;
            pictures.push(render_print(&request.scene, &made.print(), &options, &tick)?);
        }
        let picture = joined(pictures, self.split)
            .ok_or_else(|| Error::invalid("save picture", "pictures", "none", "one or two"))?;
        picture.write(&self.path, self.stops, &ToneMap::InGamut)?;
        Ok(Saved::picture(self.path.clone(), picture.size, self.samples))
    }
}
