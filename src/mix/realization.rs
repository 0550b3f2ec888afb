//! One slice at given weights (Golla & Klein 2018, eqs 14, 15, and what keeps contrast and mean).

use super::weights::Weights;
use super::{Channels, Groups, Mix, MixSlice, Path};
use crate::cluster::{Cluster, SliceStatistics, deviation_of_draws, mean_of_boxes};
use glam::DVec3;

type Corners = [[f32; 3]; 2];

/// Half-width of the band about a moving threshold, over the probability of the arc: as the slider moves, a texel fades
/// through it. Wider bands make smaller steps; up to 0.3 errors against paints simulated between the ends stay the same.
const FADE: f64 = 0.2;

/// What all slices of a blend have in common.
pub(super) struct Realization<'a> {
    weights: &'a Weights,
    /// The same in the arithmetic of corners.
    narrow: Vec<f32>,
    /// Shares of the probability, one a paint.
    shares: Weights,
    /// What weights are beyond shares, one a paint: not 0 where the blend is extrapolated.
    beyond: Vec<f64>,
    path: Path,
    channels: Channels,
    source: usize,
}

impl MixSlice {
    /// Corners of the box of every arc where all boxes travel (eqs 14, 15): `weights`, one a paint, sum to 1. Axes that would
    /// turn inside out, past the narrower paint, are flat.
    ///
    /// A box that all paints with a weight share comes back to the bit.
    pub fn corners(&self, weights: &[f32], corners: &mut Vec<Corners>) {
        corners.clear();
        let Some(reference) = weights.iter().position(|w| *w != 0.0) else { return };
        corners.extend_from_slice(&self.boxes[reference]);
        let from = self.boxes[reference].as_flattened().as_flattened();
        for (k, w) in weights.iter().enumerate().skip(reference + 1).filter(|(_, w)| **w != 0.0) {
            let to = self.boxes[k].as_flattened().as_flattened();
            let all = corners.as_flattened_mut().as_flattened_mut();
            for ((corner, to), from) in all.iter_mut().zip(to).zip(from) {
                *corner += w * (to - from);
            }
        }
        corners.iter_mut().for_each(flattened);
    }
}

/// Past the narrower paint a box would turn inside out and grow again: it stays flat instead.
fn flattened([min, max]: &mut Corners) {
    for (low, high) in min.iter_mut().zip(max).filter(|(low, high)| low > high) {
        *low = 0.5 * (*low + *high);
        *high = *low;
    }
}

impl<'a> Realization<'a> {
    pub(super) fn new(weights: &'a Weights, path: Path, channels: Channels, source: usize) -> Self {
        let narrow = weights.0.iter().map(|w| *w as f32).collect();
        let shares = weights.shares();
        let beyond = weights.0.iter().zip(&shares.0).map(|(w, s)| w - s).collect();
        Self { weights, narrow, shares, beyond, path, channels, source }
    }

    /// The slice; `buffer` is reused.
    pub(super) fn slice(&self, slice: &MixSlice, buffer: &mut Vec<Corners>) -> SliceStatistics {
        if slice.is_left_out() {
            return SliceStatistics::left_out();
        }
        slice.corners(&self.narrow, buffer);
        let mut row = Row::with_capacity(2 * slice.probabilities.len());
        for (k, (p, groups)) in slice.probabilities.iter().zip(&slice.groups).enumerate() {
            if self.path == Path::Hybrid && !groups.is_one() {
                self.exchange(slice, k, *p, *groups, &mut row);
            } else {
                row.push(*p, self.colored(slice, k, buffer[k]));
            }
        }
        self.corrected(slice, row)
    }

    /// An arc whose paints are far apart: each group has its share of the probability, and its box travels among its own.
    fn exchange(&self, slice: &MixSlice, arc: usize, probability: f64, groups: Groups, row: &mut Row) {
        let mut shares = [0.0; Groups::MOST];
        for (paint, share) in self.shares.0.iter().enumerate() {
            shares[groups.of(paint)] += share;
        }
        let there = |share: &f64| probability * share > 0.0;
        let is_alone = shares.iter().filter(|share| there(share)).count() == 1;
        let mut is_first = true;
        for (group, share) in shares.into_iter().enumerate().filter(|(_, share)| there(share)) {
            let corners = self.colored(slice, arc, self.group_box(slice, arc, groups, group, share));
            if is_alone {
                row.push(probability * share, corners);
                continue;
            }
            if !is_first {
                row.fade((FADE * probability) as f32);
            }
            is_first = false;
            row.append(probability * share, corners);
        }
    }

