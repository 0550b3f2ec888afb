//! `carpaint measure`, `calibrate` and `fit` of a capture as programs: whole, interrupted, and with all that goes wrong.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;

use carpaint::Paint;
use carpaint::color::ResponseCurve;
use carpaint::file::{read_picture, write_picture_exr};
use carpaint::measure::calibrate::Calibration;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;

const SILVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/silver_metallic.toml");
const BLUE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/blue_metallic.toml");

/// Eleven cameras, pictures of 128 x 128.
const DOME: &str = "image_px = [128, 128]\n\
    rings = [{ cameras = 1, polar_deg = 0 }, { cameras = 4, polar_deg = 20, first_azimuth_deg = 45 }, \
    { cameras = 6, polar_deg = 42, first_azimuth_deg = 10 }]\n";

fn run(folder: &Path, arguments: &[&str]) -> Output {
    common::carpaint().current_dir(folder).args(arguments).output().unwrap()
}

fn succeed(folder: &Path, arguments: &[&str]) -> (String, String) {
    let out = run(folder, arguments);
    let [stdout, stderr] = [out.stdout, out.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(out.status.success(), "{arguments:?}: {stderr}");
    (stdout, stderr)
}

fn fail(folder: &Path, arguments: &[&str], word: &str) {
    let out = run(folder, arguments);
    let error = String::from_utf8_lossy(&out.stderr).into_owned();
    assert_eq!(out.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.contains(word), "{arguments:?}: no {word:?} in: {error}");
}

/// All files below a folder with their bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path.clone(), std::fs::read(path).unwrap());
        }
    }
    found
}

#[test]
fn a_panel_is_photographed_calibrated_and_fitted() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("dome.toml"), DOME).unwrap();
    let measure = ["measure", SILVER, "--dome", "dome.toml", "-o", "shots"];
    let (_, said) = succeed(folder, &measure);
    // Two of diodes and sixteen gray fields a camera, four exposures a pair.
    assert!(said.contains(&format!("wrote {} pictures", 11 * 18 + 121 * 4)), "{said}");
    let first = files(&folder.join("shots"));

    // What was interrupted goes on, with the same bits; what is there stays.
    for name in ["leds/c003_wide.exr", "pairs/c002/l005_e1.exr", "pairs/c010/l010_e3.exr"] {
        std::fs::remove_file(folder.join("shots").join(name)).unwrap();
    }
    let (_, said) = succeed(folder, &measure);
    assert!(said.contains("wrote 3 pictures"), "{said}");
    assert!(first == files(&folder.join("shots")));
    fail(folder, &["measure", BLUE, "--dome", "dome.toml", "-o", "shots"], "another one");
    fail(folder, &["measure", SILVER, "-o", "shots"], "another one");
    assert!(first == files(&folder.join("shots")));

    let (said, _) = succeed(folder, &["calibrate", "shots"]);
    assert!(said.contains("11 of 11 cameras calibrated") && said.contains("against the truth"), "{said}");
    fail(folder, &["validate", BLUE, "--capture", "shots"], "another one");
    overlays(folder);
    validations(folder);
    spoil(&folder.join("shots"));
    let (said, warnings) = succeed(
        folder,
        &["fit", "shots", "-o", "silver.paint.exr", "--btf", "silver.btf.exr", "--clusters", "16"],
    );
    for word in ["camera 4, light 7", "pixel (3, 5)", "camera 2, light 9"] {
        assert!(warnings.contains(word), "no {word:?} in: {warnings}");
    }
    assert!(said.contains("gloss"), "{said}");
    for (option, value) in
        [("--slice-texel-um", "0"), ("--slice-bins", "1"), ("--patch", "0,1"), ("--samples", "3")]
    {
        fail(folder, &["fit", "shots", "-o", "a.paint.exr", option, value], "expected");
    }
    fail(folder, &["fit", "shots", "-o", "a.paint.exr", "--slice-texel-um", "0.2"], "texels");
    fail(folder, &["fit", "shots", "-o", "a.paint.exr", "--flakes", BLUE], "--flakes");
    fail(folder, &["fit", "silver.btf.exr", "-o", "a.paint.exr", "--btf", "b.btf.exr"], "a capture folder");
    curves(folder);
    let paint = Paint::read(&folder.join("silver.paint.exr")).unwrap();
    // A surface that mirrored more would give back more light than it gets: 4 s at grazing angles.
    assert!(paint.flakes.is_some() && paint.coat.gloss.is_some_and(|gloss| gloss.coefficient <= 0.25));
    succeed(folder, &["inspect", "silver.btf.exr"]);
    // Under a coat of the true index, flakes beneath it, the lobes explain more.
    let coat = ["--ior", "1.5", "--refract"];
    let (said, _) = succeed(
        folder,
        &[&["fit", "shots", "-o", "refracted.paint.exr", "--clusters", "16"][..], &coat].concat(),
    );
    let error = |label: &str| -> f64 {
        let line = said.lines().find(|line| line.contains(label)).expect(label);
        let after = line.split("eq. 7 ").nth(1).expect("an error");
        after.split([',', ' ']).next().expect("a number").parse().expect("a number")
    };
    assert!(error("refracted") < error("straight"), "{said}");
    // The coat's index says what its gloss mirrors.
    let f0 = said.lines().find(|line| line.contains("gloss F0")).expect("the gloss");
    let value: f64 = f0.split_whitespace().nth(2).expect("a value").parse().expect("a number");
    assert!((value / 0.04 - 1.0).abs() < 2e-3 && f0.contains("given"), "{f0}");
    let paint = Paint::read(&folder.join("refracted.paint.exr")).unwrap();
    assert!(paint.coat.refracts && paint.coat.gloss.is_some(), "{:?}", paint.coat);
    // 12 bins of outer angles, 1.5 times as dense beneath the coat.
    assert_eq!(paint.flakes.unwrap().grid.bins(), 18);
}

