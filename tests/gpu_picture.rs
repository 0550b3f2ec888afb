//! CPU against GPU: pictures of every shape under every kind of light.
#![cfg(feature = "gpu")]
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "gpu/adapter.rs"]
mod adapter;
#[path = "gpu/compare.rs"]
mod compare;
#[path = "gpu/paints.rs"]
mod gpu_paints;
#[path = "mix/paints.rs"]
mod paints;

mod common;

use adapter::{gpu, say};
use carpaint::file::write_picture_exr;
use carpaint::gpu;
use carpaint::render::{Options, Picture, Random, RenderPaint, needed_of_paint, render, tick_count};
use carpaint::scene::{
    Camera, DirectionalLight, Environment, Light, Object, PointLight, Scene, Shape, Softbox, SpotLight, Up,
};
use compare::compare;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

fn options() -> Options {
    Options { samples: 4, directions: 12, ..Options::default() }
}

fn paint(name: &str) -> &'static RenderPaint {
    &gpu_paints::all().iter().find(|(n, _)| *n == name).unwrap().1
}

/// Every shape under the default studio, under sun and sky and under lamps of each kind.
fn scenes() -> Vec<(String, Scene)> {
    let sky = Environment::Studio {
        ground: [0.1, 0.09, 0.08],
        horizon: [0.5, 0.6, 0.7],
        zenith: [0.2, 0.3, 0.6],
        softbox: Vec::new(),
    };
    let sun = DirectionalLight {
        direction: [0.4, -0.7, 0.6],
        angular_radius_deg: 0.27,
        ..DirectionalLight::default()
    };
    let bulb = PointLight { position_mm: [-60.0, -80.0, 40.0], irradiance: [2.0, 1.5, 1.0], radius_mm: 4.0 };
    let other =
        PointLight { position_mm: [40.0, -60.0, -30.0], irradiance: [0.5, 1.0, 2.0], radius_mm: 20.0 };
    let spot = SpotLight { lamp: other, target_mm: [5.0, 0.0, 5.0], cone_deg: 14.0, edge_deg: 5.0 };
    let dark = Environment::Constant { radiance: [0.0; 3] };
    let lights = [
        ("studio", Environment::default(), vec![Light::default()]),
        ("sun and sky", sky, vec![sun.into()]),
        ("lamps", dark, vec![Light::Point(bulb), Light::Spot(spot)]),
    ];
    let mut scenes = Vec::new();
    for shape in ["capsule", "sphere", "panel"] {
        for (name, environment, lights) in &lights {
            let scene = Scene {
                size: [60, 80],
                shape: Shape::named(shape).unwrap(),
                environment: environment.clone(),
                lights: lights.clone(),
                ..Scene::default()
            };
            scenes.push((format!("{shape}, {name}"), scene));
        }
    }
    scenes
}

/// So near that a pixel is a texel or two, and flakes are told apart.
fn close_ups() -> Vec<(String, Scene)> {
    let near = |(name, scene): (String, Scene)| {
        let camera = Camera { target_mm: [3.0, 0.0, 9.0], vertical_fov_deg: 0.8, ..scene.camera };
        (format!("close-up of a {name}"), Scene { camera, ..scene })
    };
    scenes()
        .into_iter()
        .filter(|(name, _)| name.contains("studio") || name.contains("lamps"))
        .map(near)
        .collect()
}

/// Pictures of both renderers.
fn pictures(scene: &Scene, paint: &RenderPaint, options: &Options) -> [Picture; 2] {
    let paints = std::slice::from_ref(paint);
    let on_gpu = gpu::render(gpu().unwrap(), scene, paints, options, &|| ()).unwrap();
    [render(scene, paints, options, &|| ()).unwrap(), on_gpu]
}

/// What [`compare`] says of the pictures of both renderers.
fn compared(scene: &Scene, paint: &RenderPaint, options: &Options) -> (f64, f64) {
    let [cpu, gpu] = pictures(scene, paint, options);
    compare(&cpu, &gpu)
}

