//! Frames in real time: one sample a pixel, drawn into a texture.
//!
//! A first pass finds what every pixel meets; it runs again only when camera, object or size change, so that the cost of a
//! frame does not hang on the scene. Then every paint shades the pixels that it covers.

use super::device::Gpu;
use super::paint::{self, GpuPaint};
use super::scene;
use super::shader::frame_source;
use super::uniform::Uniform;
use crate::error::{Error, Result};
use crate::render::{Options, Picture, Random};
use crate::scene::{Camera, Scene, Shape};
use encase::ShaderType;
use wgpu::{BufferUsages, TextureFormat, TextureUsages, TextureView};

/// How frames are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameOptions {
    /// Seed of the flakes.
    pub seed: u32,
    /// Where the flakes' random numbers come from.
    pub random: Random,
    /// Whether flakes sparkle; their mean belongs to the smooth part and stays.
    pub flakes: bool,
    /// Exposure, stops, -64 to 64; that of the scene does not count.
    pub exposure_stops: f64,
    /// Directions a pixel in which the base looks for the surroundings, 1 to 4096.
    pub directions: usize,
    /// The rectangle of pixels that is drawn, its left top corner and its size; what lies around it stays. None: all.
    pub part: Option<[[u32; 2]; 2]>,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self { seed: 1, random: Random::Hash, flakes: true, exposure_stops: 0.0, directions: 12, part: None }
    }
}

impl FrameOptions {
    fn validate(&self, size: [u32; 2]) -> Result<()> {
        if !(-64.0..=64.0).contains(&self.exposure_stops) {
            return Err(Error::invalid("frame", "exposure_stops", self.exposure_stops, "-64 to 64"));
        }
        if !(1..=4096).contains(&self.directions) {
            return Err(Error::invalid("frame", "directions", self.directions, "1 to 4096"));
        }
        if let Random::Texture(side) = self.random
            && !(1..=1 << 16).contains(&side)
        {
            return Err(Error::invalid("frame", "random texture", side, "1 to 65536"));
        }
        if let Some([first, part]) = self.part {
            let ends = |k: usize| first[k].checked_add(part[k]).is_some_and(|end| end <= size[k]);
            if !(ends(0) && ends(1)) {
                let legal = format!("a rectangle inside {} x {}", size[0], size[1]);
                return Err(Error::invalid("frame", "part", format!("{part:?} at {first:?}"), legal));
            }
        }
        Ok(())
    }
}

/// Draws frames. One for each kind of texture that is drawn into; frames of one size should follow each other.
#[derive(Debug)]
pub struct FrameRenderer {
    format: TextureFormat,
    geometry: wgpu::RenderPipeline,
    shading: wgpu::RenderPipeline,
    scene: Uniform,
    frame: Uniform,
    scene_group: wgpu::BindGroup,
    maps_layout: wgpu::BindGroupLayout,
    kept: Option<Kept>,
}

/// What pixels meet, and of what scene.
#[derive(Debug)]
struct Kept {
    geometry: Geometry,
    view: TextureView,
    maps: wgpu::BindGroup,
}

/// What the geometry of a frame hangs on.
#[derive(Debug, Clone, PartialEq)]
struct Geometry {
    size: [usize; 2],
    camera: Camera,
    shape: Shape,
}

impl Geometry {
    fn of(scene: &Scene) -> Self {
        Self { size: scene.size, camera: scene.camera, shape: scene.shape }
    }
}

/// Twin of the struct of the shader.
#[derive(Debug, Clone, ShaderType)]
struct Frame {
    exposure: f32,
    sparkles: u32,
}

impl Frame {
    fn new(options: &FrameOptions) -> Self {
        Self { exposure: options.exposure_stops.exp2() as f32, sparkles: u32::from(options.flakes) }
    }
}

/// Of the kept geometry.
const GEOMETRY: TextureFormat = TextureFormat::Rgba32Uint;