/// Against the paint that was photographed, with light going straight on and beneath the coat it has.
fn validations(folder: &Path) {
    let validate = |more: &[&str]| -> Value {
        let always = ["validate", SILVER, "--capture", "shots", "--json"];
        serde_json::from_str(&succeed(folder, &[&always[..], more].concat()).0).unwrap()
    };
    let [straight, refracting] = [&[][..], &["--refract"]].map(validate);
    let delta_e = |report: &Value, theta: usize| {
        let at = &report["colors"][theta / 5 - 1];
        assert_eq!(at["theta_deg"].as_f64(), Some(theta as f64));
        at["mean"].as_f64().unwrap()
    };
    assert_eq!(straight["fit"]["coat"]["refracts"], false);
    assert_eq!(refracting["fit"]["coat"]["refracts"], true);
    assert_eq!(refracting["fit"]["coat"]["ior"], 1.5);
    // Cameras end at 42 degrees. At 80 what goes straight on says nothing, and what refracts has seen steep angles beneath the coat.
    assert!(delta_e(&refracting, 20) < 2.0 && delta_e(&straight, 20) < 3.0, "{straight:#} {refracting:#}");
    assert!(delta_e(&refracting, 80) < 0.5 * delta_e(&straight, 80), "{straight:#} {refracting:#}");
    for report in [&straight, &refracting] {
        assert!(report["radiance"]["of_means"].as_f64().unwrap() < 0.01, "{}", report["radiance"]);
        assert!(!report["slice_errors"].as_array().unwrap().is_empty());
    }
}

/// The check of figure 7: tiles of 128 pixels, three times as wide, the flash where it should be in red, where it is in green.
fn overlays(folder: &Path) {
    let draw = |pair: &[&str]| {
        let (_, said) = succeed(folder, &[&["calibrate", "shots", "--overlay", "a.png"][..], pair].concat());
        let lines: Vec<String> =
            said.lines().filter(|l| l.starts_with("overlay, row")).map(str::to_owned).collect();
        (lines, image::open(folder.join("a.png")).unwrap().to_rgb8())
    };
    let (lines, several) = draw(&[]);
    let columns = lines.len().min(3) as u32;
    // Lines of four pixels between them.
    let side = |tiles: u32| 388 * tiles - 4;
    assert!(
        lines.len() > 1 && several.dimensions() == (side(columns), side((lines.len() as u32).div_ceil(3)))
    );
    let (camera, light) = lines[1].split_once("camera ").unwrap().1.split_once(", flash ").unwrap();
    let pair = format!("{camera},{}", light.split_once(':').unwrap().0);
    let (line, one) = draw(&["--pair", &pair]);
    assert!(line.len() == 1 && one.dimensions() == (384, 384), "{line:?}");
    let tile = image::imageops::crop_imm(&several, 388, 0, 384, 384).to_image();
    assert!(tile == one, "the second tile is that pair");
    for color in [[255, 40, 40], [60, 255, 60]] {
        assert!(one.pixels().filter(|p| p.0 == color).count() > 12, "{color:?}");
    }
    for (arguments, word) in [
        (&["--overlay", "a.txt"][..], ".png"),
        (&["--overlay", "b.png", "--pair", "0,11"], "no such camera"),
        (&["--overlay", "b.png", "--pair", "1,1"], "mirrored beside"),
    ] {
        fail(folder, &[&["calibrate", "shots"][..], arguments].concat(), word);
    }
    assert!(!folder.join("b.png").exists());
}

