//! Light in real time (prefiltered maps, flakes under the surroundings, lamps) against the path tracer. Numbers, not times.
//! `cargo bench --bench light [-- WORDS ...]`: all rows, or those whose light, shape and paint, in that order, contain one of the
//! arguments, such as `"studio.exr capsule"`.
//!
//! Smooth: frames without sparkle, averaged over blocks of 4 x 4 pixels, against as many path-traced pixels of 256 samples, the mean of
//! two pictures with other random numbers; luminance of blocks well inside the object that mirror no lamp, which paths hit by chance,
//! and whose two pictures agree to 10 %, relative; FLIP of these, others black. Flakes: what they add to single pixels of a part of the same picture; its variance path-traced
//! is the covariance of two pictures, free of their noise.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::Paint;
use carpaint::brdf::{ClearCoat, ColorTable, Lobe};
use carpaint::color::luminance;
use carpaint::gpu::{FrameOptions, FrameRenderer, Gpu, GpuPaint};
use carpaint::render::{Options, Picture, PictureDifference, RenderPaint, render, trace};
use carpaint::report::{ChainOptions, run_chain};
use carpaint::scene::{Camera, Environment, Scene, Shape};
use carpaint::simulate::Composition;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::time::Instant;
use wgpu::TextureFormat;

/// Pixels of a frame along a side of a block.
const BLOCK: usize = 4;
/// Blocks of a frame.
const BLOCKS: [usize; 2] = [30, 40];
/// Pixels along an edge of the part in which flakes are seen.
const PART: usize = 64;
/// Samples of a path-traced pixel: smooth; with flakes.
const SAMPLES: [usize; 2] = [256, 64];
/// Reflections of the path tracer by default.
const BOUNCES: usize = 4;
/// Largest relative difference of two path-traced blocks that count.
const NOISE: f64 = 0.1;

struct Bench {
    gpu: Gpu,
    renderer: FrameRenderer,
    paints: Vec<(&'static str, RenderPaint)>,
    /// A coat over black: shows where lamps are mirrored.
    mirror: RenderPaint,
    /// Rows contain one of these; none: all rows.
    wanted: Vec<String>,
}

fn main() {
    let start = Instant::now();
    let gpu = Gpu::new(None).expect("an adapter");
    println!("{}\n", gpu.name());
    let renderer = FrameRenderer::new(&gpu, TextureFormat::Rgba32Float).unwrap();
    let paints = vec![
        ("no flakes", RenderPaint::new(&without_flakes()).unwrap()),
        ("silver", simulated("silver_metallic")),
        ("blue", simulated("blue_metallic")),
    ];
    let black = Paint {
        coat: ClearCoat::ideal(1.5, false),
        diffuse: 0.0,
        lobes: Vec::new(),
        colors: ColorTable::white(),
        ..without_flakes()
    };
    let mirror = RenderPaint::new(&black).unwrap();
    let wanted = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let mut bench = Bench { gpu, renderer, paints, mirror, wanted };
    println!(
        "| light | shape | paint | mean | error | 99 % | noise | left out | FLIP | sampled: error | {BOUNCES} reflections: mean | error | contrast traced | flakes: mean | contrast |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/scenes");
    for (light, file) in [
        ("studio", "capsule.toml"),
        ("panorama", "panorama.toml"),
        ("clear sky", "clear-sky.toml"),
        ("sun and sky", "sun-and-sky.toml"),
    ] {
        let scene = Scene::read(&fixtures.join(file)).unwrap();
        for shape in ["capsule", "sphere", "panel", "speed-shape"] {
            bench.rows(light, shape, &scene);
        }
    }
    if let Some(folder) = std::env::var_os("CARPAINT_REFERENCE") {
        for name in ["studio", "esplanade", "sunset"] {
            let path = PathBuf::from(&folder).join(format!("data/hdr/{name}.exr"));
            let scene = bench.lit_by(path);
            for shape in ["capsule", "speed-shape"] {
                bench.rows(&format!("{name}.exr"), shape, &scene);
            }
        }
    }
    println!("\n{:.0} s", start.elapsed().as_secs_f64());
}

/// Three lobes under a coat with a gloss lobe.
fn without_flakes() -> Paint {
    let lobe = |coefficient, roughness, f0| Lobe { coefficient, roughness, f0 };
    let chi = [[0.9, 0.8, 0.7], [0.5, 0.6, 0.9], [1.1, 1.0, 0.8], [0.7, 0.7, 0.7]];
    Paint {
        coat: ClearCoat { gloss: Some(lobe(0.2, 0.003, 0.04)), ..ClearCoat::NONE },
        diffuse: 0.036,
        lobes: vec![lobe(0.08, 1.29, 0.44), lobe(0.11, 0.45, 0.56), lobe(0.15, 0.23, 0.81)],
        colors: ColorTable::new([2, 2], chi.to_vec(), vec![true; 4]).unwrap(),
        flakes: None,
        provenance: serde_json::Value::Null,
    }
}

fn simulated(name: &str) -> RenderPaint {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let options = ChainOptions { bins: 12, size: 256, texel_mm: None, seed: 1 };
    let chain = run_chain(name, &Composition::read(&path).unwrap(), &options, |_, _| || ()).unwrap();
    RenderPaint::new(&chain.paint).unwrap()
}

/// What two path-traced pictures of the same rays say, and other random numbers.
struct Twins([Picture; 2]);

impl Twins {
    /// The second picture is wider: the same rays have other columns, on which random numbers hang.
    fn trace(scene: &Scene, paint: &RenderPaint, options: &Options, bounces: usize) -> Self {
        let [width, height] = scene.size;
        let picture = |margin: usize| {
            let wider = Scene { size: [width + 2 * margin, height], ..scene.clone() };
            let traced = trace(&wider, std::slice::from_ref(paint), options, bounces, &|| ()).unwrap();
            let rows = traced.picture.pixels.chunks(width + 2 * margin);
            let pixels = rows.flat_map(|row| row[margin..margin + width].to_vec()).collect();
            Picture { size: scene.size, pixels }
        };
        Self([picture(0), picture(4)])
    }

