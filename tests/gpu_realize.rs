//! Blends made on the GPU against those of the CPU.
#![cfg(feature = "gpu")]
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "gpu/adapter.rs"]
mod adapter;
#[path = "mix/paints.rs"]
mod paints;

use adapter::{gpu, say};
use carpaint::Paint;
use carpaint::btf::{AngleGrid, CellSet};
use carpaint::cluster::{SliceStatistics, deviation_of_draws};
use carpaint::gpu::{Evaluator, FrameOptions, FrameRenderer, GivenQuery, Gpu, GpuMix, GpuPaint};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::mix::{BlendOptions, Channels, Mix, Path};
use carpaint::paint::FlakeLevel;
use carpaint::render::{DrawnSlice, RenderPaint};
use carpaint::scene::{Camera, DirectionalLight, Environment, Light, Scene, Shape};
use glam::{DVec3, Vec3};
use paints::{mix_along, paint};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::f32::consts::TAU;
use wgpu::TextureFormat;

/// What is drawn of a paint: boxes, and so offsets, are rounded as on the GPU.
fn drawn(paint: &Paint) -> Vec<SliceStatistics> {
    let paint = RenderPaint::new(paint).unwrap();
    let statistics = |slice: &Option<DrawnSlice>| match slice {
        Some(slice) => slice.statistics.clone(),
        None => SliceStatistics::left_out(),
    };
    paint.flakes.iter().flat_map(|f| f.levels()).flat_map(|(_, slices)| slices).map(statistics).collect()
}

/// A paint whose boxes are rounded already: those of its blends differ by the rounding of the blends alone.
fn rounded(paint: Paint) -> Paint {
    let mut slices = drawn(&paint).into_iter();
    let mut paint = paint;
    for level in &mut paint.flakes.as_mut().unwrap().levels {
        level.slices.iter_mut().for_each(|slice| *slice = slices.next().unwrap());
    }
    paint
}

fn three() -> [Paint; 3] {
    [paint(1, 50), paint(2, 50), paint(3, 20)].map(rounded)
}

fn mixes() -> Vec<(String, Mix)> {
    let three = three();
    let two: Vec<_> = three[..2].iter().collect();
    let mut mixes: Vec<_> =
        Path::ALL.iter().map(|path| (format!("two, {path}"), mix_along(*path, &two))).collect();
    mixes.push(("three".to_owned(), mix_along(Path::Hybrid, &three.iter().collect::<Vec<_>>())));
    mixes
}

/// Inside and outside of [0, 1], and at the ends. Not round, where three boxes on a lattice would meet half way between its steps.
fn weights(paints: usize) -> Vec<Vec<f64>> {
    let weights: &[&[f64]] = match paints {
        2 => &[&[0.5, 0.5], &[0.999, 0.001], &[1.0, 0.0], &[0.0, 1.0], &[-0.5, 1.5], &[3.0, -2.0]],
        _ => &[
            &[0.3137, 0.2891, 0.3972],
            &[0.0, 0.5, 0.5],
            &[0.0, 0.0, 1.0],
            &[0.7213, -0.2171, 0.4958],
            &[-0.4127, -0.3896, 1.8023],
        ],
    };
    weights.iter().map(|w| w.to_vec()).collect()
}

fn queries(n: u32) -> Vec<GivenQuery> {
    let direction = |z: f32, turn: f32| {
        let (sin, cos) = (TAU * turn).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    };
    (0..n)
        .map(|k| {
            let [a, b, c, d] = pcg4d([k, 1, 5, 6]).map(unit);
            let [u, inside @ ..] = pcg4d([k, 2, 5, 6]).map(unit);
            let side = 1.0 + (k % 3) as f32 * 0.4;
            GivenQuery { wi: direction(a, b), wo: direction(c, d), u, inside, side, widening: 0.0 }
        })
        .collect()
}

