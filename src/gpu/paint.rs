//! A paint's tables in the layout of `shaders/shared/paint.wgsl`, and on the GPU.

use super::device::Gpu;
use super::uniform::Uniform;
use crate::brdf;
use crate::cluster::{self, Ramp, SliceStatistics};
use crate::error::{Error, Result};
use crate::paint::{MissingSlice, Paint};
use crate::render::{DrawnSlice, RenderFlakes, RenderPaint, pack_box, pack_ramp, unpack_box};
use crate::sampler::{GuideTable, Sampler};
use encase::{ShaderType, StorageBuffer};
use glam::{UVec2, UVec4, Vec3, Vec4};
use std::array::from_fn;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// A [`RenderPaint`] on the GPU.
#[derive(Debug)]
pub struct GpuPaint {
    pub(super) bind_group: wgpu::BindGroup,
    /// Its own however often it changes.
    number: u64,
    version: u64,
    /// Slices of all levels that were not left out, ascending.
    there: Vec<u32>,
    /// Whether the flakes' u follows the half vector; none: no flakes that sparkle.
    turns: Option<bool>,
    /// Slices of all levels that flakes are drawn from, and whether no row of their grid is longer than those before.
    drawn_slices: u32,
    bins_shrink: bool,
    /// Texels of the color table.
    color_texels: u32,
    /// Whether boxes may have bands between them.
    has_ramps: bool,
    /// Whether the coat mirrors lamps by themselves.
    mirrors: bool,
    header: Uniform,
    /// Color table and means, slices, clusters, guide tables, ramps.
    pub(super) buffers: [wgpu::Buffer; 5],
    /// Its own among the clusters of that buffer.
    clusters: Range<usize>,
    /// Names and sizes of its buffers.
    parts: Vec<(&'static str, u64)>,
}

impl GpuPaint {
    /// Uploads a paint.
    ///
    /// # Errors
    /// A part that is too large for the GPU, what the driver complains about.
    pub fn new(gpu: &Gpu, paint: &RenderPaint) -> Result<Self> {
        Self::upload(gpu, paint, true)
    }

    /// Uploads a paint whose flakes sparkle, or are seen with their mean only.
    pub(super) fn upload(gpu: &Gpu, paint: &RenderPaint, sparkles: bool) -> Result<Self> {
        let mut tables = Tables::new(paint)?;
        if !sparkles {
            tables.header.flakes.levels = 0;
        }
        tables.upload(gpu)
    }

    /// A paint of these buffers, in the order of their bindings.
    fn of_buffers(
        gpu: &Gpu,
        values: &Header,
        buffers: [(&'static str, wgpu::Buffer); 5],
        clusters: Range<usize>,
        there: Vec<u32>,
        has_ramps: bool,
    ) -> Result<Self> {
        let header = Uniform::new(gpu, "paint", values)?;
        let all = std::iter::once(&header.buffer).chain(buffers.iter().map(|(_, buffer)| buffer));
        let entries: Vec<_> = (0..)
            .zip(all)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let bind_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("paint"),
            layout: &bind_group_layout(gpu),
            entries: &entries,
        });
        gpu.check("paint")?;
        let mut parts = vec![("paint", header.buffer.size())];
        parts.extend(buffers.iter().map(|(name, b)| (*name, b.size())));
        // Of a buffer that paints share, its own part.
        parts[3].1 = Cluster::METADATA.min_size().get() * clusters.len().max(1) as u64;
        let buffers = buffers.map(|(_, buffer)| buffer);
        let FlakeLayout { levels, knots_per_unit, .. } = values.flakes;
        Ok(Self {
            bind_group,
            number: next_version(),
            version: next_version(),
            there,
            turns: (levels > 0).then_some(knots_per_unit > 0.0),
            drawn_slices: levels * values.flakes.slices_per_level,
            bins_shrink: values.flakes.bins_shrink(),
            color_texels: values.colors_size.element_product(),
            has_ramps,
            mirrors: values.coat.mirror > 0.0,
            parts,
            header,
            buffers,
            clusters,
        })
    }

