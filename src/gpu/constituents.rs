//! The paints of a mix by themselves: their boxes are those that blends are made of.

use crate::cluster::{Cluster, SliceStatistics};
use crate::mix::{Mix, MixFlakes, MixSlice};
use crate::paint::{FlakeLevel, Flakes, Paint};
use glam::DVec3;
use std::collections::HashMap;

/// A slice of one paint: its clusters by ascending lightness, as before it was coupled, and which of them each arc begins or ends in.
pub(super) struct OwnSlice {
    pub statistics: SliceStatistics,
    pub of_arc: Vec<usize>,
}

impl OwnSlice {
    pub fn of(slice: &MixSlice, paint: usize) -> Self {
        if slice.is_left_out() {
            return Self { statistics: SliceStatistics::left_out(), of_arc: Vec::new() };
        }
        let mut clusters: Vec<Cluster> = Vec::new();
        let mut numbers: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
        let number = |(probability, [min, max]): (&f64, &[[f32; 3]; 2])| {
            let number = *numbers.entry([*min, *max].map(|c| c.map(f32::to_bits))).or_insert_with(|| {
                clusters.push(Cluster { probability: 0.0, min: *min, max: *max });
                clusters.len() - 1
            });
            clusters[number].probability += probability;
            number
        };
        let of_arc: Vec<usize> = slice.probabilities.iter().zip(&slice.boxes[paint]).map(number).collect();
        let mut order: Vec<usize> = (0..clusters.len()).collect();
        order.sort_by(|a, b| by_lightness(&clusters[*a], &clusters[*b]));
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, number)| places[*number] = place);
        let clusters = order.iter().map(|number| clusters[*number]).collect();
        let boxes = SliceStatistics::new(clusters, [0.0; 3]);
        let gain = slice.gains[paint];
        let offset = slice.means[paint] - DVec3::from(gain.map(f64::from)) * boxes.box_mean();
        Self {
            statistics: SliceStatistics { gain, offset: offset.as_vec3().to_array(), ..boxes },
            of_arc: of_arc.into_iter().map(|number| places[number]).collect(),
        }
    }
}

/// Ascending lightness of the center, then a, b.
fn by_lightness(x: &Cluster, y: &Cluster) -> std::cmp::Ordering {
    let keys = x.center().to_array().into_iter().zip(y.center().to_array());
    keys.map(|(x, y)| x.total_cmp(&y)).fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
}

/// A paint of a mix in the form that all share, from its slices, level by level.
pub(super) fn paint_of(mix: &Mix, paint: usize, slices: &[Vec<OwnSlice>]) -> Paint {
    let c = &mix.constituents[paint];
    Paint {
        coat: c.coat,
        diffuse: c.diffuse,
        lobes: c.lobes.clone(),
        colors: c.colors.clone(),
        flakes: mix.flakes.as_ref().map(|flakes| flakes_of(flakes, slices)),
        provenance: c.provenance.clone(),
    }
}

fn flakes_of(flakes: &MixFlakes, slices: &[Vec<OwnSlice>]) -> Flakes {
    let levels = flakes.levels.iter().zip(slices).map(|(level, slices)| FlakeLevel {
        pitch_mm: level.pitch_mm,
        slices: slices.iter().map(|slice| slice.statistics.clone()).collect(),
    });
    Flakes {
        grid: flakes.grid.clone(),
        missing: flakes.missing,
        size: flakes.size,
        texel_mm: flakes.texel_mm,
        levels: levels.collect(),
        inverse_cdf_steps: flakes.inverse_cdf_steps,
        knots: flakes.knots,
    }
}
