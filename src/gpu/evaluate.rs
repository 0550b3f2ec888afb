//! The BRDF of many queries at once, to compare and to measure.

use super::device::Gpu;
use super::paint::{GpuPaint, bind_group_layout};
use super::scene::random_side;
use super::shader::evaluate_source;
use crate::error::{Error, Result};
use crate::render::{Disc, Surface};
use encase::internal::WriteInto;
use encase::{ShaderSize, ShaderType, StorageBuffer};
use glam::{Vec2, Vec3};
use wgpu::BufferUsages;

/// What [`crate::render::shade()`] takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Query {
    /// Unit direction to the light, local frame.
    pub wi: Vec3,
    /// Unit direction to the eye.
    pub wo: Vec3,
    /// The patch of paint.
    pub surface: Surface,
    /// What blurs the gloss lobe ([`crate::render::gloss_widening`]).
    pub widening: f32,
}

/// A query whose flakes are given, as by [`crate::render::RenderFlakes::given_draws`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenQuery {
    /// Unit direction to the light, local frame.
    pub wi: Vec3,
    /// Unit direction to the eye.
    pub wo: Vec3,
    /// Which cluster, in (0, 1).
    pub u: f32,
    /// Where in its box, in (0, 1).
    pub inside: [f32; 3],
    /// Side of the one tap, texels, 1 or more.
    pub side: f32,
    /// What blurs the gloss lobe.
    pub widening: f32,
}

/// A query lit by a disc: what [`crate::render::disc_radiance()`] takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscQuery {
    /// The disc, local frame.
    pub disc: Disc,
    /// Unit direction to the eye.
    pub wo: Vec3,
    /// The patch of paint.
    pub surface: Surface,
    /// What blurs the gloss lobe.
    pub widening: f32,
}

/// The compute passes that evaluate queries.
#[derive(Debug)]
pub struct Evaluator {
    layout: wgpu::BindGroupLayout,
    drawn: wgpu::ComputePipeline,
    given: wgpu::ComputePipeline,
    disc: wgpu::ComputePipeline,
}

/// Queries a pass: 80 bytes each, below the largest storage buffer.
const CHUNK: usize = 1 << 20;
/// As in the shader.
const WORKGROUP: usize = 64;

impl Evaluator {
    /// Compiles the passes.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("evaluate"),
            source: wgpu::ShaderSource::Wgsl(evaluate_source().into()),
        });
        let layout = io_layout(gpu);
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("evaluate"),
            bind_group_layouts: &[Some(&bind_group_layout(gpu)), Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |entry_point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let [drawn, given, disc] = ["evaluate", "evaluate_given", "evaluate_disc"].map(pipeline);
        gpu.check("shader")?;
        Ok(Self { layout, drawn, given, disc })
    }

    /// BRDF of every query, linear Rec.709, 1/sr: the twin of [`crate::render::shade()`].
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn evaluate(&self, gpu: &Gpu, paint: &GpuPaint, queries: &[Query]) -> Result<Vec<Vec3>> {
        self.all(gpu, &self.drawn, paint, queries, |q| GpuQuery {
            wi: q.wi,
            widening: q.widening,
            wo: q.wo,
            surface: GpuSurface::new(&q.surface),
        })
    }

    /// BRDF of every query, its flakes given.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn evaluate_given(&self, gpu: &Gpu, paint: &GpuPaint, queries: &[GivenQuery]) -> Result<Vec<Vec3>> {
        self.all(gpu, &self.given, paint, queries, |q| GpuGivenQuery {
            wi: q.wi,
            widening: q.widening,
            wo: q.wo,
            u: q.u,
            inside: q.inside.into(),
            side: q.side,
        })
    }

    /// Radiance over irradiance of every query lit by a disc: the twin of [`crate::render::disc_radiance()`].
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn evaluate_discs(&self, gpu: &Gpu, paint: &GpuPaint, queries: &[DiscQuery]) -> Result<Vec<Vec3>> {
        self.all(gpu, &self.disc, paint, queries, |q| GpuDiscQuery {
            disc: GpuDisc { direction: q.disc.direction, sine: q.disc.sine },
            wo: q.wo,
            widening: q.widening,
            surface: GpuSurface::new(&q.surface),
        })
    }

    fn all<Q, G: ShaderSize + WriteInto>(
        &self,
        gpu: &Gpu,
        pipeline: &wgpu::ComputePipeline,
        paint: &GpuPaint,
        queries: &[Q],
        translate: impl Fn(&Q) -> G,
    ) -> Result<Vec<Vec3>> {
        let mut results = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(CHUNK) {
            let queries: Vec<G> = chunk.iter().map(&translate).collect();
            results.extend(self.chunk(gpu, pipeline, paint, &queries)?);
        }
        Ok(results)
    }

    fn chunk<G: ShaderSize + WriteInto>(
        &self,
        gpu: &Gpu,
        pipeline: &wgpu::ComputePipeline,
        paint: &GpuPaint,
        queries: &Vec<G>,
    ) -> Result<Vec<Vec3>> {
        let input = gpu.storage("queries", queries)?;
        let size = queries.len() as u64 * <[f32; 3]>::SHADER_SIZE.get();
        let output = gpu.empty_buffer("results", size, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let copy = gpu.empty_buffer("copy", size, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let io = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("queries and results"),
            layout: &self.layout,
            entries: &[(0, &input), (1, &output)]
                .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() }),
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &paint.bind_group, &[]);
        pass.set_bind_group(1, &io, &[]);
        pass.dispatch_workgroups(queries.len().div_ceil(WORKGROUP) as u32, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&output, 0, &copy, 0, size);
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read(&copy)?;
        let colors: Vec<[f32; 3]> = StorageBuffer::new(bytes)
            .create()
            .map_err(|e| Error::gpu(gpu.name(), "results", e, "as many as queries"))?;
        Ok(colors.into_iter().map(Vec3::from).collect())
    }
}

