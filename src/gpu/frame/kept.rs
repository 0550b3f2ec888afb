//! What is kept of pixels as long as camera and objects stay, and of their shadows as long as the lamps stay, too: see
//! `shaders/kept.wgsl`.

use super::variant::casts_shadows;
use crate::gpu::device::Gpu;
use crate::gpu::pass::{begin, full_screen, pipeline_layout, texture};
use crate::gpu::prefilter::{Prefilter, sampled};
use crate::scene::{Bodies, Camera, Form, Light, Object, Scene, Shape};
use wgpu::{TextureFormat, TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension};

/// Of the words of pixels, and of a layer of shadows.
const WORDS: TextureFormat = TextureFormat::Rgba32Uint;
const BITS: TextureFormat = TextureFormat::R8Uint;
/// Bytes of words of a pixel.
const PIXEL: u64 = 48;
/// Lamps that a layer has bits for.
const LAYER: usize = 8;
/// Most steps of loops of an invocation: Mesa's software renderer ends all of them after that many, without a word.
const MOST_STEPS: usize = 65_535;
/// Steps of the eight rays that it follows at a time through a mesh of some 100,000 triangles: boxes, and for each of them as many
/// triangles as the fullest holds.
const MESH_STEPS: usize = 3200;

/// The passes that find it.
#[derive(Debug)]
pub struct Finder {
    hits: wgpu::RenderPipeline,
    patches: wgpu::RenderPipeline,
    shadows: wgpu::RenderPipeline,
    /// Group 2 of the passes after the first: the hits alone.
    hits_layout: wgpu::BindGroupLayout,
    /// Group 2 of all others.
    maps_layout: wgpu::BindGroupLayout,
}

/// What is kept of pixels.
#[derive(Debug)]
pub struct Kept {
    pub size: [usize; 2],
    /// Of what; none: nothing yet.
    geometry: Option<Geometry>,
    /// Hits, normals, footprints.
    words: [TextureView; 3],
    hits: wgpu::BindGroup,
    /// Whose shadows are kept.
    lights: Option<Vec<Light>>,
    shadows: wgpu::Texture,
    /// The surroundings, for the group.
    around: ([TextureView; 3], wgpu::Sampler),
    /// Group 2 of the passes that shade.
    pub maps: wgpu::BindGroup,
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

/// How many lamps share a layer of shadows, which one invocation finds.
pub fn lamps_a_layer(bodies: &Bodies) -> usize {
    let meshes = bodies.iter().filter(|body| matches!(body.form, Form::Mesh(_))).count();
    (MOST_STEPS / (MESH_STEPS * meshes + Scene::MAX_OBJECTS)).clamp(1, LAYER)
}

impl Finder {
    pub fn new(gpu: &Gpu, module: &wgpu::ShaderModule, scene_layout: &wgpu::BindGroupLayout) -> Self {
        let hits_layout = layout(gpu, "hits", &[(0, words(TextureViewDimension::D2))]);
        let pass = |entry_point, hits, formats: &[TextureFormat]| {
            let layout = pipeline_layout(gpu, &[None, Some(scene_layout), hits]);
            full_screen(gpu, module, &layout, entry_point, formats, &[])
        };
        Self {
            hits: pass("hit_frame", None, &[WORDS]),
            patches: pass("patch_frame", Some(&hits_layout), &[WORDS; 2]),
            shadows: pass("shadow_frame", Some(&hits_layout), &[BITS]),
            hits_layout,
            maps_layout: maps_layout(gpu),
        }
    }

    /// Layout of the group of what is kept.
    pub fn maps_layout(&self) -> &wgpu::BindGroupLayout {
        &self.maps_layout
    }

    /// Brings up to date what is kept, its shadows if objects cast any.
    pub fn update(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene: &Scene,
        bodies: &Bodies,
        scene_group: &wgpu::BindGroup,
        kept: &mut Kept,
    ) {
        let geometry = Geometry::of(scene);
        if kept.geometry.as_ref() != Some(&geometry) {
            self.find_hits(encoder, scene_group, kept);
            kept.geometry = Some(geometry);
            kept.lights = None;
        }
        if casts_shadows(scene, bodies) && kept.lights.as_ref() != Some(&scene.lights) {
            let layers = scene.lights.len().div_ceil(lamps_a_layer(bodies)).max(1) as u32;
            kept.reserve_shadows(gpu, &self.maps_layout, layers);
            self.find_shadows(encoder, scene_group, kept, layers);
            kept.lights = Some(scene.lights.clone());
        }
    }

