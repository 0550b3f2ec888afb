//! Flicker: camera and lamp turned by a degree, weights moved from -50 % to 150 % in steps of 1 %, frames of one sample a pixel
//! against the same with many samples of the finest level. Numbers, not times. `cargo bench --bench flicker`.
//!
//! The front of a ball under one lamp, drawn by the CPU's renderer; frames of a GPU are the same but for some pixels in ten
//! thousand (tests/gpu_frame.rs, tests/gpu_flip.rs). Levels of detail draw from lattices of their own: a filtered frame shows other
//! flakes than the reference, with the same contrast, and where a pixel is more than a texel its error can be no smaller than
//! that of two independent draws, `both`.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/sweep.rs"]
mod sweep;

use carpaint::Paint;
use carpaint::mix::{CoupleOptions, Mix, couple};
use carpaint::render::RenderPaint;
use std::time::Instant;
use sweep::{
    Ball, Flicker, Pixels, contrast, enough_samples, mean, rms, simulated, steps, texel_mm, unfiltered,
};

/// Frames of a sweep of a degree.
const FRAMES: u32 = 11;
/// Pixels along an edge: of turns, of weights.
const SIDES: [usize; 2] = [48, 24];
/// Widths of a pixel, texels.
const TEXELS: [f64; 5] = [0.5, 1.0, 2.0, 4.0, 8.0];
const WEIGHT_TEXELS: [f64; 3] = [0.5, 2.0, 8.0];

fn main() {
    let start = Instant::now();
    let paints = ["silver_metallic", "blue_metallic"].map(|name| (name, simulated(name, 12, 64)));
    println!("all relative to the mean; root mean squares over {0} x {0} pixels and all frames\n", SIDES[0]);
    println!(
        "| sweep | paint | texels a pixel | contrast | filtered | raw | error: filtered | both | raw | step | filtered | raw | step error: filtered | raw |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, paint) in &paints {
        for (sweep, turned) in [("camera", camera as fn(Ball, f64) -> Ball), ("lamp", lamp)] {
            for texels in TEXELS {
                let row = Row::of(paint, texels, turned);
                println!("| {sweep} | {name} | {texels} | {row} |");
            }
        }
    }
    println!("\nweights: {0} x {0} pixels, 201 frames\n", SIDES[1]);
    let named: Vec<_> = paints.iter().map(|(name, paint)| ((*name).to_owned(), paint)).collect();
    let (mix, _) = couple(&named, &CoupleOptions::default(), &|| ()).unwrap();
    println!(
        "| texels a pixel | contrast | filtered | raw | error: filtered | both | raw | step | filtered | raw | step error: filtered | raw | largest step over median | largest of a pixel |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (sweep, texels) in weights(&mix).iter().zip(WEIGHT_TEXELS) {
        println!("| {texels} | {} | {} |", Row::new(sweep), jumps(sweep));
    }
    println!("\n{:.0} s", start.elapsed().as_secs_f64());
}

fn camera(ball: Ball, camera_deg: f64) -> Ball {
    Ball { camera_deg, ..ball }
}

fn lamp(ball: Ball, lamp_deg: f64) -> Ball {
    Ball { lamp_deg, ..ball }
}

/// Frames of a sweep, drawn in four ways.
#[derive(Default)]
struct Sweep {
    filtered: Vec<Pixels>,
    raw: Vec<Pixels>,
    reference: Vec<Pixels>,
    smooth: Vec<Pixels>,
}

/// One of its frames.
struct Frame {
    filtered: Pixels,
    raw: Pixels,
    reference: Pixels,
    smooth: Pixels,
}

impl Frame {
    /// `paints`: as it is, and not filtered.
    fn of(ball: Ball, [filtered, raw]: &[RenderPaint; 2], many: usize) -> Self {
        Self {
            filtered: ball.picture(filtered, 1, true),
            raw: ball.picture(raw, 1, true),
            reference: ball.picture(raw, many, true),
            smooth: ball.picture(filtered, 1, false),
        }
    }
}

fn both(paint: &Paint) -> [RenderPaint; 2] {
    [paint, &unfiltered(paint)].map(|paint| RenderPaint::new(paint).unwrap())
}

impl Sweep {
    fn push(&mut self, frame: Frame) {
        self.filtered.push(frame.filtered);
        self.raw.push(frame.raw);
        self.reference.push(frame.reference);
        self.smooth.push(frame.smooth);
    }
}

/// Numbers of a sweep.
struct Row {
    /// Contrast of reference, filtered, raw.
    contrasts: [f64; 3],
    filtered: Flicker,
    raw: Flicker,
}

impl Row {
    fn new(sweep: &Sweep) -> Self {
        let Sweep { filtered, raw, reference, smooth } = sweep;
        Self {
            contrasts: [reference, filtered, raw].map(|frames| contrast(frames, smooth)),
            filtered: Flicker::of(filtered, reference),
            raw: Flicker::of(raw, reference),
        }
    }

    fn of(paint: &Paint, texels: f64, turned: fn(Ball, f64) -> Ball) -> Self {
        let (first, paints) = (Ball::new(SIDES[0], texels * texel_mm(paint)), both(paint));
        let mut sweep = Sweep::default();
        for k in 0..FRAMES {
            let ball = turned(first, f64::from(k) / f64::from(FRAMES - 1));
            sweep.push(Frame::of(ball, &paints, enough_samples(texels)));
        }
        Self::new(&sweep)
    }
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { contrasts: [own, with, without], filtered, raw } = self;
        write!(f, "{own:.4} | {with:.4} | {without:.4} | ")?;
        write!(f, "{:.4} | {:.4} | {:.4} | ", filtered.error, own.hypot(*with), raw.error)?;
        write!(f, "{:.4} | {:.4} | {:.4} | ", filtered.own_step, filtered.step, raw.step)?;
        write!(f, "{:.4} | {:.4}", filtered.step_error, raw.step_error)
    }
}

/// Sweeps of weights, one for each width of a pixel.
fn weights(mix: &Mix) -> [Sweep; 3] {
    let mut sweeps = [(); 3].map(|()| Sweep::default());
    for k in -50..=150 {
        let weight = 0.01 * f64::from(k);
        let paint = mix.blend(&[1.0 - weight, weight]).unwrap();
        let paints = both(&paint);
        for (sweep, texels) in sweeps.iter_mut().zip(WEIGHT_TEXELS) {
            let ball = Ball::new(SIDES[1], texels * texel_mm(&paint));
            sweep.push(Frame::of(ball, &paints, enough_samples(texels)));
        }
    }
    sweeps
}

/// The largest of its steps, filtered: of a frame over the median one; of a pixel over the mean.
fn jumps(sweep: &Sweep) -> String {
    let moves = steps(&sweep.filtered);
    let mut sizes: Vec<f64> = moves.iter().map(|step| rms(step.iter().copied())).collect();
    sizes.sort_by(f64::total_cmp);
    let largest = sizes[sizes.len() - 1] / sizes[sizes.len() / 2];
    let of_pixel = moves.iter().flatten().fold(0.0, |most: f64, step| most.max(step.abs()));
    format!("{largest:.2} | {:.3}", of_pixel / mean(sweep.reference.iter().flatten()))
}
