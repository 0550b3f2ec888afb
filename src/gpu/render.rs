//! Pictures on the GPU: the twin of [`crate::render::render()`].

use super::device::Gpu;
use super::paint::{self, GpuPaint};
use super::scene;
use super::shader::picture_source;
use crate::error::{Error, Result};
use crate::render::{FlakeDraws, Options, Picture, RenderPaint, Stage, check};
use crate::scene::{Environment, Form, Scene};
use encase::{ShaderSize, ShaderType, StorageBuffer};
use glam::UVec2;
use wgpu::{BufferBindingType, BufferUsages};

/// The compute pass that renders pictures.
#[derive(Debug)]
pub struct Renderer {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// Side of a workgroup, as in the shader.
pub(super) const SIDE: usize = 8;
/// Most steps of loops that an invocation takes. Mesa's software renderer ends all loops after 65,535, without a word.
const INVOCATION_STEPS: usize = 1 << 15;
/// Most steps of a submission: some tenths of a second on a software adapter of two cores; a GPU is a hundred times faster.
const SOFTWARE_STEPS: usize = 1 << 26;
const HARDWARE_STEPS: usize = 1 << 33;
/// Steps of a lamp, at most: its disc, and taps of flakes with their cells, slices and clusters.
const LAMP_STEPS: usize = 20_000;
/// Steps of a tap of flakes under the surroundings: up to 52 looks at them.
const TAP_STEPS: usize = 6400;
/// Boxes and triangles that a ray tries, of a mesh of some 100,000 triangles and all around it.
const MESH_STEPS: usize = 400;
/// Most pixels of a block: a buffer of 48 MiB.
const BLOCK_PIXELS: usize = 1 << 22;

/// A rectangle of pixels, and what a submission adds to it.
#[derive(Debug, Clone, ShaderType)]
pub(super) struct Block {
    pub first: UVec2,
    pub size: UVec2,
    pub part: Part,
    pub paint: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, ShaderType)]
pub(super) struct Part {
    pub samples: UVec2,
    pub terms: UVec2,
}

/// Renders every paint as a tile of the scene's size, left to right, or all in one picture, as [`crate::render::render()`] does, which says what
/// `tick` is and how often it is called.
///
/// The GPU computes rays and places in f32: pixels differ by roundings, some 1e-7 of the mean, and by whole flakes where the
/// end of a cell or of a cluster lies within a rounding: up to four pixels in ten thousand, seen from so near that a pixel is
/// two texels wide.
///
/// # Errors
/// Those of the CPU renderer, a paint too large for the GPU, what the driver complains about.
pub fn render(
    gpu: &Gpu,
    scene: &Scene,
    paints: &[RenderPaint],
    options: &Options,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    Renderer::new(gpu)?.render(gpu, scene, paints, options, tick)
}

