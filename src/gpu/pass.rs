//! Passes over all pixels of a texture.

use super::device::Gpu;
use wgpu::{TextureFormat, TextureUsages, TextureView};

pub(super) fn pipeline_layout(gpu: &Gpu, groups: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("frame"),
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

/// A pass over all pixels of its targets.
pub(super) fn full_screen(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    entry_point: &str,
    formats: &[TextureFormat],
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
            targets: &formats.iter().map(|format| Some((*format).into())).collect::<Vec<_>>(),
        }),
        multiview_mask: None,
        cache: None,
    })
}

pub(super) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    views: &[&TextureView],
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    let attachment =
        |view| Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("frame"),
        color_attachments: &views.iter().map(|view| attachment(view)).collect::<Vec<_>>(),
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
