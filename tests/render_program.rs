//! `carpaint render` and `carpaint compare` on pictures: what they write, what they say, how they exit.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]
#![cfg(feature = "cli")]

mod common;

use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::file::write_picture_exr;
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, RenderPaint, ToneMap, render};
use carpaint::scene::{Scene, Shape};

fn paint() -> Paint {
    Paint {
        coat: ClearCoat::ideal(1.5, false),
        diffuse: 0.1,
        lobes: vec![Lobe { coefficient: 0.1, roughness: 0.3, f0: 0.5 }],
        colors: ColorTable::white(),
        flakes: None,
        provenance: serde_json::Value::Null,
    }
}

#[test]
fn compare_tells_equal_from_different_from_bad() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let gray = |v: f32, size: [usize; 2]| Picture { size, pixels: vec![[v; 3]; size[0] * size[1]] };
    gray(0.5, [4, 3]).write(&file("a.png"), 0.0, &ToneMap::Srgb).unwrap();
    gray(0.5, [4, 3]).write(&file("b.exr"), 0.0, &ToneMap::Srgb).unwrap();
    gray(0.6, [4, 3]).write(&file("c.png"), 0.0, &ToneMap::Srgb).unwrap();
    gray(0.5, [3, 4]).write(&file("d.png"), 0.0, &ToneMap::Srgb).unwrap();
    std::fs::write(file("e.png"), b"no picture").unwrap();
    let code = |a: &str, b: &str, more: &[&str]| {
        let mut command = common::carpaint();
        command.arg("compare").arg(file(a)).arg(file(b)).args(more);
        command.output().unwrap().status.code()
    };
    assert_eq!(code("a.png", "a.png", &[]), Some(0));
    // Half a step of 8 bits.
    assert_eq!(code("a.png", "b.exr", &["--tolerance", "0.002"]), Some(0));
    assert_eq!(code("a.png", "c.png", &["--json"]), Some(1));
    assert_eq!(code("a.png", "c.png", &["--tolerance", "0.1"]), Some(0));
    for (a, b) in [("a.png", "d.png"), ("a.png", "e.png"), ("a.png", "missing.png"), ("a.png", "a.jpg")] {
        assert_eq!(code(a, b, &[]), Some(2), "{a} {b}");
    }
    assert_eq!(code("a.png", "a.png", &["--tolerance", "nan"]), Some(2));
}

#[test]
fn render_writes_what_the_library_renders_and_nothing_on_errors() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    paint().write(&file("a.paint.exr")).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = common::carpaint();
        command.current_dir(folder.path()).arg("render").args(arguments);
        command.output().unwrap()
    };
    let size = ["--size", "20x30", "--samples", "2", "--seed", "9", "--shape", "sphere", "--device", "cpu"];
    let outputs = ["a.paint.exr", "-o", "a.png", "-o", "a.exr"];
    let output = run(&[&outputs[..], &size[..]].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("a.png")
            && said.contains("a.exr")
            && said.contains("clipped")
            && said.contains("device: CPU"),
        "{said}"
    );
    let scene = Scene { size: [20, 30], shape: Shape::named("sphere").unwrap(), ..Scene::default() };
    let options = Options { samples: 2, seed: 9, ..Options::default() };
    let stored = Paint::read(&file("a.paint.exr")).unwrap();
    let expected = render(&scene, &[RenderPaint::new(&stored).unwrap()], &options, &|| ()).unwrap();
    assert_eq!(Picture::read(&file("a.exr")).unwrap(), expected);
    std::fs::write(file("bad.toml"), "[camera]\nfov = 3").unwrap();
    std::fs::write(file("objects.toml"), "[[object]]\n[[object]]\npaint = 1").unwrap();
    for bad in [
        &["a.paint.exr", "-o", "x.jpg"][..],
        &["a.paint.exr", "-o", "x.png", "--scene", "bad.toml"],
        &["a.paint.exr", "-o", "x.png", "--scene", "missing.toml"],
        &["a.paint.exr", "-o", "x.png", "--scene", "objects.toml"],
        &["a.paint.exr", "a.paint.exr", "-o", "x.png", "--scene", "objects.toml", "--shape", "sphere"],
        &["a.paint.exr", "-o", "x.png", "--size", "20"],
        &["a.paint.exr", "-o", "x.png", "--size", "0x7"],
        &["a.paint.exr", "-o", "x.png", "--shape", "cube"],
        &["a.paint.exr", "-o", "x.png", "--samples", "0"],
        &["a.paint.exr", "-o", "x.png", "--device", "abacus"],
        &["a.paint.exr", "-o", "x.png", "--exposure", "nan"],
        &["a.exr", "-o", "x.png"],
        &["missing.paint.exr", "-o", "x.png"],
    ] {
        assert_eq!(run(bad).status.code(), Some(2), "{bad:?}");
        assert!(!file("x.png").exists() && !file("x.jpg").exists());
    }
}

