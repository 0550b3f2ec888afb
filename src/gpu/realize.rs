//! A mix on the GPU: any weights give a paint, in place. The twin of [`Mix::blend_with`], in f32.

use super::device::Gpu;
use super::paint::{GpuPaint, Header, Tables};
use super::shader::realize_source;
use super::uniform::Uniform;
use crate::brdf::ColorTable;
use crate::cluster::{Cluster, SliceStatistics};
use crate::color::lab_from_rgb;
use crate::error::{Error, Result};
use crate::mix::{BlendOptions, Channels, Constituent, Mix, MixSlice, Path};
use crate::render::{Memory, RenderPaint};
use encase::ShaderType;
use glam::{DVec3, Vec4};
use std::array::from_fn;
use std::collections::HashMap;
use wgpu::{BufferBindingType, ShaderStages};

/// A [`Mix`] on the GPU, and the paint that it becomes.
#[derive(Debug)]
pub struct GpuMix {
    /// Without flakes and color tables: its blends are made on the CPU.
    smooth: Mix,
    paint: GpuPaint,
    header: Header,
    blend: Uniform,
    constants: Constants,
    /// Slices; colors.
    passes: [Pass; 2],
    /// Weights, slices, moments.
    common: wgpu::BindGroup,
    /// Names and sizes of its own buffers, bytes.
    parts: Vec<(&'static str, u64)>,
    current: Option<(Vec<f64>, BlendOptions)>,
}

/// A pipeline, and what it alone reads and writes.
#[derive(Debug)]
struct Pass {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// What does not hang on the weights.
#[derive(Debug, Clone, Copy)]
struct Constants {
    colors: u32,
    slices: u32,
    /// Of a level.
    level: u32,
    arc_words: u32,
}

/// Most workgroups along an axis.
const MOST_GROUPS: u32 = 1 << 15;
/// As in the shader.
const WORKGROUP: u32 = 64;

/// Twins of the structs of the shader; what their fields mean is said there.
#[derive(Debug, Clone, PartialEq, ShaderType)]
struct Blend {
    weights: [Vec4; *Mix::PAINTS.end()],
    paints: u32,
    source: u32,
    is_hybrid: u32,
    channels: u32,
    gain: u32,
    colors: u32,
    slices: u32,
    arc_words: u32,
    coarsest: u32,
}

#[derive(Debug, Clone, Default, ShaderType)]
struct GpuSlice {
    first_arc: u32,
    arcs: u32,
    first_cluster: u32,
    clusters: u32,
    first_part: u32,
    parts: u32,
    first_box: u32,
    first_moments: u32,
}

#[derive(Debug, Clone, ShaderType)]
struct PaintMoments {
    mean: [f32; 3],
    deviation: [f32; 3],
    gain: [f32; 3],
    lasting: f32,
    fading: [f32; 4],
}

/// Everything that a mix keeps on the GPU.
#[derive(Debug, Default)]
struct MixTables {
    slices: Vec<GpuSlice>,
    /// See the shader.
    arcs: Vec<u32>,
    boxes: Vec<[f32; 6]>,
    moments: Vec<PaintMoments>,
    clusters: u32,
    guide: u32,
}

impl GpuMix {
    /// Uploads a mix. Its paint is the blend at equal weights at first.
    ///
    /// # Errors
    /// As [`Mix::validate`]; a part that is too large for the GPU, what the driver complains about.
    pub fn new(gpu: &Gpu, mix: &Mix) -> Result<Self> {
        mix.validate()?;
        let paints = mix.constituents.len();
        let equal = vec![1.0 / paints as f64; paints];
        let first = RenderPaint::new(&mix.blend(&equal)?)?;
        let mut tables = MixTables::default();
        for slice in mix.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices) {
            tables.push(slice, paints)?;
        }
        let reserved = Tables::reserved(&first, tables.slices.iter().map(|s| s.clusters as usize));
        let paint = reserved.upload(gpu)?;
        let labs: Vec<[f32; 3]> = mix.constituents.iter().flat_map(|c| labs(&c.colors)).collect();
        let constants = Constants {
            colors: first.colors.texels().len() as u32,
            slices: tables.slices.len() as u32,
            level: first.flakes.as_ref().map_or(0, |f| f.means().len() as u32),
            arc_words: arc_words(paints) as u32,
        };
        let blend = Blend::new(&equal, &BlendOptions::default(), mix.path, constants);
        let blend = Uniform::new(gpu, "blend", &blend)?;
        let buffers = [
            ("slices of the mix", gpu.storage("slices of the mix", &tables.slices)?),
            ("arcs", gpu.storage("arcs", &tables.arcs)?),
            ("boxes", gpu.storage("boxes", &tables.boxes)?),
            ("moments", gpu.storage("moments", &tables.moments)?),
            ("color tables", gpu.storage("color tables", &labs)?),
        ];
        let (common, passes) = passes(gpu, &blend, &buffers, &paint);
        gpu.check("mix")?;
        let mut mix = Self {
            smooth: without_flakes(mix),
            paint,
            header: reserved.header,
            blend,
            constants,
            passes,
            common,
            parts: buffers.iter().map(|(name, b)| (*name, b.size())).collect(),
            current: None,
        };
        mix.realize(gpu, &equal, &BlendOptions::default())?;
        Ok(mix)
    }

