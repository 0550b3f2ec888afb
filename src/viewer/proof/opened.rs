//! Files that the window of a print opens.

use super::super::job::Progress;
use crate::brdf::Ink;
use crate::color::{Spectrum, read_emission};
use crate::error::{Error, Result};
use crate::file::read_print_image;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An image that is printed.
#[derive(Debug)]
pub struct Image {
    /// Its file.
    pub path: PathBuf,
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear Rec.709, row-major, top row first.
    pub pixels: Vec<[f32; 3]>,
}

impl PartialEq for Image {
    /// The same one, not one alike: pixels are many, and this is asked at every frame.
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl Image {
    /// Reads an image.
    ///
    /// # Errors
    /// As [`read_print_image`].
    pub fn read(path: &Path) -> Result<Self> {
        let (size, pixels) = read_print_image(path)?;
        Ok(Self { path: path.to_owned(), size, pixels })
    }

    /// Width over height.
    pub fn proportions(&self) -> f64 {
        self.size[0] as f64 / self.size[1] as f64
    }
}

/// What a file holds, read without a fault.
#[derive(Debug)]
pub enum Opened {
    /// An image.
    Image(Arc<Image>),
    /// An ink.
    Ink(Box<Ink>),
    /// The emission of a lamp, and its name.
    Emission(String, Box<Spectrum>),
}

impl Opened {
    /// Reads a file, by its name's end.
    ///
    /// # Errors
    /// Another end; those of reading it.
    pub fn read(path: &Path, progress: &Progress) -> Result<Self> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let _tick = progress.begin(&format!("reading {name}"), 1);
        let lower = name.to_lowercase();
        let ends = |suffixes: &[&str]| suffixes.iter().any(|suffix| lower.ends_with(suffix));
        if ends(&[".ink.json"]) {
            Ok(Self::Ink(Box::new(Ink::read(path)?)))
        } else if ends(&[".csv"]) {
            Ok(Self::Emission(name, Box::new(read_emission(path)?)))
        } else if ends(&[".png", ".jpg", ".jpeg"]) {
            Ok(Self::Image(Arc::new(Image::read(path)?)))
        } else {
            let legal = "an image (.png, .jpg), an ink (.ink.json) or an emission (.csv)";
            Err(Error::invalid(path.display().to_string(), "kind of file", name, legal))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_a_file_is() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let read = |path: PathBuf| Opened::read(&path, &Progress::silent());
        let image = folder.path().join("A.PNG");
        crate::file::write_png(&image, [3, 2], &[[9; 3]; 6]).unwrap();
        assert!(matches!(read(image), Ok(Opened::Image(image)) if image.proportions() == 1.5));
        let ink = include_bytes!("../../../fixtures/inks/red.ink.json");
        assert!(matches!(read(write("a.ink.json", ink)), Ok(Opened::Ink(_))));
        let lamp = read(write("lamp.csv", b"nm,power\n380,1\n780,2\n"));
        assert!(matches!(lamp, Ok(Opened::Emission(name, _)) if name == "lamp.csv"));
        for (name, words) in [("a.toml", "an ink (.ink.json)"), ("b.jpg", "JPEG"), ("c.csv", "wavelengths")] {
            let message = read(write(name, b"")).unwrap_err().to_string();
            assert!(message.contains(words) && message.contains(name), "{message}");
        }
    }
}
