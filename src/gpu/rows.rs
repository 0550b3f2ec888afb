//! Colors of flakes along u, drawn beforehand: see `shaders/rows.wgsl`.

use super::device::Gpu;
use super::paint::GpuPaint;
use super::pass::pipeline_layout;
use wgpu::{BufferUsages, ShaderStages};

/// Bytes of a row: of the steps of a bin and level, and of what goes with them.
const ROW: u64 = 256 * 16;
/// Bytes of a number in the list of slices.
const WORD: u64 = 4;
/// Bytes of a texel of the color table and its neighbors.
const TEXEL: u64 = 32;
/// Texels that a workgroup fills.
const GROUP_TEXELS: u32 = 64;
/// Most workgroups along an axis.
const MOST_GROUPS: u32 = 1 << 15;

/// The pass that fills rows.
#[derive(Debug)]
pub(super) struct RowsPass {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// The rows of a paint.
#[derive(Debug)]
pub(super) struct Rows {
    pub buffer: wgpu::Buffer,
    /// The slices that they are of.
    filled: Vec<u32>,
    /// Of which paint they are, and of which version of it.
    paint: [u64; 2],
}

impl Rows {
    /// Of no paint yet.
    pub fn none(gpu: &Gpu) -> Self {
        Self::empty(gpu, ROW)
    }

    /// Of dark slices.
    fn empty(gpu: &Gpu, bytes: u64) -> Self {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        Self { buffer: gpu.empty_buffer("rows", bytes, usage), filled: Vec::new(), paint: [0; 2] }
    }

    /// Whether a paint can be drawn from rows: they are not too large, and bins lie in order.
    pub fn fit(paint: &GpuPaint) -> bool {
        bytes(paint) <= Gpu::STORAGE_BYTES && paint.bins_shrink()
    }

    /// Whether they are those of a paint as it is.
    pub fn are_of(&self, paint: &GpuPaint) -> bool {
        self.paint[1] == paint.version()
    }

    /// Whether slices were filled that a paint does not have, or another paint's.
    fn are_stale(&self, paint: &GpuPaint) -> bool {
        let is_there = |slice: &u32| paint.there().binary_search(slice).is_ok();
        self.paint[0] != paint.number() || !self.filled.iter().all(is_there)
    }
}

impl RowsPass {
    pub fn new(gpu: &Gpu, module: &wgpu::ShaderModule, paint_layout: &wgpu::BindGroupLayout) -> Self {
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("rows"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 4,
                visibility: ShaderStages::COMPUTE,
                ty: storage(false),
                count: None,
            }],
        });
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

    /// Fills the rows of a paint, in a buffer of their own where they have another size: whether that is another.
    pub fn fill(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        paint: &GpuPaint,
        rows: &mut Rows,
    ) -> bool {
        let moves = rows.buffer.size() != bytes(paint);
        if moves {
            *rows = Rows::empty(gpu, bytes(paint));
        }
        if rows.are_stale(paint) {
            // Corners without a slice stay dark.
            encoder.clear_buffer(&rows.buffer, 0, Some(first_texel(paint)));
        }
        let slices = paint.there();
        if rows.paint[0] != paint.number() || rows.filled != slices {
            rows.filled = slices.to_vec();
            let list = [&[slices.len() as u32], slices].concat();
            gpu.write_words(&rows.buffer, first_number(paint) / WORD, &list);
        }
        rows.paint = [paint.number(), paint.version()];
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("rows"),
            layout: &self.layout,
            entries: &[wgpu::BindGroupEntry { binding: 4, resource: rows.buffer.as_entire_binding() }],
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &paint.bind_group, &[]);
        pass.set_bind_group(3, &group, &[]);
        let groups = slices.len() as u32 + paint.color_texels().div_ceil(GROUP_TEXELS);
        let columns = groups.clamp(1, MOST_GROUPS);
        pass.dispatch_workgroups(columns, groups.div_ceil(columns), 1);
        moves
    }
}

/// Where texels begin, bytes: behind rows.
fn first_texel(paint: &GpuPaint) -> u64 {
    u64::from(paint.drawn_slices()) * ROW
}

/// Where the list of slices begins, bytes: their number, then theirs.
fn first_number(paint: &GpuPaint) -> u64 {
    first_texel(paint) + u64::from(paint.color_texels()) * TEXEL
}

fn bytes(paint: &GpuPaint) -> u64 {
    (first_number(paint) + WORD * (1 + u64::from(paint.drawn_slices()))).next_multiple_of(16).max(ROW)
}

/// The binding by which frames read the rows of a paint.
pub(super) fn storage(read_only: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only },
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}