impl Renderer {
    /// Compiles the pass.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("picture"),
            source: wgpu::ShaderSource::Wgsl(picture_source().into()),
        });
        let layout = picture_layout(gpu);
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&paint::bind_group_layout(gpu)), Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("picture"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("picture"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        gpu.check("shader")?;
        Ok(Self { layout, pipeline })
    }

    /// As [`render()`].
    ///
    /// # Errors
    /// As [`render()`].
    pub fn render(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[RenderPaint],
        options: &Options,
        tick: &(dyn Fn() + Sync),
    ) -> Result<Picture> {
        let stage = check(scene, paints, options)?;
        let on_gpu = paints
            .iter()
            .map(|paint| GpuPaint::upload(gpu, paint, options.flakes))
            .collect::<Result<Vec<_>>>()?;
        let scene_buffers = scene::upload(gpu, &stage)?;
        let [width, height] = scene.size;
        let tiles = scene.tiles(&on_gpu);
        let size = [width * tiles.len(), height];
        let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
        let work = Work::new(&stage);
        let parts = work.parts();
        let [columns, rows] = work.block_size(scene.size, gpu.is_software());
        for y in (0..height).step_by(rows) {
            let rows = rows.min(height - y);
            for (tile, paints) in tiles.iter().enumerate() {
                for x in (0..width).step_by(columns) {
                    let columns = columns.min(width - x);
                    let (first, size_here) = ([x, y], [columns, rows]);
                    let rendered = self.block(gpu, paints, &scene_buffers, first, size_here, &parts)?;
                    for (row, line) in rendered.chunks(columns).enumerate() {
                        let start = (y + row) * size[0] + tile * width + x;
                        pixels[start..start + columns].copy_from_slice(line);
                    }
                }
            }
            (0..rows).for_each(|_| tick());
        }
        Ok(Picture { size, pixels })
    }

    /// The pixels of a block, row-major.
    fn block(
        &self,
        gpu: &Gpu,
        paints: &[GpuPaint],
        [scene, tables]: &[wgpu::Buffer; 2],
        first: [usize; 2],
        size: [usize; 2],
        parts: &[Part],
    ) -> Result<Vec<[f32; 3]>> {
        let [first, size] = [first, size].map(|[x, y]| UVec2::new(x as u32, y as u32));
        let bytes = u64::from(size.element_product()) * <[f32; 3]>::SHADER_SIZE.get();
        // Zero at first.
        let pixels = gpu.empty_buffer("pixels", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        for (number, paint) in (0..).zip(paints) {
            for part in parts {
                let block = gpu.uniform("block", &Block { first, size, part: *part, paint: number })?;
                let buffers = [scene, &block, &pixels, tables];
                submit(gpu, &self.pipeline, (&self.layout, buffers), (0, &paint.bind_group), size)?;
            }
        }
        read(gpu, &pixels)
    }
}

/// What a pixel costs, in steps of loops.
#[derive(Debug, Clone, Copy)]
struct Work {
    samples: usize,
    directions: usize,
    lights: usize,
    /// Steps of a ray through the meshes.
    ray_steps: usize,
    /// Steps of a direction: lobes, slices, soft boxes sampled, weighed and seen.
    direction_steps: usize,
    /// Steps of a tap of flakes under the surroundings.
    tap_steps: usize,
}

impl Work {
    fn new(stage: &Stage) -> Self {
        let Stage { scene, options, .. } = stage;
        let softboxes = match &scene.environment {
            Environment::Constant { .. } => 0,
            Environment::Studio { softbox, .. } => softbox.len(),
            // Two searches among some thousands.
            Environment::Sky { .. } | Environment::Image { .. } => 10,
        };
        Self {
            samples: options.samples,
            directions: options.directions,
            lights: scene.lights.len(),
            ray_steps: MESH_STEPS * stage.bodies.iter().filter(|b| matches!(b.form, Form::Mesh(_))).count(),
            direction_steps: 3 * softboxes + 24,
            tap_steps: if options.flakes { TAP_STEPS } else { 1 },
        }
    }

    /// Terms of a sample: directions, taps of flakes under the surroundings, lamps.
    fn terms(&self) -> usize {
        self.directions + FlakeDraws::MAX_TAPS + self.lights
    }

    /// Steps of a term, and of a ray before it.
    fn term_steps(&self, term: usize) -> usize {
        match term {
            _ if term < self.directions => self.direction_steps,
            _ if term < self.directions + FlakeDraws::MAX_TAPS => self.tap_steps,
            _ => LAMP_STEPS + self.ray_steps,
        }
    }

    /// Steps of a ray, and of the five directions more in which the coat looks.
    fn first_steps(&self) -> usize {
        self.ray_steps + 5 * self.direction_steps
    }

    fn sample_steps(&self) -> usize {
        self.first_steps() + (0..self.terms()).map(|term| self.term_steps(term)).sum::<usize>()
    }

    /// What one invocation after the other adds up: whole samples, or ranges of one sample's terms where that is too much.
    fn parts(&self) -> Vec<Part> {
        let range = |first: usize, end: usize| UVec2::new(first as u32, end as u32);
        let samples_each = (INVOCATION_STEPS / self.sample_steps()).max(1);
        let mut ranges = vec![range(0, self.terms())];
        if self.sample_steps() > INVOCATION_STEPS {
            ranges.clear();
            let (mut first, mut steps) = (0, self.first_steps());
            for term in 0..self.terms() {
                if term > first && steps + self.term_steps(term) > INVOCATION_STEPS {
                    ranges.push(range(first, term));
                    (first, steps) = (term, self.first_steps());
                }
                steps += self.term_steps(term);
            }
            ranges.push(range(first, self.terms()));
        }
        let samples = (0..self.samples).step_by(samples_each);
        let samples = samples.map(|first| range(first, (first + samples_each).min(self.samples)));
        samples.flat_map(|samples| ranges.iter().map(move |terms| Part { samples, terms: *terms })).collect()
    }

    /// Columns and rows of a block: whole rows where a submission may hold eight of them, workgroups else.
    fn block_size(&self, size: [usize; 2], is_software: bool) -> [usize; 2] {
        let steps = if is_software { SOFTWARE_STEPS } else { HARDWARE_STEPS };
        let pixels = (steps / (self.samples * self.sample_steps()).min(INVOCATION_STEPS)).min(BLOCK_PIXELS);
        let groups = |n: usize| (n / SIDE).max(1) * SIDE;
        let columns = groups(pixels / SIDE).min(size[0]);
        [columns, groups(pixels / columns).min(size[1])]
    }
}

/// Group 1: scene, block, pixels, tables of the scene.
pub(super) fn picture_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let uniform = BufferBindingType::Uniform;
    let [pixels, tables] = [false, true].map(|read_only| BufferBindingType::Storage { read_only });
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene and pixels"),
        entries: &[(0, uniform), (1, uniform), (2, pixels), (3, tables)].map(entry),
    })
}

