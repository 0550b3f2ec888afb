//! Images to be printed: PNG, JPEG and OpenEXR, in the colors that files say and in no others.
//!
//! A print has no transparency, and an image in inks (CMYK) was separated for other inks than ours: decoders drop the one and
//! guess at the other, so that both are looked for and refused here.

use super::picture::{decode, image_error, read_exr};
use super::text::open;
use crate::error::{Error, Result};
use exr::meta::MetaData;
use image::ImageDecoder;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use std::path::Path;

/// Largest JPEG file, bytes: it is read as a whole.
const MAX_JPEG_BYTES: u64 = 1 << 29;

/// Reads an image to be printed as linear RGB: size (columns, rows) and pixels, row-major, top row first. PNG and JPEG, gray or
/// RGB, are decoded from sRGB; upright as the camera held them; embedded profiles are left aside. Of an EXR the first part with R, G and B is
/// taken.
///
/// # Errors
/// Another extension than `png`, `jpg`, `jpeg` or `exr`, a folder, no such file, a damaged or truncated file, transparency (an
/// alpha channel, or a transparent color of a PNG), a JPEG in CMYK or YCCK, sides above 65,536, more than 2^27 pixels, a value
/// that is not finite (its pixel named).
pub fn read_print_image(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("png") => read_opaque_png(path),
        Some("jpg" | "jpeg") => read_jpeg(path),
        Some("exr") => read_opaque_exr(path),
        found => {
            let (place, found) = (path.display().to_string(), found.unwrap_or("none"));
            Err(Error::invalid(place, "extension of an image to print", found, "png, jpg, jpeg or exr"))
        }
    }
}

fn read_opaque_png(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let (file, length) = open(path)?;
    let decoder =
        image::codecs::png::PngDecoder::new(BufReader::new(file)).map_err(|e| image_error(path, "PNG", e))?;
    // A transparent color (tRNS) counts: the decoder makes it a channel.
    if decoder.color_type().has_alpha() {
        return Err(transparent(path, "an alpha channel or a transparent color (tRNS)"));
    }
    decode(path, "PNG", length, decoder)
}

fn read_opaque_exr(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let (file, _) = open(path)?;
    let meta =
        MetaData::read_from_unbuffered(file, false).map_err(|e| super::container::exr_error(path, e))?;
    let channels = meta.headers.iter().flat_map(|h| &h.channels.list);
    // Of a layer: `layer.A`.
    if let Some(alpha) =
        channels.map(|c| c.name.to_string()).find(|name| name.rsplit('.').next() == Some("A"))
    {
        return Err(transparent(path, &format!("channel {alpha}")));
    }
    read_exr(path)
}

fn transparent(path: &Path, found: &str) -> Error {
    Error::invalid(path.display().to_string(), "transparency", found, "an opaque image")
}

fn read_jpeg(path: &Path) -> Result<([usize; 2], Vec<[f32; 3]>)> {
    let bytes = read_bytes(open(path)?.0, path)?;
    match jpeg_components(&bytes).map_err(|e| e.in_file(path))? {
        1 | 3 => {}
        4 => {
            let (place, legal) = (path.display().to_string(), "1 (gray) or 3 (color)");
            return Err(Error::invalid(place, "color components", "4 (CMYK or YCCK)", legal));
        }
        found => {
            let place = path.display().to_string();
            return Err(Error::invalid(place, "color components", found, "1 (gray) or 3 (color)"));
        }
    }
    let length = bytes.len() as u64;
    let decoder = image::codecs::jpeg::JpegDecoder::new(Cursor::new(bytes))
        .map_err(|e| image_error(path, "JPEG", e))?;
    decode(path, "JPEG", length, decoder)
}

