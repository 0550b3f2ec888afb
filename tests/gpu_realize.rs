//! Blends made on the GPU against those of the CPU.
#![cfg(feature = "gpu")]
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "gpu/adapter.rs"]
mod adapter;
#[path = "mix/paints.rs"]
mod paints;

use adapter::{gpu, say};
use carpaint::btf::CellSet;
use carpaint::gpu::{Evaluator, GivenQuery, GpuMix, GpuPaint};
use carpaint::math::hash::{pcg4d, unit};
use carpaint::mix::{BlendOptions, Channels, Mix, Path};
use carpaint::render::RenderPaint;
use glam::{DVec3, Vec3};
use paints::{mix_along, paint};
use std::f32::consts::TAU;

fn mixes() -> Vec<(String, Mix)> {
    let three = [paint(1, 50), paint(2, 50), paint(3, 20)];
    let two: Vec<_> = three[..2].iter().collect();
    let mut mixes: Vec<_> =
        Path::ALL.iter().map(|path| (format!("two, {path}"), mix_along(*path, &two))).collect();
    mixes.push(("three".to_owned(), mix_along(Path::Hybrid, &three.iter().collect::<Vec<_>>())));
    mixes
}

/// Inside and outside of [0, 1], and at the ends.
fn weights(paints: usize) -> Vec<Vec<f64>> {
    let weights: &[&[f64]] = match paints {
        2 => &[&[0.5, 0.5], &[0.999, 0.001], &[1.0, 0.0], &[0.0, 1.0], &[-0.5, 1.5], &[3.0, -2.0]],
        _ => &[&[0.3, 0.3, 0.4], &[0.0, 0.5, 0.5], &[0.0, 0.0, 1.0], &[0.7, -0.2, 0.5], &[-0.4, -0.4, 1.8]],
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
                assert_eq!(paints::slices(&expected).count(), seen.len());
                for (a, b) in paints::slices(&expected).zip(&seen) {
                    let scale = a.box_mean().abs().max_element().max(a.mean_rgb().abs().max_element());
                    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
                    let gain =
                        (vector(a.gain) - vector(b.gain)).abs() / vector(a.gain).max(DVec3::splat(1e-3));
                    let offset = (vector(a.offset) - vector(b.offset)).abs().max_element() / scale;
                    let mean = (a.mean_rgb() - b.mean_rgb()).abs().max_element() / scale;
                    (gains, offsets) = (gains.max(gain.max_element()), offsets.max(offset));
                    means = means.max(mean);
                    let place = format!("{name}: {weights:?} {channels}");
                    // A deviation is the root of a difference of mean squares in f32; an offset, what gain and boxes leave of a
                    // mean; a mean, the sum of some hundred products.
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