#[test]
fn smooth_pictures_agree() {
    if gpu().is_none() {
        return;
    }
    let paint = paint("no flakes");
    for (name, scene) in scenes() {
        let (differ, off) = compared(&scene, paint, &options());
        say(&format!("{name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
        // At the silhouette a ray of f32 may miss what one of f64 meets: a pixel or two of 4800.
        assert!(differ <= 1e-3 && off <= 1e-4, "{name}: {differ} {off:e}");
    }
}

#[test]
fn pictures_with_flakes_agree_but_for_flips() {
    if gpu().is_none() {
        return;
    }
    for paint_name in ["sparse flakes that live", "refracting, flakes that stay, sharp gloss", "simulated"] {
        for (name, scene) in scenes().into_iter().chain(close_ups()) {
            let (differ, off) = compared(&scene, paint(paint_name), &options());
            say(&format!("{paint_name}: {name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
            // Places round by 2e-6 mm, some 1e-4 of a texel: so much of the surface lies at the end of a cell, a pixel has four
            // samples, and the half vector may lie at the end of a cluster: up to 52 half vectors under surroundings.
            assert!(differ <= 5e-3 && off <= 1e-4, "{paint_name}: {name}: {differ} {off:e}");
        }
    }
}

#[test]
fn objects_in_several_paints_agree() {
    let Some(gpu) = gpu() else { return };
    let at = |shape: &str, position_mm, paint| Object {
        shape: Shape::named(shape).unwrap(),
        position_mm,
        paint,
        ..Object::default()
    };
    let objects = vec![
        at("sphere", [-8.0, -20.0, 0.0], 1),
        Object { turn_deg: 20.0, ..at("panel", [0.0, 10.0, 0.0], 0) },
        Object { tilt_deg: [10.0, 50.0], ..at("capsule", [15.0, -30.0, 5.0], 3) },
        Object { tilt_deg: [-70.0, 20.0], ..at("capsule", [-14.0, -60.0, -12.0], 3) },
    ];
    let names = ["simulated", "no flakes", "one slice, one cluster", "sparse flakes that live"];
    let paints = names.map(|name| paint(name).clone());
    for (name, scene) in scenes().into_iter().filter(|(name, _)| name.contains("capsule")) {
        let scene = Scene { objects: objects.clone(), ..scene };
        let on_gpu = gpu::render(gpu, &scene, &paints, &options(), &|| ()).unwrap();
        let (differ, off) = compare(&render(&scene, &paints, &options(), &|| ()).unwrap(), &on_gpu);
        say(&format!("objects, {name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
        // As with flakes; and a ray along an edge, of an object or of its shadow, may pass on either side.
        assert!(differ <= 5e-3 && off <= 1e-4, "{name}: {differ} {off:e}");
    }
}

/// Surroundings that are pictures: a sky, and a file with a sun in it.
fn panoramas(folder: &Path) -> Vec<(&'static str, Environment)> {
    let path = folder.join("sun.exr");
    let texel = |k: usize| match (k % 128, k / 128) {
        (30, 20) => [3e4, 2.8e4, 2.5e4],
        (x, y) if y < 32 => [0.2 + x as f32 / 300.0, 0.5, 0.8 - y as f32 / 100.0],
        _ => [0.1, 0.09, 0.05],
    };
    write_picture_exr(&path, [128, 64], &(0..128 * 64).map(texel).collect::<Vec<_>>()).unwrap();
    let sky = Environment::Sky { sun: [-0.5, -0.7, 0.6], zenith: [0.1, 0.2, 0.4], ground: [0.3, 0.25, 0.2] };
    vec![("sky", sky), ("image", Environment::Image { path, turn_deg: 70.0, scale: 0.5 })]
}

#[test]
fn panoramas_agree() {
    if gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (name, environment) in panoramas(folder.path()) {
        for paint_name in ["no flakes", "refracting, flakes that stay, sharp gloss", "simulated"] {
            for shape in ["capsule", "sphere"] {
                let shape = Shape::named(shape).unwrap();
                let scene =
                    Scene { size: [60, 80], shape, environment: environment.clone(), ..Scene::default() };
                let (differ, off) = compared(&scene, paint(paint_name), &options());
                say(&format!("{name}: {paint_name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
                // Longitude and latitude round by 1e-5 of a texel; from a sun to its neighbor that is a part of what the neighbor
                // shines. And silhouettes.
                assert!(differ <= 2e-3 && off <= 1e-4, "{name}: {paint_name}: {differ} {off:e}");
            }
        }
    }
}

#[test]
fn meshes_agree() {
    if gpu().is_none() {
        return;
    }
    let ring = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes/ring.obj");
    let ring = Shape::Mesh { path: ring, length_mm: Some(50.0), up: Up::Z };
    let ring = Object { shape: ring, tilt_deg: [50.0, 10.0], ..Object::default() };
    let car = Object { shape: Shape::named("speed-shape").unwrap(), turn_deg: -30.0, ..Object::default() };
    let inside = Object {
        shape: Shape::SpeedShape { length_mm: 40.0 },
        position_mm: [0.0, 0.0, 5.0],
        tilt_deg: [20.0, -30.0],
        ..Object::default()
    };
    let mut cases =
        vec![("ring", vec![ring.clone()]), ("car", vec![car.clone()]), ("both", vec![ring, inside])];
    if let Some(path) = common::reference("data/mesh/ToyCar_plain_geometry.glb") {
        let shape = Shape::Mesh { path, length_mm: Some(60.0), up: Up::Y };
        cases.push(("toy car", vec![Object { shape, turn_deg: 40.0, ..Object::default() }]));
    }
    let lights = scenes();
    let studio = &lights[0].1;
    let mut all: Vec<(String, Scene)> = Vec::new();
    for (name, objects) in &cases {
        all.push((format!("{name}, studio"), Scene { objects: objects.clone(), ..studio.clone() }));
    }
    for (light, scene) in &lights[1..3] {
        all.push((format!("ring, {light}"), Scene { objects: cases[0].1.clone(), ..scene.clone() }));
    }
    // So near that flakes are told apart.
    for ((name, objects), height) in cases[..2].iter().zip([12.0, 3.0]) {
        let camera = Camera { target_mm: [3.0, 0.0, height], vertical_fov_deg: 0.8, ..studio.camera };
        let scene = Scene { objects: objects.clone(), camera, ..studio.clone() };
        all.push((format!("close-up of the {name}"), scene));
    }
    for (name, scene) in all {
        let (differ, off) = compared(&scene, paint("sparse flakes that live"), &options());
        say(&format!("{name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
        // As with flakes; and a ray along an edge, of a silhouette, of a shadow, of a facet whose neighbor lies on another chart,
        // may pass on either side.
        assert!(differ <= 5e-3 && off <= 1e-4, "{name}: {differ} {off:e}");
    }
}

#[test]
fn pictures_are_whole_however_they_are_cut() {
    let Some(gpu) = gpu() else { return };
    // The second needs several submissions for its samples, the third for the directions of one, and several blocks.
    for (size, samples, directions) in [([1, 1], 1, 1), ([13, 3], 500, 5), ([37, 19], 4, 4096)] {
        let scene = Scene { size, ..Scene::default() };
        let options = Options { samples, directions, ..Options::default() };
        let paints = [paint("no flakes").clone(), paint("one slice, one cluster").clone()];
        let ticks = AtomicUsize::new(0);
        let tick = || {
            ticks.fetch_add(1, Ordering::Relaxed);
        };
        let on_gpu = gpu::render(gpu, &scene, &paints, &options, &tick).unwrap();
        assert_eq!(ticks.into_inner(), tick_count(&scene));
        let (differ, off) = compare(&render(&scene, &paints, &options, &|| ()).unwrap(), &on_gpu);
        assert!(differ <= 0.02 && off <= 1e-4, "{size:?}: {differ} {off:e}");
    }
}

#[test]
fn options_reach_the_gpu() {
    if gpu().is_none() {
        return;
    }
    let paint = paint("sparse flakes that live");
    let scene = Scene { size: [30, 40], background: Some([0.1, 0.2, 0.3]), ..Scene::default() };
    let first = pictures(&scene, paint, &options());
    for (name, other) in [
        ("seed", Options { seed: 7, ..options() }),
        ("texture", Options { random: Random::Texture(64), ..options() }),
        ("no flakes", Options { flakes: false, ..options() }),
    ] {
        let [cpu, seen] = pictures(&scene, paint, &other);
        let (differ, _) = compare(&cpu, &seen);
        assert!(differ <= 0.03, "{name}: {differ}");
        let (changed, _) = compare(&first[1], &seen);
        assert!(changed > 0.05, "{name} changes {changed} of the pixels");
    }
}

#[test]
fn hard_cases_are_finite_and_agree() {
    if gpu().is_none() {
        return;
    }
    let camera = |position_mm, target_mm, vertical_fov_deg| Camera {
        position_mm,
        target_mm,
        vertical_fov_deg,
        ..Camera::default()
    };
    let lamp =
        |position_mm, radius_mm| Light::Point(PointLight { position_mm, irradiance: [1.0; 3], radius_mm });
    let panel = |normal| Shape::Panel { size_mm: [24.0, 50.0], normal };
    let box_behind = Softbox {
        direction: [0.0, 0.0, -1.0],
        size_deg: [170.0, 170.0],
        edge_deg: 90.0,
        radiance: [1e6, 0.0, 1.0],
    };
    let huge = Environment::Studio {
        ground: [1e6; 3],
        horizon: [0.0; 3],
        zenith: [1.0; 3],
        softbox: vec![box_behind],
    };
    let from = Camera::default().position_mm;
    let scene = |shape, camera| Scene { shape, camera, ..Scene::default() };
    let capsule = Shape::default();
    let cases = [
        ("inside", scene(capsule.clone(), camera([0.0, 1.0, 2.0], [0.0, -10.0, 0.0], 90.0))),
        ("behind the eye", scene(capsule.clone(), camera(from, [0.0, -400.0, 30.0], 60.0))),
        ("beside the sight", scene(capsule.clone(), camera([20.0, -50.0, 0.0], [60.0, 0.0, 0.0], 150.0))),
        (
            "from above",
            scene(capsule, Camera { up: [0.0, 1.0, 0.0], ..camera([0.0, 0.0, 80.0], [0.0; 3], 30.0) }),
        ),
        ("from far", scene(Shape::named("sphere").unwrap(), camera([0.0, -1e6, 0.0], [0.0; 3], 0.01))),
        ("a flat panel", scene(panel([0.0, 0.0, 1.0]), camera([0.0, -100.0, 60.0], [0.0; 3], 40.0))),
        ("back of a panel", scene(panel([0.0, 1.0, 0.0]), Camera::default())),
        ("edge of a panel", scene(panel([1.0, 0.0, 0.0]), camera([0.0, -100.0, 0.0], [0.0; 3], 40.0))),
        ("a ball of two caps", scene(Shape::Capsule { radius_mm: 20.0, height_mm: 40.0 }, Camera::default())),
        (
            "lamps at the surface",
            Scene {
                lights: vec![
                    lamp([0.0, -13.0, 0.0], 1.0),
                    lamp([0.0, 0.0, 2.0], 0.5),
                    lamp([0.0, -1e7, 0.0], 5e4),
                ],
                ..Scene::default()
            },
        ),
        ("huge radiance", Scene { environment: huge, lights: Vec::new(), ..Scene::default() }),
        (
            "a light at the horizon",
            Scene {
                lights: vec![
                    DirectionalLight { direction: [0.0, 1.0, 0.0], ..DirectionalLight::default() }.into(),
                ],
                ..Scene::default()
            },
        ),
    ];
    for (name, scene) in cases {
        let scene = Scene { size: [30, 40], ..scene };
        for paint_name in ["no flakes", "refracting, flakes that stay, sharp gloss", "simulated"] {
            let (differ, _) = compared(&scene, paint(paint_name), &options());
            say(&format!("{name}: {paint_name}: {:.2} % differ", 100.0 * differ));
            assert!(differ <= 0.05, "{name}: {paint_name}: {differ}");
        }
    }
}

#[test]
fn what_the_cpu_refuses_the_gpu_refuses_in_the_same_words() {
    let Some(gpu) = gpu() else { return };
    let paints = [paint("no flakes").clone()];
    let good = Scene { size: [4, 4], ..Scene::default() };
    let bad = Scene { size: [0, 4], ..Scene::default() };
    for (scene, paints, options) in [
        (&bad, &paints[..], options()),
        (&good, &[][..], options()),
        (&good, &paints[..], Options { samples: 0, ..options() }),
        (&good, &paints[..], Options { random: Random::Texture(0), ..options() }),
    ] {
        let message = render(scene, paints, &options, &|| ()).unwrap_err().to_string();
        assert_eq!(gpu::render(gpu, scene, paints, &options, &|| ()).unwrap_err().to_string(), message);
    }
}

#[test]
fn paints_with_cells_left_out_are_checked() {
    let Some(gpu) = gpu() else { return };
    let scene = Scene { size: [30, 40], ..Scene::default() };
    let whole = paints::paint(1, 50);
    let cells = needed_of_paint(&scene, &options(), &whole, None).unwrap().unwrap();
    let mut kept = whole.clone();
    kept.flakes.as_mut().unwrap().keep(&cells);
    let [whole, kept] = [whole, kept].map(|paint| [RenderPaint::new(&paint).unwrap()]);
    let picture = |paints: &[RenderPaint]| gpu::render(gpu, &scene, paints, &options(), &|| ()).unwrap();
    // A place on the grid of angles that f32 rounds differently asks for a neighbor, whose weight is that rounding.
    assert_eq!(compare(&picture(&whole), &picture(&kept)).0, 0.0);
    // So near that the fine level is seen, which was left out.
    let near = Camera { vertical_fov_deg: 0.2, ..scene.camera };
    let other = Scene { camera: near, ..scene.clone() };
    let message = render(&other, &kept, &options(), &|| ()).unwrap_err().to_string();
    assert!(message.contains("left out"), "{message}");
    assert_eq!(gpu::render(gpu, &other, &kept, &options(), &|| ()).unwrap_err().to_string(), message);
}