    fn mean(&self) -> Picture {
        let pairs = self.0[0].pixels.iter().zip(&self.0[1].pixels);
        let pixels = pairs.map(|(a, b)| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))).collect();
        Picture { size: self.0[0].size, pixels }
    }
}

/// How far blocks are from the reference.
struct Errors {
    /// Ratio of the sums.
    mean: f64,
    /// Mean and 99 % quantile of the relative error.
    error: f64,
    quantile: f64,
    /// Mean error of the reference, and the share of the blocks that are left out for theirs.
    noise: f64,
    left_out: f64,
    /// Which blocks count.
    counted: Vec<bool>,
}

impl Errors {
    /// `is_inside`: which blocks see the object alone.
    fn of(seen: &Picture, traced: &Twins, is_inside: &[bool]) -> Self {
        let [one, two] = traced.0.each_ref().map(luminances);
        let seen = luminances(seen);
        let inside: Vec<usize> = (0..seen.len()).filter(|k| is_inside[*k]).collect();
        let reference = |k: usize| 0.5 * (one[k] + two[k]);
        let is_kept = |k: &usize| (one[*k] - two[*k]).abs() <= NOISE * reference(*k);
        let kept: Vec<usize> = inside.iter().copied().filter(is_kept).collect();
        let n = kept.len() as f64;
        let mut errors: Vec<f64> =
            kept.iter().map(|k| (seen[*k] - reference(*k)).abs() / reference(*k)).collect();
        errors.sort_by(f64::total_cmp);
        let sum = |of: &dyn Fn(usize) -> f64| kept.iter().map(|k| of(*k)).sum::<f64>();
        Self {
            mean: sum(&|k| seen[k]) / sum(&reference),
            error: errors.iter().sum::<f64>() / n,
            quantile: errors[errors.len() * 99 / 100],
            noise: sum(&|k| 0.5 * (one[k] - two[k]).abs() / reference(k)) / n,
            left_out: 1.0 - n / inside.len() as f64,
            counted: (0..seen.len()).map(|k| is_inside[k] && is_kept(&k)).collect(),
        }
    }
}

/// Black where `counted` is false.
fn masked(picture: &Picture, counted: &[bool]) -> Picture {
    let pixels = picture.pixels.iter().zip(counted).map(|(p, counts)| if *counts { *p } else { [0.0; 3] });
    Picture { size: picture.size, pixels: pixels.collect() }
}

fn luminances(picture: &Picture) -> Vec<f64> {
    picture.pixels.iter().map(|p| luminance(DVec3::from(p.map(f64::from)))).collect()
}

