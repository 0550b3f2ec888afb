//! Frames in real time: one sample a pixel, drawn into a texture.
//!
//! First passes find what every pixel meets and how that lies; they run again only when camera, object or size change, and shadows
//! when lamps do, so that the cost of a frame does not hang on the scene. Then every paint shades the pixels that it covers.

mod kept;
mod options;
mod target;
mod variant;

use super::device::Gpu;
use super::paint::{self, GpuPaint};
use super::pass::{begin, full_screen, pipeline_layout};
use super::prefilter::{Prefilter, map_scale, node_count};
use super::rival::{Rival, RivalPass};
use super::scene::Tables;
use super::shader::frame_source;
use super::uniform::Uniform;
use crate::error::{Error, Result};
use crate::render::{Options, Stage};
use crate::scene::{Bodies, Environment, Scene, Surroundings};
use encase::ShaderType;
use glam::UVec2;
use kept::{Finder, Kept, lamps_a_layer};
pub use options::FrameOptions;
use target::encodes;
use variant::Variant;
use wgpu::{TextureFormat, TextureView};

/// Draws frames. One for each kind of texture that is drawn into; frames of one size should follow each other.
#[derive(Debug)]
pub struct FrameRenderer {
    format: TextureFormat,
    module: wgpu::ShaderModule,
    finder: Finder,
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
    around: Around,
    /// Meshes and panorama of that scene.
    tables: Tables,
    frame: Uniform,
    scene_group: wgpu::BindGroup,
    prefilter: Prefilter,
    kept: Option<Kept>,
    /// Drawn in place of paints.
    rival: Option<RivalPass>,
}

/// Surroundings ready for rays, and what maps of them are made with.
#[derive(Debug)]
struct Around {
    environment: Environment,
    surroundings: Surroundings,
    map_scale: f32,
}

impl Around {
    fn new(environment: Environment, surroundings: Surroundings) -> Self {
        let map_scale = map_scale(&surroundings);
        Self { environment, surroundings, map_scale }
    }
}

/// Twin of the struct of the shader.
#[derive(Debug, Clone, ShaderType)]
struct Frame {
    exposure: f32,
    sparkles: u32,
    nodes: UVec2,
    map_scale: f32,
    lamp_points: u32,
    lamps_a_layer: u32,
}

impl Frame {
    fn new(scene: &Scene, bodies: &Bodies, around: &Around, options: &FrameOptions) -> Self {
        Self {
            exposure: options.exposure_stops.exp2() as f32,
            sparkles: u32::from(options.flakes),
            nodes: node_count(scene).into(),
            map_scale: around.map_scale,
            lamp_points: around.surroundings.lamp_points().points.len() as u32,
            lamps_a_layer: lamps_a_layer(bodies) as u32,
        }
    }
}

