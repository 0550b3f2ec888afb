//! Soft proofs on the GPU: the twin of [`crate::render::render_print`].

use super::device::Gpu;
use super::render::{Block, Part, SIDE, picture_layout, read, submit};
use super::scene;
use super::shader::picture_source;
use crate::error::{Error, Result};
use crate::proof::Coverage;
use crate::render::{InkBand, InkModel, Options, Picture, Print, PrintInks, print_stage};
use crate::scene::Scene;
use encase::{ShaderSize, ShaderType};
use glam::{UVec2, UVec4, Vec3};
use wgpu::{BufferBindingType, BufferUsages, ShaderStages, TextureFormat};

/// Levels that the shader has room for: those of 2^27 dots.
const LEVELS: usize = 28;
/// Most steps of loops that an invocation takes. Mesa's software renderer ends all loops after 65,535, without a word.
const INVOCATION_STEPS: usize = 1 << 15;
/// Steps of a lamp besides its wavelengths: texels of the coverage, and a ray to it.
const LAMP_STEPS: usize = 500;
/// Most steps of a submission, as for pictures of paints.
const SOFTWARE_STEPS: usize = 1 << 28;
const HARDWARE_STEPS: usize = 1 << 33;
/// Most pixels of a block.
const BLOCK_PIXELS: usize = 1 << 22;

/// The compute pass that renders prints in inks of one model.
#[derive(Debug)]
pub struct PrintRenderer {
    model: InkModel,
    io: wgpu::BindGroupLayout,
    inks: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

/// Twin of the struct of the shader.
#[derive(Debug, Clone, ShaderType)]
struct Uniform {
    roughness: Vec3,
    bands: u32,
    white: Vec3,
    levels: u32,
    paper: Vec3,
    sizes: [UVec4; LEVELS],
}

/// A print on the GPU.
#[derive(Debug)]
pub struct GpuPrint {
    bands: usize,
    model: InkModel,
    bind_group: wgpu::BindGroup,
}

/// Renders a print as [`crate::render::render_print`] does, which says what `tick` is and how often it is called; pixels differ by
/// roundings of f32.
///
/// # Errors
/// Those of the CPU renderer, a print too large for the GPU, what the driver complains about.
pub fn render_print(
    gpu: &Gpu,
    scene: &Scene,
    print: &Print,
    options: &Options,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    let renderer = PrintRenderer::new(gpu, print.inks.model)?;
    let on_gpu = renderer.upload(gpu, print)?;
    renderer.render(gpu, scene, &on_gpu, options, tick)
}

impl GpuPrint {
    /// Whether a print has no more dots than a buffer has room for, some 31 million.
    pub fn fits(coverage: &Coverage) -> bool {
        let texels = |level: usize| coverage.size(level).into_iter().product::<usize>() as u64;
        let means: u64 = (1..coverage.levels()).map(|level| 12 * texels(level)).sum();
        texels(0) / 4 + 4 + means <= Gpu::STORAGE_BYTES
    }
}

impl PrintRenderer {
    /// Compiles the pass.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn new(gpu: &Gpu, model: InkModel) -> Result<Self> {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("print"),
            source: wgpu::ShaderSource::Wgsl(picture_source().into()),
        });
        let (io, inks) = (picture_layout(gpu), inks_layout(gpu));
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("print"),
            bind_group_layouts: &[None, Some(&io), Some(&inks)],
            immediate_size: 0,
        });
        let constants = [("INK_MODEL", f64::from(number(model)))];
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("print"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("print_picture"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                ..Default::default()
            },
            cache: None,
        });
        gpu.check("shader")?;
        Ok(Self { model, io, inks, pipeline })
    }

    /// Brings a print to the GPU.
    ///
    /// # Errors
    /// More dots than the GPU has room for, what the driver complains about.
    pub fn upload(&self, gpu: &Gpu, print: &Print) -> Result<GpuPrint> {
        let (words, sizes) = words(print.coverage);
        let PrintInks { roughness, bands, white, model } = print.inks;
        let uniform = Uniform {
            roughness: *roughness,
            bands: bands.len() as u32,
            white: *white,
            levels: print.coverage.levels() as u32,
            paper: Vec3::new(print.paper.highlight, print.paper.shininess, print.paper.albedo),
            sizes,
        };
        let (uniform, coverage) = (gpu.uniform("print", &uniform)?, gpu.storage("coverage", &words)?);
        let spectra = spectra(gpu, bands);
        let view = spectra.create_view(&wgpu::TextureViewDescriptor::default());
        let entries = [
            uniform.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
            coverage.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(entries)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("print"),
            layout: &self.inks,
            entries: &entries,
        });
        gpu.check("print")?;
        Ok(GpuPrint { bands: bands.len(), model: *model, bind_group })
    }

    /// As [`render_print`].
    ///
    /// # Errors
    /// As [`render_print`]; inks of another model.
    pub fn render(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        print: &GpuPrint,
        options: &Options,
        tick: &(dyn Fn() + Sync),
    ) -> Result<Picture> {
        if print.model != self.model {
            let legal = format!("{:?}, for which the pass was made", self.model);
            return Err(Error::invalid("print", "model", format!("{:?}", print.model), legal));
        }
        let stage = print_stage(scene, options)?;
        let [scene_buffer, tables] = scene::upload(gpu, &stage)?;
        let [width, height] = scene.size;
        let parts = parts(options.samples, scene.lights.len(), print.bands);
        let rows = rows(scene, options, print.bands, gpu.is_software());
        let mut pixels = Vec::with_capacity(width * height);
        for y in (0..height).step_by(rows) {
            let size = UVec2::new(width as u32, rows.min(height - y) as u32);
            let bytes = u64::from(size.element_product()) * <[f32; 3]>::SHADER_SIZE.get();
            let block_pixels =
                gpu.empty_buffer("pixels", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
            for part in &parts {
                let first = UVec2::new(0, y as u32);
                let block = gpu.uniform("block", &Block { first, size, part: *part, paint: 0 })?;
                let buffers = [&scene_buffer, &block, &block_pixels, &tables];
                submit(gpu, &self.pipeline, (&self.io, buffers), (2, &print.bind_group), size)?;
            }
            pixels.extend(read(gpu, &block_pixels)?);
            (0..size.y).for_each(|_| tick());
        }
        Ok(Picture { size: scene.size, pixels })
    }
}