#[test]
fn colors_drawn_are_those_of_the_blend_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let queries = queries(20_000);
    for (name, mix) in mixes() {
        let mut on_gpu = GpuMix::new(gpu, &mix).unwrap();
        for weights in weights(mix.constituents.len()) {
            let expected = mix.blend(&weights).unwrap();
            let expected = GpuPaint::new(gpu, &RenderPaint::new(&expected).unwrap()).unwrap();
            let expected = evaluator.evaluate_given(gpu, &expected, &queries).unwrap();
            let realized = on_gpu.realize(gpu, &weights, &BlendOptions::default()).unwrap();
            let seen = evaluator.evaluate_given(gpu, realized, &queries).unwrap();
            let difference = |(a, b): (&Vec3, &Vec3)| {
                assert!(b.is_finite(), "{name}: {weights:?}");
                (*a - *b).abs().max_element() / a.abs().max_element().max(b.abs().max_element()).max(1e-6)
            };
            let mut all: Vec<f32> = expected.iter().zip(&seen).map(difference).collect();
            all.sort_by(f32::total_cmp);
            let mean = |v: &[Vec3]| v.iter().map(|v| v.as_dvec3()).sum::<DVec3>();
            let off =
                (mean(&expected) - mean(&seen)).abs().max_element() / mean(&expected).abs().max_element();
            let (most, usual) = (all[all.len() - 1], all[all.len() * 999 / 1000]);
            say(&format!(
                "{name}: {weights:?}: largest {most:.1e}, 99.9 % below {usual:.1e}, means {off:.1e}"
            ));
            // Colors at the end of a cluster may be its neighbor's, and those of narrow bands hang on the last bits of u.
            assert!(usual <= 1e-3 && off <= 1e-4, "{name}: {weights:?}: {most:e} {usual:e} {off:e}");
        }
    }
}

#[test]
fn numbers_realized_are_those_of_the_blend_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let [mut gains, mut offsets, mut means] = [0.0f64; 3];
    for (name, mix) in mixes() {
        let mut on_gpu = GpuMix::new(gpu, &mix).unwrap();
        for weights in weights(mix.constituents.len()) {
            for channels in Channels::ALL {
                let options = BlendOptions { channels, source: 1, ..BlendOptions::default() };
                let expected = mix.blend_with(&weights, &options).unwrap();
                let seen = on_gpu.realize(gpu, &weights, &options).unwrap().statistics(gpu).unwrap();
                let rounded = drawn(&expected);
                assert_eq!(rounded.len(), seen.len());
                for ((exact, a), b) in paints::slices(&expected).zip(&rounded).zip(&seen) {
                    let scale = a.box_mean().abs().max_element().max(a.mean_rgb().abs().max_element());
                    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
                    // A gain that keeps the contrast makes up for what rounding does to it; others are what they are.
                    let [of_exact, of_rounded] = [exact, a]
                        .map(|s| deviation_of_draws(&s.clusters, &s.fades).max(DVec3::splat(1e-30)));
                    let apart = |wanted: DVec3| {
                        (wanted - vector(b.gain)).abs() / vector(a.gain).max(DVec3::splat(1e-3))
                    };
                    let gain = apart(vector(a.gain)).min(apart(vector(a.gain) * of_exact / of_rounded));
                    let wanted = a.mean_rgb() - vector(b.gain) * a.box_mean();
                    let offset = (wanted - vector(b.offset)).abs().max_element() / scale;
                    let mean = (a.mean_rgb() - b.mean_rgb()).abs().max_element() / scale;
                    (gains, offsets) = (gains.max(gain.max_element()), offsets.max(offset));
                    means = means.max(mean);
                    let place = format!("{name}: {weights:?} {channels}");
                    // A deviation is the root of a mean square in f32; an offset, what gain and boxes leave of a mean; a mean, the sum
                    // of some hundred products.
                    assert!(gain.max_element() <= 1e-4, "{place}: {:?} {:?}", a.gain, b.gain);
                    assert!(offset <= 1e-4, "{place}: {:?} {:?}", a.offset, b.offset);
                    assert!(mean <= 2e-6, "{place}: {} {}", a.mean_rgb(), b.mean_rgb());
                }
            }
        }
    }
    say(&format!(
        "largest differences: gains {gains:.1e}, offsets {offsets:.1e}, means of slices {means:.1e}"
    ));
}

#[test]
fn what_the_cpu_refuses_the_gpu_refuses() {
    let Some(gpu) = gpu() else { return };
    let (_, mix) = mixes().remove(0);
    let mut on_gpu = GpuMix::new(gpu, &mix).unwrap();
    let options = BlendOptions::default();
    for weights in [&[1.0][..], &[0.5, 0.6], &[f64::NAN, 1.0]] {
        let message = mix.blend(weights).unwrap_err().to_string();
        assert_eq!(on_gpu.realize(gpu, weights, &options).unwrap_err().to_string(), message);
    }
    let source = BlendOptions { source: 2, ..options };
    assert!(on_gpu.realize(gpu, &[0.5, 0.5], &source).is_err());
}