    /// Gives the paint another smooth part; its flakes and the size of its color table stay, as in `kept`.
    pub(super) fn set_smooth(&mut self, gpu: &Gpu, paint: &RenderPaint, kept: &Header) -> Result<()> {
        let (flakes, colors_size) = (kept.flakes.clone(), kept.colors_size);
        let header = Header { flakes, colors_size, ..Header::new(paint) };
        self.mirrors = header.coat.mirror > 0.0;
        self.header.set(gpu, &header)?;
        Ok(())
    }

    /// The statistics that are there, slice by slice, finest level first, read back; bands are left out, and clusters that are never
    /// drawn.
    ///
    /// # Errors
    /// What the driver complains about.
    pub fn statistics(&self, gpu: &Gpu) -> Result<Vec<SliceStatistics>> {
        let [_, slices, clusters, ..] = &self.buffers;
        let complain = |e: encase::internal::Error| Error::gpu("paint", "layout", e, "what was written");
        let slices: Vec<Slice> = StorageBuffer::new(gpu.read_back(slices)?).create().map_err(complain)?;
        let clusters: Vec<Cluster> =
            StorageBuffer::new(gpu.read_back(clusters)?).create().map_err(complain)?;
        let end = |k: usize| slices.get(k + 1).map_or(self.clusters.end, |s| s.first_cluster as usize);
        let statistics = |(k, slice): (usize, &Slice)| match slice.guide {
            0 => SliceStatistics::left_out(),
            _ => slice.statistics(&clusters[slice.first_cluster as usize..end(k)]),
        };
        Ok(slices.iter().enumerate().map(statistics).collect())
    }

    /// The paint is another one from now on, and has these slices, ascending.
    pub(super) fn touch(&mut self, there: Vec<u32>) {
        self.version = next_version();
        self.there = there;
    }

    /// Slices of all levels that were not left out, ascending.
    pub(super) fn there(&self) -> &[u32] {
        &self.there
    }

    /// A number that no other paint has, the same however often this one changes.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// Whether the flakes' u follows the half vector; none: no flakes that sparkle.
    pub(super) fn turns(&self) -> Option<bool> {
        self.turns
    }

    /// Whether boxes may have bands between them.
    pub(super) fn has_ramps(&self) -> bool {
        self.has_ramps
    }

    /// Whether the coat mirrors lamps by themselves.
    pub(super) fn mirrors(&self) -> bool {
        self.mirrors
    }

    /// Whether no row of the flakes' grid is longer than those before.
    pub(super) fn bins_shrink(&self) -> bool {
        self.bins_shrink
    }

    /// Slices of all levels that flakes are drawn from.
    pub(super) fn drawn_slices(&self) -> u32 {
        self.drawn_slices
    }

    /// Texels of the color table.
    pub(super) fn color_texels(&self) -> u32 {
        self.color_texels
    }

    /// A number that no other paint has, nor this one before it was changed.
    pub(super) fn version(&self) -> u64 {
        self.version
    }

    /// Memory on the GPU, bytes.
    pub fn bytes(&self) -> u64 {
        self.parts.iter().map(|(_, bytes)| bytes).sum()
    }

