//! Frames in real time against the CPU's pictures.
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

use adapter::{gpu, say};
use carpaint::gpu::{self, FrameOptions, FrameRenderer, Gpu, GpuPaint};
use carpaint::render::{Options, Picture, Random, RenderPaint, ToneMap, render};
use carpaint::scene::{
    Camera, DirectionalLight, Environment, Light, Object, PointLight, Scene, Shape, Softbox, SpotLight,
};
use compare::{compare, difference};
use wgpu::TextureFormat;

fn paint(name: &str) -> &'static RenderPaint {
    &gpu_paints::all().iter().find(|(n, _)| *n == name).unwrap().1
}

/// No surroundings: every shape under lamps of each kind, whole and from near.
fn lamp_scenes() -> Vec<(String, Scene)> {
    let sun = DirectionalLight { direction: [0.4, -0.7, 0.6], ..DirectionalLight::default() };
    let bulb = PointLight { position_mm: [-60.0, -80.0, 40.0], irradiance: [2.0, 1.5, 1.0], radius_mm: 4.0 };
    let other =
        PointLight { position_mm: [40.0, -60.0, -30.0], irradiance: [0.5, 1.0, 2.0], radius_mm: 20.0 };
    let spot = SpotLight { lamp: other, target_mm: [5.0, 0.0, 5.0], cone_deg: 14.0, edge_deg: 5.0 };
    let mut scenes = Vec::new();
    for shape in ["capsule", "sphere", "panel"] {
        let scene = Scene {
            size: [60, 80],
            shape: Shape::named(shape).unwrap(),
            environment: Environment::Constant { radiance: [0.0; 3] },
            lights: vec![sun.into(), Light::Point(bulb), Light::Spot(spot)],
            ..Scene::default()
        };
        let camera = Camera { target_mm: [3.0, 0.0, 9.0], vertical_fov_deg: 0.8, ..scene.camera };
        scenes.push((format!("close-up of a {shape}"), Scene { camera, ..scene.clone() }));
        scenes.push((shape.to_owned(), scene));
    }
    scenes
}

fn renderer(gpu: &Gpu) -> FrameRenderer {
    FrameRenderer::new(gpu, TextureFormat::Rgba32Float).unwrap()
}

/// By a new renderer.
fn frame(gpu: &Gpu, scene: &Scene, paint: &RenderPaint, options: &FrameOptions) -> Picture {
    next_frame(&mut renderer(gpu), gpu, scene, paint, options)
}

fn next_frame(
    renderer: &mut FrameRenderer,
    gpu: &Gpu,
    scene: &Scene,
    paint: &RenderPaint,
    options: &FrameOptions,
) -> Picture {
    let on_gpu = GpuPaint::new(gpu, paint).unwrap();
    renderer.picture(gpu, scene, &[&on_gpu], options).unwrap()
}

fn reference(scene: &Scene, paint: &RenderPaint, options: &FrameOptions) -> Picture {
    let options = Options {
        samples: 1,
        directions: 1,
        seed: options.seed,
        flakes: options.flakes,
        random: options.random,
    };
    render(scene, std::slice::from_ref(paint), &options, &|| ()).unwrap()
}

