//! Frames in real time: (a) a plain GGX shader, (b) car paint with raw slices of flakes, four fetches a light, (c) with their
//! statistics, (d) the same while the paint is another blend every frame; (e), (f): as (c), (d), flakes drawn from rows;
//! (g): as (b), with up to 16 samples along a footprint, as (c) to (f) take. `cargo bench
//! --bench frame`, or with `--profile dev`.
//!
//! 465 slices of 50 clusters; a sphere under lamps alone, two to eight texels a pixel; runs of all in turn, medians of the time
//! of a frame over that of another way, and the quartiles of these ratios; how far frames are from pictures of the CPU.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::btf::AngleGrid;
use carpaint::cluster::{Cluster, SliceStatistics};
use carpaint::gpu::{FrameOptions, FrameRenderer, Gpu, GpuMix, GpuPaint, RawSlices, Rival};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::mix::{BlendOptions, CoupleOptions, couple};
use carpaint::paint::{FlakeLevel, Flakes, Knots, MissingSlice};
use carpaint::render::{Options, Picture, PictureDifference, RenderPaint, render};
use carpaint::scene::{DirectionalLight, Environment, Light, Scene, Shape};
use std::array::from_fn;
use std::time::Instant;
use wgpu::{TextureFormat, TextureView};

const BINS: usize = 30;
/// Of all slices, 1/sr.
const MEAN: f64 = 0.02;
/// Texels along an edge of a raw slice, and levels down to one.
const SIDE: u32 = 128;
const LEVELS: usize = 8;
const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
/// Runs of each way, in turn, on a GPU and on a software adapter, whose frames take seconds.
const RUNS: [usize; 2] = [15, 3];
const WARM_UP: usize = 1;
/// A run takes this long at least, seconds.
const RUN: f64 = 0.05;
/// (a) to (g).
const WAYS: usize = 7;
/// Which renderer draws each. A still paint and one that moves have the same: where in memory a renderer's textures come to lie makes
/// frames of a software adapter up to twice as slow.
const RENDERER: [usize; WAYS] = [0, 1, 2, 2, 3, 3, 4];
const RENDERERS: usize = 5;
/// Ways whose times are divided.
const RATIOS: [&str; 7] = ["a/b", "c/b", "d/c", "e/b", "f/e", "e/g", "g/b"];
/// Side of the pictures by which errors are told, and samples of a pixel of the reference.
const ERROR_SIDE: u32 = 192;
const SAMPLES: usize = 64;
const MIB: f64 = (1 << 20) as f64;

/// Like those of a flake slice: many dark clusters about zero, a few bright and rare ones, narrow boxes.
fn slice(seed: u32, number: u32, n: u32) -> SliceStatistics {
    let numbers = |k: u32, salt: u32| pcg4d([k, number, salt, seed]).map(unit);
    let weight = |k: u32| f64::from((-5.0 * k as f32 / n as f32).exp() * (0.5 + numbers(k, 0)[0]));
    let total: f64 = (0..n).map(weight).sum();
    let cluster = |k: u32| {
        let ([_, a, b, _], [l, c, d, _]) = (numbers(k, 0), numbers(k, 1));
        let center = [-25.0 + 150.0 * k as f32 / n as f32, 8.0 * a, 8.0 * b];
        let half = [2.0 * l, 2.0 * c, 2.0 * d];
        Cluster {
            probability: weight(k) / total,
            min: [0, 1, 2].map(|c| center[c] - half[c]),
            max: [0, 1, 2].map(|c| center[c] + half[c]),
        }
    };
    let drawn = SliceStatistics::new((0..n).map(cluster).collect(), [0.0; 3]);
    // All levels have the same mean.
    let offset = drawn.mean_rgb().to_array().map(|mean| (MEAN - mean) as f32);
    SliceStatistics { offset, ..drawn }
}