/// As in the shader.
fn number(model: InkModel) -> u32 {
    match model {
        InkModel::Goniochromatic => 0,
        InkModel::Schlick => 1,
        InkModel::Exact => 2,
    }
}

/// What one invocation after the other adds up: some samples, all lamps; or some lamps of one sample.
fn parts(samples: usize, lamps: usize, bands: usize) -> Vec<Part> {
    let lamp_steps = bands + LAMP_STEPS;
    let lamps_each = (INVOCATION_STEPS / lamp_steps).clamp(1, lamps.max(1));
    let samples_each = (INVOCATION_STEPS / (lamp_steps * lamps_each)).max(1);
    let ranges = |count: usize, each: usize| {
        (0..count).step_by(each).map(move |first| UVec2::new(first as u32, (first + each).min(count) as u32))
    };
    // Without lamps there is the background.
    let terms: Vec<UVec2> = if lamps == 0 { vec![UVec2::ZERO] } else { ranges(lamps, lamps_each).collect() };
    let samples = ranges(samples, if terms.len() > 1 { 1 } else { samples_each });
    samples.flat_map(|samples| terms.iter().map(move |terms| Part { samples, terms: *terms })).collect()
}

/// Rows of a block: a submission ends in some tenths of a second on a software adapter.
fn rows(scene: &Scene, options: &Options, bands: usize, is_software: bool) -> usize {
    let steps = if is_software { SOFTWARE_STEPS } else { HARDWARE_STEPS };
    let pixel = (options.samples * scene.lights.len().max(1) * (bands + LAMP_STEPS)).min(INVOCATION_STEPS);
    let pixels = (steps / pixel).min(BLOCK_PIXELS);
    (pixels / scene.size[0] / SIDE).max(1) * SIDE
}

