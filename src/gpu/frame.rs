//! Frames in real time: one sample a pixel, drawn into a texture.
//!
//! A first pass finds what every pixel meets; it runs again only when camera, object or size change, so that the cost of a
//! frame does not hang on the scene. Then every paint shades the pixels that it covers.

use super::device::Gpu;
use super::paint::{self, GpuPaint};
use super::prefilter::{Prefilter, map_scale, node_count, sampled};
use super::rival::Rival;
use super::scene;
use super::shader::frame_source;
use super::uniform::Uniform;
use crate::error::{Error, Result};
use crate::render::{Options, Picture, Random, Stage};
use crate::scene::{Bodies, Camera, Environment, Form, Object, Scene, Shape};
use encase::ShaderType;
use glam::UVec2;
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
    /// Directions a pixel in which the base looks for the surroundings as in [`crate::render::Options`], 1 to 4096; none:
    /// prefiltered maps, in real time.
    pub directions: Option<usize>,
    /// Whether flakes are drawn from colors along u that were drawn beforehand, 320 a slice, instead of from their boxes: twice as
    /// fast on software adapters. Mean and contrast stay, where in its box a color lies is the same for all flakes of a
    /// step, and what is rarer than 6e-5 shares a step; lamps count with
    /// their middle, at the contrast that their disc leaves.
    pub rows: bool,
    /// Whether flakes sparkle under the surroundings too, if they sparkle: some forty looks at them a pixel.
    pub around: bool,
    /// The rectangle of pixels that is drawn, its left top corner and its size; what lies around it stays. None: all.
    pub part: Option<[[u32; 2]; 2]>,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            random: Random::Hash,
            flakes: true,
            exposure_stops: 0.0,
            directions: None,
            rows: false,
            around: true,
            part: None,
        }
    }
}

impl FrameOptions {
    fn validate(&self, size: [u32; 2]) -> Result<()> {
        if !(-64.0..=64.0).contains(&self.exposure_stops) {
            return Err(Error::invalid("frame", "exposure_stops", self.exposure_stops, "-64 to 64"));
        }
        if let Some(n) = self.directions
            && !(1..=4096).contains(&n)
        {
            return Err(Error::invalid("frame", "directions", n, "1 to 4096"));
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
    module: wgpu::ShaderModule,
    geometry: wgpu::RenderPipeline,
    shading: wgpu::PipelineLayout,
    /// Compiled when first needed.
    variants: Vec<(Variant, wgpu::RenderPipeline)>,
    /// What sees no paint.
    beyond: wgpu::RenderPipeline,
    scene_layout: wgpu::BindGroupLayout,
    /// The scene that the group holds, as it is drawn.
    shown: Option<(Scene, Options)>,
    /// Its objects and surroundings, ready for rays: files are read once.
    bodies: Bodies,
    surroundings: (Environment, crate::scene::Surroundings),
    frame: Uniform,
    scene_group: wgpu::BindGroup,
    maps_layout: wgpu::BindGroupLayout,
    prefilter: Prefilter,
    kept: Option<Kept>,
    /// Drawn in place of paints.
    rival: Option<(wgpu::RenderPipeline, Option<wgpu::BindGroup>)>,
}

/// What a way of shading is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Variant {
    surroundings: Surroundings,
    /// Whether objects may stand in each other's light.
    shades: bool,
    /// Whether flakes sparkle under the surroundings.
    around: bool,
    /// Whether flakes are drawn from rows, and whether they turn.
    rows: Option<bool>,
}

impl Variant {
    fn of(scene: &Scene, bodies: &Bodies, options: &FrameOptions, paint: &GpuPaint) -> Self {
        let meshes = bodies.iter().any(|body| matches!(body.form, Form::Mesh(_)));
        let surroundings = Surroundings::of(scene, options);
        Self {
            surroundings,
            shades: meshes || scene.objects.len() > 1,
            around: options.around && options.flakes && surroundings != Surroundings::None,
            rows: paint.turns().filter(|_| options.rows && options.flakes),
        }
    }
}

/// How a frame knows the surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Surroundings {
    /// They are dark.
    None,
    Maps,
    Sampled,
}

