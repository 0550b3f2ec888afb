//! The path tracer: laws of light between objects, and agreement with the renderer that leaves them out.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::paint::Paint;
use carpaint::render::{Options, Picture, RenderPaint, render, trace};
use carpaint::scene::{DirectionalLight, Environment, Scene, Shape};
use glam::Vec3;
use serde_json::Value;

fn paint(coat: ClearCoat, diffuse: f64, lobes: Vec<Lobe>) -> RenderPaint {
    let paint =
        Paint { coat, diffuse, lobes, colors: ColorTable::white(), flakes: None, provenance: Value::Null };
    RenderPaint::new(&paint).unwrap()
}

/// A metallic paint under a coat with both an ideal mirror and a gloss lobe.
fn metallic() -> RenderPaint {
    let coat = ClearCoat {
        mirror: 0.6,
        gloss: Some(Lobe { coefficient: 0.005, roughness: 0.02, f0: 1.0 }),
        ..ClearCoat::ideal(1.5, true)
    };
    paint(coat, 0.05, vec![Lobe { coefficient: 0.15, roughness: 0.25, f0: 0.7 }])
}

/// Two balls beside each other before the camera.
fn pair() -> Scene {
    let text = "size = [24, 16]\nlight = []\n\
        [environment]\nkind = \"constant\"\nradiance = [1.0, 1.0, 1.0]\n\
        [[object]]\nposition_mm = [-11.0, 0.0, 0.0]\npaint = 0\nshape = { kind = \"sphere\", radius_mm = 10.0 }\n\
        [[object]]\nposition_mm = [11.0, 0.0, 0.0]\npaint = 1\nshape = { kind = \"sphere\", radius_mm = 10.0 }\n";
    Scene::parse(text).unwrap()
}

fn options(samples: usize) -> Options {
    Options { samples, ..Options::default() }
}

fn mean(picture: &Picture) -> Vec3 {
    picture.pixels.iter().map(|p| Vec3::from(*p)).sum::<Vec3>() / picture.pixels.len() as f32
}

#[test]
fn white_objects_vanish_in_white_light() {
    let white = paint(ClearCoat::ideal(1.0, false), 1.0, Vec::new());
    let scene = pair();
    let lit = trace(&scene, &[white.clone(), white.clone()], &options(64), 64, &|| ()).unwrap();
    // Between the balls a few paths in a thousand are longer than any limit that is tried.
    let found = mean(&lit.picture);
    assert!(lit.standard_error < 0.02, "{}", lit.standard_error);
    assert!((found - Vec3::ONE).abs().max_element() < 4e-3, "{found}");
    for pixel in &lit.picture.pixels {
        // Weights of the tabulated directions scatter by a twentieth: six standard errors of 64 samples.
        assert!((pixel[0] - 1.0).abs() < 0.05, "{pixel:?}");
    }
    // One reflection alone: what the balls hide from each other is dark.
    let direct = trace(&scene, &[white.clone(), white], &options(64), 1, &|| ()).unwrap();
    let between = direct.picture.pixels[8 * 24 + 11][0];
    assert!(between < 0.8 && mean(&direct.picture).x < 0.999, "{between}");
}

#[test]
fn one_reflection_of_one_object_is_what_the_renderer_shows() {
    let lamps = [
        DirectionalLight {
            direction: [-0.62, -0.78, 0.3],
            irradiance: [3.0, 2.0, 1.0],
            angular_radius_deg: 0.5,
        },
        DirectionalLight {
            direction: [0.5, -0.8, 0.2],
            irradiance: [1.0, 1.0, 2.0],
            angular_radius_deg: 6.0,
        },
    ];
    for (name, shape) in [("sphere", "sphere"), ("panel", "panel")] {
        for lit in [true, false] {
            let mut scene = Scene { size: [24, 32], ..Scene::default() };
            scene.shape = Shape::named(shape).unwrap();
            scene.lights = if lit { lamps.map(Into::into).to_vec() } else { Vec::new() };
            if lit {
                scene.environment = Environment::Constant { radiance: [0.0; 3] };
            }
            scene.background = Some([0.0; 3]);
            let paints = [metallic()];
            let fine = Options { directions: 128, ..options(144) };
            let expected = render(&scene, &paints, &fine, &|| ()).unwrap();
            let traced = trace(&scene, &paints, &options(144), 1, &|| ()).unwrap();
            let (found, expected) = (mean(&traced.picture), mean(&expected));
            let pixels = (scene.size[0] * scene.size[1]) as f64;
            // Four standard errors of the mean, and 1 % for lamps that the renderer takes for points and blurs the gloss by.
            let allowed = 4.0 * traced.standard_error / pixels.sqrt() + 0.01;
            let off = ((found - expected) / expected).abs().max_element();
            assert!(f64::from(off) < allowed, "{name}, lamps {lit}: {found} {expected}, allowed {allowed}");
        }
    }
}

#[test]
fn light_goes_from_object_to_object() {
    // A mirror ball beside a white one shows it; with one reflection the white one in it is black.
    let mirror = paint(ClearCoat::ideal(4.0, false), 0.0, Vec::new());
    let white = paint(ClearCoat::ideal(1.0, false), 1.0, Vec::new());
    let scene = pair();
    let seen = |bounces| {
        let traced = trace(&scene, &[mirror.clone(), white.clone()], &options(64), bounces, &|| ()).unwrap();
        mean(&traced.picture).x
    };
    let (one, two, many) = (seen(1), seen(2), seen(8));
    // The white ball fills a small part of the mirror one.
    assert!(one + 1e-3 < two && two <= many + 5e-4, "{one} {two} {many}");
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let scene = Scene { size: [20, 20], ..Scene::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace(&scene, &[metallic()], &options(4), 4, &|| ()).unwrap())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn numbers_of_reflections_are_checked() {
    for bounces in [0, 65] {
        let message = trace(&pair(), &[metallic(), metallic()], &options(1), bounces, &|| ()).unwrap_err();
        assert!(message.to_string().contains("1 to 64"), "{message}");
    }
}