/// Runs a pass over a block of pixels to its end; what the picture shows is bound as group 0 or 2.
pub(super) fn submit(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    (layout, buffers): (&wgpu::BindGroupLayout, [&wgpu::Buffer; 4]),
    (group, shown): (u32, &wgpu::BindGroup),
    size: UVec2,
) -> Result<()> {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    let io = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scene, block, pixels, tables"),
        layout,
        entries: &entries,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(pipeline);
    pass.set_bind_group(group, shown, &[]);
    pass.set_bind_group(1, &io, &[]);
    let groups = size.map(|n| n.div_ceil(SIDE as u32));
    pass.dispatch_workgroups(groups.x, groups.y, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    gpu.wait()
}

/// The pixels of a block.
pub(super) fn read(gpu: &Gpu, pixels: &wgpu::Buffer) -> Result<Vec<[f32; 3]>> {
    StorageBuffer::new(gpu.read_back(pixels)?)
        .create()
        .map_err(|e| Error::gpu(gpu.name(), "pixels", e, "as many as the block has"))
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<Part, _>("Part");
        assert_same_layout::<Block, _>("Block");
    }

    #[test]
    fn parts_make_the_whole() {
        for samples in [1, 8, 100, 4096] {
            for directions in [1, 48, 4096] {
                for lights in [0, 1, 64] {
                    let work = Work {
                        samples,
                        directions,
                        lights,
                        ray_steps: 0,
                        direction_steps: 33,
                        tap_steps: TAP_STEPS,
                    };
                    let area = |p: &Part| u64::from((p.samples.y - p.samples.x) * (p.terms.y - p.terms.x));
                    let parts = work.parts();
                    let whole = samples as u64 * work.terms() as u64;
                    assert_eq!(parts.iter().map(area).sum::<u64>(), whole);
                    assert!(parts.iter().filter(|p| p.terms.x == 0 && p.samples.x == 0).count() == 1);
                }
            }
        }
    }

    #[test]
    fn blocks_are_small_and_never_empty() {
        for side in [1, 7, 8, 360, Scene::MAX_SIDE] {
            for samples in [1, 8, 4096] {
                for is_software in [false, true] {
                    let work = Work {
                        samples,
                        directions: 48,
                        lights: 1,
                        ray_steps: 0,
                        direction_steps: 33,
                        tap_steps: TAP_STEPS,
                    };
                    let size = [side, side.min(4096)];
                    let [columns, rows] = work.block_size(size, is_software);
                    assert!((1..=size[0]).contains(&columns) && (1..=size[1]).contains(&rows));
                    assert!(columns * rows <= BLOCK_PIXELS);
                    // Only the last block of a row may be narrower than a workgroup.
                    assert!(columns == size[0] || columns % SIDE == 0);
                }
            }
        }
    }
}
