//! The picture that is printed, and its dots.

use carpaint::error::Result;
use carpaint::file::read_print_image;
use carpaint::proof::{Halftone, InkLimit, Method, Separation};
use carpaint::render::Picture;
use std::path::Path;

/// The picture of fixtures, by half: its dots shall be seen.
pub fn image() -> Result<Picture> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/pictures/still-life.png");
    let ([width, height], pixels) = read_print_image(&path)?;
    let size = [width / 2, height / 2];
    let mean = |k: usize| {
        let (x, y) = (2 * (k % size[0]), 2 * (k / size[0]));
        let four = [0, 1, width, width + 1].map(|step| pixels[y * width + x + step]);
        [0, 1, 2].map(|c| four.iter().map(|p| p[c]).sum::<f32>() / 4.0)
    };
    Ok(Picture { size, pixels: (0..size[0] * size[1]).map(mean).collect() })
}

/// Tones of the picture, those that ask for more ink than there is paper limited one by one, and its dots, so many along a side of a
/// pixel.
pub fn print(cell: usize) -> Result<(Separation, Halftone)> {
    let image = image()?;
    let separation = Separation::new(image.size, &image.pixels, InkLimit::Clip)?;
    let dots = Method::ErrorDiffusion.halftone(&separation, cell, 1)?;
    Ok((separation, dots))
}