    /// The paint at these weights, as [`Mix::blend_with`]: probabilities, corners, gains and offsets are those of the CPU up to f32's
    /// rounding; clusters that become alike stay apart, which no draw shows. Nothing is done where nothing changed.
    ///
    /// # Errors
    /// As [`Mix::blend_with`]; what the driver complains about.
    pub fn realize(&mut self, gpu: &Gpu, weights: &[f64], options: &BlendOptions) -> Result<&GpuPaint> {
        if self.current.as_ref().is_some_and(|(w, o)| w == weights && o == options) {
            return Ok(&self.paint);
        }
        let smooth = RenderPaint::new(&self.smooth.blend_with(weights, options)?)?;
        self.paint.set_smooth(gpu, &smooth, &self.header)?;
        self.blend.set(gpu, &Blend::new(weights, options, self.smooth.path, self.constants))?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let Constants { colors, slices, level, .. } = self.constants;
        let columns = slices.clamp(1, MOST_GROUPS);
        let sizes = [[columns, slices.div_ceil(columns)], [(colors + level).div_ceil(WORKGROUP), 1]];
        pass.set_bind_group(0, &self.common, &[]);
        for (Pass { pipeline, group }, [x, y]) in self.passes.iter().zip(sizes) {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, group, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        self.paint.touch();
        self.current = Some((weights.to_vec(), *options));
        gpu.check("blend")?;
        Ok(&self.paint)
    }

    /// The paint at the last weights.
    pub fn paint(&self) -> &GpuPaint {
        &self.paint
    }

    /// Memory on the GPU, its paint included, bytes.
    pub fn bytes(&self) -> u64 {
        self.paint.bytes() + self.blend.buffer.size() + self.parts.iter().map(|(_, bytes)| bytes).sum::<u64>()
    }

    /// Names and sizes of what it keeps besides its paint, bytes.
    pub fn parts(&self) -> &[(&'static str, u64)] {
        &self.parts
    }
}

/// The mix whose blends are cheap: what the GPU blends is left out.
fn without_flakes(mix: &Mix) -> Mix {
    let plain = |c: &Constituent| Constituent { colors: ColorTable::white(), ..c.clone() };
    Mix { constituents: mix.constituents.iter().map(plain).collect(), flakes: None, ..*mix }
}

fn labs(colors: &ColorTable) -> impl Iterator<Item = [f32; 3]> {
    colors.texels().iter().map(|c| lab_from_rgb(DVec3::from(c.map(f64::from))).as_vec3().to_array())
}

/// Words of an arc: four of its own, then a half word for its place and one for each paint's box.
fn arc_words(paints: usize) -> usize {
    4 + (1 + paints).div_ceil(2)
}

impl MixTables {
    fn push(&mut self, slice: &MixSlice, paints: usize) -> Result<()> {
        let arcs = slice.probabilities.len();
        let clusters: usize = slice.groups.iter().map(|g| g.count(paints)).sum();
        let parts = if arcs == 0 { 0 } else { clusters.next_power_of_two() as u32 };
        self.slices.push(GpuSlice {
            first_arc: (self.arcs.len() / arc_words(paints)) as u32,
            arcs: arcs as u32,
            first_cluster: self.clusters,
            clusters: clusters as u32,
            first_part: self.guide,
            parts,
            first_box: self.boxes.len() as u32,
            first_moments: self.moments.len() as u32,
        });
        self.clusters += clusters as u32;
        self.guide += parts.next_multiple_of(2);
        let vector = |v: DVec3| v.as_vec3().to_array();
        self.moments.extend((0..paints).map(|k| {
            let memory = Memory::of(&alone(slice, k));
            PaintMoments {
                mean: vector(slice.means[k]),
                deviation: vector(slice.deviations[k]),
                gain: slice.gains[k],
                lasting: memory.lasting,
                fading: memory.fading.to_array(),
            }
        }));
        self.push_arcs(slice, paints)
    }

    fn push_arcs(&mut self, slice: &MixSlice, paints: usize) -> Result<()> {
        let first_box = self.boxes.len();
        // Most arcs of a paint share a box.
        let mut numbers: HashMap<[u32; 6], usize> = HashMap::new();
        let (mut before, mut place) = (0.0f64, 0);
        for (k, (probability, groups)) in slice.probabilities.iter().zip(&slice.groups).enumerate() {
            let high = before as f32;
            let rest = (before - f64::from(high)) as f32;
            self.arcs.extend([high, rest, *probability as f32].map(f32::to_bits));
            self.arcs.push(groups.0);
            let mut halves = vec![place];
            for boxes in &slice.boxes {
                let corners: [f32; 6] = from_fn(|c| boxes[k][c / 3][c % 3]);
                let number = *numbers.entry(corners.map(f32::to_bits)).or_insert_with(|| {
                    self.boxes.push(corners);
                    self.boxes.len() - 1 - first_box
                });
                halves.push(number);
            }
            if let Some(number) = halves.iter().find(|n| **n > usize::from(u16::MAX)) {
                return Err(Error::gpu("mix", "boxes of a slice", number, "up to 65536"));
            }
            self.arcs.extend(
                halves.chunks(2).map(|pair| pair.iter().rev().fold(0, |word, n| word << 16 | *n as u32)),
            );
            before += probability;
            place += groups.count(paints);
        }
        Ok(())
    }
}

impl Blend {
    /// Legal weights.
    fn new(weights: &[f64], options: &BlendOptions, path: Path, constants: Constants) -> Self {
        let path = options.path.unwrap_or(path);
        let sum: f64 = weights.iter().sum();
        let above: f64 = weights.iter().map(|w| w.max(0.0)).sum();
        let four = |w: &f64| {
            let (weight, share) = (w / sum, w.max(0.0) / above);
            Vec4::new(weight as f32, share as f32, (weight - share) as f32, 0.0)
        };
        let is_alone = weights.iter().filter(|w| **w != 0.0).count() == 1;
        let keeps_contrast = path != Path::Transport && !is_alone;
        Self {
            weights: from_fn(|k| weights.get(k).map_or(Vec4::ZERO, four)),
            paints: weights.len() as u32,
            source: options.source as u32,
            is_hybrid: u32::from(path == Path::Hybrid),
            channels: match options.channels {
                Channels::All => 0,
                Channels::Lightness => 1,
                Channels::AllButLightness => 2,
                Channels::WhiteFlakes => 3,
            },
            gain: match options.channels {
                Channels::Lightness | Channels::AllButLightness => 0,
                Channels::All if keeps_contrast => 2,
                _ => 1,
            },
            colors: constants.colors,
            slices: constants.slices,
            arc_words: constants.arc_words,
            coarsest: constants.slices - constants.level,
        }
    }
}

/// A slice of one paint of a mix.
fn alone(slice: &MixSlice, paint: usize) -> SliceStatistics {
    let arcs = slice.probabilities.iter().zip(&slice.boxes[paint]);
    let clusters =
        arcs.map(|(probability, [min, max])| Cluster { probability: *probability, min: *min, max: *max });
    SliceStatistics { gain: slice.gains[paint], ..SliceStatistics::new(clusters.collect(), [0.0; 3]) }
}

/// What all passes share; the passes that realize slices, and the color table with the slices' means.
fn passes(
    gpu: &Gpu,
    blend: &Uniform,
    inputs: &[(&str, wgpu::Buffer); 5],
    paint: &GpuPaint,
) -> (wgpu::BindGroup, [Pass; 2]) {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("realize"),
        source: wgpu::ShaderSource::Wgsl(realize_source().into()),
    });
    let [mix_slices, arcs, boxes, moments, labs] = inputs.each_ref().map(|(_, buffer)| buffer);
    let [colors, slices, clusters, guide, ramps] = &paint.buffers;
    let (read, write) = ([true, false]).map(|read_only| BufferBindingType::Storage { read_only }).into();
    let common = layout(gpu, &[BufferBindingType::Uniform, read, read]);
    let pass = |entry_point, kinds: &[BufferBindingType], buffers: &[&wgpu::Buffer]| {
        let own = layout(gpu, kinds);
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry_point),
            bind_group_layouts: &[Some(&common), Some(&own)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Pass { pipeline, group: group(gpu, &own, buffers) }
    };
    let passes = [
        pass(
            "realize_slice",
            &[read, read, write, write, write, write],
            &[arcs, boxes, slices, clusters, guide, ramps],
        ),
        pass("realize_colors", &[read, write], &[labs, colors]),
    ];
    (group(gpu, &common, &[&blend.buffer, mix_slices, moments]), passes)
}

fn layout(gpu: &Gpu, kinds: &[BufferBindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(kinds)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("realize"), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

fn group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("realize"),
        layout,
        entries: &entries,
    })
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<Blend, _>("Blend");
        assert_same_layout::<GpuSlice, _>("MixSlice");
        assert_same_layout::<PaintMoments, _>("PaintMoments");
    }
}