fn paint(seed: u32, grid: AngleGrid) -> Paint {
    let level = |k: usize| {
        // As many clusters as texels where these are few.
        let clusters = (SIDE >> k).pow(2).clamp(1, 50);
        let number = |slice: usize| (k * grid.len() + slice) as u32;
        FlakeLevel {
            pitch_mm: 0.022 * f64::from(1u32 << k),
            slices: (0..grid.len()).map(|s| slice(seed, number(s), clusters)).collect(),
        }
    };
    let levels = (0..LEVELS).map(level).collect();
    let lobe = |coefficient, roughness, f0| Lobe { coefficient, roughness, f0 };
    let [columns, rows] = ColorTable::DEFAULT_SIZE;
    let texel = |k: usize| [0.9, 0.5 + (k % columns) as f32 / 200.0, 0.4 + (k / columns) as f32 / 150.0];
    let texels = (0..columns * rows).map(texel).collect();
    Paint {
        coat: ClearCoat { gloss: Some(lobe(0.2, 0.003, 0.04)), ..ClearCoat::NONE },
        diffuse: 0.05,
        lobes: vec![lobe(0.08, 1.2, 0.4), lobe(0.11, 0.45, 0.5), lobe(0.15, 0.22, 0.8)],
        colors: ColorTable::new([columns, rows], texels, vec![true; columns * rows]).expect("legal"),
        flakes: Some(Flakes {
            grid,
            missing: MissingSlice::Zero,
            size: [SIDE as usize; 2],
            texel_mm: 0.015,
            levels,
            inverse_cdf_steps: 500,
            knots: Some(Knots::usual(0.1)),
        }),
        provenance: serde_json::Value::Null,
    }
}

fn scene(lights: usize, [width, height]: [u32; 2]) -> Scene {
    let light = |k: usize| {
        let turn = 2.4 * k as f64;
        let direction = [0.7 * turn.cos(), -1.0, 0.7 * turn.sin()];
        Light::from(DirectionalLight { direction, ..DirectionalLight::default() })
    };
    Scene {
        size: [width as usize, height as usize],
        shape: Shape::named("sphere").expect("legal"),
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: (0..lights).map(light).collect(),
        ..Scene::default()
    }
}

/// An adapter whose arrays are long enough for all slices, where there is one.
fn gpu() -> Gpu {
    let plain = Gpu::new(None).expect("an adapter");
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let same = adapters.into_iter().find(|a| plain.name().starts_with(&a.get_info().name));
    let adapter = same.expect("the same adapter");
    let limits = wgpu::Limits {
        max_texture_array_layers: 465.min(adapter.limits().max_texture_array_layers),
        ..Gpu::required_limits().using_resolution(adapter.limits())
    };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
    Gpu::from_device(device, queue, &adapter.get_info()).expect("limits")
}

fn target(gpu: &Gpu, [width, height]: [u32; 2]) -> TextureView {
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Seconds a frame, of as many as fill a run.
fn run(gpu: &Gpu, frames: usize, draw: &mut dyn FnMut(usize)) -> f64 {
    let start = Instant::now();
    (0..frames).for_each(draw);
    gpu.wait().expect("drawn");
    start.elapsed().as_secs_f64() / frames as f64
}

/// Median and quartiles.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [0.5, 0.25, 0.75].map(|q| values[(q * (values.len() - 1) as f64).round() as usize])
}