/// Means over blocks of so many pixels a side.
fn blocks(picture: &Picture, side: usize) -> Picture {
    let size = picture.size.map(|n| n / side);
    let pixel = |k: usize| {
        let (x, y) = (k % size[0] * side, k / size[0] * side);
        let inside =
            (0..side * side).map(|i| picture.pixels[(y + i / side) * picture.size[0] + x + i % side]);
        let sum = inside.fold(DVec3::ZERO, |sum, p| sum + DVec3::from(p.map(f64::from)));
        (sum / (side * side) as f64).as_vec3().to_array()
    };
    Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() }
}

/// Which pixels and their neighbours are not black.
fn inside(picture: &Picture) -> Vec<bool> {
    let [width, height] = picture.size;
    let is_lit = |x: usize, y: usize| picture.pixels[y * width + x] != [0.0; 3];
    let is_inside = |k: usize| {
        let (x, y) = (k % width, k / width);
        let is_rim = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
        !is_rim && (0..9).all(|n| is_lit(x + n % 3 - 1, y + n / 3 - 1))
    };
    (0..width * height).map(is_inside).collect()
}

/// What flakes add to pixels: mean of all light, and their contrast, both relative to the smooth mean.
struct Sparkle {
    mean: f64,
    contrast: f64,
    /// Standard error of the contrast by what two pictures do not have in common.
    error: f64,
}

impl Sparkle {
    /// Of two pictures each, which may be the same.
    fn of(sparkling: [&Picture; 2], smooth: [&Picture; 2], is_inside: &[bool]) -> Self {
        let added = |k: usize| -> Vec<f64> {
            let pairs = luminances(sparkling[k]).into_iter().zip(luminances(smooth[k])).zip(is_inside);
            pairs.filter(|(_, inside)| **inside).map(|((a, b), _)| a - b).collect()
        };
        let (one, two) = (added(0), added(1));
        let n = one.len() as f64;
        let lit = luminances(smooth[0]).into_iter().zip(is_inside).filter(|(_, inside)| **inside);
        let level = lit.map(|(l, _)| l).sum::<f64>() / n;
        let [a, b] = [&one, &two].map(|added| added.iter().sum::<f64>() / n);
        let covariance =
            |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - a) * (y - b)).sum::<f64>() / n;
        let variance = covariance(&one, &two).max(0.0);
        // Of the mean of products of two noises, and of either with what is common.
        let noise = (0.5 * (covariance(&one, &one) + covariance(&two, &two)) - variance).max(0.0);
        let of_variance = ((noise * noise + 2.0 * noise * variance) / n).sqrt();
        let contrast = variance.sqrt() / level;
        let error = 0.5 * of_variance / (level * level * contrast);
        Self { mean: 1.0 + 0.5 * (a + b) / level, contrast, error }
    }
}

impl Bench {
    /// Surroundings of a file, so bright that a white surface would be about as bright on average.
    fn lit_by(&self, path: PathBuf) -> Scene {
        let image = |scale| Environment::Image { path: path.clone(), turn_deg: 0.0, scale };
        let plain = image(1.0).surroundings().unwrap();
        let n = 4096u32;
        // Vogel's spiral over the sphere.
        let total = (0..n).fold(DVec3::ZERO, |sum, k| {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(n);
            let (sin, cos) = (2.399_963_229_728_653 * f64::from(k)).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            sum + plain.radiance(DVec3::new(radius * cos, radius * sin, z).as_vec3()).as_dvec3()
        });
        let scale = f64::from(n) / luminance(total);
        Scene { environment: image(scale), lights: Vec::new(), ..Scene::default() }
    }

    fn frame(&mut self, scene: &Scene, paint: &RenderPaint, flakes: bool) -> Picture {
        let options = FrameOptions { flakes, ..FrameOptions::default() };
        let on_gpu = GpuPaint::new(&self.gpu, paint).unwrap();
        self.renderer.picture(&self.gpu, scene, &[&on_gpu], &options).unwrap()
    }

