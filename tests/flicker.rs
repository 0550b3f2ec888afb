//! What moves must not flicker: sweeps of camera and lamp against supersampled ones, sweeps of weights against themselves.
//! `cargo bench --bench flicker` prints the numbers of larger ones.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "common/sweep.rs"]
mod sweep;

use carpaint::Paint;
use carpaint::mix::{CoupleOptions, Mix, couple};
use carpaint::render::RenderPaint;
use std::sync::LazyLock;
use sweep::{Ball, Flicker, Pixels, enough_samples, mean, rms, simulated, steps, texel_mm, unfiltered};

/// Pixels along an edge of a frame.
const SIDE: usize = 48;

static PAINTS: LazyLock<[Paint; 2]> =
    LazyLock::new(|| ["silver_metallic", "blue_metallic"].map(|name| simulated(name, 6, 64)));

/// Silver as it is, and without its filter.
fn silver() -> [RenderPaint; 2] {
    [&PAINTS[0], &unfiltered(&PAINTS[0])].map(|paint| RenderPaint::new(paint).unwrap())
}

/// Five frames of a quarter of a degree, pixels so many texels wide.
fn frames(
    paint: &RenderPaint,
    texels: f64,
    samples: usize,
    turned: &dyn Fn(Ball, f64) -> Ball,
) -> Vec<Pixels> {
    let first = Ball::new(SIDE, texels * texel_mm(&PAINTS[0]));
    let frame = |k: u32| turned(first, 0.0625 * f64::from(k)).picture(paint, samples, true);
    (0..5).map(frame).collect()
}

fn camera(ball: Ball, camera_deg: f64) -> Ball {
    Ball { camera_deg, ..ball }
}

fn lamp(ball: Ball, lamp_deg: f64) -> Ball {
    Ball { lamp_deg, ..ball }
}

#[test]
fn the_filter_of_footprints_keeps_frames_from_flickering() {
    let (texels, [filtered, raw]) = (8.0, silver());
    // What one sample of a pixel may change by from frame to frame, over what all of it does. Half vectors turn by less under a
    // moving lamp than they differ by within a pixel, over which the reference is a mean.
    for (name, turned, most) in [("camera", &camera as &dyn Fn(_, _) -> _, 1.3), ("lamp", &lamp, 2.0)] {
        let reference = frames(&raw, texels, enough_samples(texels), turned);
        let [with, without] =
            [&filtered, &raw].map(|paint| Flicker::of(&frames(paint, texels, 1, turned), &reference));
        println!("{name}: filtered {with:.4?}; unfiltered {without:.4?}");
        // A pixel of 64 texels has a fourth of the contrast of one of them. The reference shows other flakes than the filter does:
        // two independent pictures are off by the root of two of that.
        assert!(with.error < 0.6 * without.error, "{name}: {with:?} {without:?}");
        assert!(with.step < most * with.own_step, "{name}: {with:?}");
        // Else the sweep shows nothing.
        assert!(without.step > 3.0 * without.own_step, "{name}: {without:?}");
    }
}

#[test]
fn pixels_within_a_texel_are_not_filtered() {
    let [filtered, raw] = silver();
    assert_eq!(frames(&filtered, 0.5, 1, &camera), frames(&raw, 0.5, 1, &camera));
}

fn mix() -> Mix {
    let named: Vec<_> = PAINTS.iter().map(|paint| ("paint".to_owned(), paint)).collect();
    couple(&named, &CoupleOptions::default(), &|| ()).unwrap().0
}

/// Frames at the weight of the second paint, a pixel half a texel and four texels wide.
fn blended(mix: &Mix, weight: f64) -> [Pixels; 2] {
    let paint = mix.blend(&[1.0 - weight, weight]).unwrap();
    let drawn = RenderPaint::new(&paint).unwrap();
    [0.5, 4.0].map(|texels| Ball::new(SIDE, texels * texel_mm(&paint)).picture(&drawn, 1, true))
}

#[test]
fn weights_fade_texels_and_never_switch_them() {
    let mix = mix();
    let weights: Vec<f64> = (-50..=150).map(|k| 0.01 * f64::from(k)).collect();
    let all: Vec<[Pixels; 2]> = weights.iter().map(|weight| blended(&mix, *weight)).collect();
    for scale in 0..2 {
        let frames: Vec<Pixels> = all.iter().map(|frames| frames[scale].clone()).collect();
        let (moves, level) = (steps(&frames), mean(frames.iter().flatten()));
        let mut sizes: Vec<f64> = moves.iter().map(|step| rms(step.iter().copied())).collect();
        sizes.sort_by(f64::total_cmp);
        // Frames 50 and 150 show one paint each: other flakes everywhere, as if all were drawn anew.
        let anew = rms(frames[50].iter().zip(&frames[150]).map(|(a, b)| a - b));
        let [largest, median] = [sizes.len() - 1, sizes.len() / 2].map(|k| sizes[k] / anew);
        // The pixel that changes most in a step, in sixteen parts of that.
        let pixels = moves.iter().enumerate().flat_map(|(k, step)| (0..step.len()).map(move |p| (k, p)));
        let size = |(k, p): (usize, usize)| moves[k][p].abs();
        let (step, pixel) = pixels.max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap();
        let part = |k: u32| blended(&mix, weights[step] + 0.01 * f64::from(k) / 16.0)[scale][pixel];
        let parts: Vec<f64> = (0..=16).map(part).collect();
        let jump = parts.windows(2).map(|p| (p[1] - p[0]).abs()).fold(0.0, f64::max) / size((step, pixel));
        println!(
            "largest step {largest:.4} of a picture drawn anew, median {median:.4}; {:.2} of the mean in a pixel at {:.2}, of that {jump:.2} in a sixteenth",
            size((step, pixel)) / level,
            weights[step]
        );
        // A hundred even steps are 0.01 each; most where a paint begins or ends, as its rarest flakes are the brightest: 0.022 to 0.048
        // over eight seeds of the paints, which this statistic of few texels hangs on. Half of that to spare; texels chosen anew are 1.
        assert!(largest < 0.07, "{largest}");
        // A sixteenth if the step is even, all of it if the texel is switched. Ramps of flakes that are rare are steep.
        assert!(jump < 0.4, "{jump}");
    }
}
