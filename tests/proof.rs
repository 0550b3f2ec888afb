//! Soft proofs: laws of prints, and `carpaint proof` as a program.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

mod common;
#[path = "common/folder.rs"]
mod folder;

use carpaint::brdf::{Ink, LobeGeometry};
use carpaint::color::{
    Illuminant, WHITE_XYZ, bradford, delta_e_2000, into_gamut, lab_from_rgb, luminance, rgb_from_xyz,
};
use carpaint::file::{read_picture, write_picture_exr, write_png};
use carpaint::proof::{Coverage, Halftone, InkLimit, Method, Separation};
use carpaint::render::{InkModel, Options, Paper, Picture, Print, PrintInks, own_inks, render_print};
use carpaint::scene::{Camera, DirectionalLight, Environment, Scene, Shape};
use folder::Folder;
use glam::DVec3;

/// A panel that fills the picture, and a lamp that it mirrors about its middle.
fn panel(side: usize) -> Scene {
    Scene {
        size: [side, side],
        shape: Shape::Panel { size_mm: [60.0, 60.0], normal: [0.0, -1.0, 0.0] },
        camera: Camera { position_mm: [0.0, -220.0, 0.0], vertical_fov_deg: 13.0, ..Camera::default() },
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![
            DirectionalLight {
                direction: [0.2, -1.0, 0.1],
                irradiance: [2.0; 3],
                ..DirectionalLight::default()
            }
            .into(),
        ],
        ..Scene::default()
    }
}

fn coverage(method: Method, side: usize) -> Coverage {
    let pixel = |k: usize| {
        let (x, y) = ((k % side) as f32 / side as f32, (k / side) as f32 / side as f32);
        [0.5 * x, 0.4 * (1.0 - x) * y, 0.3 * y * y]
    };
    let pixels: Vec<_> = (0..side * side).map(pixel).collect();
    let separation = Separation::new([side, side], &pixels, InkLimit::Scale).unwrap();
    Coverage::new(method.halftone(&separation, 2, 1).unwrap())
}

fn mean(picture: &Picture) -> DVec3 {
    let sum: DVec3 = picture.pixels.iter().map(|p| DVec3::from(p.map(f64::from))).sum();
    sum / picture.pixels.len() as f64
}

/// Far away dots become tones: the light of the print stays the same to half a percent, from three pixels a dot to thirty
/// dots a pixel.
#[test]
fn the_mean_tone_outlives_minification() {
    // A rough ink shines alike everywhere, so that eight pixels know its light as well as 720 do: what is left are the dots.
    let rough: Vec<Ink> =
        own_inks().unwrap().into_iter().map(|ink| ink.with_roughness(1.0).unwrap()).collect();
    let ready = PrintInks::new(&rough, InkModel::Goniochromatic, &Illuminant::D65.spectrum(), false).unwrap();
    for method in [Method::ErrorDiffusion, Method::BlueNoise] {
        let coverage = coverage(method, 120);
        let print = Print { inks: &ready, coverage: &coverage, paper: Paper::NONE };
        let of = |side: usize| {
            let options = Options { samples: 1, ..Options::default() };
            mean(&render_print(&panel(side), &print, &options, &|| ()).unwrap())
        };
        let near = of(720);
        for side in [240, 100, 33, 8] {
            let far = of(side);
            let off = (far / near - 1.0).abs().max_element();
            println!("{method:?}, {side} pixels: mean off by {off:.1e}");
            assert!(off < 5e-3, "{method:?} {side}: {off}");
        }
    }
}

/// What a pixel shows is irradiance times the color of the spectrum, of ink and paper.
#[test]
fn a_pixel_is_the_color_of_the_spectrum_it_reflects() {
    let inks = own_inks().unwrap();
    for (light, adapted) in [(Illuminant::D65, false), (Illuminant::A, false), (Illuminant::A, true)] {
        let ready = PrintInks::new(&inks, InkModel::Goniochromatic, &light.spectrum(), adapted).unwrap();
        for (k, ink) in inks.iter().enumerate() {
            let coverage = Coverage::new(Halftone::new([1, 1], vec![k as u8 + 1]).unwrap());
            let print = Print { inks: &ready, coverage: &coverage, paper: Paper::NONE };
            let scene = panel(1);
            let picture =
                render_print(&scene, &print, &Options { samples: 1, ..Options::default() }, &|| ()).unwrap();
            let wi = DVec3::new(0.2, 0.1, 1.0).normalize();
            let f = ink.spectrum(&LobeGeometry::of(wi, DVec3::Z));
            let shown = DVec3::from(picture.pixels[0].map(f64::from));
            let white = if adapted { light.white() } else { Illuminant::D65.white() };
            let xyz = bradford(white, WHITE_XYZ) * f.xyz(&light.spectrum());
            let expected = rgb_from_xyz(xyz) * (2.0 * wi.z);
            // Roundings of f32 of 41 terms and of a narrow lobe's tangent.
            assert!(shown.distance(expected) < 1e-5 * expected.length(), "{light:?} {k}: {shown} {expected}");
        }
    }
}

