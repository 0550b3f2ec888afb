//! A mix on the GPU: any weights give a paint, in place. The twin of [`Mix::blend_with`], in f32.

use super::constituents::{OwnSlice, paint_of};
use super::device::Gpu;
use super::mix_tables::{ArcBits, MixTables};
use super::paint::{GpuPaint, Header, Tables};
use super::patterns::{Patterns, Weights};
use super::shader::realize_source;
use super::uniform::Uniform;
use super::view::View;
use crate::brdf::ColorTable;
use crate::btf::CellSet;
use crate::color::lab_from_rgb;
use crate::error::Result;
use crate::mix::{BlendOptions, Channels, Constituent, Mix, Path};
use crate::render::{FlakeLayout, RenderCoat, RenderPaint};
use crate::scene::Scene;
use encase::ShaderType;
use glam::{DVec3, Vec4};
use std::array::from_fn;
use wgpu::{BufferBindingType, ShaderStages};

/// A [`Mix`] on the GPU, the paint that it becomes, and the paints that it is made of.
#[derive(Debug)]
pub struct GpuMix {
    /// Without flakes and color tables: its blends are made on the CPU.
    smooth: Mix,
    paint: GpuPaint,
    constituents: Vec<GpuPaint>,
    header: Header,
    blend: Uniform,
    constants: Constants,
    patterns: Patterns,
    /// Slices; colors.
    passes: [Pass; 2],
    /// Weights, slices, moments.
    common: wgpu::BindGroup,
    /// What is planned, patterns, arcs.
    arcs: wgpu::Buffer,
    /// Names and sizes of its own buffers, bytes.
    parts: Vec<(&'static str, u64)>,
    current: Option<(Vec<f64>, BlendOptions)>,
    /// Whether slices are there at the current weights; none: left out of the mix.
    there: Vec<Option<bool>>,
    /// None without flakes.
    layout: Option<FlakeLayout>,
    /// Of the last frame that was realized for.
    view: Option<View>,
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
    patterns: u32,
    pattern_words: u32,
    bits: ArcBits,
}

/// Most workgroups along an axis.
const MOST_GROUPS: u32 = 1 << 15;
/// As in the shader.
const WORKGROUP: u32 = 64;
const LEAVE_OUT: u32 = 1 << 31;

/// Twin of the struct of the shader; what its fields mean is said there.
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
    coarsest: u32,
    planned: u32,
    first_pattern: u32,
    pattern_words: u32,
    first_arc: u32,
    arc_words: u32,
    place_bits: u32,
    pattern_bits: u32,
    box_bits: u32,
}

impl GpuMix {
    /// Uploads a mix. Its paint is the blend at equal weights at first.
    ///
    /// # Errors
    /// As [`Mix::validate`]; a part that is too large for the GPU, what the driver complains about.
    pub fn new(gpu: &Gpu, mix: &Mix) -> Result<Self> {
        mix.validate()?;
        let paints = mix.constituents.len();
        let own: Vec<_> = (0..paints).map(|k| own_slices(mix, k)).collect();
        let rendered = own.iter().enumerate().map(|(k, own)| RenderPaint::new(&paint_of(mix, k, own)));
        let rendered: Vec<RenderPaint> = rendered.collect::<Result<_>>()?;
        let mut own_tables = rendered.iter().map(Tables::new).collect::<Result<Vec<_>>>()?;
        let (constituents, boxes) = Tables::upload_together(&mut own_tables, gpu)?;
        let tables = MixTables::new(mix, &own, &own_tables)?;
        let reserved = Tables::reserved(&rendered[0], tables.clusters());
        let paint = reserved.upload(gpu)?;
        let labs: Vec<[f32; 3]> = mix.constituents.iter().flat_map(|c| labs(&c.colors)).collect();
        let constants = Constants {
            colors: rendered[0].colors.texels().len() as u32,
            slices: tables.slices.len() as u32,
            level: rendered[0].flakes.as_ref().map_or(0, |f| f.means().len() as u32),
            patterns: tables.patterns.len() as u32,
            pattern_words: Patterns::words(paints) as u32,
            bits: tables.bits,
        };
        let equal = vec![1.0 / paints as f64; paints];
        let blend = Blend::new(&Weights::new(&equal), &BlendOptions::default(), mix.path, constants, 0);
        let blend = Uniform::new(gpu, "blend", &blend)?;
        let dynamic = (constants.first_pattern() + constants.patterns * constants.pattern_words) as usize;
        let arcs = [vec![0; dynamic], tables.arcs].concat();
        let buffers = [
            ("slices of the mix", gpu.storage("slices of the mix", &tables.slices)?),
            ("arcs", gpu.storage("arcs", &arcs)?),
            ("moments", gpu.storage("moments", &tables.moments)?),
            ("color tables", gpu.storage("color tables", &labs)?),
        ];
        let [slices, arcs, moments, labs] = buffers.each_ref().map(|(_, buffer)| buffer);
        let (common, passes) = passes(gpu, &blend, [slices, arcs, &boxes, moments, labs], &paint);
        gpu.check("mix")?;
        let mut mix = Self {
            smooth: without_flakes(mix),
            paint,
            constituents,
            header: reserved.header,
            blend,
            constants,
            patterns: tables.patterns,
            passes,
            common,
            arcs: arcs.clone(),
            parts: buffers.iter().map(|(name, b)| (*name, b.size())).collect(),
            current: None,
            there: tables.slices.iter().map(|slice| (slice.arcs() > 0).then_some(false)).collect(),
            layout: mix.flakes.as_ref().map(FlakeLayout::of_mix),
            view: None,
        };
        mix.realize(gpu, &equal, &BlendOptions::default())?;
        Ok(mix)
    }

