//! Pictures: eight-bit PNG and linear EXR.

use super::atomic::write_atomically;
use super::container::exr_error;
use super::text::open;
use crate::error::{Error, Result};
use exr::prelude::*;
use image::{ExtendedColorType, ImageDecoder, ImageEncoder};
use std::io::BufReader;
use std::path::Path;

/// Largest side of a picture, pixels.
const MAX_SIDE: usize = 1 << 16;
/// Most pixels of a picture.
const MAX_PIXELS: usize = 1 << 27;

/// Pixels that any file may claim to hold.
const FREE_PIXELS: usize = 1 << 20;
/// Most bytes that a byte of a file unpacks to: deflate (PNG; EXR's ZIP, and its PXR24, which drops a fourth) gives up to 1032,
/// JPEG up to 1366 (a bit for a block of 8 x 8 pixels, of both hues for sixteen such), run lengths, PIZ and B44 less.
pub(super) const MOST_UNPACKED: u64 = 2048;

/// Kinds of picture files, told apart by their extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// Eight bits, sRGB.
    Png,
    /// Linear Rec.709, f32.
    Exr,
}

impl PictureFormat {
    /// The format that a file name asks for.
    ///
    /// # Errors
    /// An extension other than `png` or `exr`.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            found => {
                let found = found.unwrap_or("none");
                Err(Error::invalid(path.display().to_string(), "extension of a picture", found, "png or exr"))
            }
        }
    }
}

/// Writes an eight-bit RGB PNG, whole or not at all. `pixels` row-major, top row first.
///
/// # Errors
/// Those of the file system; a number of pixels that does not fit.
pub fn write_png(path: &Path, size: [usize; 2], pixels: &[[u8; 3]]) -> Result<()> {
    check_size(size, pixels.len()).map_err(|e| e.in_file(path))?;
    write_atomically(path, |w| {
        image::codecs::png::PngEncoder::new(w)
            .write_image(pixels.as_flattened(), size[0] as u32, size[1] as u32, ExtendedColorType::Rgb8)
            .map_err(|e| image_error(path, "PNG", e))
    })
}

/// Writes linear RGB, f32, losslessly compressed, whole or not at all.
///
/// # Errors
/// Those of the file system; a number of pixels that does not fit.
pub fn write_picture_exr(path: &Path, size: [usize; 2], pixels: &[[f32; 3]]) -> Result<()> {
    check_size(size, pixels.len()).map_err(|e| e.in_file(path))?;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = pixels[at.y() * size[0] + at.x()];
        (r, g, b)
    });
    let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::UNCOMPRESSED };
    let image = Image::from_encoded_channels((size[0], size[1]), encoding, channels);
    write_atomically(path, |w| image.write().to_buffered(w).map_err(|e| exr_error(path, e)))
}

/// Reads a picture as linear RGB: size (columns, rows) and pixels, row-major, top row first. A PNG of 8 or 16 bits, gray or
/// RGB, is decoded from sRGB, its alpha dropped; of an EXR the first part with R, G and B is taken.
///
/// # Errors
/// Another extension, a folder, no such file, a damaged or truncated file, sides above 65,536, more than 2^27 pixels, a
/// value that is not finite (its pixel named).
pub fn read_picture(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    match PictureFormat::of(path)? {
        PictureFormat::Png => read_png(path),
        PictureFormat::Exr => read_exr(path),
    }
}

/// Reads a panorama as linear RGB, OpenEXR or Radiance (`.hdr`): size (columns, rows) and pixels, row-major, top row first.
///
/// # Errors
/// As [`read_picture`], with the extensions `exr` and `hdr`.
pub fn read_panorama(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("exr") => read_exr(path),
        Some("hdr") => read_hdr(path),
        found => {
            let found = found.unwrap_or("none");
            Err(Error::invalid(path.display().to_string(), "extension of a panorama", found, "exr or hdr"))
        }
    }
}

