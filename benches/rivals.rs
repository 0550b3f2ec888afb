//! Statistics of flakes beside what else a flake BTF is compressed by (Rump et al. 2008, section 6): raw half floats, principal
//! components, random patches of a smaller piece. `cargo bench --bench rivals [PRESET ...]`.
//!
//! Every method gives a texture for each of the most energetic slices, which is compared with the slice; numbers are means over
//! these slices. Bytes are those of all slices at the finest level, without angles, smooth part and color table, the same for all.
//!
//! Measured, 300 slices of 128 x 128, 28,800 KiB raw (W1 of L*, of L* over weak slices too, of Lab):
//!
//! | method | blue, KiB | W1 | silver, KiB | W1 |
//! |---|---|---|---|---|
//! | statistics, 50 clusters | 352 | 1.11, 0.67, 1.10 | 346 | 1.36, 0.80, -0.37 |
//! | 8 color components of all | 773 | 1.28, 1.60, 6.35 | 773 | 0.48, 2.16, 0.15 |
//! | 16 color components of all | 1,545 | 0.23, 0.56, 0.91 | 1,545 | 0.03, 0.10, 0.02 |
//! | 25 gray components of all | 844 | 0.34, 0.94, 1.66 | 844 | 0.01, 0.03, 0.02 |
//! | 8 color components a row | 15,749 | 0.24, 0.72, 0.53 | 15,749 | 0.08, 1.21, 0.06 |
//! | patches from 64 x 64 | 7,200 | 1.20, 1.04, 0.94 | 7,200 | 1.81, 1.25, 0.63 |
//!
//! Of components a view the paper's 20 to 25 save nothing here, where a row (theta_i) has up to 24 slices; 8 save 45 %. Those of
//! all slices save far more, since simulated slices of equal theta_h are nearly alike, and they keep every texel in its place.
//! But they grow with the texture and end with it: the statistics are the same for any area.

#![allow(clippy::print_stdout)]

use carpaint::btf::{AngleGrid, FlakeBtf};
use carpaint::cluster::{BoxRule, LevelStatistics, cluster_levels};
use carpaint::color::{lab_from_rgb, luminance};
use carpaint::error::Result;
use carpaint::math::hash::{pcg4d, unit};
use carpaint::report::{energetic_slices, wasserstein};
use carpaint::rivals::{Grouping, Images, Patches, Pca};
use carpaint::sampler::{Sampler, color};
use carpaint::simulate::{Composition, Model, ModelOptions, SynthesisOptions, synthesize};
use glam::DVec3;
use half::f16;
use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

const SIDE: usize = 128;
const SIZE: [usize; 2] = [SIDE; 2];
/// Bins a quarter turn: 300 slices, rows of up to 24.
const BINS: usize = 24;
/// Components that are tried.
const COMPONENTS: [usize; 8] = [1, 2, 4, 8, 16, 25, 50, 100];
/// Colors on either side of a distance in Lab, and how many of them are averaged.
const POINTS: u32 = 1000;
const REPEATS: u32 = 2;
const SEED: u32 = 5;
/// Every so manieth slice, weak ones too, is looked at for lightness.
const STEP: usize = 7;

type Texture = Vec<[f32; 3]>;

fn main() -> Result<()> {
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let names = if given.is_empty() { vec!["silver_metallic".into(), "blue_metallic".into()] } else { given };
    for name in names {
        compare(&name)?;
    }
    println!(
        "W1: Wasserstein-1 distance, Delta-E; of L* between all texels, of Lab above that of two samples of the slice."
    );
    println!("any: W1 of L* over every {STEP}th slice, weak ones too.");
    println!(
        "std, q99.9: of the luminance, over the slice's; width: texels to half the autocorrelation, over the slice's."
    );
    println!(
        "energy: variance of the luminance summed over slices, over theirs; rms: of texels, over the slice's rms."
    );
    Ok(())
}

fn compare(name: &str) -> Result<()> {
    let btf = btf(name)?;
    let slices = energetic_slices(&btf);
    let raw_bytes = btf.grid.len() * SIDE * SIDE * 6;
    println!(
        "{name}: {} slices of {SIDE} x {SIDE}, raw half floats {:.0} KiB",
        btf.grid.len(),
        kib(raw_bytes)
    );
    println!(
        "{:<28} {:>9} {:>8} {:>6} {:>6} {:>7} {:>6} {:>6} {:>6} {:>7} {:>6} {:>7}",
        "method", "KiB", "1:", "W1 L*", "any", "W1 Lab", "std", "q99.9", "width", "energy", "rms", "s"
    );
    let judge = Judge { btf: &btf, slices: &slices, raw_bytes };
    let half = |k: usize| -> Texture {
        btf.slices[k].fluctuation.iter().map(|t| t.map(|v| f16::from_f32(v).to_f32())).collect()
    };
    judge.line("raw", raw_bytes, true, 0.0, &half);
    for n in [10, 25, 50, 100, 200] {
        statistics(&judge, n)?;
    }
    for side in [16, 24, 32, 64, 128] {
        patches(&judge, side)?;
    }
    for (grouping, images) in [
        (Grouping::Row, Images::Color),
        (Grouping::Row, Images::Gray),
        (Grouping::All, Images::Color),
        (Grouping::All, Images::Gray),
    ] {
        components(&judge, grouping, images)?;
    }
    Ok(())
}

