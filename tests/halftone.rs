//! `carpaint halftone` as a program: dots, tones, and every refusal.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::file::{read_print_image, write_picture_exr, write_png};
use carpaint::proof::{Halftone, InkLimit, Separation};
use folder::Folder;
use std::path::Path;

const METHODS: [&str; 2] = ["error-diffusion", "blue-noise"];

/// A folder with `sky.png`, 96 x 64: gradients of all colors, up to white.
fn prints() -> Folder {
    let f = Folder::new(&["halftone"]);
    let pixel = |k: usize| [(k % 96 * 8 / 3) as u8, (k / 96 * 4) as u8, 255 - (k % 96) as u8];
    write_png(&f.path("sky.png"), [96, 64], &(0..96 * 64).map(pixel).collect::<Vec<_>>()).unwrap();
    f
}

/// The dots that a file holds; overlaps and other values than 0 and 255 are errors.
fn dots(path: &Path) -> Halftone {
    let (size, pixels) = read_print_image(path).unwrap();
    let pixels: Vec<[u8; 3]> = pixels.iter().map(|p| p.map(|c| (c * 255.0).round() as u8)).collect();
    Halftone::from_rgb(size, &pixels).unwrap()
}

#[test]
fn prints_reach_the_tones_of_the_image_and_say_so() {
    let f = prints();
    let (size, pixels) = read_print_image(&f.path("sky.png")).unwrap();
    for (name, limit) in [("scale", InkLimit::Scale), ("clip", InkLimit::Clip)] {
        let separation = Separation::new(size, &pixels, limit).unwrap();
        for method in METHODS {
            for cell in [1, 3] {
                let cell_text = cell.to_string();
                let options = ["--method", method, "--ink-limit", name, "--cell", &cell_text, "--json"];
                let said = f.json(&[&["sky.png", "-o", "dots.png"], &options[..]].concat());
                let print = dots(&f.path("dots.png"));
                assert_eq!(print.size(), [96 * cell, 64 * cell]);
                assert_eq!(said["dots"], 96 * 64 * cell * cell);
                assert_eq!(said["factor"], separation.factor());
                for c in 0..3 {
                    let mean =
                        separation.tones().iter().map(|t| f64::from(t[c])).sum::<f64>() / (96.0 * 64.0);
                    let (wished, reached) = (&said["tones"]["wished"][c], &said["tones"]["reached"][c]);
                    // Sums in another order.
                    assert!((wished.as_f64().unwrap() - mean).abs() < 1e-9);
                    assert_eq!(reached.as_f64().unwrap(), print.mean_tone()[c]);
                    // The border is 320 dots, each of which may be off at random: sqrt(320) = 18 of 6,144.
                    let error = (reached.as_f64().unwrap() - mean).abs();
                    assert!(error < 0.003, "{method} {name} {cell}: {error}");
                    // Of 256 dots, seven, as in the gradients of the library's tests.
                    let block = said["tones"]["largest_of_blocks"][c].as_f64().unwrap();
                    assert!(error <= block && block < 7.5 / 256.0, "{method} {name} {cell}: {block}");
                }
            }
        }
    }
    let text = f.succeed(&["sky.png", "-o", "dots.png"]);
    for word in ["96 x 64 = 6144 dots", "wished", "reached", "green", "16 x 16 pixels"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let f = prints();
    for method in METHODS {
        let print = |threads: &str, seed: &str| {
            let arguments =
                ["halftone", "sky.png", "-o", "dots.png", "--cell", "2", "--method", method, "--seed", seed];
            let out = common::carpaint()
                .current_dir(f.path(""))
                .env("RAYON_NUM_THREADS", threads)
                .args(arguments)
                .output()
                .unwrap();
            assert!(out.status.success());
            std::fs::read(f.path("dots.png")).unwrap()
        };
        let first = print("1", "4");
        assert_eq!(print("8", "4"), first, "{method}");
        assert_ne!(print("8", "5"), first, "{method}");
    }
}

/// The start of a JPEG in four components, up to its frame, and its end.
const CMYK: [u8; 24] =
    [0xff, 0xd8, 0xff, 0xc0, 0, 20, 8, 0, 1, 0, 1, 4, 1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0, 4, 0x11, 0];

#[test]
fn what_cannot_be_printed_is_refused() {
    let f = prints();
    let transparent = image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 255]));
    transparent.save(f.path("glass.png")).unwrap();
    f.fail(
        &["glass.png", "-o", "dots.png"],
        &["glass.png: transparency: found an alpha channel", "expected an opaque image"],
    );
    std::fs::write(f.path("cmyk.jpg"), [&CMYK[..], &[0xff, 0xd9]].concat()).unwrap();
    f.fail(
        &["cmyk.jpg", "-o", "dots.png"],
        &["cmyk.jpg: color components: found 4 (CMYK or YCCK), expected 1 (gray) or 3"],
    );
    write_picture_exr(&f.path("dark.exr"), [2, 1], &[[0.0; 3], [0.5, -0.25, 0.0]]).unwrap();
    f.fail(
        &["dark.exr", "-o", "dots.png"],
        &["dark.exr: pixel (1, 0): linear RGB: found [0.5, -0.25, 0.0]", "0 or more"],
    );
    std::fs::write(f.path("a.tiff"), b"II*\0").unwrap();
    f.fail(
        &["a.tiff", "-o", "dots.png"],
        &["extension of an image to print: found tiff, expected png, jpg, jpeg or exr"],
    );
    f.fail(&["none.png", "-o", "dots.png"], &["none.png"]);
    std::fs::write(f.path("cut.png"), &std::fs::read(f.path("sky.png")).unwrap()[..200]).unwrap();
    f.fail(&["cut.png", "-o", "dots.png"], &["cut.png: not a readable PNG file"]);
}

#[test]
fn what_cannot_be_written_or_done_is_refused() {
    let f = prints();
    f.fail(&["sky.png", "-o", "sky.png"], &["sky.png: output: found an input"]);
    f.fail(
        &["sky.png", "-o", "dots.jpg"],
        &["--output: name: found dots.jpg, expected one that ends in .png"],
    );
    for cell in ["0", "33"] {
        f.fail(
            &["sky.png", "-o", "dots.png", "--cell", cell],
            &["halftone: cell: found", "expected 1 to 32"],
        );
    }
    write_png(&f.path("large.png"), [1 << 13, 1 << 5], &vec![[0; 3]; 1 << 18]).unwrap();
    f.fail(
        &["large.png", "-o", "dots.png", "--cell", "32"],
        &["halftone: dots: found 262144 x 1024", "134217728"],
    );
    f.fail(&["sky.png", "-o", "dots.png", "--method", "dither"], &["error-diffusion", "blue-noise"]);
}