fn read_hdr(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let (file, length) = open(path)?;
    let complaint = |e| image_error(path, "Radiance", e);
    let decoder = image::codecs::hdr::HdrDecoder::new(BufReader::new(file)).map_err(complaint)?;
    let (width, height) = decoder.dimensions();
    let size = [width as usize, height as usize];
    // A byte a channel and one for the exponent.
    check_claim(size, 32, length).map_err(|e| e.in_file(path))?;
    let decoded = image::DynamicImage::from_decoder(decoder).map_err(complaint)?;
    Ok((size, decoded.into_rgb32f().pixels().map(|p| p.0).collect()))
}

fn read_png(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let (file, length) = open(path)?;
    let decoder =
        image::codecs::png::PngDecoder::new(BufReader::new(file)).map_err(|e| image_error(path, "PNG", e))?;
    decode(path, "PNG", length, decoder)
}

/// Decodes a picture in sRGB to linear RGB, once its size is known to be legal, and one that `length` bytes can hold.
pub(super) fn decode(
    path: &Path,
    kind: &str,
    length: u64,
    mut decoder: impl ImageDecoder,
) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let (width, height) = decoder.dimensions();
    let size = [width as usize, height as usize];
    let bits = decoder.original_color_type().bits_per_pixel();
    check_claim(size, bits.into(), length).map_err(|e| e.in_file(path))?;
    let upright = decoder.orientation().map_err(|e| image_error(path, kind, e))?;
    let mut decoded = image::DynamicImage::from_decoder(decoder).map_err(|e| image_error(path, kind, e))?;
    decoded.apply_orientation(upright);
    let size = [decoded.width() as usize, decoded.height() as usize];
    let linear = |c: [f32; 3]| -> [f32; 3] { palette::Srgb::from(c).into_linear().into() };
    Ok((size, decoded.into_rgb32f().pixels().map(|p| linear(p.0)).collect()))
}

