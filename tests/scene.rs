//! Scene files: hostile ones are refused with reasons, the shipped ones are legal.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::file::write_picture_exr;
use carpaint::scene::{Bodies, Environment, Object, Scene};
use glam::{DVec3, Vec3};
use std::path::{Path, PathBuf};

#[test]
fn bad_scenes_are_refused_with_reasons() {
    let refused = |text: &str, words: &[&str]| {
        let message = Scene::parse(text).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{text}: no {word} in {message}");
        }
    };
    refused("exposure = 1", &["exposure", "exposure_stops", "camera"]);
    refused("[camera]\nfov = 30", &["fov", "vertical_fov_deg"]);
    refused("[shape]\nkind = \"cube\"", &["cube", "capsule", "sphere", "panel"]);
    refused("[shape]\nkind = \"sphere\"\nradius_mm = nan", &["shape", "radius_mm", "NaN"]);
    refused("[shape]\nkind = \"capsule\"\nradius_mm = 12\nheight_mm = 20", &["height_mm", "24"]);
    refused("size = [0, 480]", &["size", "0 x 480", "16384"]);
    refused("size = [16384, 16384]", &["size", "67108864"]);
    refused("size = [-1, 480]", &["-1"]);
    refused("exposure_stops = inf", &["exposure_stops", "inf"]);
    refused("background = [0.1, -1.0, 0.0]", &["background", "-1"]);
    refused("[camera]\nposition_mm = [0, 0, 50]\nup = [0, 0, 1]", &["camera", "line of sight"]);
    refused("[camera]\nvertical_fov_deg = 180", &["vertical_fov_deg", "180", "170"]);
    refused("[[light]]\ndirection = [0, 0, 0]", &["light 0", "direction"]);
    refused("[[light]]\nangular_radius_deg = 0", &["light 0", "angular_radius_deg", "0.25"]);
    refused(
        "[environment]\nkind = \"constant\"\nradiance = [1, 1, nan]",
        &["environment", "radiance", "NaN"],
    );
    refused("[shape]\nkind = \"mesh\"", &["path"]);
    refused("[shape]\nkind = \"mesh\"\npath = \"a.obj\"\nup = \"x\"", &["x", "y", "z"]);
    refused("[shape]\nkind = \"mesh\"\npath = \"a.obj\"\nlength_mm = 0", &["shape", "length_mm"]);
    refused("[shape]\nkind = \"speed-shape\"\nlength_mm = nan", &["shape", "length_mm", "NaN"]);
    refused("[[object]]\npaint = -1", &["paint", "-1"]);
    refused("[[object]]\nturn_deg = nan", &["object 0", "turn_deg", "NaN"]);
    refused("[[object]]\n[[object]]\nposition_mm = [0, 0, 1e9]", &["object 1", "position_mm"]);
    refused("[[object]]\nshape = { kind = \"sphere\", radius_mm = 0 }", &["object 0: shape", "radius_mm"]);
    refused(&"[[object]]\n".repeat(17), &["objects", "17", "16"]);
    refused("[environment]\nkind = \"image\"", &["path"]);
    refused("[environment]\nkind = \"image\"\npath = \"a.exr\"\nscale = -1", &["environment", "scale", "-1"]);
    let sky = "[environment]\nkind = \"sky\"\nzenith = [1, 1, 1]\n";
    refused(&format!("{sky}ground = [0, 0, 0]\nsun = [1, 0, -0.1]"), &["height of the sun", "-0.1"]);
    refused(&format!("{sky}ground = [0, 2, 0]\nsun = [1, 0, 0]"), &["ground", "2"]);
    refused("not toml", &["TOML"]);
    Scene::parse("").unwrap();
    Scene::parse("[shape]\nkind = \"sphere\"\nradius_mm = 5").unwrap();
}

#[test]
fn scene_files_survive_the_round_trip_and_the_shipped_ones_are_legal() {
    for scene in [Scene::default(), Scene::strip()] {
        assert_eq!(Scene::parse(&toml::to_string(&scene).unwrap()).unwrap(), scene);
    }
    let objects = vec![Object { turn_deg: 30.0, paint: 3, ..Object::default() }, Object::default()];
    let scene = Scene { objects, ..Scene::default() };
    assert_eq!(Scene::parse(&toml::to_string(&scene).unwrap()).unwrap(), scene);
    let files: Vec<_> = std::fs::read_dir(fixtures()).unwrap().map(|f| f.unwrap().path()).collect();
    assert!(!files.is_empty());
    for file in files.iter().filter(|f| f.extension().is_some_and(|e| e == "toml")) {
        let scene = Scene::read(file).unwrap();
        Bodies::new(&scene).unwrap();
        scene.environment.surroundings().unwrap();
    }
}

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes")
}

/// `CARPAINT_BLESS=1` writes it anew.
#[test]
fn the_shipped_panorama_is_the_default_studio() {
    let size = [128, 64];
    let studio = Environment::default().surroundings().unwrap();
    let direction = |k: usize| {
        let longitude = std::f64::consts::TAU * (((k % size[0]) as f64 + 0.5) / size[0] as f64 - 0.5);
        let colatitude = std::f64::consts::PI * ((k / size[0]) as f64 + 0.5) / size[1] as f64;
        let (sin, cos) = colatitude.sin_cos();
        DVec3::new(sin * longitude.sin(), sin * longitude.cos(), cos).as_vec3()
    };
    let path = fixtures().join("studio.exr");
    if std::env::var_os("CARPAINT_BLESS").is_some() {
        let seen = |k: usize| studio.radiance(direction(k)).to_array();
        write_picture_exr(&path, size, &(0..size[0] * size[1]).map(seen).collect::<Vec<_>>()).unwrap();
    }
    let image = Environment::Image { path, turn_deg: 0.0, scale: 1.0 }.surroundings().unwrap();
    for k in 0..size[0] * size[1] {
        let [a, b]: [Vec3; 2] = [studio.radiance(direction(k)), image.radiance(direction(k))];
        // Other mathematics libraries, and the middle of a texel to a thousandth of its width: 1e-3 of an edge's fall of 2.7 over
        // three texels.
        assert!((a - b).abs().max_element() < 2e-3, "{k}: {a} {b}");
    }
}