    fn find_hits(&self, encoder: &mut wgpu::CommandEncoder, scene_group: &wgpu::BindGroup, kept: &Kept) {
        let [hits, normals, footprints] = &kept.words;
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut pass = begin(encoder, &[hits], clear);
        pass.set_pipeline(&self.hits);
        pass.set_bind_group(1, scene_group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        let mut pass = begin(encoder, &[normals, footprints], clear);
        pass.set_pipeline(&self.patches);
        pass.set_bind_group(1, scene_group, &[]);
        pass.set_bind_group(2, &kept.hits, &[]);
        pass.draw(0..3, 0..1);
    }

    fn find_shadows(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        scene_group: &wgpu::BindGroup,
        kept: &Kept,
        layers: u32,
    ) {
        for layer in 0..layers {
            let view = kept.shadows.create_view(&TextureViewDescriptor {
                dimension: Some(TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let mut pass = begin(encoder, &[&view], wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT));
            pass.set_pipeline(&self.shadows);
            pass.set_bind_group(1, scene_group, &[]);
            pass.set_bind_group(2, &kept.hits, &[]);
            pass.draw(0..3, layer..layer + 1);
        }
    }

    /// Nothing yet, of frames of the size.
    pub fn empty(&self, gpu: &Gpu, size: [usize; 2], prefilter: &Prefilter) -> Kept {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let words = ["hits", "normals", "footprints"].map(|label| {
            let map = texture(gpu, label, WORDS, size.map(|n| n as u32), usage);
            map.create_view(&TextureViewDescriptor::default())
        });
        let hits = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("hits"),
            layout: &self.hits_layout,
            entries: &[entry(0, &words[0])],
        });
        let shadows = shadows(gpu, [1; 2], 1);
        let around = (prefilter.views(), prefilter.sampler.clone());
        let maps = maps(gpu, &self.maps_layout, &words, &shadows, &around);
        Kept { size, geometry: None, words, hits, lights: None, shadows, around, maps }
    }
}

impl Kept {
    /// Memory on the GPU, bytes.
    pub fn bytes(&self) -> u64 {
        let [width, height] = self.size.map(|n| n as u64);
        let layers = u64::from(self.shadows.depth_or_array_layers());
        PIXEL * width * height + u64::from(self.shadows.width()) * u64::from(self.shadows.height()) * layers
    }

    fn reserve_shadows(&mut self, gpu: &Gpu, layout: &wgpu::BindGroupLayout, layers: u32) {
        let size = self.size.map(|n| n as u32);
        let old = &self.shadows;
        if [old.width(), old.height()] != size || old.depth_or_array_layers() != layers {
            self.shadows = shadows(gpu, size, layers);
            self.maps = maps(gpu, layout, &self.words, &self.shadows, &self.around);
        }
    }
}

fn shadows(gpu: &Gpu, [width, height]: [u32; 2], layers: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shadows"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: BITS,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn maps(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    [hits, normals, footprints]: &[TextureView; 3],
    shadows: &wgpu::Texture,
    ([all, dim, lamps], sampler): &([TextureView; 3], wgpu::Sampler),
) -> wgpu::BindGroup {
    let dimension = Some(TextureViewDimension::D2Array);
    let shadows = shadows.create_view(&TextureViewDescriptor { dimension, ..Default::default() });
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("maps"),
        layout,
        entries: &[
            entry(0, hits),
            entry(1, all),
            wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(sampler) },
            entry(3, normals),
            entry(4, footprints),
            entry(5, &shadows),
            entry(6, dim),
            entry(7, lamps),
        ],
    })
}

fn entry(binding: u32, view: &TextureView) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) }
}

/// Group 2: what is kept, the surroundings.
fn maps_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let plain = words(TextureViewDimension::D2);
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let bits = words(TextureViewDimension::D2Array);
    let cube = sampled(TextureViewDimension::Cube);
    let lamps = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: TextureViewDimension::D2,
        multisampled: false,
    };
    let words = [(0, plain), (3, plain), (4, plain), (5, bits)];
    let around = [(1, cube), (2, sampler), (6, cube), (7, lamps)];
    layout(gpu, "maps", &[words, around].concat())
}

fn words(view_dimension: TextureViewDimension) -> wgpu::BindingType {
    let sample_type = wgpu::TextureSampleType::Uint;
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

fn layout(gpu: &Gpu, label: &str, bindings: &[(u32, wgpu::BindingType)]) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): &(u32, wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding: *binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: *ty,
        count: None,
    };
    let entries: Vec<_> = bindings.iter().map(entry).collect();
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}
