//! Saving: pictures rendered anew by the offline renderer, and paints.

use super::job::Progress;
use super::picture::Request;
use super::worn::Worn;
use crate::error::{Error, Result};
use crate::file::{PictureFormat, check_output};
use crate::paint::Paint;
use crate::render::{Options, Picture, RenderPaint, ToneMap, render, tick_count};
use std::fmt;
use std::path::{Path, PathBuf};

/// What was saved.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// What is in it, for people.
    pub what: String,
}

impl Saved {
    /// A picture of so many rays a pixel.
    pub fn picture(path: PathBuf, [width, height]: [usize; 2], samples: usize) -> Self {
        Self { path, what: format!("{width} \u{00d7} {height} pixels, {samples} rays each") }
    }
}

impl fmt::Display for Saved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "saved {} ({})", self.path.display(), self.what)
    }
}

/// A picture to save.
#[derive(Debug, Clone)]
pub struct Order {
    /// One or two pictures of one size.
    pub requests: Vec<Request>,
    /// Where two share one picture, share of the width; none: side by side.
    pub split: Option<f64>,
    /// File to write.
    pub path: PathBuf,
    /// Rays a pixel.
    pub samples: usize,
}

impl Order {
    /// Renders and writes.
    ///
    /// # Errors
    /// Those of rendering and of the file system; another extension than those of pictures.
    pub fn run(&self, progress: &Progress) -> Result<Saved> {
        PictureFormat::of(&self.path)?;
        check_output(&self.path)?;
        let mut pictures = Vec::new();
        for request in &self.requests {
            let tick = progress.begin("rendering", tick_count(&request.scene));
            let (flakes, seed) = (request.flakes, request.seed);
            let options = Options { samples: self.samples, flakes, seed, ..Options::default() };
            let paint = |worn: &Worn| Ok(worn.ready()?.paint.clone());
            let paints: Vec<RenderPaint> = request.worn.iter().map(paint).collect::<Result<_>>()?;
            pictures.push(render(&request.scene, &paints, &options, &tick)?);
        }
        let stops = self.requests.first().map_or(0.0, |request| request.scene.exposure_stops);
        let picture = joined(pictures, self.split)
            .ok_or_else(|| Error::invalid("save picture", "pictures", "none", "one or two"))?;
        picture.write(&self.path, stops, &ToneMap::default())?;
        Ok(Saved::picture(self.path.clone(), picture.size, self.samples))
    }
}

/// One picture of one or two of the same size: the columns left of the split of the first and the others of the second, or both
/// side by side.
pub fn joined(pictures: Vec<Picture>, split: Option<f64>) -> Option<Picture> {
    let mut pictures = pictures.into_iter();
    let (first, second) = (pictures.next()?, pictures.next());
    let Some(second) = second else { return Some(first) };
    let [width, height] = first.size;
    let (kept, size) = match split {
        Some(share) => ((share * width as f64).round() as usize, [width, height]),
        None => (width, [2 * width, height]),
    };
    let rows = first.pixels.chunks(width).zip(second.pixels.chunks(width));
    let skipped = 2 * width - size[0];
    let skipped = if skipped == 0 { 0 } else { kept };
    let pixels = rows.flat_map(|(a, b)| [&a[..kept], &b[skipped..]].concat()).collect();
    Some(Picture { size, pixels })
}

/// Writes a paint.
///
/// # Errors
/// A name that does not end in `.paint.exr`; those of writing.
pub fn paint(paint: &Paint, path: &Path) -> Result<Saved> {
    if !path.to_string_lossy().to_ascii_lowercase().ends_with(".paint.exr") {
        return Err(Error::invalid("save paint", "name", path.display(), "one that ends in .paint.exr"));
    }
    paint.write(path)?;
    let flakes = if paint.flakes.is_some() { "with flakes" } else { "without flakes" };
    Ok(Saved { path: path.to_owned(), what: format!("paint {flakes}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pictures_become_one() {
        let of = |value: f32| Picture { size: [4, 2], pixels: vec![[value; 3]; 8] };
        let beside = joined(vec![of(1.0), of(2.0)], None).unwrap();
        assert_eq!(beside.size, [8, 2]);
        assert_eq!(beside.pixels[3..5], [[1.0; 3], [2.0; 3]]);
        let split = joined(vec![of(1.0), of(2.0)], Some(0.25)).unwrap();
        assert_eq!(split.size, [4, 2]);
        assert_eq!(split.pixels[4..6], [[1.0; 3], [2.0; 3]]);
        assert_eq!(joined(vec![of(3.0)], Some(0.5)).unwrap(), of(3.0));
        assert!(joined(Vec::new(), None).is_none());
    }
}