impl FrameRenderer {
    /// Compiles the passes for targets of a format. Float formats get linear Rec.709 radiance times the exposure, sRGB and
    /// eight-bit formats the same clipped to [0, 1] and encoded.
    ///
    /// # Errors
    /// What the driver complains about: a format that cannot be drawn into.
    pub fn new(gpu: &Gpu, target_format: TextureFormat) -> Result<Self> {
        let scene = Scene::default();
        let scene = Uniform::new(gpu, "scene", &scene::Scene::new(&scene, &Options::default()))?;
        let frame = Uniform::new(gpu, "frame", &Frame::new(&FrameOptions::default()))?;
        let (scene_layout, maps_layout) = (scene_layout(gpu), maps_layout(gpu));
        let scene_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene and frame"),
            layout: &scene_layout,
            entries: &[(0, &scene.buffer), (1, &frame.buffer)]
                .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() }),
        });
        let paint_layout = paint::bind_group_layout(gpu);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("frame"),
            source: wgpu::ShaderSource::Wgsl(frame_source().into()),
        });
        let shade = match encodes(target_format) {
            true => "encoded_frame",
            false => "linear_frame",
        };
        let pass = |layouts: &[Option<&wgpu::BindGroupLayout>], entry_point, format| {
            full_screen(gpu, &module, layouts, entry_point, format)
        };
        let geometry = pass(&[None, Some(&scene_layout)], "geometry_frame", GEOMETRY);
        let shading =
            pass(&[Some(&paint_layout), Some(&scene_layout), Some(&maps_layout)], shade, target_format);
        gpu.check("shader")?;
        let format = target_format;
        Ok(Self { format, geometry, shading, scene, frame, scene_group, maps_layout, kept: None })
    }

    /// Draws a frame of the scene into `target`, a view of the renderer's format and of `size` pixels, columns and rows; the
    /// scene's own size does not count. Nothing is drawn where a side is 0. Slices that were left out of a paint are not drawn.
    ///
    /// # Errors
    /// An illegal scene or option, no paints, a size beyond what the GPU can draw, what the driver complains about.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
        target: &TextureView,
        size: [u32; 2],
    ) -> Result<()> {
        if size.contains(&0) {
            return Ok(());
        }
        let scene = Scene { size: size.map(|n| n as usize), ..scene.clone() };
        check(gpu, &scene, paints, options, size)?;
        let render = Options {
            samples: 1,
            directions: options.directions,
            seed: options.seed,
            flakes: options.flakes,
            random: options.random,
        };
        self.scene.set(gpu, &scene::Scene::new(&scene, &render))?;
        self.frame.set(gpu, &Frame::new(options))?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let kept = match self.kept.take() {
            Some(kept) if kept.geometry == Geometry::of(&scene) => kept,
            other => self.find(gpu, &mut encoder, &scene, other),
        };
        self.shade(&mut encoder, paints, options, target, &kept);
        self.kept = Some(kept);
        gpu.queue.submit([encoder.finish()]);
        gpu.check("frame")
    }

    /// What [`FrameRenderer::draw`] draws, of the scene's size, read back; for a renderer of [`TextureFormat::Rgba32Float`].
    ///
    /// # Errors
    /// As [`FrameRenderer::draw`]; another format.
    pub fn picture(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
    ) -> Result<Picture> {
        if self.format != TextureFormat::Rgba32Float {
            return Err(Error::gpu("frame", "format", format!("{:?}", self.format), "Rgba32Float to read"));
        }
        scene.validate()?;
        let size = scene.size.map(|n| n as u32);
        check(gpu, scene, paints, options, size)?;
        let target = texture(
            gpu,
            "target",
            self.format,
            size,
            TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
        );
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.draw(gpu, scene, paints, options, &view, size)?;
        let texels = read_texels(gpu, &target, 16)?;
        let float = |at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|k| texels[at + k]));
        let pixel = |k: usize| [0, 4, 8].map(|c| float(16 * k + c));
        Ok(Picture { size: scene.size, pixels: (0..scene.size[0] * scene.size[1]).map(pixel).collect() })
    }

    /// Finds what pixels meet, in the texture of `old` if that has the size.
    fn find(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, scene: &Scene, old: Option<Kept>) -> Kept {
        let geometry = Geometry::of(scene);
        let kept = match old {
            Some(kept) if kept.geometry.size == geometry.size => Kept { geometry, ..kept },
            _ => {
                let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
                let map = texture(gpu, "geometry", GEOMETRY, geometry.size.map(|n| n as u32), usage);
                let view = map.create_view(&wgpu::TextureViewDescriptor::default());
                let maps = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("maps"),
                    layout: &self.maps_layout,
                    entries: &[wgpu::BindGroupEntry {
                        binding: 0,
                        resource: wgpu::BindingResource::TextureView(&view),
                    }],
                });
                Kept { geometry, view, maps }
            }
        };
        let mut pass = begin(encoder, &kept.view, wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT));
        pass.set_pipeline(&self.geometry);
        pass.set_bind_group(1, &self.scene_group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        kept
    }

    fn shade(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        paints: &[&GpuPaint],
        options: &FrameOptions,
        target: &TextureView,
        kept: &Kept,
    ) {
        let load = match options.part {
            None => wgpu::LoadOp::Clear(wgpu::Color::BLACK),
            Some(_) => wgpu::LoadOp::Load,
        };
        let mut pass = begin(encoder, target, load);
        pass.set_pipeline(&self.shading);
        pass.set_bind_group(1, &self.scene_group, &[]);
        pass.set_bind_group(2, &kept.maps, &[]);
        if let Some([[x, y], [width, height]]) = options.part {
            pass.set_scissor_rect(x, y, width, height);
        }
        for (k, paint) in (0..).zip(paints) {
            pass.set_bind_group(0, &paint.bind_group, &[]);
            pass.draw(0..3, k..k + 1);
        }
    }
}