/// Group 1: queries, results.
fn io_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |(binding, read_only)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("queries and results"),
        entries: &[(0, true), (1, false)].map(entry),
    })
}

/// Twins of the structs of the shaders.
#[derive(Debug, Clone, ShaderType)]
struct GpuSurface {
    uv_mm: Vec2,
    chart: u32,
    seed: u32,
    footprint: [Vec2; 2],
    random: u32,
}

#[derive(Debug, Clone, ShaderType)]
struct GpuQuery {
    wi: Vec3,
    widening: f32,
    wo: Vec3,
    surface: GpuSurface,
}

#[derive(Debug, Clone, ShaderType)]
struct GpuGivenQuery {
    wi: Vec3,
    widening: f32,
    wo: Vec3,
    u: f32,
    inside: Vec3,
    side: f32,
}

#[derive(Debug, Clone, ShaderType)]
struct GpuDisc {
    direction: Vec3,
    sine: f32,
}

#[derive(Debug, Clone, ShaderType)]
struct GpuDiscQuery {
    disc: GpuDisc,
    wo: Vec3,
    widening: f32,
    surface: GpuSurface,
}

impl GpuSurface {
    fn new(surface: &Surface) -> Self {
        Self {
            uv_mm: surface.uv_mm,
            chart: surface.chart,
            seed: surface.seed,
            footprint: surface.footprint,
            random: random_side(surface.random),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;
    use crate::brdf::{ClearCoat, ColorTable};
    use crate::paint::Paint;
    use crate::render::RenderPaint;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<GpuSurface, _>("Surface");
        assert_same_layout::<GpuQuery, _>("Query");
        assert_same_layout::<GpuGivenQuery, _>("GivenQuery");
        assert_same_layout::<GpuDisc, _>("Disc");
        assert_same_layout::<GpuDiscQuery, _>("DiscQuery");
    }

    #[test]
    fn a_lost_device_is_an_error() {
        // `tests/gpu.rs` says loudly where there is none.
        let Ok(gpu) = Gpu::new(None) else { return };
        let paint = Paint {
            coat: ClearCoat::NONE,
            diffuse: 0.5,
            lobes: Vec::new(),
            colors: ColorTable::white(),
            flakes: None,
            provenance: serde_json::Value::Null,
        };
        let paint = RenderPaint::new(&paint).unwrap();
        let (evaluator, on_gpu) = (Evaluator::new(&gpu).unwrap(), GpuPaint::new(&gpu, &paint).unwrap());
        let query =
            GivenQuery { wi: Vec3::Z, wo: Vec3::Z, u: 0.5, inside: [0.5; 3], side: 1.0, widening: 0.0 };
        let seen = evaluator.evaluate_given(&gpu, &on_gpu, &[query]).unwrap();
        assert!((seen[0] - 0.5 * std::f32::consts::FRAC_1_PI).length() < 1e-6, "{seen:?}");
        assert_eq!(evaluator.evaluate_given(&gpu, &on_gpu, &[]).unwrap(), []);
        gpu.device.destroy();
        let lost = evaluator.evaluate_given(&gpu, &on_gpu, &[query]);
        assert!(matches!(lost, Err(Error::Gpu(_))), "{lost:?}");
        assert!(matches!(GpuPaint::new(&gpu, &paint), Err(Error::Gpu(_))));
    }
}