/// Seen from the front the picture stands upright, its left on the left, on whatever it is printed.
#[test]
fn pictures_are_upright_on_every_shape() {
    let ready =
        PrintInks::new(&own_inks().unwrap(), InkModel::Goniochromatic, &Illuminant::D65.spectrum(), true)
            .unwrap();
    // Red and green above, blue and nothing below.
    let coverage = Coverage::new(Halftone::new([2, 2], vec![1, 2, 3, 0]).unwrap());
    let print = Print { inks: &ready, coverage: &coverage, paper: Paper::NONE };
    for name in Shape::PRINTED {
        let lamp = DirectionalLight {
            direction: [0.0, -1.0, 0.0],
            irradiance: [3.0; 3],
            ..DirectionalLight::default()
        };
        let camera = Camera { position_mm: [0.0, -220.0, 0.0], ..Camera::default() };
        let shape = Shape::printed(name, 1.0).unwrap();
        let scene = Scene { size: [64, 64], shape, camera, lights: vec![lamp.into()], ..panel(64) };
        let picture =
            render_print(&scene, &print, &Options { samples: 1, ..Options::default() }, &|| ()).unwrap();
        let at = |x: usize, y: usize| picture.pixels[y * 64 + x];
        let brightest = |rgb: [f32; 3]| (0..3).max_by(|a, b| rgb[*a].total_cmp(&rgb[*b])).unwrap();
        let [a, b, c, d] = [(29, 29), (34, 29), (29, 34), (34, 34)].map(|(x, y)| at(x, y));
        assert_eq!([a, b, c].map(brightest), [0, 1, 2], "{name}: {a:?} {b:?} {c:?}");
        assert_eq!(d, [0.0; 3], "{name}");
    }
}

/// How many wavelengths a proof needs: color over mirror directions, at the luminance of paper white.
#[test]
fn few_wavelengths_are_enough() {
    let inks = own_inks().unwrap();
    let light = Illuminant::D65.spectrum();
    let colors = |ready: &PrintInks| -> Vec<DVec3> {
        let lit = (0..3).flat_map(|ink| (0..=14).map(move |k| (ink, f64::from(5 * k).to_radians())));
        lit.map(|(ink, theta)| {
            let (wi, wo) =
                (DVec3::new(theta.sin(), 0.0, theta.cos()), DVec3::new(-theta.sin(), 0.0, theta.cos()));
            ready.reflectance(glam::Vec3::AXES[ink], wi.as_vec3(), wo.as_vec3()).as_dvec3()
        })
        .collect()
    };
    let at = |count: usize| {
        let grid = carpaint::color::Wavelengths::even(count).unwrap();
        colors(&PrintInks::at(&grid, &inks, InkModel::Goniochromatic, &light, false).unwrap())
    };
    let truth = at(41);
    let worst = |found: Vec<DVec3>| {
        let lab = |rgb: DVec3, white: f64| lab_from_rgb(rgb / white);
        let pairs = truth.iter().zip(&found);
        let errors = pairs.map(|(a, b)| {
            let white = 2.0 * luminance(*a);
            delta_e_2000(lab(*a, white), lab(*b, white))
        });
        errors.fold(0.0, f64::max)
    };
    let [fine, half, sixteen] = [81, 21, 16].map(|count| worst(at(count)));
    println!("Delta-E 2000 at most: 81: {fine:.3}, 21: {half:.3}, 16: {sixteen:.3}");
    // Every other of them is that of 41, and nothing between bands counts.
    assert!(fine < 1e-3, "{fine}");
    // 21 are within what the eye sees just so.
    assert!(half < 1.0 && half < sixteen, "{half} {sixteen}");
    let xyz = worst(colors(&PrintInks::tristimulus(&inks, &light, false).unwrap()));
    println!("three numbers: {xyz:.3}");
    // One exponential for a sum of many: off by more than the eye sees just so, and by less than a step between neighbors of a color
    // chart.
    assert!(xyz > half && xyz < 5.0, "{xyz}");
}

