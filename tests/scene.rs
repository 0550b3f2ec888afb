//! Scene files: hostile ones are refused with reasons, the shipped ones are legal.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::scene::Scene;

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
    refused("not toml", &["TOML"]);
    Scene::parse("").unwrap();
    Scene::parse("[shape]\nkind = \"sphere\"\nradius_mm = 5").unwrap();
}

#[test]
fn scene_files_survive_the_round_trip_and_the_shipped_ones_are_legal() {
    for scene in [Scene::default(), Scene::strip()] {
        assert_eq!(Scene::parse(&toml::to_string(&scene).unwrap()).unwrap(), scene);
    }
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path()).collect();
    assert!(!files.is_empty());
    for file in files {
        Scene::read(&file).unwrap();
    }
}