fn btf(name: &str) -> Result<FlakeBtf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let model = Model::new(&Composition::read(&path)?, ModelOptions::default())?;
    let grid = AngleGrid::triangle(BINS)?;
    synthesize(&model, &SynthesisOptions { size: SIZE, ..SynthesisOptions::new(grid) }, &|| ())
}

fn kib(bytes: usize) -> f64 {
    bytes as f64 / 1024.0
}

fn statistics(judge: &Judge<'_>, n: usize) -> Result<()> {
    let start = Instant::now();
    let texels = |k: usize| Ok(judge.btf.slices[k].fluctuation.clone());
    let levels = cluster_levels(judge.btf.grid.len(), texels, SIZE, n, BoxRule::MomentMatched, &|| ())?;
    let seconds = start.elapsed().as_secs_f64();
    // Two corners and a cumulative probability in f32, a cluster.
    let bytes: usize = levels[0].slices.iter().map(|s| 28 * s.clusters.len()).sum();
    let samplers: Vec<Sampler> = levels[0].slices.iter().map(Sampler::exact).collect::<Result<_>>()?;
    let line = format!("statistics, {n} clusters");
    judge.line(&line, bytes, false, seconds, &|k| drawn(&levels[0], &samplers[k], k));
    Ok(())
}

/// A texture drawn on the lattice of the level, a cell of which has one color.
fn drawn(level: &LevelStatistics, sampler: &Sampler, k: usize) -> Texture {
    let cell = |at: usize| (at as f64 / level.pitch_texels) as u32;
    let texel = |at: usize| {
        let [u, r0, r1, r2] = pcg4d([cell(at % SIDE), cell(at / SIDE), 7, SEED]).map(unit);
        color(&level.slices[k], sampler, u, [r0, r1, r2])
    };
    (0..SIDE * SIDE).map(texel).collect()
}

fn patches(judge: &Judge<'_>, side: usize) -> Result<()> {
    let start = Instant::now();
    let patch = Patches::SIDE.min(side / 2);
    let map = Patches::new([side; 2], SIZE, patch, SEED)?;
    let seconds = start.elapsed().as_secs_f64();
    let bytes = judge.btf.grid.len() * side * side * 6 + map.bytes();
    let surface = |k: usize| {
        let rows = judge.btf.slices[k].fluctuation.chunks_exact(SIDE).take(side);
        let piece: Texture = rows.flat_map(|row| row[..side].to_vec()).collect();
        map.surface(&piece).unwrap_or_default()
    };
    judge.line(&format!("patches of {patch} from {side}"), bytes, false, seconds, &surface);
    Ok(())
}

fn components(judge: &Judge<'_>, grouping: Grouping, images: Images) -> Result<()> {
    let start = Instant::now();
    let pca = Pca::new(judge.btf, grouping, images, COMPONENTS[COMPONENTS.len() - 1])?;
    let seconds = start.elapsed().as_secs_f64();
    let mut before = 0;
    for n in COMPONENTS {
        let bytes = pca.bytes(n);
        // More components than slices, or than the slices themselves take.
        if bytes == before || before > judge.raw_bytes {
            break;
        }
        before = bytes;
        let slice = |k: usize| pca.slice(k, n).unwrap_or_default();
        judge.line(&format!("PCA {grouping:?} {images:?} {n}"), bytes, true, seconds, &slice);
    }
    Ok(())
}

/// Compares textures with slices.
struct Judge<'a> {
    btf: &'a FlakeBtf,
    slices: &'a [usize],
    raw_bytes: usize,
}