    /// Names and sizes of its parts, bytes.
    pub fn parts(&self) -> &[(&'static str, u64)] {
        &self.parts
    }
}

fn next_version() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

/// Group 0 of every pass that shades.
pub(super) fn bind_group_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding: u32| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: match binding {
                0 => wgpu::BufferBindingType::Uniform,
                _ => wgpu::BufferBindingType::Storage { read_only: true },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = (0..6).map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("paint"), entries: &entries };
    gpu.device.create_bind_group_layout(&descriptor)
}

/// Twins of the structs of the shader; what their fields mean is said there.
#[derive(Debug, Clone, Copy, Default, ShaderType)]
struct Lobe {
    coefficient: f32,
    roughness: f32,
    #[shader(size(8))]
    f0: f32,
}

#[derive(Debug, Clone, Copy, Default, ShaderType)]
struct Technique {
    probability: f32,
    #[shader(size(12))]
    roughness: f32,
}

#[derive(Debug, Clone, Default, ShaderType)]
struct Coat {
    gloss: Lobe,
    ior: f32,
    refracts: u32,
    mirror: f32,
}

#[derive(Debug, Clone, ShaderType)]
struct FlakeLayout {
    cells_per_mm: [Vec4; 4],
    starts: [UVec4; 46],
    bins: u32,
    rows: u32,
    missing_is_nearest: u32,
    texel_mm: f32,
    levels: u32,
    slices_per_level: u32,
    knots_per_unit: f32,
    knot_compression: f32,
    first_cluster: u32,
}

#[derive(Debug, Clone, ShaderType)]
pub(super) struct Header {
    lobes: [Lobe; Paint::MAX_LOBES],
    coat: Coat,
    flakes: FlakeLayout,
    colors_size: UVec2,
    lobe_count: u32,
    diffuse: f32,
    techniques: [Technique; Paint::MAX_LOBES],
    cosine: f32,
}

#[derive(Debug, Clone, Default, ShaderType)]
struct Slice {
    gain: Vec3,
    first_cluster: u32,
    offset: Vec3,
    guide: u32,
    lasting: f32,
    fading: Vec4,
}

#[derive(Debug, Clone, ShaderType)]
pub(super) struct Cluster {
    cumulative: f32,
    corners: [u32; 3],
}

/// Everything of a paint, ready to be uploaded.
#[derive(Debug)]
pub(super) struct Tables {
    pub header: Header,
    colors: Vec<[f32; 3]>,
    slices: Vec<Slice>,
    clusters: Vec<Cluster>,
    guide: Vec<u16>,
    ramps: Vec<u32>,
}

impl Tables {
    pub fn upload(&self, gpu: &Gpu) -> Result<GpuPaint> {
        let clusters = gpu.storage("clusters", &self.clusters)?;
        self.upload_with(gpu, clusters, 0..self.clusters.len())
    }

    /// Paints whose clusters lie in one buffer, one paint after the other, and that buffer.
    pub fn upload_together(paints: &mut [Self], gpu: &Gpu) -> Result<(Vec<GpuPaint>, wgpu::Buffer)> {
        let mut all: Vec<Cluster> = Vec::new();
        let mut own = Vec::new();
        for paint in paints.iter_mut() {
            let first = all.len();
            paint.slices.iter_mut().for_each(|slice| slice.first_cluster += first as u32);
            paint.header.flakes.first_cluster = first as u32;
            all.append(&mut paint.clusters);
            own.push(first..all.len());
        }
        let buffer = gpu.storage("clusters", &all)?;
        let upload = |(paint, own): (&Self, _)| paint.upload_with(gpu, buffer.clone(), own);
        let uploaded = paints.iter().zip(own).map(upload).collect::<Result<_>>()?;
        Ok((uploaded, buffer))
    }

    /// The first of a slice's clusters in their buffer.
    pub fn first_cluster(&self, slice: usize) -> u32 {
        self.slices[slice].first_cluster
    }

    fn upload_with(&self, gpu: &Gpu, clusters: wgpu::Buffer, own: Range<usize>) -> Result<GpuPaint> {
        let buffers = [
            ("color table", gpu.storage("color table", &self.colors)?),
            ("slices", gpu.storage("slices", &self.slices)?),
            ("clusters", clusters),
            ("guide tables", gpu.storage("guide tables", &self.packed_guide())?),
            ("ramps", gpu.storage("ramps", &self.ramps)?),
        ];
        let FlakeLayout { levels, slices_per_level, .. } = self.header.flakes;
        let slices = (0..levels * slices_per_level).zip(&self.slices);
        let there = slices.filter(|(_, slice)| slice.guide != 0).map(|(number, _)| number).collect();
        GpuPaint::of_buffers(gpu, &self.header, buffers, own, there, !self.ramps.is_empty())
    }

    pub fn new(paint: &RenderPaint) -> Result<Self> {
        let means = paint.flakes.iter().flat_map(RenderFlakes::means);
        let means: Vec<[f32; 3]> = means.map(Vec3::to_array).collect();
        let mut tables = Self {
            header: Header::new(paint),
            colors: [paint.colors.texels(), &means[..]].concat(),
            slices: Vec::new(),
            clusters: Vec::new(),
            guide: Vec::new(),
            ramps: Vec::new(),
        };
        for (_, slices) in paint.flakes.iter().flat_map(RenderFlakes::levels) {
            for slice in slices {
                tables.push(slice.as_ref())?;
            }
        }
        if !tables.ramps.is_empty() {
            tables.ramps.resize(tables.clusters.len(), 0);
        }
        Ok(tables)
    }