/// A folder with `a.png`, 48 x 36.
fn prints() -> Folder {
    let f = Folder::new(&["proof"]);
    let pixel = |k: usize| [(k % 48 * 5) as u8, (k / 48 * 7) as u8, 255 - (k % 48 * 5) as u8];
    write_png(&f.path("a.png"), [48, 36], &(0..48 * 36).map(pixel).collect::<Vec<_>>()).unwrap();
    f
}

const SMALL: [&str; 6] = ["--size", "48x36", "--samples", "2", "--device", "cpu"];

#[test]
fn the_program_proofs_under_every_light_and_model() {
    let f = prints();
    let run = |name: &str, more: &[&str]| {
        let said = f.json(&[&["a.png", "-o", name, "--json"], &SMALL[..], more].concat());
        let tone: f64 = (0..3).map(|c| said["mean_tone"][c].as_f64().unwrap()).sum();
        assert!(tone > 0.0 && tone <= 1.0);
        read_picture(&f.path(name)).unwrap()
    };
    let plain = run("plain.exr", &[]);
    assert_eq!(plain.0, [48, 36]);
    let mut seen = vec![plain];
    for more in [
        &["--illuminant", "A"][..],
        &["--illuminant", "a", "--adapted"],
        &["--model", "schlick"],
        &["--model", "exact"],
        &["--roughness", "0.4"],
        &["--paper", "none"],
        &["--paper", "0.1,2,0.3"],
        &["--back-light"],
        &["--wavelengths", "16"],
        &["--wavelengths", "xyz"],
        &["--shape", "panel"],
        &["--shape", "sphere"],
        &["--shape", "capsule"],
        &["--cell", "3"],
        &["--method", "blue-noise"],
        &["--ink-limit", "clip"],
        &["--exposure", "1"],
    ] {
        let found = run("next.exr", more);
        // Exposure is for eight bits alone.
        assert_eq!(seen.contains(&found), more[0] == "--exposure", "{more:?}");
        seen.push(found);
    }
    // The lamp as a file.
    let d65 = Illuminant::D65.spectrum();
    let line = |(k, power): (usize, &f64)| format!("{},{power}\n", 380 + 10 * k);
    std::fs::write(f.path("lamp.csv"), d65.0.iter().enumerate().map(line).collect::<String>()).unwrap();
    assert_eq!(run("lamp.exr", &["--illuminant", "lamp.csv"]), seen[0]);
    // Eight bits by the gamut rule.
    run("plain.png", &["--exposure", "0"]);
    let shown = read_picture(&f.path("plain.png")).unwrap().1;
    for (png, exr) in shown.iter().zip(&seen[0].1) {
        let expected = into_gamut(DVec3::from(exr.map(f64::from)));
        let off = (DVec3::from(png.map(f64::from)) - expected).abs().max_element();
        // Half a step of eight bits is 0.5 % of white near white.
        assert!(off < 0.006, "{png:?} {expected}");
    }
}

#[test]
fn a_halftone_is_taken_as_it_is_and_threads_change_nothing() {
    let f = prints();
    let dots = |program: &Folder| {
        let mut command = common::carpaint();
        command.current_dir(program.path(".")).args(["halftone", "a.png", "-o", "dots.png"]);
        assert!(command.output().unwrap().status.success());
    };
    dots(&f);
    f.succeed(&[&["a.png", "-o", "one.exr"], &SMALL[..]].concat());
    f.succeed(&[&["dots.png", "-o", "two.exr", "--halftoned"], &SMALL[..]].concat());
    let [one, two] = ["one.exr", "two.exr"].map(|name| std::fs::read(f.path(name)).unwrap());
    assert_eq!(one, two);
    for threads in ["1", "8"] {
        let mut command = common::carpaint();
        command.env("RAYON_NUM_THREADS", threads).current_dir(f.path("."));
        let out = command.args(["proof", "a.png", "-o", "more.exr"]).args(SMALL).output().unwrap();
        assert!(out.status.success());
        assert_eq!(std::fs::read(f.path("more.exr")).unwrap(), one, "{threads} threads");
    }
}