#[test]
fn under_lamps_frames_are_the_pictures_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut renderer = renderer(gpu);
    for paint_name in
        ["no flakes", "sparse flakes that live", "refracting, flakes that stay, sharp gloss", "simulated"]
    {
        for (name, scene) in lamp_scenes() {
            let options = FrameOptions::default();
            let expected = reference(&scene, paint(paint_name), &options);
            let (differ, off) =
                compare(&expected, &next_frame(&mut renderer, gpu, &scene, paint(paint_name), &options));
            say(&format!("{paint_name}: {name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
            // As of pictures of several samples (`gpu_picture`), where a place or a half vector rounds into another cell.
            // With one sample a pixel a flake that flips is four times as bright in the mean of a close-up.
            assert!(differ <= 5e-3 && off <= 4e-4, "{paint_name}: {name}: {differ} {off:e}");
        }
    }
}

/// Far lamps all around, in front of the picture and above.
fn many_lamps(n: usize) -> Vec<Light> {
    let lamp = |k: usize| {
        let turn = 2.4 * k as f64;
        let direction = [turn.cos(), -0.6, 0.2 + turn.sin().abs()];
        Light::from(DirectionalLight {
            direction,
            irradiance: [1.0, 0.8, 0.6],
            ..DirectionalLight::default()
        })
    };
    (0..n).map(lamp).collect()
}

/// Capsules, and the body that stands in front of them, as in the demonstration that the viewer shows.
fn demonstration() -> Scene {
    let capsule = |x: f64, y: f64, paint| Object {
        shape: Shape::Capsule { radius_mm: 8.0, height_mm: 40.0 },
        position_mm: [x, y, 0.0],
        paint,
        ..Object::default()
    };
    let shape = Shape::SpeedShape { length_mm: 110.0 };
    let body = Object { shape, position_mm: [-2.0, -78.0, -10.0], turn_deg: -24.0, ..Object::default() };
    let camera = Camera {
        position_mm: [0.0, -420.0, 150.0],
        target_mm: [0.0, -8.0, -4.0],
        vertical_fov_deg: 22.0,
        ..Camera::default()
    };
    let (_, scene) = lamp_scenes().remove(1);
    let objects = vec![capsule(0.0, 46.0, 1), capsule(-57.0, -23.0, 0), capsule(14.0, 4.0, 1), body];
    Scene { size: [64, 48], camera, objects, lights: many_lamps(2), ..scene }
}

#[test]
fn meshes_and_their_shadows_are_kept_and_shaded() {
    let Some(gpu) = gpu() else { return };
    let (_, usual) = lamp_scenes().remove(1);
    let mesh = Scene { shape: Shape::named("speed-shape").unwrap(), ..usual };
    // More lamps than a layer of shadows holds.
    let crowd = Scene { size: [40, 30], lights: many_lamps(11), ..demonstration() };
    let paints = ["sparse flakes that live", "no flakes"].map(|name| paint(name).clone());
    let on_gpu = paints.each_ref().map(|paint| GpuPaint::new(gpu, paint).unwrap());
    let shown: Vec<_> = on_gpu.iter().collect();
    let mut renderer = renderer(gpu);
    for (name, scene) in [
        ("one lamp", Scene { lights: mesh.lights[..1].to_vec(), ..mesh.clone() }),
        ("three lamps", mesh),
        // Groups of pixels that the first lamp does not reach are still lit by the second.
        ("demonstration", demonstration()),
        ("the same, lit from elsewhere", Scene { lights: many_lamps(3)[1..].to_vec(), ..demonstration() }),
        ("eleven lamps", crowd),
    ] {
        // Pictures on the same adapter, whose geometry is not kept; `gpu_picture` compares these with the CPU's.
        let options = Options { samples: 1, directions: 1, ..Options::default() };
        let expected = gpu::render(gpu, &scene, &paints, &options, &|| ()).unwrap();
        let expected = if scene.objects.is_empty() { first_tile(&expected) } else { expected };
        let seen = renderer.picture(gpu, &scene, &shown, &FrameOptions::default()).unwrap();
        let (differ, off) = compare(&expected, &seen);
        say(&format!("{name}: {:.2} % differ, means off by {off:.1e}", 100.0 * differ));
        // A compiler may round otherwise in another pass, and so pass the edge of a shadow on its other side.
        assert!(differ <= 2e-3 && off <= 1e-3, "{name}: {differ} {off:e}");
    }
}

/// The left of two tiles.
fn first_tile(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    let rows = picture.pixels.chunks(width).flat_map(|row| &row[..width / 2]);
    Picture { size: [width / 2, height], pixels: rows.copied().collect() }
}

#[test]
fn options_reach_the_frame() {
    let Some(gpu) = gpu() else { return };
    let paint = paint("sparse flakes that live");
    let (_, scene) = lamp_scenes().remove(0);
    let usual = FrameOptions::default();
    let first = frame(gpu, &scene, paint, &usual);
    for (name, options) in [
        ("seed", FrameOptions { seed: 7, ..usual }),
        ("texture", FrameOptions { random: Random::Texture(64), ..usual }),
        ("no flakes", FrameOptions { flakes: false, ..usual }),
    ] {
        let seen = frame(gpu, &scene, paint, &options);
        let (differ, _) = compare(&reference(&scene, paint, &options), &seen);
        assert!(differ <= 5e-3, "{name}: {differ}");
        let (changed, _) = compare(&first, &seen);
        assert!(changed > 0.05, "{name} changes {changed} of the pixels");
    }
    let bright = frame(gpu, &scene, paint, &FrameOptions { exposure_stops: 3.0, ..usual });
    for (a, b) in first.pixels.iter().zip(&bright.pixels) {
        // A power of two is exact.
        assert_eq!(a.map(|c| 8.0 * c), *b);
    }
}

#[test]
fn one_renderer_follows_camera_and_size() {
    let Some(gpu) = gpu() else { return };
    let paint = paint("no flakes");
    let on_gpu = GpuPaint::new(gpu, paint).unwrap();
    let mut renderer = renderer(gpu);
    let options = FrameOptions::default();
    let (_, first) = lamp_scenes().remove(1);
    let camera = Camera { position_mm: [60.0, -200.0, 0.0], ..first.camera };
    let scenes = [
        first.clone(),
        Scene { camera, ..first.clone() },
        Scene { size: [33, 7], ..first.clone() },
        Scene { shape: Shape::named("sphere").unwrap(), ..first.clone() },
        first,
    ];
    for scene in scenes {
        let seen = renderer.picture(gpu, &scene, &[&on_gpu], &options).unwrap();
        let (differ, off) = compare(&reference(&scene, paint, &options), &seen);
        // A pixel of 231 at the silhouette.
        assert!(differ <= 5e-3 && off <= 4e-4, "{differ} {off:e}");
    }
}

/// Under the default studio alone.
fn studio(shape: &str) -> Scene {
    let shape = Shape::named(shape).unwrap();
    Scene { size: [45, 60], shape, lights: Vec::new(), background: Some([0.0; 3]), ..Scene::default() }
}

/// Mean and 99 % quantile of the relative error of pixels that see paint.
fn errors(expected: &Picture, seen: &Picture) -> (f32, f32) {
    let pairs = expected.pixels.iter().zip(&seen.pixels).filter(|(a, _)| **a != [0.0; 3]);
    let mut errors: Vec<f32> = pairs.map(|(a, b)| difference(*a, *b)).collect();
    errors.sort_by(f32::total_cmp);
    (errors.iter().sum::<f32>() / errors.len() as f32, errors[errors.len() * 99 / 100])
}

#[test]
fn prefiltered_surroundings_are_those_of_many_directions() {
    let Some(gpu) = gpu() else { return };
    let mut renderer = renderer(gpu);
    let options = Options { samples: 1, directions: 1500, flakes: false, ..Options::default() };
    let mut worst = [0.0f32; 2];
    // A dim room with small lamps, two of them 2 to 3 degrees wide and the third a line.
    let lamp = |direction, size_deg, radiance| Softbox {
        direction,
        size_deg,
        edge_deg: 1.0,
        radiance: [radiance; 3],
    };
    let softbox = vec![
        lamp([0.6, -0.5, 0.6], [2.0, 3.0], 900.0),
        lamp([-0.8, 0.1, -0.2], [2.0, 2.0], 300.0),
        lamp([-0.2, -1.0, 0.9], [40.0, 1.5], 40.0),
    ];
    let [ground, horizon, zenith] = [0.1, 0.2, 0.15].map(|radiance| [radiance; 3]);
    let room = Environment::Studio { ground, horizon, zenith, softbox };
    for paint_name in
        ["no flakes", "sparse flakes that live", "refracting, flakes that stay, sharp gloss", "simulated"]
    {
        let paint = paint(paint_name);
        let scenes = ["capsule", "sphere"].map(|shape| (shape, studio(shape)));
        let small = ("small lamps", Scene { environment: room.clone(), ..studio("sphere") });
        for (shape, scene) in scenes.into_iter().chain([small]) {
            let expected = render(&scene, std::slice::from_ref(paint), &options, &|| ()).unwrap();
            let (mean, most) =
                errors(&expected, &next_frame(&mut renderer, gpu, &scene, paint, &FrameOptions::default()));
            say(&format!(
                "{paint_name}: {shape}: mean {:.2} %, 99 % below {:.2} %",
                100.0 * mean,
                100.0 * most
            ));
            // A sharp gloss mirrors the edge of a small lamp in pixels of its own.
            let least = if shape == "small lamps" { [0.0127, 0.167] } else { [0.0122, 0.0578] };
            worst = [worst[0].max(mean / least[0]), worst[1].max(most / least[1])];
        }
    }
    // As measured, with a fifth to spare: 128 directions, 256 points of lamps, a map of 40 x 40 normals.
    assert!(worst[0] <= 1.2 && worst[1] <= 1.2, "{worst:?}");
}

#[test]
fn maps_follow_camera_paint_and_surroundings() {
    let Some(gpu) = gpu() else { return };
    let paints = ["no flakes", "simulated"].map(paint);
    let on_gpu = paints.map(|p| GpuPaint::new(gpu, p).unwrap());
    let mut renderer = renderer(gpu);
    let first = studio("capsule");
    let camera = Camera { position_mm: [90.0, -180.0, 60.0], vertical_fov_deg: 40.0, ..first.camera };
    let dim = Environment::Constant { radiance: [0.3, 0.2, 0.1] };
    let sky =
        |green: f64| Environment::Sky { sun: [1.0, -1.0, 1.0], zenith: [0.1, green, 0.4], ground: [0.2; 3] };
    let under = |green| Scene { environment: sky(green), ..first.clone() };
    let cases = [
        (0, first.clone()),
        (0, Scene { camera, ..first.clone() }),
        (1, Scene { camera, ..first.clone() }),
        // Panoramas: kept while the camera moves, and another one.
        (0, under(0.2)),
        (0, Scene { camera, ..under(0.2) }),
        (0, under(0.3)),
        (1, Scene { environment: dim, ..first.clone() }),
        (0, first),
    ];
    for (number, scene) in cases {
        let seen = renderer.picture(gpu, &scene, &[&on_gpu[number]], &FrameOptions::default()).unwrap();
        // A renderer that knows nothing of what was before.
        assert_eq!(seen, frame(gpu, &scene, paints[number], &FrameOptions::default()));
    }
}

#[test]
fn objects_wear_paints_of_their_own() {
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
        Object { tilt_deg: [10.0, 50.0], ..at("capsule", [15.0, -30.0, 5.0], 2) },
    ];
    let paints = ["simulated", "no flakes", "sparse flakes that live"].map(|name| paint(name).clone());
    let (_, scene) = lamp_scenes().remove(1);
    let scene = Scene { objects, ..scene };
    let options = Options { samples: 1, directions: 1, ..Options::default() };
    let expected = render(&scene, &paints, &options, &|| ()).unwrap();
    let on_gpu = paints.each_ref().map(|p| GpuPaint::new(gpu, p).unwrap());
    let shown: Vec<_> = on_gpu.iter().collect();
    let seen = renderer(gpu).picture(gpu, &scene, &shown, &FrameOptions::default()).unwrap();
    let (differ, off) = compare(&expected, &seen);
    // As of one object; and a ray along the edge of an object or of its shadow may pass on either side.
    assert!(differ <= 5e-3 && off <= 1e-3, "{differ} {off:e}");
    assert!(renderer(gpu).picture(gpu, &scene, &shown[..2], &FrameOptions::default()).is_err());
}