pub(super) fn read_exr(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let (file, length) = open(path)?;
    let meta = MetaData::read_from_unbuffered(file, false).map_err(|e| exr_error(path, e))?;
    for header in &meta.headers {
        let size = [header.layer_size.width(), header.layer_size.height()];
        let bits = 8 * header.channels.bytes_per_pixel as u64;
        check_claim(size, bits, length).map_err(|e| e.in_file(path))?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size: Vec2<usize>, _| (size.width(), vec![[0.0f32; 3]; size.area()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|e| exr_error(path, e))?;
    let (width, pixels) = image.layer_data.channel_data.pixels;
    if let Some(k) = pixels.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        let place = format!("{}: pixel ({}, {})", path.display(), k % width, k / width);
        return Err(Error::invalid(place, "value", format!("{:?}", pixels[k]), "finite numbers"));
    }
    Ok(([width, pixels.len() / width.max(1)], pixels))
}

/// Refuses a size beyond the caps, or beyond what a file of `length` bytes can hold, before anything is allocated.
fn check_claim(size: [usize; 2], bits_per_pixel: u64, length: u64) -> Result<()> {
    let pixels = size[0].saturating_mul(size[1]);
    check_size(size, pixels)?;
    let unpacked = pixels as u64 * bits_per_pixel / 8;
    if pixels <= FREE_PIXELS || unpacked <= length.saturating_mul(MOST_UNPACKED) {
        return Ok(());
    }
    let found = format!("{} x {} in {length} bytes", size[0], size[1]);
    let legal = format!("up to {MOST_UNPACKED} bytes of pixels a byte of the file");
    Err(Error::invalid("picture", "size", found, legal))
}

fn check_size(size: [usize; 2], pixels: usize) -> Result<()> {
    let found = format!("{} x {}", size[0], size[1]);
    if size.iter().any(|n| !(1..=MAX_SIDE).contains(n)) || size[0] * size[1] > MAX_PIXELS {
        return Err(Error::invalid("picture", "size", found, "sides of 1 to 65536, up to 134217728 pixels"));
    }
    if pixels != size[0] * size[1] {
        return Err(Error::invalid("picture", "pixels", pixels, format!("{} ({found})", size[0] * size[1])));
    }
    Ok(())
}

pub(super) fn image_error(path: &Path, kind: &str, error: image::ImageError) -> Error {
    match error {
        image::ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            Error::io(path, source)
        }
        other => Error::invalid(
            path.display().to_string(),
            format!("not a readable {kind} file"),
            other,
            format!("a complete {kind} file"),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_survive_the_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let exr = folder.path().join("a.exr");
        let pixels = [[0.0, -1.5, 3e4], [1e-9, 0.25, 1.0], [0.5; 3], [2.0; 3], [0.1; 3], [7.0; 3]];
        write_picture_exr(&exr, [3, 2], &pixels).unwrap();
        assert_eq!(read_picture(&exr).unwrap(), ([3, 2], pixels.to_vec()));
        let png = folder.path().join("a.PNG");
        write_png(&png, [2, 1], &[[0, 128, 255], [64, 1, 2]]).unwrap();
        let (size, back) = read_picture(&png).unwrap();
        assert_eq!(size, [2, 1]);
        // IEC 61966-2-1 of 128/255, in f32.
        assert!((back[0][1] - 0.215_860_5).abs() < 1e-6, "{back:?}");
        assert_eq!([back[0][0], back[0][2]], [0.0, 1.0]);
    }

    #[test]
    fn every_truncation_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.exr"] {
            let path = folder.path().join(name);
            match PictureFormat::of(&path).unwrap() {
                PictureFormat::Png => write_png(&path, [4, 3], &[[9, 99, 199]; 12]).unwrap(),
                PictureFormat::Exr => write_picture_exr(&path, [4, 3], &[[0.3; 3]; 12]).unwrap(),
            }
            let bytes = std::fs::read(&path).unwrap();
            // A PNG is complete with its pixels: the last 12 bytes only say that nothing follows.
            let needed = if name == "a.png" { bytes.len() - 12 } else { bytes.len() };
            for length in 0..needed {
                std::fs::write(&path, &bytes[..length]).unwrap();
                assert!(
                    read_picture(&path).is_err(),
                    "{length} of {} bytes of {name} were accepted",
                    bytes.len()
                );
            }
        }
    }

    #[test]
    fn radiance_files_are_read_and_their_truncations_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.hdr");
        // Shared exponent 129: a byte counts 2^(129 - 128 - 8).
        let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
        bytes.extend([128, 64, 0, 129, 255, 0, 1, 140]);
        std::fs::write(&path, &bytes).unwrap();
        let (size, pixels) = read_panorama(&path).unwrap();
        assert_eq!((size, pixels), ([2, 1], vec![[1.0, 0.5, 0.0], [4080.0, 0.0, 16.0]]));
        for length in 0..bytes.len() {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(read_panorama(&path).is_err(), "{length} bytes were accepted");
        }
        assert!(read_panorama(&folder.path().join("a.png")).is_err());
    }

    #[test]
    fn hostile_pictures_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        write_picture_exr(&path, [2, 1], &[[0.0; 3], [0.0, f32::NAN, 0.0]]).unwrap();
        let message = read_picture(&path).unwrap_err().to_string();
        assert!(message.contains("a.exr") && message.contains("pixel (1, 0)"), "{message}");
        assert!(read_picture(folder.path()).is_err(), "a folder");
        assert!(read_picture(&folder.path().join("a.jpg")).is_err(), "another extension");
        assert!(write_png(&folder.path().join("b.png"), [2, 2], &[[0; 3]; 3]).is_err());
        // A header that claims 2^31 - 1 columns and rows.
        let png = folder.path().join("c.png");
        write_png(&png, [1, 1], &[[1, 2, 3]]).unwrap();
        let mut bytes = std::fs::read(&png).unwrap();
        bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        std::fs::write(&png, bytes).unwrap();
        assert!(read_picture(&png).is_err());
    }
}