impl FrameRenderer {
    /// Compiles the passes for targets of a format. Float formats get linear Rec.709 radiance times the exposure, sRGB and
    /// eight-bit formats the same clipped to [0, 1] and encoded.
    ///
    /// # Errors
    /// What the driver complains about: a format that cannot be drawn into.
    pub fn new(gpu: &Gpu, target_format: TextureFormat) -> Result<Self> {
        let (scene, options) = (Scene::default(), Options::default());
        let stage = Stage::new(&scene, &options)?;
        let around = Around::new(scene.environment.clone(), stage.surroundings.clone());
        let frame = Frame::new(&scene, &stage.bodies, &around, &FrameOptions::default());
        let frame = Uniform::new(gpu, "frame", &frame)?;
        let (paint_layout, scene_layout) = (paint::bind_group_layout(gpu), scene_layout(gpu));
        let tables = Tables::new(gpu, &stage)?;
        let scene_group = scene_group(gpu, &scene_layout, &tables.with(gpu, &stage)?, &frame);
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("frame"),
            source: wgpu::ShaderSource::Wgsl(frame_source().into()),
        });
        let finder = Finder::new(gpu, &module, &scene_layout);
        let maps_layout = finder.maps_layout();
        let entry_point = if encodes(target_format) { "encoded_beyond" } else { "linear_beyond" };
        let unpainted = pipeline_layout(gpu, &[None, Some(&scene_layout), Some(maps_layout)]);
        let beyond = full_screen(gpu, &module, &unpainted, entry_point, &[target_format], &[]);
        let prefilter = Prefilter::new(gpu, &module, [&paint_layout, &scene_layout, maps_layout]);
        let layouts = [&paint_layout, &scene_layout, maps_layout, prefilter.paint_layout()];
        let shading = pipeline_layout(gpu, &layouts.map(Some));
        gpu.check("shader")?;
        let mut renderer = Self {
            format: target_format,
            module,
            finder,
            shading,
            variants: Vec::new(),
            beyond,
            scene_layout,
            shown: None,
            bodies: stage.bodies,
            around,
            tables,
            frame,
            scene_group,
            prefilter,
            kept: None,
            rival: None,
        };
        renderer.compile(gpu, Variant::FIRST)?;
        Ok(renderer)
    }

    /// From now on draws what a rival draws of the first paint.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn draw_rival(&mut self, gpu: &Gpu, rival: &Rival) -> Result<()> {
        let (paint, maps) = (paint::bind_group_layout(gpu), self.finder.maps_layout());
        self.rival = Some(rival.compile(gpu, [&paint, &self.scene_layout, maps], self.format));
        gpu.check("rival")
    }

    /// Compiles a way of shading, unless that is done.
    fn compile(&mut self, gpu: &Gpu, variant: Variant) -> Result<()> {
        if self.variants.iter().any(|(v, _)| *v == variant) {
            return Ok(());
        }
        let entry_point = if encodes(self.format) { "encoded_frame" } else { "linear_frame" };
        let constants = variant.constants();
        let pass = full_screen(gpu, &self.module, &self.shading, entry_point, &[self.format], &constants);
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
            // None, if one of the steps fails.
            self.shown = None;
            self.bodies = self.bodies.changed(&scene)?;
            if self.around.environment != scene.environment {
                self.around = Around::new(scene.environment.clone(), scene.environment.surroundings()?);
            }
            let around = self.around.surroundings.clone();
            let stage = Stage::with(&scene, &render, self.bodies.clone(), around);
            if !self.tables.are_of(&stage) {
                self.tables = Tables::new(gpu, &stage)?;
            }
            let buffers = self.tables.with(gpu, &stage)?;
            self.scene_group = scene_group(gpu, &self.scene_layout, &buffers, &self.frame);
            self.shown = Some((scene.clone(), render));
        }
        self.frame.set(gpu, &Frame::new(&scene, &self.bodies, &self.around, options))?;
        let variants: Vec<_> =
            paints.iter().map(|paint| Variant::of(&scene, &self.bodies, options, paint)).collect();
        variants.iter().try_for_each(|variant| self.compile(gpu, *variant))?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut kept = match self.kept.take() {
            Some(kept) if kept.size == scene.size => kept,
            _ => self.finder.empty(gpu, scene.size, &self.prefilter),
        };
        self.finder.update(gpu, &mut encoder, &scene, &self.bodies, &self.scene_group, &mut kept);
        self.prefilter.reserve(gpu, paints.len());
        if self.rival.is_some() || variants.iter().any(|variant| variant.rows.is_some()) {
            self.prefilter.update_rows(gpu, &mut encoder, paints);
        }
        if variants.iter().any(|variant| variant.surroundings == variant::Surroundings::Maps) {
            let groups = [&self.scene_group, &kept.maps];
            self.prefilter.update(
                gpu,
                &mut encoder,
                &scene,
                self.around.surroundings.lamp_points(),
                paints,
                groups,
            );
        }
        match &self.rival {
            Some(rival) => self.shade_rival(gpu, &mut encoder, rival, paints[0], target, &kept),
            None => self.shade(&mut encoder, &variants, paints, options, target, &kept),
        }
        self.kept = Some(kept);
        gpu.queue.submit([encoder.finish()]);
        let drawn = gpu.check("frame");
        if drawn.is_err() {
            // What should have been filled may not be.
            self.kept = None;
            self.prefilter.forget();
        }
        drawn
    }

    /// Memory on the GPU besides paints, bytes: geometry, surroundings, what paints scatter of them.
    pub fn bytes(&self) -> u64 {
        self.kept.as_ref().map_or(0, Kept::bytes) + self.prefilter.bytes()
    }

    fn shade_rival(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        rival: &RivalPass,
        paint: &GpuPaint,
        target: &TextureView,
        kept: &Kept,
    ) {
        let group = self.prefilter.rows(0).and_then(|rows| rival.group(gpu, rows));
        let mut pass = begin(encoder, &[target], wgpu::LoadOp::Clear(wgpu::Color::BLACK));
        pass.set_bind_group(1, &self.scene_group, &[]);
        pass.set_bind_group(2, &kept.maps, &[]);
        pass.set_pipeline(&self.beyond);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&rival.pipeline);
        pass.set_bind_group(0, &paint.bind_group, &[]);
        if group.is_some() {
            pass.set_bind_group(3, group.as_ref(), &[]);
        }
        pass.draw(0..3, 0..1);
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
        let mut pass = begin(encoder, &[target], load);
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

/// Group 1 of a scene that is ready for rays.
fn scene_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    [scene, tables]: &[wgpu::Buffer; 2],
    frame: &Uniform,
) -> wgpu::BindGroup {
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scene, frame, tables"),
        layout,
        entries: &[(0, scene), (1, &frame.buffer), (3, tables)]
            .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() }),
    })
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

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<Frame, _>("Frame");
    }
}