fn main() {
    let gpu = gpu();
    println!("{}; {SIDE} x {SIDE} texels a raw slice", gpu.name());
    let grid = || AngleGrid::triangle(BINS).expect("legal");
    let paints = [paint(1, grid()), paint(2, grid())];
    let named: Vec<_> = paints.iter().map(|p| ("paint".to_owned(), p)).collect();
    let (two, _) = couple(&named, &CoupleOptions::default(), &|| ()).expect("coupled");
    let on_gpu = uploaded(&gpu, &paints[0]);
    // One that stays as it is, one that changes every frame.
    let mut mixes = [(); 2].map(|()| GpuMix::new(&gpu, &two).expect("uploaded"));
    mixes[0].realize(&gpu, &[0.5, 0.5], &BlendOptions::default()).expect("legal");
    let raw = RawSlices::new(&gpu, SIDE, grid().len() as u32, |slice| {
        (0..SIDE * SIDE).map(|k| pcg4d([k, slice, 1, 2]).map(unit)).map(|[r, g, b, _]| [r, g, b]).collect()
    })
    .expect("uploaded");
    memory(&gpu, &grid());
    // As AxF car paints are laid out.
    memory(&gpu, &AngleGrid::new(12, (0..12).map(|j| 8.min(12 - j)).collect()).expect("legal"));
    let rival = |rival: &Rival| {
        let mut renderer = FrameRenderer::new(&gpu, FORMAT).expect("compiled");
        renderer.draw_rival(&gpu, rival).expect("compiled");
        renderer
    };
    let mut renderers = [
        rival(&Rival::Ggx),
        rival(&Rival::Raw(&raw, 1)),
        FrameRenderer::new(&gpu, FORMAT).expect("compiled"),
        FrameRenderer::new(&gpu, FORMAT).expect("compiled"),
        rival(&Rival::Raw(&raw, 16)),
    ];
    errors(&gpu, &paints[0]);
    println!("picture, lights: ms a frame of each way; ratios as medians and quartiles");
    for size in [[512, 512], [1920, 1080]] {
        let mut one_light = [0.0; WAYS];
        for lights in [1, 16] {
            // There (g) takes minutes a frame.
            let is_slow = gpu.is_software() && lights as u32 * size[0] > 10_000;
            let ways = if is_slow { WAYS - 1 } else { WAYS };
            let times = measure(&gpu, &mut renderers, ways, &on_gpu, &mut mixes, lights, size);
            let ratio = |name: &&str| {
                let [a, b] = ways_of(name);
                let [m, l, h] = quartiles(times.iter().map(|t| t[a] / t[b]).collect());
                format!("{name} {m:.3} ({l:.3} to {h:.3})")
            };
            let median = from_fn::<_, WAYS, _>(|k| quartiles(times.iter().map(|t| t[k]).collect())[0]);
            let list = |numbers: [f64; WAYS]| {
                numbers.map(|n| if n.is_nan() { "-".to_owned() } else { format!("{n:.2}") }).join(", ")
            };
            println!("{} x {}, {lights:>2}: {} ms", size[0], size[1], list(median.map(|m| 1e3 * m)));
            let there = RATIOS.iter().filter(|name| ways_of(name).iter().all(|way| *way < ways));
            println!("    {}", there.map(ratio).collect::<Vec<_>>().join(";  "));
            if lights == 1 {
                one_light = median;
            } else {
                println!("    sixteen lights over one: {}", list(from_fn(|k| median[k] / one_light[k])));
            }
        }
    }
    println!(
        "frame {:.1} MiB besides the paint (c), {:.1} with rows (e)",
        mib(&renderers[2]),
        mib(&renderers[3])
    );
}

/// The two of a ratio.
fn ways_of(name: &str) -> [usize; 2] {
    [0, 2].map(|k| usize::from(name.as_bytes()[k] - b'a'))
}

fn mib(renderer: &FrameRenderer) -> f64 {
    renderer.bytes() as f64 / MIB
}

/// Says how far frames from boxes (c, d) and from rows (e, f) are from the CPU's picture of as many samples, one a pixel, and from its
/// mean over many, and what of the picture's contrast they have. The rival's slices are another material.
fn errors(gpu: &Gpu, paint: &Paint) {
    let scene = scene(1, [ERROR_SIDE; 2]);
    let (drawn, on_gpu) = (RenderPaint::new(paint).expect("legal"), uploaded(gpu, paint));
    let mut renderer = FrameRenderer::new(gpu, TextureFormat::Rgba32Float).expect("compiled");
    let picture = |samples| {
        let options = Options { samples, ..Options::default() };
        render(&scene, std::slice::from_ref(&drawn), &options, &|| ()).expect("drawn")
    };
    let (one, many) = (picture(1), picture(SAMPLES));
    let difference = |a: &Picture, b: &Picture| {
        let flip = PictureDifference::of(a, b).expect("of one size").flip;
        format!("{:.2} % in the mean, FLIP {flip:.4}", 100.0 * mean_difference(a, b))
    };
    println!("  one sample over many: {}", difference(&many, &one));
    for (name, rows) in [("c, d", false), ("e, f", true)] {
        let options = FrameOptions { rows, ..FrameOptions::default() };
        let seen = renderer.picture(gpu, &scene, &[&on_gpu], &options).expect("drawn");
        println!(
            "  {name}: from one sample {}; from {SAMPLES} {}; contrast {:.3} of one sample's",
            difference(&one, &seen),
            difference(&many, &seen),
            contrast(&seen) / contrast(&one)
        );
    }
}