    /// The paint at these weights, as [`Mix::blend_with`]: probabilities, corners, gains and offsets are those of the CPU up to f32's
    /// rounding and that of [`RenderPaint`]'s boxes; clusters that become alike stay apart, which no draw shows. Nothing is done where
    /// nothing changed.
    ///
    /// # Errors
    /// As [`Mix::blend_with`]; what the driver complains about.
    pub fn realize(&mut self, gpu: &Gpu, weights: &[f64], options: &BlendOptions) -> Result<&GpuPaint> {
        self.realize_wanted(gpu, weights, options, |_, _| true)
    }

    /// The same, but for flakes outside of `cells`: a slice at a level that is neither among them nor was realized at these weights
    /// before is left out, and not drawn. See [`crate::render::needed_cells`].
    ///
    /// # Errors
    /// As [`GpuMix::realize`].
    pub fn realize_cells(
        &mut self,
        gpu: &Gpu,
        weights: &[f64],
        options: &BlendOptions,
        cells: &CellSet,
    ) -> Result<&GpuPaint> {
        self.realize_wanted(gpu, weights, options, |level, slice| cells.contains(level, slice))
    }

    /// The same for frames of a scene of their size, in which objects wear the paint as number `worn`, or as any number without that: only
    /// flakes that a pixel draws from are realized, from the second time on that the scene stays as it was. While it changes, all are.
    ///
    /// # Errors
    /// As [`GpuMix::realize`] and [`crate::render::needed_cells`].
    pub fn realize_for(
        &mut self,
        gpu: &Gpu,
        weights: &[f64],
        options: &BlendOptions,
        scene: &Scene,
        worn: Option<usize>,
    ) -> Result<&GpuPaint> {
        let coat = RenderCoat::new(&self.smooth.blended_coat(weights, options)?);
        if let Some(layout) = &self.layout {
            self.view = Some(View::after(self.view.take(), scene, worn, &coat, layout)?);
        }
        match self.view.as_ref().and_then(View::cells).cloned() {
            Some(cells) => self.realize_cells(gpu, weights, options, &cells),
            None => self.realize(gpu, weights, options),
        }
    }

    fn realize_wanted(
        &mut self,
        gpu: &Gpu,
        weights: &[f64],
        options: &BlendOptions,
        is_wanted: impl Fn(usize, usize) -> bool,
    ) -> Result<&GpuPaint> {
        let is_same = self.current.as_ref().is_some_and(|(w, o)| w == weights && o == options);
        let (plan, there) = self.plan(is_same, is_wanted);
        if is_same && plan.is_empty() {
            return Ok(&self.paint);
        }
        let smooth = match is_same {
            true => None,
            false => Some(RenderPaint::new(&self.smooth.blend_with(weights, options)?)?),
        };
        // Whatever fails from here on: nothing that is there counts.
        self.current = None;
        let weighed = Weights::new(weights);
        let blend = Blend::new(&weighed, options, self.smooth.path, self.constants, plan.len() as u32);
        self.blend.set(gpu, &blend)?;
        gpu.write_words(&self.arcs, 0, &plan);
        if let Some(smooth) = &smooth {
            self.paint.set_smooth(gpu, smooth, &self.header)?;
            let patterns = self.patterns.at(&weighed, blend.is_hybrid != 0);
            gpu.write_words(&self.arcs, u64::from(self.constants.first_pattern()), &patterns);
        }
        self.run(gpu, plan.len() as u32, smooth.is_some());
        self.there = there;
        let slices = (0..).zip(&self.there).filter(|(_, is_there)| **is_there == Some(true));
        self.paint.touch(slices.map(|(number, _)| number).collect());
        gpu.check("blend")?;
        self.current = Some((weights.to_vec(), *options));
        Ok(&self.paint)
    }