#[test]
fn mixes_without_flakes_and_with_slices_left_out_are_realized() {
    let Some(gpu) = gpu() else { return };
    let (_, mix) = mixes().remove(0);
    let mut few = mix.clone();
    let mut cells = CellSet::none(paint(1, 50).flakes.unwrap().grid.len(), 2);
    cells.insert(0, 1);
    few.flakes.as_mut().unwrap().keep(&cells);
    let mut none = mix;
    none.flakes = None;
    for mix in [few, none] {
        let mut on_gpu = GpuMix::new(gpu, &mix).unwrap();
        let expected = RenderPaint::new(&mix.blend(&[0.3, 0.7]).unwrap()).unwrap();
        let expected = GpuPaint::new(gpu, &expected).unwrap();
        let realized = on_gpu.realize(gpu, &[0.3, 0.7], &BlendOptions::default()).unwrap();
        let evaluator = Evaluator::new(gpu).unwrap();
        let queries = queries(2000);
        let [a, b] = [&expected, realized].map(|p| evaluator.evaluate_given(gpu, p, &queries).unwrap());
        let far = a
            .iter()
            .zip(&b)
            .filter(|(a, b)| (**a - **b).abs().max_element() > 1e-3 * a.abs().max_element().max(1e-6));
        // As of whole mixes.
        assert!(far.count() <= 2);
    }
}

#[test]
fn paints_of_a_mix_are_there_by_themselves() {
    let Some(gpu) = gpu() else { return };
    let three = three();
    let mix = mix_along(Path::Hybrid, &three.iter().collect::<Vec<_>>());
    let on_gpu = GpuMix::new(gpu, &mix).unwrap();
    assert_eq!(on_gpu.constituents().len(), 3);
    for (paint, own) in three.iter().zip(on_gpu.constituents()) {
        let seen = own.statistics(gpu).unwrap();
        assert_eq!(seen.len(), paints::slices(paint).count());
        for (a, b) in paints::slices(paint).zip(&seen) {
            let (x, y) = (paints::merged(&a.clusters), paints::merged(&b.clusters));
            assert_eq!(x.len(), y.len());
            for (x, y) in x.iter().zip(&y) {
                assert_eq!((x.min, x.max), (y.min, y.max));
                // A difference of two sums in f32.
                assert!((x.probability - y.probability).abs() < 2e-7, "{} {}", x.probability, y.probability);
            }
            let lightness = |k: usize| b.clusters[k].min[0] + b.clusters[k].max[0];
            assert!((1..b.clusters.len()).all(|k| lightness(k - 1) <= lightness(k)), "u runs upwards");
            // Offsets of 0.01 or less in f32.
            let off = (DVec3::from(a.offset.map(f64::from)) - DVec3::from(b.offset.map(f64::from))).length();
            assert!(off < 1e-8 && a.gain == b.gain, "{off}");
        }
    }
    let paints: u64 = on_gpu.constituents().iter().chain([on_gpu.paint()]).map(GpuPaint::bytes).sum();
    let own: u64 = on_gpu.parts().iter().map(|(_, bytes)| bytes).sum();
    assert!(on_gpu.bytes() >= paints + own);
}

/// Slices that are there.
fn count(slices: &[SliceStatistics]) -> usize {
    slices.iter().filter(|s| !s.is_left_out()).count()
}