impl Surroundings {
    fn of(scene: &Scene, options: &FrameOptions) -> Self {
        match (&scene.environment, options.directions) {
            (Environment::Constant { radiance: [0.0, 0.0, 0.0] }, _) => Self::None,
            (_, None) => Self::Maps,
            (_, Some(_)) => Self::Sampled,
        }
    }
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
    objects: Vec<Object>,
}

impl Geometry {
    fn of(scene: &Scene) -> Self {
        Self {
            size: scene.size,
            camera: scene.camera,
            shape: scene.shape.clone(),
            objects: scene.objects.clone(),
        }
    }
}

/// Twin of the struct of the shader.
#[derive(Debug, Clone, ShaderType)]
struct Frame {
    exposure: f32,
    sparkles: u32,
    nodes: UVec2,
    map_scale: f32,
}

impl Frame {
    fn new(scene: &Scene, map_scale: f32, options: &FrameOptions) -> Self {
        Self {
            exposure: options.exposure_stops.exp2() as f32,
            sparkles: u32::from(options.flakes),
            nodes: node_count(scene).into(),
            map_scale,
        }
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
        let (scene, options) = (Scene::default(), Options::default());
        let stage = Stage::new(&scene, &options)?;
        let frame = Uniform::new(gpu, "frame", &Frame::new(&scene, 1.0, &FrameOptions::default()))?;
        let (scene_layout, maps_layout) = (scene_layout(gpu), maps_layout(gpu));
        let scene_group = scene_group(gpu, &scene_layout, &stage, &frame)?;
        let paint_layout = paint::bind_group_layout(gpu);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("frame"),
            source: wgpu::ShaderSource::Wgsl(frame_source().into()),
        });
        let geometry = full_screen(
            gpu,
            &module,
            &pipeline_layout(gpu, &[None, Some(&scene_layout)]),
            "geometry_frame",
            GEOMETRY,
            &[],
        );
        let entry_point = if encodes(target_format) { "encoded_beyond" } else { "linear_beyond" };
        let unpainted = pipeline_layout(gpu, &[None, Some(&scene_layout), Some(&maps_layout)]);
        let beyond = full_screen(gpu, &module, &unpainted, entry_point, target_format, &[]);
        let prefilter = Prefilter::new(gpu, &module, [&paint_layout, &scene_layout, &maps_layout]);
        let layouts = [&paint_layout, &scene_layout, &maps_layout, prefilter.paint_layout()];
        let shading = pipeline_layout(gpu, &layouts.map(Some));
        gpu.check("shader")?;
        let mut renderer = Self {
            format: target_format,
            module,
            geometry,
            shading,
            variants: Vec::new(),
            beyond,
            scene_layout,
            shown: None,
            bodies: stage.bodies,
            surroundings: (scene.environment.clone(), stage.surroundings),
            frame,
            scene_group,
            maps_layout,
            prefilter,
            kept: None,
            rival: None,
        };
        renderer.compile(
            gpu,
            Variant { surroundings: Surroundings::Maps, shades: false, around: true, rows: None },
        )?;
        Ok(renderer)
    }

    /// From now on draws what a rival draws of the first paint.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn draw_rival(&mut self, gpu: &Gpu, rival: &Rival) -> Result<()> {
        let layouts = [paint::bind_group_layout(gpu), scene_layout(gpu), maps_layout(gpu)];
        self.rival = Some(rival.compile(gpu, &layouts, self.format));
        gpu.check("rival")
    }

    /// Compiles a way of shading, unless that is done.
    fn compile(&mut self, gpu: &Gpu, variant: Variant) -> Result<()> {
        if self.variants.iter().any(|(v, _)| *v == variant) {
            return Ok(());
        }
        let entry_point = if encodes(self.format) { "encoded_frame" } else { "linear_frame" };
        let Variant { surroundings, shades, around, rows } = variant;
        let constants = [
            ("SURROUNDINGS", f64::from(surroundings as u8)),
            ("SHADES", f64::from(u8::from(shades))),
            ("AROUND", f64::from(u8::from(around))),
            ("ROWS", f64::from(u8::from(rows.is_some()))),
            ("TURNING", f64::from(u8::from(rows == Some(true)))),
        ];
        let pass = full_screen(gpu, &self.module, &self.shading, entry_point, self.format, &constants);
        gpu.check("shader")?;
        self.variants.push((variant, pass));
        Ok(())
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
            directions: options.directions.unwrap_or(1),
            seed: options.seed,
            flakes: options.flakes,
            random: options.random,
        };
        if self.shown.as_ref() != Some(&(scene.clone(), render)) {
            self.bodies = self.bodies.changed(&scene)?;
            if self.surroundings.0 != scene.environment {
                self.surroundings = (scene.environment.clone(), scene.environment.surroundings()?);
            }
            let stage = Stage::with(&scene, &render, self.bodies.clone(), self.surroundings.1.clone());
            self.scene_group = scene_group(gpu, &self.scene_layout, &stage, &self.frame)?;
            self.shown = Some((scene.clone(), render));
        }
        self.frame.set(gpu, &Frame::new(&scene, map_scale(&self.surroundings.1), options))?;
        let variants: Vec<_> =
            paints.iter().map(|paint| Variant::of(&scene, &self.bodies, options, paint)).collect();
        variants.iter().try_for_each(|variant| self.compile(gpu, *variant))?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let kept = match self.kept.take() {
            Some(kept) if kept.geometry == Geometry::of(&scene) => kept,
            other => self.find(gpu, &mut encoder, &scene, other),
        };
        self.prefilter.reserve(gpu, paints.len());
        if variants.iter().any(|variant| variant.rows.is_some()) {
            self.prefilter.update_rows(gpu, &mut encoder, paints);
        }
        if variants.iter().any(|variant| variant.surroundings == Surroundings::Maps) {
            self.prefilter.update(gpu, &mut encoder, &scene, paints, [&self.scene_group, &kept.maps]);
        }
        self.shade(&mut encoder, &variants, paints, options, target, &kept);
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
        let target = self.drawn(gpu, scene, paints, options)?;
        self.read(gpu, &target)
    }

    /// The same as eight-bit sRGB; for a renderer of [`TextureFormat::Rgba8Unorm`] or [`TextureFormat::Rgba8UnormSrgb`].
    ///
    /// # Errors
    /// As [`FrameRenderer::draw`]; another format.
    pub fn codes(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
    ) -> Result<Vec<[u8; 3]>> {
        self.expect(&[TextureFormat::Rgba8Unorm, TextureFormat::Rgba8UnormSrgb])?;
        let texels = read_texels(gpu, &self.drawn(gpu, scene, paints, options)?, 4)?;
        Ok(texels.chunks(4).map(|t| [t[0], t[1], t[2]]).collect())
    }

    /// What a texture shows that was drawn into, [`TextureFormat::Rgba32Float`] with usage `COPY_SRC`.
    ///
    /// # Errors
    /// A renderer of another format, what the driver complains about.
    pub fn read(&self, gpu: &Gpu, target: &wgpu::Texture) -> Result<Picture> {
        self.expect(&[TextureFormat::Rgba32Float])?;
        let texels = read_texels(gpu, target, 16)?;
        let float = |at: usize| f32::from_le_bytes([0, 1, 2, 3].map(|k| texels[at + k]));
        let pixels = (0..texels.len() / 16).map(|k| [0, 4, 8].map(|c| float(16 * k + c)));
        Ok(Picture { size: [target.width(), target.height()].map(|n| n as usize), pixels: pixels.collect() })
    }

    fn expect(&self, formats: &[TextureFormat]) -> Result<()> {
        if formats.contains(&self.format) {
            return Ok(());
        }
        Err(Error::gpu("frame", "format", format!("{:?}", self.format), format!("{formats:?} to be read")))
    }

    /// A texture of the scene's size, drawn into.
    fn drawn(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        paints: &[&GpuPaint],
        options: &FrameOptions,
    ) -> Result<wgpu::Texture> {
        scene.validate()?;
        let size = scene.size.map(|n| n as u32);
        check(gpu, scene, paints, options, size)?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let target = texture(gpu, "target", self.format, size, usage);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.draw(gpu, scene, paints, options, &view, size)?;
        Ok(target)
    }

    /// Memory on the GPU besides paints, bytes: geometry, surroundings, what paints scatter of them.
    pub fn bytes(&self) -> u64 {
        let texels = self.kept.as_ref().map_or(0, |kept| kept.geometry.size.iter().product::<usize>());
        16 * texels as u64 + self.prefilter.bytes()
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
                    entries: &[
                        wgpu::BindGroupEntry {
                            binding: 0,
                            resource: wgpu::BindingResource::TextureView(&view),
                        },
                        wgpu::BindGroupEntry {
                            binding: 1,
                            resource: wgpu::BindingResource::TextureView(&self.prefilter.cube_view()),
                        },
                        wgpu::BindGroupEntry {
                            binding: 2,
                            resource: wgpu::BindingResource::Sampler(&self.prefilter.sampler),
                        },
                    ],
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
        variants: &[Variant],
        paints: &[&GpuPaint],
        options: &FrameOptions,
        target: &TextureView,
        kept: &Kept,
    ) {
        let load = match options.part {
            None => wgpu::LoadOp::Clear(wgpu::Color::BLACK),
            Some(_) => wgpu::LoadOp::Load,
        };
        if let Some((pipeline, group)) = &self.rival {
            let mut pass = begin(encoder, target, wgpu::LoadOp::Clear(wgpu::Color::BLACK));
            pass.set_bind_group(1, &self.scene_group, &[]);
            pass.set_bind_group(2, &kept.maps, &[]);
            pass.set_pipeline(&self.beyond);
            pass.draw(0..3, 0..1);
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &paints[0].bind_group, &[]);
            if group.is_some() {
                pass.set_bind_group(3, group.as_ref(), &[]);
            }
            return pass.draw(0..3, 0..1);
        }
        let mut pass = begin(encoder, target, load);
        pass.set_bind_group(1, &self.scene_group, &[]);
        pass.set_bind_group(2, &kept.maps, &[]);
        if let Some([[x, y], [width, height]]) = options.part {
            pass.set_scissor_rect(x, y, width, height);
        }
        pass.set_pipeline(&self.beyond);
        pass.draw(0..3, 0..1);
        for (k, (paint, variant)) in (0..).zip(paints.iter().zip(variants)) {
            let Some((_, pipeline)) = self.variants.iter().find(|(v, _)| v == variant) else { continue };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &paint.bind_group, &[]);
            pass.set_bind_group(3, self.prefilter.paint_group(k as usize), &[]);
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
    scene.check_paints(paints.len())?;
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