fn read_bytes(file: File, path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(MAX_JPEG_BYTES + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    if bytes.len() as u64 > MAX_JPEG_BYTES {
        let legal = format!("up to {MAX_JPEG_BYTES}");
        return Err(Error::invalid(path.display().to_string(), "number of bytes", "more", legal));
    }
    Ok(bytes)
}

/// Number of color components that the frame of a JPEG declares (ITU-T T.81, annex B), all of whose segments are there up to
/// the end of the image: the decoder fills what a truncated file lacks with gray.
fn jpeg_components(bytes: &[u8]) -> Result<u8> {
    let damaged = |at: usize, what: &str| {
        Error::invalid(format!("byte {at}"), "not a readable JPEG file", what, "a complete JPEG file")
    };
    if !bytes.starts_with(&[0xff, 0xd8]) {
        return Err(damaged(0, "no start of image"));
    }
    let mut components = None;
    let mut at = 2;
    loop {
        let rest = bytes.get(at..).unwrap_or_default();
        match *rest {
            // Fill bytes, stuffed bytes and restarts.
            [0xff, 0xff, ..] => at += 1,
            [0xff, 0x00 | 0x01 | 0xd0..=0xd7, ..] => at += 2,
            [0xff, 0xd9, ..] => return components.ok_or_else(|| damaged(at, "no frame")),
            [0xff, marker, high, low, ..] => {
                let length = usize::from(u16::from_be_bytes([high, low]));
                // Start of frame; three of its numbers have other meanings.
                if matches!(marker, 0xc0..=0xcf)
                    && !matches!(marker, 0xc4 | 0xc8 | 0xcc)
                    && components.is_none()
                {
                    components = Some(*rest.get(9).ok_or_else(|| damaged(at, "an incomplete frame"))?);
                }
                at += 2 + length.max(2);
            }
            // Data of a scan; nothing else stands between segments.
            [_, _, ..] if components.is_some() => at += 1,
            [_, _, ..] => return Err(damaged(at, "no segment")),
            _ => return Err(damaged(bytes.len(), "its end")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::write_png;
    use exr::prelude::*;
    use image::{ExtendedColorType, ImageEncoder};

    fn message(path: &std::path::Path) -> String {
        read_print_image(path).unwrap_err().to_string()
    }

    fn jpeg(pixels: &[u8], size: [u32; 2], color: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100);
        encoder.write_image(pixels, size[0], size[1], color).unwrap();
        bytes
    }

    fn png(path: &std::path::Path, pixels: &[u8], color: ExtendedColorType) {
        let file = std::fs::File::create(path).unwrap();
        image::codecs::png::PngEncoder::new(file).write_image(pixels, 2, 1, color).unwrap();
    }

    #[test]
    fn gray_and_color_are_read_from_both_formats() {
        let folder = tempfile::tempdir().unwrap();
        let [p, j] = ["a.png", "a.JPG"].map(|n| folder.path().join(n));
        write_png(&p, [2, 1], &[[0, 128, 255], [255; 3]]).unwrap();
        let (size, pixels) = read_print_image(&p).unwrap();
        assert_eq!((size, pixels[1]), ([2, 1], [1.0; 3]));
        png(&p, &[128, 255], ExtendedColorType::L8);
        // IEC 61966-2-1 of 128/255.
        assert!((read_print_image(&p).unwrap().1[0][2] - 0.215_860_5).abs() < 1e-6);
        std::fs::write(&j, jpeg(&[128; 12], [4, 3], ExtendedColorType::L8)).unwrap();
        let (size, pixels) = read_print_image(&j).unwrap();
        assert_eq!(size, [4, 3]);
        assert!(pixels.iter().all(|p| (p[1] - 0.215_860_5).abs() < 1e-6), "{pixels:?}");
        std::fs::write(&j, jpeg(&[200, 30, 60].repeat(12), [4, 3], ExtendedColorType::Rgb8)).unwrap();
        let linear = palette::LinSrgb::from(read_print_image(&j).unwrap().1[5]);
        let encoded: [f32; 3] = palette::Srgb::from_linear(linear).into();
        let encoded = encoded.map(|c| 255.0 * c);
        // The color conversion of JPEG rounds to whole steps there and back.
        assert!(encoded.iter().zip([200.0, 30.0, 60.0]).all(|(a, b)| (a - b).abs() < 3.0), "{encoded:?}");
    }

    /// A photograph taken with the camera on its side stands upright.
    #[test]
    fn photographs_are_turned_as_they_ask() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let gray: Vec<u8> = (0..32 * 16).map(|k| if k % 32 < 16 { 0 } else { 255 }).collect();
        let mut bytes = jpeg(&gray, [32, 16], ExtendedColorType::L8);
        // Exif of one entry, orientation 6: the first column is the upper row.
        let entry = [0x12, 0x01, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0];
        let exif = [&[0xff, 0xe1, 0, 34][..], b"Exif\0\0II*\0\x08\0\0\0\x01\0", &entry].concat();
        bytes.splice(2..2, exif);
        std::fs::write(&path, bytes).unwrap();
        let (size, pixels) = read_print_image(&path).unwrap();
        assert_eq!(size, [16, 32]);
        assert!(pixels[4 * 16 + 8][0] < 0.01 && pixels[28 * 16 + 8][0] > 0.99);
    }

    #[test]
    fn transparency_is_refused_in_every_form() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for (pixels, color) in [(&[1; 8][..], ExtendedColorType::Rgba8), (&[1; 4], ExtendedColorType::La8)] {
            png(&path, pixels, color);
            assert!(message(&path).contains("transparency: found an alpha channel"), "{}", message(&path));
        }
        // A transparent color in front of the pixels, which its checksum makes legal.
        png(&path, &[1; 6], ExtendedColorType::Rgb8);
        let mut bytes = std::fs::read(&path).unwrap();
        let at = bytes.windows(4).position(|w| w == b"IDAT").unwrap() - 4;
        let chunk = [0, 0, 0, 6, b't', b'R', b'N', b'S', 0, 1, 0, 1, 0, 1];
        bytes.splice(at..at, chunk.into_iter().chain(crc(&chunk[4..]).to_be_bytes()));
        std::fs::write(&path, bytes).unwrap();
        assert!(message(&path).contains("transparency: found an alpha channel"), "{}", message(&path));
        let path = folder.path().join("a.exr");
        let channels = SpecificChannels::rgba(|_| (0.5f32, 0.5f32, 0.5f32, 1.0f32));
        Image::from_channels((2, 1), channels).write().to_file(&path).unwrap();
        assert!(message(&path).contains("transparency: found channel A, expected an opaque image"));
    }

    /// Checksum of a PNG's chunk (ISO 3309).
    fn crc(bytes: &[u8]) -> u32 {
        let step = |c: u32, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
        !bytes.iter().fold(!0, |c, b| (0..8).fold(c ^ u32::from(*b), step))
    }

    #[test]
    fn inks_of_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpeg");
        let three = jpeg(&[9; 3], [1, 1], ExtendedColorType::Rgb8);
        let frame = three.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        for (count, found) in [(4, "found 4 (CMYK or YCCK)"), (2, "found 2"), (0, "found 0")] {
            let mut bytes = three.clone();
            bytes[frame + 9] = count;
            std::fs::write(&path, bytes).unwrap();
            assert!(message(&path).contains(found) && message(&path).contains("1 (gray) or 3 (color)"));
        }
    }

    #[test]
    fn every_truncation_and_any_changed_byte_ends_without_a_panic() {
        let folder = tempfile::tempdir().unwrap();
        let gradient: Vec<u8> = (0..192).collect();
        let bytes = jpeg(&gradient, [8, 8], ExtendedColorType::Rgb8);
        let path = folder.path().join("a.jpg");
        for length in 0..bytes.len() {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(read_print_image(&path).is_err(), "{length} of {} bytes were accepted", bytes.len());
        }
        for k in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[k] ^= 0x55;
            std::fs::write(&path, changed).unwrap();
            let _ = read_print_image(&path);
        }
    }

    #[test]
    fn other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.tiff", "a.webp", "a"] {
            assert!(message(&folder.path().join(name)).contains("png, jpg, jpeg or exr"));
        }
        for name in ["a.png", "a.jpg", "a.exr"] {
            let path = folder.path().join(name);
            assert!(read_print_image(&path).is_err(), "no such file");
            std::fs::write(&path, b"II*\0not an image of this kind").unwrap();
            assert!(message(&path).contains("not a readable"), "{}", message(&path));
            assert!(read_print_image(folder.path()).is_err(), "a folder");
        }
    }
}