#[test]
fn bad_input_is_named() {
    let f = prints();
    let rgba = image::RgbaImage::from_pixel(4, 4, image::Rgba([1, 2, 3, 128]));
    rgba.save(f.path("alpha.png")).unwrap();
    // Start of image, a frame of four components, and the end.
    let frame =
        [0xFF, 0xD8, 0xFF, 0xC0, 0, 20, 8, 0, 4, 0, 4, 4, 1, 17, 0, 2, 17, 0, 3, 17, 0, 4, 17, 0, 0xFF, 0xD9];
    std::fs::write(f.path("cmyk.jpg"), frame).unwrap();
    write_png(&f.path("overlap.png"), [2, 1], &[[255, 0, 0], [255, 255, 0]]).unwrap();
    write_png(&f.path("gray.png"), [2, 1], &[[255, 0, 0], [0, 99, 0]]).unwrap();
    write_picture_exr(&f.path("negative.exr"), [1, 1], &[[0.1, -0.5, 0.1]]).unwrap();
    std::fs::write(f.path("um.csv"), "0.38 1\n0.78 1\n").unwrap();
    std::fs::write(f.path("order.csv"), "780 1\n380 1\n").unwrap();
    std::fs::write(f.path("bad.ink.json"), "{}").unwrap();
    let bad = ["bad.ink.json"; 3];
    std::fs::write(f.path("dark.toml"), "light = []\n").unwrap();
    std::fs::write(f.path("bare.toml"), "[shape]\nkind = \"speed-shape\"\nlength_mm = 50.0\n").unwrap();
    for (image, more, words) in [
        ("none.png", &[][..], &["none.png"][..]),
        ("alpha.png", &[], &["alpha.png", "alpha"]),
        ("cmyk.jpg", &[], &["cmyk.jpg", "CMYK"]),
        ("overlap.png", &["--halftoned"], &["overlap.png", "(1, 0)"]),
        ("gray.png", &["--halftoned"], &["gray.png", "99"]),
        ("negative.exr", &[], &["negative.exr", "-0.5"]),
        ("a.png", &["--illuminant", "F11"], &["--illuminant", "F11", "D65, A or a file"]),
        ("a.png", &["--illuminant", "um.csv"], &["um.csv", "micrometres"]),
        ("a.png", &["--illuminant", "order.csv"], &["order.csv", "ascending"]),
        ("a.png", &["--roughness", "0"], &["--roughness", "alpha"]),
        ("a.png", &["--paper", "1,2"], &["HIGHLIGHT"]),
        ("a.png", &["--paper", "2,2,0"], &["highlight"]),
        ("a.png", &["--back-light", "2"], &["--back-light", "0 to 1"]),
        ("a.png", &["--wavelengths", "1"], &["2 to 4096"]),
        ("a.png", &["--wavelengths", "xyz", "--model", "exact"], &["--model", "goniochromatic"]),
        ("a.png", &["--shape", "speed-shape"], &["--shape", "sheet"]),
        ("a.png", &["--scene", "dark.toml"], &["lamps: found none"]),
        ("overlap.png", &["--halftoned", "--cell", "3"], &["--halftoned"]),
        ("a.png", &["--scene", "bare.toml"], &["texture coordinates: found none"]),
        ("a.png", &["--cell", "99"], &["cell"]),
        ("a.png", &["--inks", bad[0], bad[1], bad[2]], &["bad.ink.json", "kind"]),
    ] {
        f.fail(&[&[image, "-o", "x.png"], more].concat(), words);
    }
    f.fail(&["a.png", "-o", "a.png"], &["a.png"]);
    f.fail(&["a.png", "-o", "a.jpg"], &["png or exr"]);
    // Nor is a file replaced that the scene reads.
    write_picture_exr(&f.path("room.exr"), [2, 1], &[[1.0; 3]; 2]).unwrap();
    std::fs::write(f.path("room.toml"), "[environment]\nkind = \"image\"\npath = \"room.exr\"\n").unwrap();
    f.fail(
        &["a.png", "--scene", "room.toml", "-o", "room.exr"],
        &["room.exr", "an input of the same command"],
    );
}
