//! CPU against GPU: soft proofs of every shape and model.
#![cfg(feature = "gpu")]
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "gpu/adapter.rs"]
mod adapter;
#[path = "gpu/compare.rs"]
mod compare;

use adapter::{gpu, say};
use carpaint::color::{Illuminant, Wavelengths};
use carpaint::gpu::{PrintRenderer, render_print};
use carpaint::proof::{Coverage, InkLimit, Method, Separation};
use carpaint::render::{self, InkModel, Options, Paper, Print, PrintInks, lit_from_behind, own_inks};
use carpaint::scene::{Camera, Environment, Light, Object, PointLight, Scene, Shape, Up};
use compare::compare;
use std::path::Path;

/// 150 x 90 dots.
fn coverage() -> Coverage {
    let pixel = |k: usize| {
        let (x, y) = ((k % 50) as f32 / 50.0, (k / 50) as f32 / 30.0);
        [x, 1.0 - y, 0.5 * (1.0 - x)]
    };
    let pixels: Vec<_> = (0..1500).map(pixel).collect();
    let separation = Separation::new([50, 30], &pixels, InkLimit::Scale).unwrap();
    Coverage::new(Method::ErrorDiffusion.halftone(&separation, 3, 1).unwrap())
}

fn scene(shape: Shape) -> Scene {
    let lamp = |position_mm: [f64; 3], power: f64| {
        Light::Point(PointLight { position_mm, irradiance: [power; 3], radius_mm: 4.0 })
    };
    let scene = Scene {
        size: [80, 60],
        shape,
        camera: Camera { position_mm: [20.0, -220.0, 30.0], ..Camera::default() },
        background: Some([0.1, 0.2, 0.3]),
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![lamp([-60.0, -220.0, 60.0], 3.0), Light::default()],
        ..Scene::default()
    };
    lit_from_behind(scene, 0.1)
}

fn scenes() -> Vec<(String, Scene)> {
    let names = ["sheet", "panel", "sphere", "capsule"];
    let mut scenes: Vec<_> =
        names.map(|name| (name.to_owned(), scene(Shape::named(name).unwrap()))).into_iter().collect();
    let ring = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes/ring.obj");
    let mesh = Shape::Mesh { path: ring, length_mm: Some(40.0), up: Up::Y };
    let turned = |shape: Shape, x: f64| Object {
        shape,
        position_mm: [x, 0.0, 3.0],
        tilt_deg: [20.0, -10.0],
        turn_deg: 30.0,
        ..Object::default()
    };
    let objects = vec![
        turned(mesh, -12.0),
        turned(Shape::named("sheet").unwrap(), 14.0),
        turned(Shape::Sphere { radius_mm: 8.0 }, 0.0),
    ];
    scenes.push(("objects".into(), Scene { objects, ..scene(Shape::default()) }));
    scenes
}

#[test]
fn proofs_agree() {
    let Some(gpu) = gpu() else { return };
    let (coverage, options) = (coverage(), Options { samples: 3, ..Options::default() });
    let grid = Wavelengths::even(41).unwrap();
    let light = Illuminant::D65.spectrum();
    for model in InkModel::ALL {
        let ready = PrintInks::at(&grid, &own_inks().unwrap(), model, &light, false).unwrap();
        let print = Print { inks: &ready, coverage: &coverage, paper: Paper::BLACK };
        let renderer = PrintRenderer::new(gpu, model).unwrap();
        let on_gpu = renderer.upload(gpu, &print).unwrap();
        for (name, scene) in scenes() {
            let expected = render::render_print(&scene, &print, &options, &|| ()).unwrap();
            let found = renderer.render(gpu, &scene, &on_gpu, &options, &|| ()).unwrap();
            let (differ, off) = compare(&expected, &found);
            say(&format!("{model:?}, {name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
            // Silhouettes, edges of prints and of shadows: rays of f32 fall on the other side in some pixels of 4800.
            assert!(differ <= 4e-3 && off <= 1e-3, "{model:?} {name}: {differ} {off:e}");
        }
    }
}

/// From a dot of many pixels to many dots a pixel, and in three numbers.
#[test]
fn proofs_agree_at_every_distance() {
    let Some(gpu) = gpu() else { return };
    let coverage = coverage();
    let ready = PrintInks::tristimulus(&own_inks().unwrap(), &Illuminant::A.spectrum(), true).unwrap();
    let print = Print { inks: &ready, coverage: &coverage, paper: Paper::NONE };
    for fov in [0.7, 4.0, 15.0, 90.0] {
        let far = scene(Shape::named("sheet").unwrap());
        let far = Scene { camera: Camera { vertical_fov_deg: fov, ..far.camera }, ..far };
        let options = Options { samples: 2, ..Options::default() };
        let expected = render::render_print(&far, &print, &options, &|| ()).unwrap();
        let found = render_print(gpu, &far, &print, &options, &|| ()).unwrap();
        let (differ, off) = compare(&expected, &found);
        say(&format!("{fov} degrees: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
        // Close up, places in the picture are f32: 1e-7 of 60 mm in a pixel of .01 mm.
        assert!(differ <= 4e-3 && off <= 1e-3, "{fov}: {differ} {off:e}");
    }
}