pub(super) fn pipeline_layout(gpu: &Gpu, groups: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("frame"),
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

/// A pass over all pixels of a target.
pub(super) fn full_screen(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    entry_point: &str,
    format: TextureFormat,
    constants: &[(&str, f64)],
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry_point),
        layout: Some(layout),
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
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

pub(super) fn begin<'a>(
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

/// Group 1 of a scene that is ready for rays.
fn scene_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    stage: &Stage<'_>,
    frame: &Uniform,
) -> Result<wgpu::BindGroup> {
    let [scene, tables] = scene::upload(gpu, stage)?;
    Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scene, frame, tables"),
        layout,
        entries: &[(0, &scene), (1, &frame.buffer), (3, &tables)]
            .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() }),
    }))
}

/// Group 1: scene, frame, tables of the scene.
fn scene_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding {
                3 => wgpu::BufferBindingType::Storage { read_only: true },
                _ => wgpu::BufferBindingType::Uniform,
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene, frame, tables"),
        entries: &[0, 1, 3].map(entry),
    })
}

/// Group 2: the kept geometry, the surroundings.
fn maps_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let geometry = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Uint,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let entries = [(0, geometry), (1, sampled(wgpu::TextureViewDimension::Cube)), (2, sampler)].map(entry);
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("maps"), entries: &entries })
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