    /// Appends a slice, `None` for one that was left out.
    fn push(&mut self, slice: Option<&DrawnSlice>) -> Result<()> {
        let Some(DrawnSlice { statistics, sampler, memory }) = slice else {
            let first_cluster = self.clusters.len() as u32;
            self.slices.push(Slice { first_cluster, ..Slice::default() });
            return Ok(());
        };
        let Sampler::Exact(table, ramps) = sampler else {
            return Err(Error::gpu("paint", "sampler", "another one", "the exact one"));
        };
        self.slices.push(Slice {
            gain: statistics.gain.into(),
            first_cluster: self.clusters.len() as u32,
            offset: statistics.offset.into(),
            guide: guide_word(self.guide.len(), table.guide().len()),
            lasting: memory.lasting,
            fading: memory.fading,
        });
        let boxes = statistics.clusters.iter().zip(table.cumulative());
        self.clusters.extend(
            boxes.map(|(c, cumulative)| Cluster { cumulative: *cumulative, corners: pack_box(c.min, c.max) }),
        );
        self.guide.extend(first_candidates(table, ramps));
        if !ramps.is_empty() {
            // Clusters before may have none.
            self.ramps.resize(self.clusters.len() - ramps.len(), 0);
            self.ramps.extend(ramps.iter().map(|ramp| pack_ramp(*ramp)));
        }
        Ok(())
    }

    /// Room for slices of so many clusters, at every level, finest first, all left out as yet. The smooth part and the layout are
    /// those of `paint`.
    pub fn reserved(paint: &RenderPaint, clusters: impl Iterator<Item = usize>) -> Self {
        let means = paint.flakes.as_ref().map_or(0, |flakes| flakes.means().len());
        let colors = paint.colors.texels().iter().copied().chain(std::iter::repeat_n([0.0; 3], means));
        let mut tables = Self {
            header: Header::new(paint),
            colors: colors.collect(),
            slices: Vec::new(),
            clusters: Vec::new(),
            guide: Vec::new(),
            ramps: Vec::new(),
        };
        for n in clusters {
            let first_cluster = tables.clusters.len() as u32;
            tables.slices.push(Slice { first_cluster, ..Slice::default() });
            tables.clusters.extend(std::iter::repeat_n(Cluster { cumulative: 0.0, corners: [0; 3] }, n));
            tables.ramps.extend(std::iter::repeat_n(0, n));
            // Whole words, so that slices can be written side by side.
            tables.guide.extend(std::iter::repeat_n(0, guide_parts(n).next_multiple_of(2)));
        }
        tables
    }