impl Judge<'_> {
    /// One line; `same_place` says whether texels are where those of the slice are.
    fn line(
        &self,
        name: &str,
        bytes: usize,
        same_place: bool,
        seconds: f64,
        texture: &dyn Fn(usize) -> Texture,
    ) {
        let (mut sum, mut energy) = ([0.0; 6], [0.0; 2]);
        for k in self.slices {
            let (source, made) = (&self.btf.slices[*k].fluctuation, texture(*k));
            let (of_source, of_made) = (Moments::of(source), Moments::of(&made));
            let terms = [
                lightness_distance(source, &made),
                lab_distance(source, &made),
                of_made.std / of_source.std,
                of_made.quantile / of_source.quantile,
                half_width(&made) / half_width(source),
                rms(source, &made),
            ];
            sum.iter_mut().zip(terms).for_each(|(s, t)| *s += t / self.slices.len() as f64);
            energy[0] += of_made.std.powi(2);
            energy[1] += of_source.std.powi(2);
        }
        let [l, lab, std, quantile, width, rms] = sum;
        let any: Vec<usize> = (0..self.btf.grid.len()).step_by(STEP).collect();
        let distance = |k: &usize| lightness_distance(&self.btf.slices[*k].fluctuation, &texture(*k));
        let any = any.iter().map(distance).sum::<f64>() / any.len() as f64;
        let rms = if same_place { format!("{rms:.3}") } else { "-".into() };
        println!(
            "{name:<28} {:>9.1} {:>8.1} {l:>6.2} {any:>6.2} {lab:>7.2} {std:>6.3} {quantile:>6.3} {width:>6.2} {:>7.3} {rms:>6} {seconds:>7.2}",
            kib(bytes),
            self.raw_bytes as f64 / bytes as f64,
            energy[0] / energy[1],
        );
    }
}

fn wide(texel: &[f32; 3]) -> DVec3 {
    DVec3::from(texel.map(f64::from))
}

fn luminances(texels: &[[f32; 3]]) -> Vec<f64> {
    texels.iter().map(|t| luminance(wide(t))).collect()
}

fn lab(texel: &[f32; 3]) -> DVec3 {
    lab_from_rgb(PI * wide(texel))
}

/// Standard deviation of the luminance, and its 99.9 % quantile above the mean.
struct Moments {
    std: f64,
    quantile: f64,
}

impl Moments {
    fn of(texels: &[[f32; 3]]) -> Self {
        let mut y = luminances(texels);
        let n = y.len() as f64;
        let mean = y.iter().sum::<f64>() / n;
        let variance = y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        let rank = y.len() - 1 - y.len() / 1000;
        Self { std: variance.sqrt(), quantile: *y.select_nth_unstable_by(rank, f64::total_cmp).1 - mean }
    }
}

/// Wasserstein-1 distance of L*, of all texels: in one dimension the mean distance of sorted values.
fn lightness_distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let sorted = |texels: &[[f32; 3]]| {
        let mut l: Vec<f64> = texels.iter().map(|t| lab(t).x).collect();
        l.sort_by(f64::total_cmp);
        l
    };
    let n = a.len() as f64;
    sorted(a).iter().zip(sorted(b)).map(|(a, b)| (a - b).abs()).sum::<f64>() / n
}

/// Wasserstein-1 distance in Lab, above that of two samples of the source.
fn lab_distance(source: &[[f32; 3]], made: &[[f32; 3]]) -> f64 {
    let cloud = |texels: &[[f32; 3]], stream: u32| -> Vec<DVec3> {
        let pick = |k: u32| pcg4d([k, stream, 1, SEED])[0] as usize % texels.len();
        (0..POINTS).map(|k| lab(&texels[pick(k)])).collect()
    };
    let excess = |repeat: u32| {
        let texels = cloud(source, 3 * repeat);
        wasserstein(&cloud(made, 3 * repeat + 1), &texels)
            - wasserstein(&cloud(source, 3 * repeat + 2), &texels)
    };
    (0..REPEATS).map(excess).sum::<f64>() / f64::from(REPEATS)
}

/// Texels to the right at which the autocorrelation of the luminance falls to a half, linear between texels.
fn half_width(texels: &[[f32; 3]]) -> f64 {
    let y = luminances(texels);
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let product = |shift: usize| {
        let place = |k: usize| k / SIDE * SIDE + (k % SIDE + shift) % SIDE;
        (0..y.len()).map(|k| (y[k] - mean) * (y[place(k)] - mean)).sum::<f64>()
    };
    let whole = product(0);
    let mut before = 1.0;
    for shift in 1..SIDE / 2 {
        let now = product(shift) / whole;
        if now < 0.5 {
            return shift as f64 - 1.0 + (before - 0.5) / (before - now);
        }
        before = now;
    }
    SIDE as f64 / 2.0
}

/// Root mean square of the difference over that of the source.
fn rms(source: &[[f32; 3]], made: &[[f32; 3]]) -> f64 {
    let square = |texels: &mut dyn Iterator<Item = DVec3>| texels.map(DVec3::length_squared).sum::<f64>();
    let difference = square(&mut source.iter().zip(made).map(|(a, b)| wide(a) - wide(b)));
    (difference / square(&mut source.iter().map(wide))).sqrt()
}