#[test]
fn objects_wear_the_paints_in_one_picture() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    paint().write(&file("a.paint.exr")).unwrap();
    Paint { diffuse: 0.8, ..paint() }.write(&file("b.paint.exr")).unwrap();
    let text = "size = [30, 20]\n[[object]]\npaint = 0\n[[object]]\nposition_mm = [30, 0, 0]\npaint = 1";
    std::fs::write(file("s.toml"), text).unwrap();
    let run = |paints: &[&str]| {
        let mut command = common::carpaint();
        command.current_dir(folder.path()).arg("render").args(paints);
        command.args(["-o", "x.exr", "--scene", "s.toml", "--device", "cpu", "--samples", "1"]);
        command.output().unwrap()
    };
    let output = run(&["a.paint.exr", "b.paint.exr"]);
    assert!(output.status.success());
    let paints =
        ["a.paint.exr", "b.paint.exr"].map(|n| RenderPaint::new(&Paint::read(&file(n)).unwrap()).unwrap());
    let options = Options { samples: 1, ..Options::default() };
    let expected = render(&Scene::parse(text).unwrap(), &paints, &options, &|| ()).unwrap();
    assert_eq!(expected.size, [30, 20]);
    assert_eq!(Picture::read(&file("x.exr")).unwrap(), expected);
    let output = run(&["a.paint.exr"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(said.contains("object 1: paint: found 1, expected 0 to 0"), "{said}");
}

#[test]
fn files_of_a_scene_are_found_beside_it_and_bad_ones_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::create_dir(file("scenes")).unwrap();
    paint().write(&file("a.paint.exr")).unwrap();
    let picture = |name: &str, pixel: [f32; 3]| {
        write_picture_exr(&file("scenes").join(name), [2, 1], &[[0.5; 3], pixel]).unwrap();
    };
    picture("good.exr", [1.0, 2.0, 65504.0]);
    picture("negative.exr", [1.0, -2.0, 3.0]);
    picture("nan.exr", [f32::NAN, 2.0, 3.0]);
    std::fs::write(file("scenes").join("cut.hdr"), "#?RADIANCE\n\n-Y 99999999 +X 99999999\n").unwrap();
    std::fs::write(file("scenes").join("a.jpg"), "no picture").unwrap();
    let run_text = |text: &str| {
        std::fs::write(file("scenes").join("s.toml"), text).unwrap();
        let mut command = common::carpaint();
        command.current_dir(folder.path()).args(["render", "a.paint.exr", "-o", "x.png"]);
        command.args(["--scene", "scenes/s.toml", "--size", "8x8", "--device", "cpu"]);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let run = |name: &str| run_text(&format!("[environment]\nkind = \"image\"\npath = \"{name}\""));
    for (name, words) in [
        ("negative.exr", &["scenes/negative.exr", "pixel (1, 0)", "-2"][..]),
        ("nan.exr", &["pixel (1, 0)", "NaN"]),
        ("cut.hdr", &["cut.hdr", "99999999"]),
        ("a.jpg", &["extension of a panorama: found jpg, expected exr or hdr"]),
        ("missing.exr", &["missing.exr"]),
        ("..", &["extension"]),
    ] {
        let (code, said) = run(name);
        assert!(code == Some(2) && words.iter().all(|word| said.contains(word)), "{name}: {said}");
        assert!(!file("x.png").exists());
    }
    for (name, text, words) in [
        ("none.obj", "v 0 0 0", &["scene: shape: scenes/none.obj", "triangles with an area: found none"][..]),
        ("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3", &["nan.obj", "vertex 2", "NaN"]),
        ("cut.glb", "glTF\u{2}\0\0\0\u{ff}\0\0\0", &["cut.glb", "glTF"]),
        ("a.stl", "solid", &["found stl, expected glb, gltf or obj"]),
    ] {
        std::fs::write(file("scenes").join(name), text).unwrap();
        let (code, said) = run_text(&format!("[shape]\nkind = \"mesh\"\npath = \"{name}\""));
        assert!(code == Some(2) && words.iter().all(|word| said.contains(word)), "{name}: {said}");
        assert!(!file("x.png").exists());
    }
    let (code, said) = run("good.exr");
    assert!(code == Some(0) && file("x.png").exists(), "{said}");
}

#[test]
fn the_device_is_named_or_missed() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    paint().write(&file("a.paint.exr")).unwrap();
    let run = |device: &str, without_drivers: bool| {
        let mut command = common::carpaint();
        command.current_dir(folder.path()).args(["render", "a.paint.exr", "-o", "a.png", "--size", "8x8"]);
        command.args(["--device", device]);
        if without_drivers {
            // Where the loaders of Vulkan and EGL look for drivers.
            let loaders = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "__EGL_VENDOR_LIBRARY_FILENAMES"];
            command.envs(loaders.map(|name| (name, file("none"))));
        }
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = run("auto", false);
    assert!(code == Some(0) && said.contains("device: "), "{said}");
    // Not everywhere do drivers come from these loaders: then a GPU is found, and named.
    let (code, said) = run("gpu", true);
    let missed = code == Some(2) && (said.contains("GPU adapter") || said.contains("feature gpu"));
    assert!(missed || code == Some(0) && said.contains("device: "), "{said}");
    assert_eq!(run("auto", true).0, Some(0));
}