#[test]
fn cells_that_are_asked_for_are_there_and_no_others_are_stale() {
    let Some(gpu) = gpu() else { return };
    let mix = mix_along(Path::Hybrid, &three().iter().collect::<Vec<_>>());
    let slices = mix.flakes.as_ref().unwrap().grid.len();
    let options = BlendOptions::default();
    let [first, second] = [[0.3, 0.3, 0.4], [0.6, 0.5, -0.1]];
    let [whole_first, whole_second] = [first, second].map(|weights| {
        let mut whole = GpuMix::new(gpu, &mix).unwrap();
        whole.realize(gpu, &weights, &options).unwrap().statistics(gpu).unwrap()
    });
    let cells = |places: &[(usize, usize)]| {
        let mut cells = CellSet::none(slices, 2);
        places.iter().for_each(|(level, slice)| cells.insert(*level, *slice));
        cells
    };
    let [some, others] = [cells(&[(0, 1), (1, 4)]), cells(&[(0, 2), (1, 4)])];
    let mut both = some.clone();
    both.extend(&others);
    let mut on_gpu = GpuMix::new(gpu, &mix).unwrap();
    on_gpu.realize(gpu, &first, &options).unwrap();
    let mut check = |weights: &[f64], asked: &CellSet, there: &CellSet, whole: &[SliceStatistics]| {
        let version_there = on_gpu.realize_cells(gpu, weights, &options, asked).unwrap();
        let seen = version_there.statistics(gpu).unwrap();
        for (k, (seen, whole)) in seen.iter().zip(whole).enumerate() {
            if there.contains(k / slices, k % slices) {
                assert_eq!(seen, whole, "slice {k}");
            } else {
                assert!(seen.is_left_out(), "slice {k}");
            }
        }
    };
    let all = CellSet::all(slices, 2);
    check(&second, &some, &some, &whole_second);
    check(&second, &others, &both, &whole_second);
    check(&second, &some, &both, &whole_second);
    check(&first, &others, &others, &whole_first);
    check(&second, &cells(&[]), &cells(&[]), &whole_second);
    check(&second, &all, &all, &whole_second);
}

/// Paints of many slices and levels.
fn wide_paint(seed: u64) -> Paint {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut paint = paint(seed, 4);
    let flakes = paint.flakes.as_mut().unwrap();
    flakes.grid = AngleGrid::triangle(12).unwrap();
    let mut level = |k: i32| FlakeLevel {
        pitch_mm: 0.02 * 2f64.powi(k),
        slices: (0..flakes.grid.len()).map(|_| paints::slice(&mut rng, [12, 8, 4, 1][k as usize])).collect(),
    };
    flakes.levels = (0..4).map(&mut level).collect();
    flakes.size = [8, 8];
    paint
}

#[test]
fn frames_of_what_they_need_are_frames_of_all() {
    let Some(gpu) = gpu() else { return };
    let (one, two) = (wide_paint(1), wide_paint(2));
    let mix = mix_along(Path::Hybrid, &[&one, &two]);
    let [mut whole, mut part] = [GpuMix::new(gpu, &mix).unwrap(), GpuMix::new(gpu, &mix).unwrap()];
    let renderer = || FrameRenderer::new(gpu, TextureFormat::Rgba32Float).unwrap();
    // One each, so that what a renderer has of the last frame's paint is of this mix.
    let mut renderers = [renderer(), renderer()];
    let sun =
        |x: f64| Light::from(DirectionalLight { direction: [x, -0.7, 0.6], ..DirectionalLight::default() });
    let far = Scene {
        size: [60, 80],
        shape: Shape::named("sphere").unwrap(),
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![sun(0.4)],
        ..Scene::default()
    };
    let near = Scene {
        camera: Camera { vertical_fov_deg: 1.0, ..far.camera },
        lights: vec![sun(-0.2)],
        ..far.clone()
    };
    let mut fewest = usize::MAX;
    // Weights change in every frame, the scene at times, back to one of before, too.
    for (frame, scene) in [&far, &far, &far, &near, &near, &near, &far, &far].into_iter().enumerate() {
        let weights = [0.1 * frame as f64, 1.0 - 0.1 * frame as f64];
        let blend = BlendOptions::default();
        let expected = whole.realize(gpu, &weights, &blend).unwrap();
        let seen = part.realize_for(gpu, &weights, &blend, scene, None).unwrap();
        fewest = fewest.min(count(&seen.statistics(gpu).unwrap()));
        for rows in [false, true] {
            let options = FrameOptions { rows, ..FrameOptions::default() };
            let expected = renderers[0].picture(gpu, scene, &[expected], &options).unwrap();
            let seen = renderers[1].picture(gpu, scene, &[seen], &options).unwrap();
            for (a, b) in expected.pixels.iter().zip(&seen.pixels) {
                let (a, b) = (Vec3::from(*a), Vec3::from(*b));
                // Where the GPU rounds an angle over the edge of a slice, that slice counts for the rounding.
                assert!(
                    (a - b).abs().max_element() <= 1e-5 * a.abs().max_element().max(1e-3),
                    "{frame}: {a} {b}"
                );
            }
        }
    }
    // Rows of slices that are there no more are dark, like those that never were.
    let options = FrameOptions { rows: true, ..FrameOptions::default() };
    let mut last = |paint: &GpuPaint| renderers[1].picture(gpu, &far, &[paint], &options).unwrap();
    let before = last(part.paint());
    let cells = CellSet::none(one.flakes.as_ref().unwrap().grid.len(), 4);
    let bare = part.realize_cells(gpu, &[0.35, 0.65], &BlendOptions::default(), &cells).unwrap();
    let seen = last(bare);
    assert_eq!(seen, renderer().picture(gpu, &far, &[bare], &options).unwrap());
    assert_ne!(seen, before);
    let total = 4 * one.flakes.unwrap().grid.len();
    say(&format!("{fewest} of {total} cells realized"));
    assert!(fewest < total / 2, "{fewest} of {total}");
}

