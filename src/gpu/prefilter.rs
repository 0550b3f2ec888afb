//! Maps by which a frame knows the surroundings: see `shaders/prefilter.wgsl`.

use super::device::Gpu;
use super::paint::GpuPaint;
use super::pass::{begin, full_screen, pipeline_layout, texture};
use super::rows::{Rows, RowsPass, storage};
use crate::scene::{Camera, Environment, LampPoint, LampPoints, Scene, Surroundings};
use glam::Vec3;
use wgpu::{ShaderStages, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor};

/// Of all maps: floats that can be filtered and drawn into everywhere.
const FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Texels along an edge of the cube, a power of two: 0.7 degrees wide.
const SIDE: u32 = 128;
/// As in the shader.
const NORMALS: u32 = 40;
const WORKGROUP: u32 = 8;
/// Largest radiance of a map, with room to 65504 for what a paint makes of it.
const MOST: f32 = 1e4;
/// Angle between directions to the eye for which scattered light is kept, degrees, and most of them a side.
const NODE_DEG: f64 = 12.0;
const MOST_NODES: u32 = 5;

/// The maps of the surroundings, and the passes that fill them.
#[derive(Debug)]
pub(super) struct Prefilter {
    /// The finest level of either cube.
    finest: [wgpu::ComputePipeline; 2],
    coarser: wgpu::ComputePipeline,
    scattered: wgpu::RenderPipeline,
    rows: RowsPass,
    levels_layout: wgpu::BindGroupLayout,
    paint_layout: wgpu::BindGroupLayout,
    /// The surroundings, all of them and what is no lamp.
    cubes: [wgpu::Texture; 2],
    /// What is: a column a point.
    lamps: wgpu::Texture,
    pub sampler: wgpu::Sampler,
    /// What the cubes show, and how often that has changed.
    environment: Option<Environment>,
    version: u64,
    /// One a paint, in the order in which they are drawn.
    maps: Vec<PaintMaps>,
}

/// What is known of a paint beforehand.
#[derive(Debug)]
struct PaintMaps {
    key: ScatteredKey,
    /// What it scatters, for normals all over the hemisphere and a few directions to the eye.
    scattered: wgpu::Texture,
    rows: Rows,
    group: wgpu::BindGroup,
}

/// What a map hangs on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ScatteredKey {
    paint: u64,
    environment: u64,
    camera: Camera,
    size: [usize; 2],
}

impl Prefilter {
    pub fn new(
        gpu: &Gpu,
        module: &wgpu::ShaderModule,
        [paint, scene, maps]: [&wgpu::BindGroupLayout; 3],
    ) -> Self {
        let (levels_layout, paint_layout) = (levels_layout(gpu), paint_layout(gpu));
        let compute = |entry_point, groups: &[Option<&wgpu::BindGroupLayout>]| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&pipeline_layout(gpu, groups)),
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let levels = [None, Some(scene), Some(&levels_layout)];
        let scattering = pipeline_layout(gpu, &[Some(paint), Some(scene), Some(maps)]);
        Self {
            finest: ["finest_environment", "finest_dim"].map(|entry_point| compute(entry_point, &levels)),
            coarser: compute("coarser_environment", &levels),
            rows: RowsPass::new(gpu, module, paint),
            scattered: full_screen(gpu, module, &scattering, "scattered_frame", &[FORMAT], &[]),
            levels_layout,
            paint_layout,
            cubes: [cube(gpu), cube(gpu)],
            lamps: lamps(gpu),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("maps"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
            environment: None,
            version: 0,
            maps: Vec::new(),
        }
    }

    /// The surroundings as cubes, all levels: all of them, and what is no lamp; the points of lamps.
    pub fn views(&self) -> [TextureView; 3] {
        let view = |texture: &wgpu::Texture, dimension| {
            let dimension = Some(dimension);
            texture.create_view(&TextureViewDescriptor { dimension, ..Default::default() })
        };
        let cube = wgpu::TextureViewDimension::Cube;
        let [all, dim] = &self.cubes;
        [view(all, cube), view(dim, cube), view(&self.lamps, wgpu::TextureViewDimension::D2)]
    }

    /// Layout of the group of a paint's maps.
    pub fn paint_layout(&self) -> &wgpu::BindGroupLayout {
        &self.paint_layout
    }

