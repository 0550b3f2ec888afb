//! Other ways to draw a frame, to measure beside: `cargo bench --bench frame`. They draw lamps alone, encoded.

use super::device::Gpu;
use super::pass::{full_screen, pipeline_layout};
use super::prefilter::sampled;
use super::rows::storage;
use super::shader::rivals_source;
use crate::error::{Error, Result};
use half::f16;
use wgpu::{ShaderStages, TextureFormat, TextureUsages};

/// What is drawn instead of a paint.
#[derive(Debug)]
pub enum Rival<'a> {
    /// Lambert's law and one GGX lobe.
    Ggx,
    /// The paint's smooth part, its flakes from raw slices, filtered with up to so many samples along a long footprint, 1 to 16.
    Raw(&'a RawSlices, u16),
}

/// One object, whose coat mirrors no lamps.
const CONSTANTS: [(&str, f64); 2] = [("ALONE", 1.0), ("MIRRORS", 0.0)];

/// The slices of a flake BTF as an array of textures with all their levels.
#[derive(Debug)]
pub struct RawSlices {
    texture: wgpu::Texture,
}

impl RawSlices {
    const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

    /// Uploads square slices of `side` texels, a power of two; `texels` gives those of a slice, row-major, linear Rec.709, 1/sr.
    ///
    /// # Errors
    /// More slices than the GPU has layers; a slice of another size; what the driver complains about.
    pub fn new(
        gpu: &Gpu,
        side: u32,
        slices: u32,
        mut texels: impl FnMut(u32) -> Vec<[f32; 3]>,
    ) -> Result<Self> {
        let most = gpu.device.limits().max_texture_array_layers;
        if slices > most {
            return Err(Error::gpu(gpu.name(), "slices", slices, format!("up to {most}")));
        }
        let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: slices };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("raw slices"),
            size,
            mip_level_count: side.ilog2() + 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::FORMAT,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for slice in 0..slices {
            let mut level = texels(slice);
            if level.len() != (side * side) as usize {
                return Err(Error::invalid("raw slices", "texels", level.len(), format!("{}", side * side)));
            }
            for mip in 0..=side.ilog2() {
                write(gpu, &texture, slice, mip, &level);
                level = halved(&level, (side >> mip) as usize);
            }
        }
        gpu.check("raw slices")?;
        Ok(Self { texture })
    }

    /// Memory on the GPU, bytes.
    pub fn bytes(&self) -> u64 {
        let levels = 0..self.texture.mip_level_count();
        let texels: u64 = levels.map(|l| u64::from(self.texture.width() >> l).pow(2)).sum();
        8 * texels * u64::from(self.texture.depth_or_array_layers())
    }
}

/// What draws a rival.
#[derive(Debug)]
pub(super) struct RivalPass {
    pub pipeline: wgpu::RenderPipeline,
    /// Group 3 of raw slices: their textures, and rows for the color table.
    textures: Option<(wgpu::BindGroupLayout, wgpu::TextureView, wgpu::Sampler)>,
}

impl Rival<'_> {
    /// `layouts`: of paint, scene and maps.
    pub(super) fn compile(
        &self,
        gpu: &Gpu,
        [paint, scene, maps]: [&wgpu::BindGroupLayout; 3],
        format: TextureFormat,
    ) -> RivalPass {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("rivals"),
            source: wgpu::ShaderSource::Wgsl(rivals_source().into()),
        });
        let textures = match self {
            Self::Ggx => None,
            Self::Raw(slices, anisotropy) => {
                let view = slices.texture.create_view(&wgpu::TextureViewDescriptor::default());
                Some((raw_layout(gpu), view, sampler(gpu, *anisotropy)))
            }
        };
        let entry_point = if textures.is_some() { "raw_frame" } else { "ggx_frame" };
        let own = textures.as_ref().map(|(layout, ..)| layout);
        let layout = pipeline_layout(gpu, &[Some(paint), Some(scene), Some(maps), own]);
        let pipeline = full_screen(gpu, &module, &layout, entry_point, &[format], &CONSTANTS);
        RivalPass { pipeline, textures }
    }
}

impl RivalPass {
    /// Group 3, with the rows of the paint that it takes the place of.
    pub fn group(&self, gpu: &Gpu, rows: &wgpu::Buffer) -> Option<wgpu::BindGroup> {
        let (layout, view, sampler) = self.textures.as_ref()?;
        Some(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("raw slices"),
            layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(view) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(sampler) },
                wgpu::BindGroupEntry { binding: 3, resource: rows.as_entire_binding() },
            ],
        }))
    }
}

fn raw_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("raw slices"),
        entries: &[
            entry(1, sampled(wgpu::TextureViewDimension::D2Array)),
            entry(2, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            entry(3, storage(true)),
        ],
    })
}

fn sampler(gpu: &Gpu, anisotropy_clamp: u16) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("raw slices"),
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        anisotropy_clamp,
        ..Default::default()
    })
}

fn write(gpu: &Gpu, texture: &wgpu::Texture, slice: u32, mip: u32, texels: &[[f32; 3]]) {
    let half = |c: f32| f16::from_f32(c).to_le_bytes();
    let bytes: Vec<u8> = texels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0].map(half)).flatten().collect();
    let side = texture.width() >> mip;
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: mip,
            origin: wgpu::Origin3d { x: 0, y: 0, z: slice },
            aspect: wgpu::TextureAspect::All,
        },
        &bytes,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * side), rows_per_image: Some(side) },
        wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
    );
}

/// The next level: means of two by two texels.
fn halved(texels: &[[f32; 3]], side: usize) -> Vec<[f32; 3]> {
    let mean = |x: usize, y: usize| {
        let at = |dx, dy| texels[(2 * y + dy) * side + 2 * x + dx];
        [0, 1, 2].map(|c| 0.25 * (at(0, 0)[c] + at(1, 0)[c] + at(0, 1)[c] + at(1, 1)[c]))
    };
    (0..side / 2).flat_map(|y| (0..side / 2).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect()
}
