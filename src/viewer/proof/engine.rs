//! What renders prints for the window: the GPU of the window, or the reference renderer where that is software.

use super::made::Made;
use crate::error::Result;
use crate::gpu::{Gpu, GpuPrint, PrintRenderer};
use crate::render::{InkModel, Options, Picture, render_print_rows};
use crate::scene::Scene;
use eframe::egui_wgpu::RenderState;

/// Prints kept on the GPU: those of two pictures.
const KEPT: usize = 2;
/// Fewest rows that are rendered before the next look whether they are still wanted.
const ROWS: usize = 8;
/// First guess of what a ray costs, seconds, of the CPU and of a GPU.
const GUESS: [f64; 2] = [2e-6, 1e-9];

/// What renders.
#[derive(Debug)]
pub enum Engine {
    /// The reference renderer.
    Cpu,
    /// A GPU.
    Gpu(Box<OnGpu>),
}

/// A GPU, and what is on it.
#[derive(Debug)]
pub struct OnGpu {
    gpu: Gpu,
    /// One for each of [`InkModel::ALL`].
    renderers: [Option<PrintRenderer>; InkModel::ALL.len()],
    /// The last used first.
    prints: Vec<(Made, GpuPrint)>,
}

impl Engine {
    /// The one for a window.
    ///
    /// # Errors
    /// As [`Gpu::from_device`].
    pub fn of_window(state: &RenderState) -> Result<Self> {
        let gpu = Gpu::from_device(state.device.clone(), state.queue.clone(), &state.adapter.get_info())?;
        Ok(if gpu.is_software() { Self::Cpu } else { Self::on(gpu) })
    }

    /// A GPU, be it software.
    pub fn on(gpu: Gpu) -> Self {
        Self::Gpu(Box::new(OnGpu { gpu, renderers: [const { None }; _], prints: Vec::new() }))
    }

    /// First guess of what a ray costs, seconds.
    pub fn guess(&self) -> f64 {
        GUESS[usize::from(matches!(self, Self::Gpu(_)))]
    }

    /// Renders a print with so many rays a pixel; none if that is not wanted any more, of which `goes_on` tells, which takes the share
    /// that is done.
    ///
    /// # Errors
    /// Those of [`render_print_rows`] and [`PrintRenderer`].
    pub fn render(
        &mut self,
        scene: &Scene,
        made: &Made,
        rays: usize,
        goes_on: &dyn Fn(f32) -> bool,
    ) -> Result<Option<Picture>> {
        let options = Options { samples: rays, ..Options::default() };
        match self {
            Self::Gpu(on_gpu) => on_gpu.render(scene, made, &options).map(Some),
            Self::Cpu => by_rows(scene, made, &options, goes_on),
        }
    }
}

fn by_rows(
    scene: &Scene,
    made: &Made,
    options: &Options,
    goes_on: &dyn Fn(f32) -> bool,
) -> Result<Option<Picture>> {
    let height = scene.size[1];
    let step = ROWS.max(rayon::current_num_threads());
    let mut pixels = Vec::with_capacity(scene.size[0] * height);
    for first in (0..height).step_by(step) {
        if !goes_on(first as f32 / height as f32) {
            return Ok(None);
        }
        let rows = first..height.min(first + step);
        pixels.extend(render_print_rows(scene, &made.print(), options, rows, &|| ())?.pixels);
    }
    Ok(Some(Picture { size: scene.size, pixels }))
}

impl OnGpu {
    fn render(&mut self, scene: &Scene, made: &Made, options: &Options) -> Result<Picture> {
        let model = made.inks.model;
        let number = InkModel::ALL.iter().position(|one| *one == model).unwrap_or_default();
        let renderer = match &mut self.renderers[number] {
            Some(renderer) => renderer,
            none => none.insert(PrintRenderer::new(&self.gpu, model)?),
        };
        let kept = match self.prints.iter().position(|(kept, _)| kept.is(made)) {
            Some(k) => self.prints.remove(k),
            None => (made.clone(), renderer.upload(&self.gpu, &made.print())?),
        };
        self.prints.truncate(KEPT - 1);
        self.prints.insert(0, kept);
        renderer.render(&self.gpu, scene, &self.prints[0].1, options, &|| ())
    }
}