/// Mean, standard deviation and 99.9 % quantile of the green of a picture.
fn spread(picture: &Picture) -> [f64; 3] {
    let mut green: Vec<f64> = picture.pixels.iter().map(|p| f64::from(p[1])).collect();
    green.sort_by(f64::total_cmp);
    let n = green.len() as f64;
    let mean = green.iter().sum::<f64>() / n;
    let variance = green.iter().map(|g| (g - mean) * (g - mean)).sum::<f64>() / n;
    [mean, variance.sqrt(), green[green.len() * 999 / 1000]]
}

#[test]
fn rows_keep_mean_contrast_and_sparkles() {
    let Some(gpu) = gpu() else { return };
    let mut renderer = renderer(gpu);
    let (_, mut scene) = lamp_scenes().into_iter().find(|(name, _)| name == "panel").unwrap();
    // So small that boxes, too, look at its middle only.
    for light in &mut scene.lights {
        match light {
            Light::Directional(light) => light.angular_radius_deg = 0.5,
            Light::Point(lamp) | Light::Spot(SpotLight { lamp, .. }) => lamp.radius_mm *= 0.25,
        }
    }
    for paint_name in ["sparse flakes that live", "simulated"] {
        let on_gpu = GpuPaint::new(gpu, paint(paint_name)).unwrap();
        // A pixel 0.3 and 1.5 texels of 0.02 mm wide, and one of some levels.
        for vertical_fov_deg in [0.4, 2.0, 12.0] {
            let camera = Camera { vertical_fov_deg, ..scene.camera };
            let scene = Scene { size: [256, 256], camera, ..scene.clone() };
            let mut drawn = |rows| {
                let options = FrameOptions { rows, ..FrameOptions::default() };
                spread(&renderer.picture(gpu, &scene, &[&on_gpu], &options).unwrap())
            };
            let ([mean, deviation, bright], seen) = (drawn(false), drawn(true));
            let ratios = [seen[0] / mean, seen[1] / deviation, seen[2] / bright];
            say(&format!("{paint_name}: {vertical_fov_deg}: rows over boxes: mean, std, q99.9 {ratios:.3?}"));
            // Where in its box a color lies is drawn once a step instead of once a texel: four standard errors of draws that scatter by
            // a third of the mean, one for each of (256 x 0.3 texels)^2 and more; one draw of 65 is the quantile.
            let error = 4.0 / 3.0 / (256.0 * 0.75 * vertical_fov_deg);
            assert!((ratios[0] - 1.0).abs() <= 0.002 + error, "{ratios:?}");
            assert!((ratios[1] - 1.0).abs() <= 0.01 + error, "{ratios:?}");
            assert!((ratios[2] - 1.0).abs() <= 0.03, "{ratios:?}");
        }
    }
}