    /// The group of the maps of the paint drawn as number `paint`.
    pub fn paint_group(&self, paint: usize) -> Option<&wgpu::BindGroup> {
        self.maps.get(paint).map(|map| &map.group)
    }

    /// The rows of the paint drawn as number `paint`.
    pub fn rows(&self, paint: usize) -> Option<&wgpu::Buffer> {
        self.maps.get(paint).map(|map| &map.rows.buffer)
    }

    /// Memory on the GPU, bytes.
    pub fn bytes(&self) -> u64 {
        let texels = |t: &wgpu::Texture| u64::from(t.width()) * u64::from(t.height());
        let cube: u64 = (0..SIDE.ilog2() + 1).map(|level| 6 * 8 * u64::from(SIDE >> level).pow(2)).sum();
        2 * cube
            + self.maps.iter().map(|map| 8 * texels(&map.scattered) + map.rows.buffer.size()).sum::<u64>()
    }

    /// Brings all maps up to date. `lamps`: of the scene's surroundings. `scene_group`, `maps_group`: groups 1 and 2 of the shading
    /// passes.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene: &Scene,
        lamps: &LampPoints,
        paints: &[&GpuPaint],
        [scene_group, maps_group]: [&wgpu::BindGroup; 2],
    ) {
        if self.environment.as_ref() != Some(&scene.environment) {
            for (cube, finest) in self.cubes.iter().zip(&self.finest) {
                self.fill_cube(gpu, encoder, scene_group, cube, finest);
            }
            self.fill_lamps(gpu, lamps);
            self.environment = Some(scene.environment.clone());
            self.version += 1;
        }
        for (k, paint) in paints.iter().enumerate() {
            let key = ScatteredKey {
                paint: paint.version(),
                environment: self.version,
                camera: scene.camera,
                size: scene.size,
            };
            if self.maps.get(k).is_some_and(|map| map.key == key) {
                continue;
            }
            let size = node_count(scene).map(|n| n * NORMALS);
            let map = &mut self.maps[k];
            map.key = key;
            if [map.scattered.width(), map.scattered.height()] != size {
                map.scattered = scattered(gpu, size);
                map.group = paint_group(gpu, &self.paint_layout, &map.scattered, &map.rows);
            }
            let view = map.scattered.create_view(&TextureViewDescriptor::default());
            let mut pass = begin(encoder, &[&view], wgpu::LoadOp::Clear(wgpu::Color::BLACK));
            pass.set_pipeline(&self.scattered);
            pass.set_bind_group(0, &paint.bind_group, &[]);
            pass.set_bind_group(1, scene_group, &[]);
            pass.set_bind_group(2, maps_group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Holds nothing for filled any more.
    pub fn forget(&mut self) {
        self.environment = None;
        self.maps.clear();
    }

    /// Makes sure that so many paints have maps, filled or not.
    pub fn reserve(&mut self, gpu: &Gpu, paints: usize) {
        for _ in self.maps.len()..paints {
            let key = ScatteredKey { paint: 0, environment: 0, camera: Camera::default(), size: [0; 2] };
            let (scattered, rows) = (scattered(gpu, [1; 2]), Rows::none(gpu));
            let group = paint_group(gpu, &self.paint_layout, &scattered, &rows);
            self.maps.push(PaintMaps { key, scattered, rows, group });
        }
    }

    /// Brings the rows of all paints that have room for them up to date; maps are reserved.
    pub fn update_rows(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, paints: &[&GpuPaint]) {
        for (map, paint) in self.maps.iter_mut().zip(paints) {
            let is_stale = Rows::fit(paint) && !map.rows.are_of(paint);
            if is_stale && self.rows.fill(gpu, encoder, paint, &mut map.rows) {
                map.group = paint_group(gpu, &self.paint_layout, &map.scattered, &map.rows);
            }
        }
    }

    fn fill_lamps(&self, gpu: &Gpu, lamps: &LampPoints) {
        let texel = |v: Vec3, w: f32| v.extend(w).to_array().map(f32::to_le_bytes).concat();
        let row = |of: &dyn Fn(&LampPoint) -> Vec<u8>| {
            let dark = vec![0; 16 * (LampPoints::MOST - lamps.points.len())];
            [lamps.points.iter().flat_map(of).collect(), dark].concat()
        };
        let rows = [row(&|p| texel(p.direction, p.luminance)), row(&|p| texel(p.light, 0.0))].concat();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(16 * self.lamps.width()),
            rows_per_image: None,
        };
        gpu.queue.write_texture(self.lamps.as_image_copy(), &rows, layout, self.lamps.size());
    }

    fn fill_cube(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene_group: &wgpu::BindGroup,
        cube: &wgpu::Texture,
        finest: &wgpu::ComputePipeline,
    ) {
        let view = |level: u32| {
            cube.create_view(&TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        for level in 0..=SIDE.ilog2() {
            // The finest level is filled from none; what is bound as its finer one is not read.
            let (finer, own) = (view(if level == 0 { 1 } else { level - 1 }), view(level));
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("levels of the surroundings"),
                layout: &self.levels_layout,
                entries: &[(0, &finer), (1, &own)].map(|(binding, view)| wgpu::BindGroupEntry {
                    binding,
                    resource: wgpu::BindingResource::TextureView(view),
                }),
            });
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(if level == 0 { finest } else { &self.coarser });
            pass.set_bind_group(1, scene_group, &[]);
            pass.set_bind_group(2, &group, &[]);
            let groups = (SIDE >> level).div_ceil(WORKGROUP);
            pass.dispatch_workgroups(groups, groups, 6);
        }
    }
}

/// Columns and rows of the directions to the eye for which scattered light is kept.
pub(super) fn node_count(scene: &Scene) -> [u32; 2] {
    let tangent = (0.5 * scene.camera.vertical_fov_deg.to_radians()).tan();
    let [width, height] = scene.size.map(|n| n as f64);
    [tangent * width / height, tangent].map(|t| {
        let angle = 2.0 * t.atan().to_degrees();
        ((angle / NODE_DEG).ceil() as u32 + 1).clamp(2, MOST_NODES)
    })
}

/// What radiance is multiplied with in maps, so that half floats hold it.
pub(super) fn map_scale(surroundings: &Surroundings) -> f32 {
    let gradient = surroundings.gradient.iter().map(|c| c.max_element()).fold(0.0, f32::max);
    let most = surroundings.lamps.iter().fold(gradient, |sum, lamp| sum + lamp.radiance.max_element());
    let panorama = surroundings.panorama.iter().flat_map(|p| &p.texels);
    let most = panorama.fold(most, |most, ([r, g, b], _)| most.max(*r).max(*g).max(*b));
    (MOST / most.max(1e-6)).min(1.0)
}

fn cube(gpu: &Gpu) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("surroundings"),
        size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 6 },
        mip_level_count: SIDE.ilog2() + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Group 2 of the passes that fill the cube: a level, and the one that is made of it.