/// Measured response curves, as the renderer reads them.
fn curves(folder: &Path) {
    succeed(folder, &["calibrate", "shots", "-o", "again.json", "--curves", "curves"]);
    let calibration = std::fs::read_to_string(folder.join("again.json")).unwrap();
    let calibration = Calibration::from_json(&calibration).unwrap();
    for (camera, response) in calibration.responses.iter().enumerate() {
        let text = std::fs::read_to_string(folder.join(format!("curves/c{camera:03}.txt"))).unwrap();
        let curve = ResponseCurve::parse(&text).unwrap();
        assert_eq!(curve, response.as_ref().unwrap().curve().unwrap());
        // From darkness to saturation: the first channel says 1 of light 1.
        let most = [0, 1, 2].map(|c| curve.response(1.0, c)).into_iter().fold(0.0, f64::max);
        assert!(curve.response(0.0, 1) < 0.1 && most > 0.99, "{most}");
    }
    let render = ["render", "silver.paint.exr", "--size", "24x32", "--samples", "1", "--device", "cpu"];
    let through = ["-o", "a.png", "--tone-map", "camera:curves/c003.txt"];
    succeed(folder, &[&render[..], &through].concat());
    let onto_a_file = ["calibrate", "shots", "-o", "b.json", "--curves", "again.json"];
    fail(folder, &onto_a_file, "again.json: output: found a file");
    assert!(!folder.join("b.json").exists());
}

/// A picture with a pixel that is no number, and one cut off.
fn spoil(shots: &Path) {
    for exposure in 0..4 {
        let path = shots.join(format!("pairs/c004/l007_e{exposure}.exr"));
        let (size, mut pixels) = read_picture(&path).unwrap();
        pixels[5 * size[0] + 3][1] = f32::NAN;
        write_picture_exr(&path, size, &pixels).unwrap();
        let path = shots.join(format!("pairs/c002/l009_e{exposure}.exr"));
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    }
}

#[test]
fn what_is_no_capture_is_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("dome.toml"), "radius = 3").unwrap();
    fail(folder, &["measure", SILVER, "--dome", "dome.toml", "-o", "shots"], "dome.toml");
    fail(folder, &["measure", SILVER, "--noise=-1", "-o", "shots"], "noise");
    fail(folder, &["measure", "dome.toml", "-o", "shots"], "dome.toml");
    fail(folder, &["measure", SILVER, "-o", "dome.toml"], "dome.toml: output: found a file");
    assert!(!folder.join("shots").exists(), "nothing is made in vain");
    fail(folder, &["calibrate", "shots"], "capture.json");
    std::fs::create_dir(folder.join("shots")).unwrap();
    fail(folder, &["calibrate", "shots"], "capture.json");
    fail(folder, &["fit", "shots", "-o", "a.paint.exr"], "capture.json");
    for (text, word) in [
        ("", "capture"),
        ("{\"kind\": \"paint\", \"version\": 1}", "kind of file"),
        ("{\"kind\": \"capture\", \"version\": 2, \"rig\": {}}", "version"),
        ("{\"kind\": \"capture\", \"version\": 1, \"rig\": {}}", "rig"),
    ] {
        std::fs::write(folder.join("shots/capture.json"), text).unwrap();
        fail(folder, &["calibrate", "shots"], word);
    }
    assert!(!folder.join("a.paint.exr").exists());
}
