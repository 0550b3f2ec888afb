//! The tables of a mix in the layout of `shaders/realize.wgsl`.

use super::constituents::OwnSlice;
use super::paint::{Tables, guide_parts};
use super::patterns::Patterns;
use crate::cluster::{Cluster, SliceStatistics};
use crate::error::Result;
use crate::mix::{Mix, MixSlice};
use crate::render::Memory;
use encase::ShaderType;
use glam::DVec3;

/// Twins of the structs of the shader; what their fields mean is said there.
#[derive(Debug, Clone, Default, ShaderType)]
pub(super) struct GpuSlice {
    first_arc: u32,
    arcs: u32,
    first_cluster: u32,
    clusters: u32,
    first_part: u32,
    parts: u32,
    first_moments: u32,
}

#[derive(Debug, Clone, ShaderType)]
pub(super) struct PaintMoments {
    mean: [f32; 3],
    deviation: [f32; 3],
    gain: [f32; 3],
    lasting: f32,
    fading: [f32; 4],
    first_box: u32,
}

impl GpuSlice {
    /// Number of arcs; 0: left out.
    pub fn arcs(&self) -> u32 {
        self.arcs
    }
}

/// Bits of the numbers of an arc, see the shader.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ArcBits {
    pub place: u32,
    pub pattern: u32,
    pub of_box: u32,
    /// Words of an arc.
    pub words: u32,
}

/// Everything that a mix keeps on the GPU besides boxes and colors.
#[derive(Debug, Default)]
pub(super) struct MixTables {
    pub slices: Vec<GpuSlice>,
    pub moments: Vec<PaintMoments>,
    pub arcs: Vec<u32>,
    pub bits: ArcBits,
    pub patterns: Patterns,
    clusters: u32,
    guide: u32,
}

impl MixTables {
    /// `own`: slices of every paint, level by level. `paints`: its tables, all of them placed in one buffer.
    pub fn new(mix: &Mix, own: &[Vec<Vec<OwnSlice>>], paints: &[Tables]) -> Result<Self> {
        let slices: Vec<&MixSlice> =
            mix.flakes.iter().flat_map(|f| &f.levels).flat_map(|l| &l.slices).collect();
        let own: Vec<Vec<&OwnSlice>> = own.iter().map(|levels| levels.iter().flatten().collect()).collect();
        let mut tables = Self::default();
        for groups in slices.iter().flat_map(|s| &s.groups) {
            tables.patterns.number(*groups);
        }
        let places = slices.iter().map(|s| clusters_of(s, paints.len())).max();
        let boxes = own.iter().flatten().map(|own| own.statistics.clusters.len()).max();
        tables.bits = ArcBits::of([places, Some(tables.patterns.len()), boxes], paints.len());
        for (k, slice) in slices.iter().enumerate() {
            let own: Vec<&OwnSlice> = own.iter().map(|slices| slices[k]).collect();
            let first_boxes = paints.iter().map(|paint| paint.first_cluster(k));
            tables.push(slice, &own, first_boxes);
        }
        Ok(tables)
    }

    /// Most clusters of every slice of a blend; 0: left out.
    pub fn clusters(&self) -> impl Iterator<Item = usize> {
        self.slices.iter().map(|slice| slice.clusters as usize)
    }

    fn push(&mut self, slice: &MixSlice, own: &[&OwnSlice], first_boxes: impl Iterator<Item = u32>) {
        let clusters = clusters_of(slice, own.len());
        let parts = guide_parts(clusters);
        self.slices.push(GpuSlice {
            first_arc: self.arcs.len() as u32 / self.bits.words,
            arcs: slice.probabilities.len() as u32,
            first_cluster: self.clusters,
            clusters: clusters as u32,
            first_part: self.guide,
            parts: parts as u32,
            first_moments: self.moments.len() as u32,
        });
        self.clusters += clusters as u32;
        self.guide += parts.next_multiple_of(2) as u32;
        let vector = |v: DVec3| v.as_vec3().to_array();
        self.moments.extend(first_boxes.enumerate().map(|(k, first_box)| {
            let memory = Memory::of(&alone(slice, k));
            PaintMoments {
                mean: vector(slice.means[k]),
                deviation: vector(slice.deviations[k]),
                gain: slice.gains[k],
                lasting: memory.lasting,
                fading: memory.fading.to_array(),
                first_box,
            }
        }));
        let total: f64 = slice.probabilities.iter().sum();
        let (mut before, mut place) = (0.0, 0);
        for (k, (probability, groups)) in slice.probabilities.iter().zip(&slice.groups).enumerate() {
            // Steps of 2^-32: a probability is off by as much, far less than u tells apart.
            self.arcs.push((before / total * 2f64.powi(32)).round() as u32);
            let pattern = self.patterns.number(*groups);
            let numbers = [(place, self.bits.place), (pattern, self.bits.pattern)];
            let boxes = own.iter().map(|own| (own.of_arc[k], self.bits.of_box));
            push_bits(&mut self.arcs, numbers.into_iter().chain(boxes));
            before += probability;
            place += groups.count(own.len());
        }
    }
}

impl ArcBits {
    /// Of so many places, patterns and boxes.
    fn of(counts: [Option<usize>; 3], paints: usize) -> Self {
        let [place, pattern, of_box] = counts.map(|n| n.unwrap_or(0).max(1).next_power_of_two().ilog2());
        let words = 1 + (place + pattern + paints as u32 * of_box).div_ceil(32);
        Self { place, pattern, of_box, words }
    }
}

fn clusters_of(slice: &MixSlice, paints: usize) -> usize {
    slice.groups.iter().map(|groups| groups.count(paints)).sum()
}

/// Appends numbers of so many bits, lowest bits first, filled up to a word.
fn push_bits(words: &mut Vec<u32>, numbers: impl Iterator<Item = (usize, u32)>) {
    let (mut word, mut filled) = (0u64, 0);
    for (number, bits) in numbers {
        word |= (number as u64) << filled;
        filled += bits;
        if filled >= 32 {
            words.push(word as u32);
            word >>= 32;
            filled -= 32;
        }
    }
    if filled > 0 {
        words.push(word as u32);
    }
}

/// A slice of one paint of a mix, in the order of its arcs.
fn alone(slice: &MixSlice, paint: usize) -> SliceStatistics {
    let arcs = slice.probabilities.iter().zip(&slice.boxes[paint]);
    let clusters =
        arcs.map(|(probability, [min, max])| Cluster { probability: *probability, min: *min, max: *max });
    SliceStatistics { gain: slice.gains[paint], ..SliceStatistics::new(clusters.collect(), [0.0; 3]) }
}

#[cfg(test)]
mod tests {
    use super::super::reflection::assert_same_layout;
    use super::*;

    #[test]
    fn structs_lie_as_the_shader_reads_them() {
        assert_same_layout::<GpuSlice, _>("MixSlice");
        assert_same_layout::<PaintMoments, _>("PaintMoments");
    }

    #[test]
    fn numbers_follow_each_other_bit_after_bit() {
        let mut words = vec![7];
        push_bits(&mut words, [(0x1ff, 9), (0x5, 4), (0, 0), (0xabcde, 20), (1, 31)].into_iter());
        assert_eq!(words, [7, 0x1ff | 0x5 << 9 | 0xabcde << 13, 0xabcde >> 19 | 1 << 1]);
    }
}