fn check(
    gpu: &Gpu,
    scene: &Scene,
    paints: &[&GpuPaint],
    options: &FrameOptions,
    size: [u32; 2],
) -> Result<()> {
    scene.validate()?;
    options.validate(size)?;
    if paints.is_empty() {
        return Err(Error::invalid("frame", "number of paints", 0, "1 or more"));
    }
    let most = gpu.device.limits().max_texture_dimension_2d;
    if size.iter().any(|n| *n > most) {
        let found = format!("{} x {}", size[0], size[1]);
        return Err(Error::gpu(gpu.name(), "size of a frame", found, format!("sides of up to {most}")));
    }
    Ok(())
}

/// Whether the shader has to encode what such a texture shows: floats stay linear, others may encode by themselves.
fn encodes(format: TextureFormat) -> bool {
    use TextureFormat as F;
    !(format.is_srgb() || matches!(format, F::Rgba16Float | F::Rgba32Float | F::Rg11b10Ufloat))
}

/// A pass over all pixels of a target.
fn full_screen(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layouts: &[Option<&wgpu::BindGroupLayout>],
    entry_point: &str,
    format: TextureFormat,
) -> wgpu::RenderPipeline {
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry_point),
        bind_group_layouts: layouts,
        immediate_size: 0,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("whole"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    view: &TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("frame"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops,
        })],
        ..Default::default()
    })
}

pub(super) fn texture(
    gpu: &Gpu,
    label: &str,
    format: TextureFormat,
    [width, height]: [u32; 2],
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// The texels of a texture of so many bytes each, row after row.
fn read_texels(gpu: &Gpu, texture: &wgpu::Texture, bytes: u32) -> Result<Vec<u8>> {
    let (row, rows) = (texture.width() * bytes, texture.height());
    // Rows of a copy start at multiples of this.
    let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copy = gpu.empty_buffer(
        "copy",
        u64::from(stride) * u64::from(rows),
        BufferUsages::MAP_READ | BufferUsages::COPY_DST,
    );
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: Some(rows) };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &copy, layout },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let texels = gpu.read(&copy)?;
    Ok(texels.chunks(stride as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}

/// Group 1: scene, frame.
fn scene_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene and frame"),
        entries: &[0, 1].map(entry),
    })
}

/// Group 2: the kept geometry.
fn maps_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("maps"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    })
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<Frame, _>("Frame");
    }

    #[test]
    fn eight_bits_are_encoded_once() {
        assert!(encodes(TextureFormat::Rgba8Unorm) && encodes(TextureFormat::Bgra8Unorm));
        assert!(!encodes(TextureFormat::Rgba8UnormSrgb) && !encodes(TextureFormat::Rgba32Float));
    }
}