#[test]
fn sampled_surroundings_are_those_of_the_reference() {
    let Some(gpu) = gpu() else { return };
    let scene = studio("capsule");
    let options = Options { samples: 1, directions: 24, ..Options::default() };
    let paint = paint("simulated");
    let expected = render(&scene, std::slice::from_ref(paint), &options, &|| ()).unwrap();
    let sampled = FrameOptions { directions: Some(24), ..FrameOptions::default() };
    let (differ, off) = compare(&expected, &frame(gpu, &scene, paint, &sampled));
    assert!(differ <= 1e-3 && off <= 1e-4, "{differ} {off:e}");
}

#[test]
fn eight_bits_are_those_of_a_picture() {
    let Some(gpu) = gpu() else { return };
    let paint = GpuPaint::new(gpu, paint("no flakes")).unwrap();
    let scene = Scene { size: [64, 40], ..Scene::default() };
    let options = FrameOptions { exposure_stops: 0.7, ..FrameOptions::default() };
    let linear = FrameOptions { exposure_stops: 0.0, ..options };
    let expected =
        renderer(gpu).picture(gpu, &scene, &[&paint], &linear).unwrap().encode(0.7, &ToneMap::default());
    for format in [TextureFormat::Rgba8Unorm, TextureFormat::Rgba8UnormSrgb] {
        let seen = FrameRenderer::new(gpu, format).unwrap().codes(gpu, &scene, &[&paint], &options).unwrap();
        for (a, b) in expected.iter().zip(&seen) {
            // The built-in power may be off by some units of f32, and rounds to a neighboring code.
            assert!((0..3).all(|c| a[c].abs_diff(b[c]) <= 1), "{format:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn parts_of_a_frame_are_drawn_alone() {
    let Some(gpu) = gpu() else { return };
    let [one, two] = ["no flakes", "simulated"].map(|name| GpuPaint::new(gpu, paint(name)).unwrap());
    let scene = Scene { size: [64, 40], ..Scene::default() };
    let mut renderer = FrameRenderer::new(gpu, TextureFormat::Rgba32Float).unwrap();
    let usual = FrameOptions::default();
    let whole = [&one, &two].map(|p| renderer.picture(gpu, &scene, &[p], &usual).unwrap());
    let target = gpu_target(gpu, [64, 40], TextureFormat::Rgba32Float);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    for (paint, part) in [(&one, [[0, 0], [20, 40]]), (&two, [[20, 0], [44, 40]])] {
        let options = FrameOptions { part: Some(part), ..usual };
        renderer.draw(gpu, &scene, &[paint], &options, &view, [64, 40]).unwrap();
    }
    let seen = renderer.read(gpu, &target).unwrap();
    for (k, pixel) in seen.pixels.iter().enumerate() {
        assert_eq!(*pixel, whole[usize::from(k % 64 >= 20)].pixels[k], "{k}");
    }
    let options = FrameOptions { part: Some([[60, 0], [5, 40]]), ..usual };
    assert!(renderer.draw(gpu, &scene, &[&one], &options, &view, [64, 40]).is_err());
}

fn gpu_target(gpu: &Gpu, [width, height]: [u32; 2], format: TextureFormat) -> wgpu::Texture {
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

#[test]
fn nothing_is_drawn_into_nothing() {
    let Some(gpu) = gpu() else { return };
    let paint = GpuPaint::new(gpu, paint("no flakes")).unwrap();
    let view = gpu_target(gpu, [1, 1], TextureFormat::Rgba32Float)
        .create_view(&wgpu::TextureViewDescriptor::default());
    let mut renderer = renderer(gpu);
    let (scene, options) = (Scene::default(), FrameOptions::default());
    for size in [[0, 0], [0, 5], [7, 0]] {
        renderer.draw(gpu, &scene, &[&paint], &options, &view, size).unwrap();
    }
    renderer.draw(gpu, &scene, &[&paint], &options, &view, [1, 1]).unwrap();
    assert!(renderer.draw(gpu, &scene, &[], &options, &view, [1, 1]).is_err());
    let message = renderer.draw(gpu, &scene, &[&paint], &options, &view, [1 << 14, 1 << 20]).unwrap_err();
    assert!(message.to_string().contains("size"), "{message}");
}

#[test]
fn a_frame_that_fails_leaves_nothing_half_filled() {
    if gpu().is_none() {
        return;
    }
    // Its own, so that no other test is told of the fault.
    let gpu = &Gpu::new(None).unwrap();
    let (scene, paint) = (studio("capsule"), paint("simulated"));
    let on_gpu = GpuPaint::new(gpu, paint).unwrap();
    let mut renderer = renderer(gpu);
    let options = FrameOptions { rows: true, ..FrameOptions::default() };
    // A target of another format: no pass is run.
    let size = scene.size.map(|n| n as u32);
    let other = gpu_target(gpu, size, TextureFormat::Rgba16Float);
    let other = other.create_view(&wgpu::TextureViewDescriptor::default());
    assert!(renderer.draw(gpu, &scene, &[&on_gpu], &options, &other, size).is_err());
    let seen = renderer.picture(gpu, &scene, &[&on_gpu], &options).unwrap();
    assert_eq!(seen, frame(gpu, &scene, paint, &options));
}

#[test]
fn hard_cases_are_finite() {
    let Some(gpu) = gpu() else { return };
    let from = Camera::default();
    let camera = |position_mm, vertical_fov_deg| Camera { position_mm, vertical_fov_deg, ..from };
    let panel = Shape::Panel { size_mm: [24.0, 50.0], normal: [0.0, 0.0, 1.0] };
    let far = |direction| Light::from(DirectionalLight { direction, ..DirectionalLight::default() });
    let bright =
        Environment::Studio { ground: [1e6; 3], horizon: [0.0; 3], zenith: [1.0; 3], softbox: Vec::new() };
    let disc = Softbox { direction: [0.5, -1.0, 0.7], size_deg: [1.0; 2], edge_deg: 0.5, radiance: [1e6; 3] };
    let sun =
        Environment::Studio { ground: [0.0; 3], horizon: [0.0; 3], zenith: [0.0; 3], softbox: vec![disc] };
    let usual = Scene { size: [30, 40], ..Scene::default() };
    let lamp =
        |position_mm, radius_mm| Light::Point(PointLight { position_mm, irradiance: [1e6; 3], radius_mm });
    let cases = [
        ("grazing", Scene { shape: panel, camera: camera([0.0, -100.0, 0.01], 40.0), ..usual.clone() }),
        (
            "back",
            Scene { shape: Shape::Panel { size_mm: [24.0, 50.0], normal: [0.0, 1.0, 0.0] }, ..usual.clone() },
        ),
        ("inside", Scene { camera: camera([0.0, 1.0, 2.0], 90.0), ..usual.clone() }),
        ("zero footprint", Scene { camera: camera([0.0, -1e6, 0.0], 0.01), ..usual.clone() }),
        ("huge radiance", Scene { environment: bright, ..usual.clone() }),
        ("huge lamp", Scene { environment: sun, ..usual.clone() }),
        (
            "at the horizon",
            Scene { lights: vec![far([0.0, 1.0, 0.0]), far([0.0, 0.0, -1.0])], ..usual.clone() },
        ),
        (
            "at the surface",
            Scene { lights: vec![lamp([0.0, -13.0, 0.0], 1.0), lamp([0.0, 0.0, 2.0], 0.5)], ..usual },
        ),
    ];
    let mut renderer = renderer(gpu);
    for (name, paint) in gpu_paints::all() {
        let on_gpu = GpuPaint::new(gpu, paint).unwrap();
        for (case, scene) in &cases {
            let seen = renderer.picture(gpu, scene, &[&on_gpu], &FrameOptions::default()).unwrap();
            let bad = seen.pixels.iter().flatten().filter(|c| !c.is_finite()).count();
            assert_eq!(bad, 0, "{name}: {case}");
        }
    }
}

#[test]
fn a_device_of_a_window_is_checked() {
    let Some(gpu) = gpu() else { return };
    let paint = paint("no flakes");
    let (scene, options) = (Scene { size: [20, 30], ..Scene::default() }, FrameOptions::default());
    let first = frame(gpu, &scene, paint, &options);
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = same_adapter(&instance);
    let limits = Gpu::required_limits().using_resolution(adapter.limits());
    for (required_limits, is_enough) in [(limits, true), (wgpu::Limits::downlevel_defaults(), false)] {
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
        match Gpu::from_device(device, queue, &adapter.get_info()) {
            Ok(window) => {
                assert!(is_enough);
                let (differ, _) = compare(&first, &frame(&window, &scene, paint, &options));
                assert_eq!(differ, 0.0);
            }
            Err(e) => assert!(!is_enough && e.to_string().contains("max_storage_buffers"), "{e}"),
        }
    }
}

fn same_adapter(instance: &wgpu::Instance) -> wgpu::Adapter {
    let name = gpu().unwrap().name().to_owned();
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.into_iter().find(|a| name.starts_with(&a.get_info().name)).unwrap()
}