    /// Two parts a word.
    fn packed_guide(&self) -> Vec<u32> {
        let word = |pair: &[u16]| pair.iter().rev().fold(0, |word, part| word << 16 | u32::from(*part));
        self.guide.chunks(2).map(word).collect()
    }
}

/// Parts of the guide table of so many clusters.
pub(super) fn guide_parts(clusters: usize) -> usize {
    if clusters == 0 { 0 } else { clusters.next_power_of_two() }
}

/// Twin of the function of the shader.
fn guide_word(first_part: usize, parts: usize) -> u32 {
    (first_part as u32) << 5 | (parts.ilog2() + 1)
}

/// The guide table of clusters with bands: to the first cluster whose color has not gone over at the start of a part.
fn first_candidates<'a>(table: &'a GuideTable, ramps: &'a [Ramp]) -> impl Iterator<Item = u16> + use<'a> {
    let (guide, ends) = (table.guide(), table.cumulative());
    guide.iter().enumerate().map(move |(part, candidate)| {
        let at = part as f32 / guide.len() as f32;
        let has_faded =
            |k: usize| ramps.get(k).is_none_or(|r| r.slope <= 0.0 || r.share(at - ends[k]) >= 1.0);
        let mut first = *candidate;
        while first > 0 && !has_faded(usize::from(first) - 1) {
            first -= 1;
        }
        first
    })
}

impl Slice {
    fn statistics(&self, clusters: &[Cluster]) -> SliceStatistics {
        let before = std::iter::once(0.0).chain(clusters.iter().map(|c| c.cumulative));
        let drawn = clusters.iter().zip(before).filter(|(c, before)| c.cumulative > *before);
        let clusters = drawn.map(|(c, before)| {
            let [min, max] = unpack_box(c.corners);
            cluster::Cluster { probability: f64::from(c.cumulative) - f64::from(before), min, max }
        });
        let gain = self.gain.to_array();
        SliceStatistics { gain, ..SliceStatistics::new(clusters.collect(), self.offset.to_array()) }
    }
}

impl Header {
    fn new(paint: &RenderPaint) -> Self {
        let [columns, rows] = paint.colors.size().map(|n| n as u32);
        Self {
            lobes: from_fn(|k| paint.lobes.get(k).map_or_else(Lobe::default, Lobe::new)),
            coat: Coat {
                gloss: paint.coat.gloss.as_ref().map_or_else(Lobe::default, Lobe::new),
                ior: paint.coat.ior,
                refracts: u32::from(paint.coat.refracts),
                mirror: paint.coat.mirror,
            },
            flakes: paint.flakes.as_ref().map_or(FlakeLayout::NONE, FlakeLayout::new),
            colors_size: UVec2::new(columns, rows),
            lobe_count: paint.lobes.len() as u32,
            diffuse: paint.diffuse,
            techniques: from_fn(|k| match paint.proposal.lobes.get(k) {
                Some(&(probability, roughness)) => Technique { probability, roughness },
                None => Technique::default(),
            }),
            cosine: paint.proposal.cosine,
        }
    }
}

impl Lobe {
    fn new(lobe: &brdf::Lobe<f32>) -> Self {
        Self { coefficient: lobe.coefficient, roughness: lobe.roughness, f0: lobe.f0 }
    }
}

impl FlakeLayout {
    const NONE: Self = Self {
        cells_per_mm: [Vec4::ZERO; 4],
        starts: [UVec4::ZERO; 46],
        bins: 1,
        rows: 0,
        missing_is_nearest: 0,
        texel_mm: 1.0,
        levels: 0,
        slices_per_level: 0,
        knots_per_unit: 0.0,
        knot_compression: 0.0,
        first_cluster: 0,
    };

    fn new(flakes: &RenderFlakes) -> Self {
        let (layout, grid) = (flakes.layout(), flakes.layout().grid());
        let cells_per_mm: Vec<f32> = flakes.levels().map(|(cells_per_mm, _)| cells_per_mm).collect();
        let mut starts = vec![0];
        starts.extend(grid.rows().iter().scan(0, |end, n| {
            *end += *n as u32;
            Some(*end)
        }));
        Self {
            cells_per_mm: fours(&cells_per_mm),
            starts: fours(&starts),
            bins: grid.bins() as u32,
            rows: grid.rows().len() as u32,
            missing_is_nearest: u32::from(layout.missing() == MissingSlice::Nearest),
            texel_mm: layout.texel_mm(),
            levels: cells_per_mm.len() as u32,
            slices_per_level: grid.len() as u32,
            knots_per_unit: flakes.knots().map_or(0.0, |k| k.per_unit),
            knot_compression: flakes.knots().map_or(0.0, |k| k.compression),
            first_cluster: 0,
        }
    }

    /// Whether no row of the grid is longer than those before.
    fn bins_shrink(&self) -> bool {
        let starts: Vec<u32> = self.starts.iter().flat_map(UVec4::to_array).collect();
        let lengths: Vec<u32> = starts.windows(2).take(self.rows as usize).map(|w| w[1] - w[0]).collect();
        lengths.is_sorted_by(|a, b| a >= b)
    }
}

/// Numbers, four a vector, as uniform buffers want them; 0 behind the last.
fn fours<T: Copy + Default, V: From<[T; 4]>, const N: usize>(values: &[T]) -> [V; N] {
    from_fn(|k| V::from(from_fn(|c| values.get(4 * k + c).copied().unwrap_or_default())))
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<Lobe, _>("Lobe");
        assert_same_layout::<Technique, _>("Technique");
        assert_same_layout::<Coat, _>("Coat");
        assert_same_layout::<FlakeLayout, _>("FlakeLayout");
        assert_same_layout::<Header, _>("Paint");
        assert_same_layout::<Slice, _>("Slice");
        assert_same_layout::<Cluster, _>("Cluster");
    }
}