    /// Which blocks of the scene's pixels, so many a side, see nothing but the object, and no mirrored lamp.
    fn usable(&mut self, scene: &Scene, seen: &Picture, side: usize) -> Vec<bool> {
        let dark = Scene { environment: Environment::Constant { radiance: [0.0; 3] }, ..scene.clone() };
        let mirrored = self.frame(&dark, &self.mirror.clone(), false);
        let pairs = seen.pixels.iter().zip(&mirrored.pixels);
        let usable = pairs
            .map(|(seen, lamp)| if *seen != [0.0; 3] && *lamp == [0.0; 3] { [1.0; 3] } else { [0.0; 3] });
        let mut shares = blocks(&Picture { size: seen.size, pixels: usable.collect() }, side);
        shares.pixels.iter_mut().filter(|p| p[0] < 1.0).for_each(|p| *p = [0.0; 3]);
        inside(&shares)
    }

    fn rows(&mut self, light: &str, shape: &str, lit: &Scene) {
        let scene = Scene {
            size: BLOCKS,
            camera: Camera::default(),
            background: Some([0.0; 3]),
            shape: Shape::named(shape).unwrap(),
            ..lit.clone()
        };
        for (name, paint) in self.paints.clone() {
            let row = format!("{light} {shape} {name}");
            if !self.wanted.is_empty() && !self.wanted.iter().any(|wanted| row.contains(wanted)) {
                continue;
            }
            let smooth = self.smooth(&scene, &paint, shape == "speed-shape");
            let flakes = if paint.flakes.is_some() { self.flakes(&scene, &paint) } else { "| |".to_owned() };
            println!("| {light} | {shape} | {name} | {smooth} | {flakes} |");
        }
    }

    /// `is_hollow`: whether the object lights and hides itself.
    fn smooth(&mut self, scene: &Scene, paint: &RenderPaint, is_hollow: bool) -> String {
        let fine = Scene { size: BLOCKS.map(|n| n * BLOCK), ..scene.clone() };
        let frame = self.frame(&fine, paint, false);
        let seen = blocks(&frame, BLOCK);
        let is_inside = self.usable(&fine, &frame, BLOCK);
        let options = Options { samples: SAMPLES[0], flakes: false, ..Options::default() };
        let once = Twins::trace(scene, paint, &options, 1);
        let errors = Errors::of(&seen, &once, &is_inside);
        let shown = [&seen, &once.mean()].map(|picture| masked(picture, &errors.counted));
        let flip = PictureDifference::of(&shown[0], &shown[1]).unwrap().flip;
        let sampled = Options { samples: 16, directions: 128, ..options };
        let sampled = render(scene, std::slice::from_ref(paint), &sampled, &|| ()).unwrap();
        let sampled = Errors::of(&sampled, &once, &is_inside).error;
        // Elsewhere no light comes back.
        let more = if is_hollow {
            let often = Errors::of(&seen, &Twins::trace(scene, paint, &options, BOUNCES), &is_inside);
            format!("{:.3} | {:.2} %", often.mean, 100.0 * often.error)
        } else {
            "same | same".to_owned()
        };
        let Errors { mean, error, quantile, noise, left_out, .. } = errors;
        let percent = [error, quantile, noise, left_out].map(|e| format!("{:.2} %", 100.0 * e)).join(" | ");
        format!("{mean:.3} | {percent} | {flip:.4} | {:.2} % | {more}", 100.0 * sampled)
    }

    fn flakes(&mut self, scene: &Scene, paint: &RenderPaint) -> String {
        // Pixels as wide as those of the whole frame.
        let half = (0.5 * scene.camera.vertical_fov_deg).to_radians().tan();
        let part = half * PART as f64 / (BLOCKS[1] * BLOCK) as f64;
        let camera = Camera { vertical_fov_deg: 2.0 * part.atan().to_degrees(), ..scene.camera };
        let scene = Scene { size: [PART; 2], camera, ..scene.clone() };
        let [on, off] = [true, false].map(|flakes| self.frame(&scene, paint, flakes));
        let is_inside = self.usable(&scene, &off, 1);
        let [traced_on, traced_off] = [true, false].map(|flakes| {
            let options = Options { samples: SAMPLES[1], flakes, ..Options::default() };
            Twins::trace(&scene, paint, &options, 1)
        });
        let seen = Sparkle::of([&on; 2], [&off; 2], &is_inside);
        let traced = Sparkle::of(traced_on.0.each_ref(), traced_off.0.each_ref(), &is_inside);
        let (mean, contrast) = (seen.mean / traced.mean, seen.contrast / traced.contrast);
        format!("{:.4} +- {:.4} | {mean:.4} | {contrast:.3}", traced.contrast, traced.error)
    }
}