/// A device of its own, to be lost.
fn own_gpu() -> Option<Gpu> {
    gpu().map(|_| Gpu::new(None).unwrap())
}

#[test]
fn a_device_that_is_lost_is_an_error_and_another_one_goes_on() {
    let Some(first) = own_gpu() else { return };
    let (_, mix) = mixes().remove(0);
    let options = BlendOptions::default();
    let scene = Scene { size: [16, 16], ..Scene::default() };
    let draw = |gpu: &Gpu, renderer: &mut FrameRenderer, paint: &GpuPaint| {
        renderer.picture(gpu, &scene, &[paint], &FrameOptions::default())
    };
    let mut on_gpu = GpuMix::new(&first, &mix).unwrap();
    let mut renderer = FrameRenderer::new(&first, TextureFormat::Rgba32Float).unwrap();
    let expected =
        draw(&first, &mut renderer, on_gpu.realize(&first, &[0.3, 0.7], &options).unwrap()).unwrap();
    first.device().destroy();
    // Whatever comes next, and after that.
    for _ in 0..2 {
        let complaints = [
            draw(&first, &mut renderer, on_gpu.paint()).map(|_| ()).unwrap_err(),
            on_gpu.realize(&first, &[0.5, 0.5], &options).map(|_| ()).unwrap_err(),
            on_gpu.paint().statistics(&first).map(|_| ()).unwrap_err(),
            GpuMix::new(&first, &mix).map(|_| ()).unwrap_err(),
            FrameRenderer::new(&first, TextureFormat::Rgba32Float).map(|_| ()).unwrap_err(),
            first.wait().unwrap_err(),
        ];
        for complaint in complaints {
            assert!(complaint.to_string().contains("device lost"), "{complaint}");
        }
    }
    let Some(second) = own_gpu() else { return };
    let mut on_gpu = GpuMix::new(&second, &mix).unwrap();
    let mut renderer = FrameRenderer::new(&second, TextureFormat::Rgba32Float).unwrap();
    let seen = draw(&second, &mut renderer, on_gpu.realize(&second, &[0.3, 0.7], &options).unwrap()).unwrap();
    assert_eq!(expected.pixels, seen.pixels);
}

#[test]
fn a_device_lost_between_realization_and_frame_is_an_error() {
    let Some(gpu) = own_gpu() else { return };
    let (_, mix) = mixes().remove(0);
    let mut on_gpu = GpuMix::new(&gpu, &mix).unwrap();
    let mut renderer = FrameRenderer::new(&gpu, TextureFormat::Rgba32Float).unwrap();
    let scene = Scene { size: [16, 16], ..Scene::default() };
    let realized = on_gpu.realize(&gpu, &[0.3, 0.7], &BlendOptions::default()).unwrap();
    gpu.device().destroy();
    let complaint = renderer.picture(&gpu, &scene, &[realized], &FrameOptions::default()).unwrap_err();
    assert!(complaint.to_string().contains("device lost"), "{complaint}");
}

#[test]
fn a_device_of_small_limits_is_refused_by_name() {
    if gpu().is_none() {
        return;
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = adapters.into_iter().next().unwrap();
    let descriptor =
        wgpu::DeviceDescriptor { required_limits: wgpu::Limits::downlevel_defaults(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let message = Gpu::from_device(device, queue, &adapter.get_info()).unwrap_err().to_string();
    assert!(
        message.contains("max_storage_buffers_per_shader_stage: found 4, expected 8 or better"),
        "{message}"
    );
}