/// Mean difference over mean.
fn mean_difference(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let sums = pairs.fold([0.0; 2], |[d, s], (a, b)| [d + f64::from((a - b).abs()), s + f64::from(*a)]);
    sums[0] / sums[1]
}

/// Root mean square difference of neighbors in a row, in green.
fn contrast(picture: &Picture) -> f64 {
    let rows = picture.pixels.chunks(picture.size[0]);
    let squares = rows.flat_map(|row| row.windows(2)).map(|w| f64::from(w[0][1] - w[1][1]).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Bytes on the GPU of three paints and their mix, of so many slices.
fn memory(gpu: &Gpu, grid: &AngleGrid) {
    let mib = |bytes: u64| bytes as f64 / MIB;
    let paints = [1, 2, 3].map(|seed| paint(seed, grid.clone()));
    let named: Vec<_> = paints.iter().map(|p| ("paint".to_owned(), p)).collect();
    let (three, _) = couple(&named, &CoupleOptions::default(), &|| ()).expect("coupled");
    let three = GpuMix::new(gpu, &three).expect("uploaded");
    let alone = uploaded(gpu, &paints[0]);
    println!(
        "{} slices: a paint {:.2} MiB, three of them and their mix {:.2}; raw {:.1}, of 512 x 512 texels {:.1}",
        grid.len(),
        mib(alone.bytes()),
        mib(three.bytes()),
        mib(raw_bytes(grid.len(), SIDE)),
        mib(raw_bytes(grid.len(), 512)),
    );
    println!("  a paint: {:?}; the mix besides paints: {:?}", alone.parts(), three.parts());
}

/// Of slices in half floats, all levels.
fn raw_bytes(slices: usize, side: u32) -> u64 {
    let texels: u64 = (0..=side.ilog2()).map(|level| u64::from(side >> level).pow(2)).sum();
    8 * texels * slices as u64
}

fn uploaded(gpu: &Gpu, paint: &Paint) -> GpuPaint {
    GpuPaint::new(gpu, &RenderPaint::new(paint).expect("legal")).expect("uploaded")
}

/// Seconds a frame of the first ways, run by run; others take no number.
fn measure(
    gpu: &Gpu,
    renderers: &mut [FrameRenderer; RENDERERS],
    ways: usize,
    paint: &GpuPaint,
    [still, moving]: &mut [GpuMix; 2],
    lights: usize,
    size: [u32; 2],
) -> Vec<[f64; WAYS]> {
    let (scene, target) = (scene(lights, size), target(gpu, size));
    let realize = |mix: &mut GpuMix, weight: f64| {
        mix.realize_for(gpu, &[weight, 1.0 - weight], &BlendOptions::default(), &scene, None).expect("legal");
    };
    // The second time it is known what the scene needs.
    realize(moving, 0.4);
    realize(moving, 0.5);
    let mut frames = [1; WAYS];
    let mut times = Vec::new();
    // The first runs warm up and find how many frames fill a run.
    for turn in 0..RUNS[usize::from(gpu.is_software())] + WARM_UP {
        let mut row = [f64::NAN; WAYS];
        for k in 0..ways {
            let renderer = &mut renderers[RENDERER[k]];
            let mut draw = |frame: usize| {
                if k == 3 || k == 5 {
                    let weight = 0.2 + 0.6 * ((turn * 7 + frame) % 64) as f64 / 64.0;
                    realize(moving, weight);
                }
                let shown = match k {
                    2 | 4 => still.paint(),
                    3 | 5 => moving.paint(),
                    _ => paint,
                };
                let options = FrameOptions { rows: k == 4 || k == 5, ..FrameOptions::default() };
                renderer.draw(gpu, &scene, &[shown], &options, &target, size).expect("drawn");
            };
            if k == 2 || k == 4 {
                // What the renderer knows of the paint that moved.
                run(gpu, 1, &mut draw);
            }
            row[k] = run(gpu, frames[k], &mut draw);
            if turn < WARM_UP {
                frames[k] = ((RUN / row[k]).ceil() as usize).clamp(1, 256);
            }
        }
        if turn >= WARM_UP {
            times.push(row);
        }
    }
    times
}