    /// The box of a group: the blend of its own by their shares; what weights are beyond shares (extrapolated) all paints move.
    fn group_box(&self, slice: &MixSlice, arc: usize, groups: Groups, group: usize, share: f64) -> Corners {
        let weight = |k: usize| {
            let own = if groups.of(k) == group { self.shares.0[k] / share } else { 0.0 };
            own + self.beyond[k]
        };
        // On the stack: this runs for most arcs.
        let mut weights = [0.0; *Mix::PAINTS.end()];
        for (k, w) in weights.iter_mut().enumerate().take(self.shares.0.len()) {
            *w = weight(k) as f32;
        }
        let reference = weights.iter().position(|w| *w != 0.0).unwrap_or(0);
        let from = slice.boxes[reference][arc];
        let mut corners = from;
        for (k, w) in weights.iter().enumerate().skip(reference + 1).filter(|(_, w)| **w != 0.0) {
            let to = slice.boxes[k][arc];
            for (end, axis) in [0, 1].into_iter().flat_map(|e| [(e, 0), (e, 1), (e, 2)]) {
                corners[end][axis] += w * (to[end][axis] - from[end][axis]);
            }
        }
        flattened(&mut corners);
        corners
    }

    /// A box with the channels that do not go taken from the source.
    #[inline]
    fn colored(&self, slice: &MixSlice, arc: usize, corners: Corners) -> Corners {
        let kept = &slice.boxes[self.source];
        match self.channels {
            Channels::All => corners,
            Channels::Lightness => [0, 1].map(|end| [corners[end][0], kept[arc][end][1], kept[arc][end][2]]),
            Channels::AllButLightness => {
                [0, 1].map(|end| [kept[arc][end][0], corners[end][1], corners[end][2]])
            }
            Channels::WhiteFlakes => [0, 1].map(|end| [corners[end][0], 0.0, 0.0]),
        }
    }

    /// Brings contrast and mean to where they belong.
    fn corrected(&self, slice: &MixSlice, row: Row) -> SliceStatistics {
        let Row { clusters, fades, .. } = row;
        let fades = if fades.iter().all(|f| *f == 0.0) { Vec::new() } else { fades };
        let gain = self.gain(slice, &clusters, &fades);
        let mean = match self.channels {
            // The smooth part stays, and so does the color from afar.
            Channels::Lightness => slice.means[self.source],
            _ => self.weights.vector(slice.means.iter().copied()),
        };
        let offset = mean - DVec3::from(gain.map(f64::from)) * mean_of_boxes(&clusters);
        SliceStatistics { clusters, fades, gain, offset: offset.as_vec3().to_array() }
    }

    /// The paints' own gain (1 but for blends of blends), or the one that makes the standard deviation their blend
    /// ([`Weights::deviation`]), linear beyond the ends.
    fn gain(&self, slice: &MixSlice, clusters: &[Cluster], fades: &[f32]) -> [f32; 3] {
        let wide = |k: usize| DVec3::from(slice.gains[k].map(f64::from));
        let paints = 0..slice.gains.len();
        if matches!(self.channels, Channels::Lightness | Channels::AllButLightness) {
            return slice.gains[self.source];
        }
        let own = self.weights.vector(paints.clone().map(wide)).max(DVec3::ZERO);
        let most = f64::from(SliceStatistics::MAX_GAIN);
        // A paint alone keeps its own; white flakes are to have less contrast of color.
        let alone = self.weights.0.iter().filter(|w| **w != 0.0).count() == 1;
        if !self.path.keeps_contrast() || alone || self.channels == Channels::WhiteFlakes {
            return own.min(DVec3::splat(most)).as_vec3().to_array();
        }
        let deviations = paints.map(|k| wide(k) * slice.deviations[k]);
        let beyond: DVec3 = self.beyond.iter().zip(deviations.clone()).map(|(w, d)| *w * d).sum();
        let wanted = (self.shares.deviation(deviations) + beyond).max(DVec3::ZERO);
        let gain = wanted / deviation_of_draws(clusters, fades);
        DVec3::from([0, 1, 2].map(|c| {
            // Without any scatter there is no contrast to keep; what differs in f32 only is the same.
            let undone = !gain[c].is_finite() || (gain[c] - own[c]).abs() <= 1e-6 * own[c];
            if undone { own[c] } else { gain[c].min(most) }
        }))
        .as_vec3()
        .to_array()
    }
}

/// Clusters in the making.
struct Row {
    clusters: Vec<Cluster>,
    fades: Vec<f32>,
    /// Whether the last cluster belongs to no arc of several.
    is_open: bool,
}

impl Row {
    fn with_capacity(n: usize) -> Self {
        Self { clusters: Vec::with_capacity(n), fades: Vec::with_capacity(n), is_open: false }
    }

    /// Adds a cluster. Neighbours in the order of u that end up in the same box become one.
    #[inline]
    fn push(&mut self, probability: f64, [min, max]: Corners) {
        match self.clusters.last_mut() {
            Some(last) if self.is_open && last.min == min && last.max == max => {
                last.probability += probability;
            }
            _ => self.append(probability, [min, max]),
        }
        self.is_open = true;
    }

    /// Adds a cluster of an arc of several: its ramps end with the arc.
    #[inline]
    fn append(&mut self, probability: f64, [min, max]: Corners) {
        self.clusters.push(Cluster { probability, min, max });
        self.fades.push(0.0);
        self.is_open = false;
    }

    /// Half-width of the band behind the last cluster.
    fn fade(&mut self, half_width: f32) {
        if let Some(last) = self.fades.last_mut() {
            *last = half_width;
        }
    }
}