/// Words of the coverage, and columns, rows and first word of each level.
fn words(coverage: &Coverage) -> (Vec<u32>, [UVec4; LEVELS]) {
    let mut sizes = [UVec4::ZERO; LEVELS];
    let packed = |dots: &[u8]| dots.iter().rev().fold(0, |word, dot| word << 2 | u32::from(*dot));
    let mut words: Vec<u32> = coverage.dots().dots().chunks(16).map(packed).collect();
    for (level, entry) in sizes.iter_mut().enumerate().take(coverage.levels()) {
        let [columns, rows] = coverage.size(level);
        let first = if level == 0 { 0 } else { words.len() };
        *entry = UVec4::new(columns as u32, rows as u32, first as u32, 0);
        if level > 0 {
            words.extend((0..columns * rows).flat_map(|k| coverage.texel(level, k).map(f32::to_bits)));
        }
    }
    (words, sizes)
}

/// The texture of the inks' spectra.
fn spectra(gpu: &Gpu, bands: &[InkBand]) -> wgpu::Texture {
    let rows: [&dyn Fn(&InkBand) -> Vec3; 4] =
        [&|b| b.reflectance, &|b| b.growth, &|b| b.color, &|b| b.index.extend(0.0)];
    let texels = rows.iter().flat_map(|row| bands.iter().map(|band| row(band).extend(0.0).to_array()));
    let bytes: Vec<u8> = texels.flatten().flat_map(f32::to_le_bytes).collect();
    let size = wgpu::Extent3d { width: bands.len() as u32, height: 4, depth_or_array_layers: 1 };
    let texture = super::pass::texture(
        gpu,
        "spectra",
        TextureFormat::Rgba32Float,
        [size.width, size.height],
        wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
    );
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * size.width), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), &bytes, layout, size);
    texture
}

/// Group 2: the print, spectra, coverage.
fn inks_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let spectra = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let types =
        [buffer(BufferBindingType::Uniform), spectra, buffer(BufferBindingType::Storage { read_only: true })];
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("print"),
        entries: &entries,
    })
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;
    use crate::proof::Halftone;

    #[test]
    fn the_struct_lies_as_the_shader_reads_it() {
        assert_same_layout::<Uniform, _>("Print");
    }

    #[test]
    fn parts_make_the_whole_in_few_steps() {
        for (samples, lamps, bands) in [(1, 0, 2), (8, 2, 41), (4096, 64, 41), (3, 64, 4096), (1, 1, 3)] {
            let parts = parts(samples, lamps, bands);
            let area = |p: &Part| (p.samples.y - p.samples.x) * (p.terms.y - p.terms.x).max(1);
            assert_eq!(parts.iter().map(area).sum::<u32>() as usize, samples * lamps.max(1));
            assert!(parts.iter().all(|p| area(p) as usize * (bands + LAMP_STEPS) <= INVOCATION_STEPS));
        }
    }

    #[test]
    fn dots_and_levels_lie_one_behind_the_other() {
        let dots: Vec<u8> = (0..35).map(|k| k % 4).collect();
        let coverage = Coverage::new(Halftone::new([7, 5], dots.clone()).unwrap());
        let (words, sizes) = words(&coverage);
        (0..35).for_each(|k| assert_eq!(words[k / 16] >> (2 * (k % 16)) & 3, u32::from(dots[k])));
        assert_eq!(sizes[1].truncate(), glam::UVec3::new(4, 3, 3));
        assert_eq!(f32::from_bits(words[3 + 3 * 5 + 1]), coverage.texel(1, 5)[1]);
        assert_eq!(words.len(), 3 + 3 * (12 + 4 + 1));
    }
}
