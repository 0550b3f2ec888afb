//! Colors of flakes along u, drawn beforehand: see `shaders/rows.wgsl`.

use super::device::Gpu;
use super::paint::GpuPaint;
use super::pass::{pipeline_layout, texture};
use super::prefilter::sampled;
use wgpu::{ShaderStages, TextureFormat, TextureUsages, TextureViewDescriptor, TextureViewDimension};

/// Steps of a row, as in the shader.
const ROW: u32 = 320;
const COLORS: TextureFormat = TextureFormat::Rgba16Float;
const SLICES: TextureFormat = TextureFormat::Rgba32Float;
/// Most workgroups along an axis.
const MOST_GROUPS: u32 = 1 << 15;

/// The pass that fills rows.
#[derive(Debug)]
pub(super) struct RowsPass {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// The rows of a paint, and what its slices have besides.
#[derive(Debug)]
pub(super) struct Rows {
    pub colors: wgpu::Texture,
    pub slices: wgpu::Texture,
    /// Of which version of the paint they are.
    version: u64,
}

impl Rows {
    /// Of no paint yet.
    pub fn none(gpu: &Gpu) -> Self {
        Self::empty(gpu, [1; 2])
    }

    /// Room for so many levels and slices a level.
    fn empty(gpu: &Gpu, [levels, slices]: [u32; 2]) -> Self {
        let map = |label, format, columns| {
            let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
            texture(gpu, label, format, [columns, slices], usage)
        };
        let (colors, slices) = (map("rows", COLORS, levels * ROW), map("slices", SLICES, levels * 2));
        Self { colors, slices, version: 0 }
    }

    /// Whether the rows of a paint fit into textures.
    pub fn fit(gpu: &Gpu, paint: &GpuPaint) -> bool {
        let [levels, slices] = paint.levels_and_slices();
        let most = gpu.device.limits().max_texture_dimension_2d;
        slices <= most && levels * ROW <= most
    }

    /// Whether they are those of a paint as it is.
    pub fn are_of(&self, paint: &GpuPaint) -> bool {
        self.version == paint.version()
    }

    /// Memory on the GPU, bytes.
    pub fn bytes(&self) -> u64 {
        let texels = |map: &wgpu::Texture| u64::from(map.width()) * u64::from(map.height());
        8 * texels(&self.colors) + 16 * texels(&self.slices)
    }
}

impl RowsPass {
    pub fn new(gpu: &Gpu, module: &wgpu::ShaderModule, paint_layout: &wgpu::BindGroupLayout) -> Self {
        let layout = layout(gpu);
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("fill_rows"),
            layout: Some(&pipeline_layout(gpu, &[Some(paint_layout), None, None, Some(&layout)])),
            module,
            entry_point: Some("fill_rows"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pipeline, layout }
    }

    /// Fills the rows of a paint, in textures of their own where they have another size: whether those are others.
    pub fn fill(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        paint: &GpuPaint,
        rows: &mut Rows,
    ) -> bool {
        let [levels, slices] = paint.levels_and_slices();
        let moves = [rows.colors.width(), rows.colors.height()] != [levels * ROW, slices];
        if moves {
            *rows = Rows::empty(gpu, [levels, slices]);
        }
        rows.version = paint.version();
        let views =
            [&rows.colors, &rows.slices].map(|map| map.create_view(&TextureViewDescriptor::default()));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("rows"),
            layout: &self.layout,
            entries: &[(4, &views[0]), (6, &views[1])].map(|(binding, view)| wgpu::BindGroupEntry {
                binding,
                resource: wgpu::BindingResource::TextureView(view),
            }),
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &paint.bind_group, &[]);
        pass.set_bind_group(3, &group, &[]);
        let columns = (levels * slices).clamp(1, MOST_GROUPS);
        pass.dispatch_workgroups(columns, (levels * slices).div_ceil(columns), 1);
        moves
    }
}

/// Group 3 of the pass.
fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |(binding, format)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::COMPUTE,
        ty: wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: TextureViewDimension::D2,
        },
        count: None,
    };
    let entries = [(4, COLORS), (6, SLICES)].map(entry);
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("rows"), entries: &entries })
}

/// Bindings by which frames read the rows of a paint.
pub(super) fn bindings() -> [(u32, wgpu::BindingType); 2] {
    let plain = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: TextureViewDimension::D2,
        multisampled: false,
    };
    [(3, sampled(TextureViewDimension::D2)), (5, plain)]
}