#[test]
fn a_camera_says_what_its_response_curve_says() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    paint().write(&file("a.paint.exr")).unwrap();
    // A camera that says half of the light, at most half: with one stop more, the light itself.
    std::fs::write(file("half.txt"), "0 0\n1 0.5\n").unwrap();
    std::fs::write(file("bad.txt"), "0 0\n1 2\n").unwrap();
    let run = |name: &str, tone_map: &str| {
        let mut command = common::carpaint();
        command.current_dir(folder.path()).args([
            "render",
            "a.paint.exr",
            "--size",
            "24x32",
            "--samples",
            "1",
        ]);
        command.args(["--exposure", "1", "--device", "cpu", "-o", name, "--tone-map", tone_map]);
        command.output().unwrap()
    };
    assert!(run("a.exr", "srgb").status.success());
    assert!(run("a.png", "camera:half.txt").status.success());
    let linear = Picture::read(&file("a.exr")).unwrap();
    let coded = image::open(file("a.png")).unwrap().to_rgb8();
    for (light, code) in linear.pixels.iter().zip(coded.pixels()) {
        for (light, code) in light.iter().zip(code.0) {
            // Rounded to eight bits, from numbers that are not f64 in the file.
            assert!((light.min(0.5) * 255.0 - f32::from(code)).abs() < 0.501, "{light} {code}");
        }
    }
    for (name, said) in [("bad.txt", "response: found 2"), ("missing.txt", "missing.txt")] {
        let output = run("b.png", &format!("camera:{name}"));
        assert_eq!(output.status.code(), Some(2));
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(text.contains(name) && text.contains(said), "{text}");
    }
    assert_eq!(run("b.png", "filmic").status.code(), Some(2));
    assert!(!file("b.png").exists());
}
