//! What draws: the processor, the graphics adapter, frames in real time.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::error::Result;
use crate::gpu::{FrameOptions, FrameRenderer, Gpu, GpuPaint, Renderer};
use crate::render::{Options, Picture, PictureDifference, RenderPaint, render};
use crate::scene::Scene;
use std::cell::RefCell;
use wgpu::TextureFormat;

/// Directions of the truth.
const DIRECTIONS_OF_TRUTH: usize = 1024;

/// The curve; none without an adapter.
pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let Ok(gpu) = Gpu::new(None) else { return Ok(Vec::new()) };
    let gpu = &gpu;
    let paint = &[RenderPaint::new(&subject.chain.paint)?];
    let scene = &Scene { size: if effort.quick { [60, 80] } else { [120, 160] }, ..Scene::default() };
    let options = Options { samples: 1, seed: effort.seed, ..Options::default() };
    let truth = render(scene, paint, &Options { directions: DIRECTIONS_OF_TRUTH, ..options }, &|| ())?;

    let pictures = Renderer::new(gpu)?;
    let on_gpu = GpuPaint::new(gpu, &paint[0])?;
    let frames = RefCell::new(FrameRenderer::new(gpu, TextureFormat::Rgba32Float)?);
    let (pictures, on_gpu, frames) = (&pictures, &on_gpu, &frames);
    let usual = FrameOptions { seed: effort.seed, ..FrameOptions::default() };
    let frame = |options: FrameOptions| move || frames.borrow_mut().picture(gpu, scene, &[on_gpu], &options);
    let trials: Vec<Trial<Picture>> = vec![
        Trial::new("CPU", true, move || render(scene, paint, &options, &|| ())),
        Trial::new("GPU, as the CPU", false, move || pictures.render(gpu, scene, paint, &options, &|| ())),
        Trial::new("frame", false, frame(usual)),
        Trial::new(
            "frame, every direction",
            false,
            frame(FrameOptions { directions: Some(options.directions), ..usual }),
        ),
        Trial::new("frame from rows", false, frame(FrameOptions { rows: true, ..usual })),
        Trial::new("frame, flakes under lamps alone", false, frame(FrameOptions { around: false, ..usual })),
    ];
    let head = Head {
        stage: "Rendering",
        knob: "what draws, one ray a pixel (render --device; view)",
        error: "mean FLIP, 0 to 1, against the CPU with 1024 directions into the surroundings",
        why: "The processor is the reference and everywhere; render takes a GPU that is not software, which draws the same picture. Frames \
              of the viewer prefilter the surroundings. Times hold the picture's way back from the adapter.",
    };
    let judge = |found: &Picture| Ok((PictureDifference::of(&truth, found)?.flip, None));
    Ok(vec![curve(head, &trials, *effort, judge)?])
}