    /// Slices to be realized and to be left out, and what is there then; `is_same`: at the weights of what is there.
    fn plan(&self, is_same: bool, is_wanted: impl Fn(usize, usize) -> bool) -> (Vec<u32>, Vec<Option<bool>>) {
        let level = self.constants.level as usize;
        let mut plan = Vec::new();
        let after = |(number, was): (usize, &Option<bool>)| {
            let was = (*was)?;
            let is_wanted = is_wanted(number / level, number % level);
            if is_wanted && !(is_same && was) {
                plan.push(number as u32);
            } else if was && !is_same {
                plan.push(number as u32 | LEAVE_OUT);
            }
            Some(is_wanted || (is_same && was))
        };
        let there = self.there.iter().enumerate().map(after).collect();
        (plan, there)
    }

    /// Submits the passes: so many slices, and colors if they change.
    fn run(&self, gpu: &Gpu, planned: u32, colors: bool) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let columns = planned.min(MOST_GROUPS);
        let texels = if colors { self.constants.colors + self.constants.level } else { 0 };
        let sizes = [[columns, planned.div_ceil(columns.max(1))], [texels.div_ceil(WORKGROUP), 1]];
        pass.set_bind_group(0, &self.common, &[]);
        for (Pass { pipeline, group }, [x, y]) in
            self.passes.iter().zip(sizes).filter(|(_, size)| size[0] > 0)
        {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(1, group, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }

    /// The paint at the last weights.
    pub fn paint(&self) -> &GpuPaint {
        &self.paint
    }

    /// The paints of the mix by themselves, in the form that they share; blends are made of their boxes, which lie here once.
    pub fn constituents(&self) -> &[GpuPaint] {
        &self.constituents
    }

    /// Memory on the GPU, bytes: its paint and those that it is made of included.
    pub fn bytes(&self) -> u64 {
        let paints = self.constituents.iter().chain([&self.paint]).map(GpuPaint::bytes).sum::<u64>();
        paints + self.blend.buffer.size() + self.parts.iter().map(|(_, bytes)| bytes).sum::<u64>()
    }

    /// Names and sizes of what it keeps besides paints, bytes.
    pub fn parts(&self) -> &[(&'static str, u64)] {
        &self.parts
    }
}

impl Constants {
    /// Of the words of arcs: behind the plan.
    fn first_pattern(&self) -> u32 {
        self.slices
    }
}

/// Slices of one paint, level by level.
fn own_slices(mix: &Mix, paint: usize) -> Vec<Vec<OwnSlice>> {
    let levels = mix.flakes.iter().flat_map(|flakes| &flakes.levels);
    levels.map(|level| level.slices.iter().map(|slice| OwnSlice::of(slice, paint)).collect()).collect()
}

/// The mix whose blends are cheap: what the GPU blends is left out.
fn without_flakes(mix: &Mix) -> Mix {
    let plain = |c: &Constituent| Constituent { colors: ColorTable::white(), ..c.clone() };
    Mix { constituents: mix.constituents.iter().map(plain).collect(), flakes: None, ..*mix }
}

fn labs(colors: &ColorTable) -> impl Iterator<Item = [f32; 3]> {
    colors.texels().iter().map(|c| lab_from_rgb(DVec3::from(c.map(f64::from))).as_vec3().to_array())
}

impl Blend {
    fn new(
        weights: &Weights,
        options: &BlendOptions,
        path: Path,
        constants: Constants,
        planned: u32,
    ) -> Self {
        let path = options.path.unwrap_or(path);
        let Weights { all, shares, beyond } = weights;
        let four = |k: usize| match all.get(k) {
            Some(weight) => Vec4::new(*weight as f32, shares[k] as f32, beyond[k] as f32, 0.0),
            None => Vec4::ZERO,
        };
        let is_alone = all.iter().filter(|w| **w != 0.0).count() == 1;
        let keeps_contrast = path != Path::Transport && !is_alone;
        let Constants { colors, slices, level, patterns, pattern_words, bits } = constants;
        let first_pattern = constants.first_pattern();
        Self {
            weights: from_fn(four),
            paints: all.len() as u32,
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
            colors,
            slices,
            coarsest: slices - level,
            planned,
            first_pattern,
            pattern_words,
            first_arc: first_pattern + patterns * pattern_words,
            arc_words: bits.words,
            place_bits: bits.place,
            pattern_bits: bits.pattern,
            box_bits: bits.of_box,
        }
    }
}

/// What all passes share; the passes that realize slices, and the color table with the slices' means.
fn passes(
    gpu: &Gpu,
    blend: &Uniform,
    inputs: [&wgpu::Buffer; 5],
    paint: &GpuPaint,
) -> (wgpu::BindGroup, [Pass; 2]) {
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("realize"),
        source: wgpu::ShaderSource::Wgsl(realize_source().into()),
    });
    let [mix_slices, arcs, boxes, moments, labs] = inputs;
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
    }
}