fn levels_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let view_dimension = wgpu::TextureViewDimension::D2Array;
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("levels of the surroundings"),
        entries: &[
            entry(0, sampled(view_dimension)),
            entry(
                1,
                wgpu::BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::WriteOnly,
                    format: FORMAT,
                    view_dimension,
                },
            ),
        ],
    })
}

/// Group 3: the maps of a paint.
fn paint_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let entries = [(0, sampled(wgpu::TextureViewDimension::D2)), (3, storage(true))].map(entry);
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("maps of a paint"),
        entries: &entries,
    })
}

fn paint_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    scattered: &wgpu::Texture,
    rows: &Rows,
) -> wgpu::BindGroup {
    let view = scattered.create_view(&TextureViewDescriptor::default());
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("maps of a paint"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
            wgpu::BindGroupEntry { binding: 3, resource: rows.buffer.as_entire_binding() },
        ],
    })
}

fn lamps(gpu: &Gpu) -> wgpu::Texture {
    let usage = TextureUsages::COPY_DST | TextureUsages::TEXTURE_BINDING;
    texture(gpu, "lamps", TextureFormat::Rgba32Float, [LampPoints::MOST as u32, 2], usage)
}

fn scattered(gpu: &Gpu, size: [u32; 2]) -> wgpu::Texture {
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    texture(gpu, "scattered", FORMAT, size, usage)
}

/// A texture of floats that are filtered.
pub(super) fn sampled(view_dimension: wgpu::TextureViewDimension) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension,
        multisampled: false,
    }
}
