//! Bands between clusters that share an arc of a blend: there a texel's color goes over from one to the next. Ours: boxes of
//! Golla & Klein 2018 (eqs 14, 15) travel instead.
//!
//! An arc is a run of clusters linked by bands. At u, the share of what lies behind boundary j is a ramp in u of a width
//! that all boundaries of the arc share, cut off where the arc ends; its integral is the probability of what lies behind,
//! so that bands leave the mean alone. A ramp that is cut off stops short of 0 or 1: as a cluster's probability p goes
//! to 0, its share goes to 0 like sqrt(p) everywhere, instead of staying 1 in a vanishing interval of u, and no texel
//! ever jumps.

use super::Cluster;
use std::ops::Range;

/// Share of what lies behind a boundary, as a function of u.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ramp {
    /// Growth of the share per unit of u; 0: no band.
    pub slope: f32,
    /// Share at the boundary: 1/2 unless the arc ends before the ramp does.
    pub middle: f32,
}

impl Ramp {
    /// Share of what lies behind the boundary, 0 to 1, at `beyond` = u less the boundary.
    #[inline]
    pub fn share(self, beyond: f32) -> f32 {
        (self.middle + self.slope * beyond).clamp(0.0, 1.0)
    }
}

/// Clusters that are linked by bands, each to the next; at least two.
#[derive(Debug, Clone)]
pub(super) struct Arc {
    pub clusters: Range<usize>,
    /// Probability.
    total: f64,
    /// Half the width in u of a ramp that is not cut off: the least of those given, and no more than half of the arc, so that
    /// ramps do not cross and a cut-off one is cut at one end only.
    half_width: f64,
}

/// A boundary inside an arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Boundary {
    /// Number of the cluster before it.
    pub cluster: usize,
    /// Probabilities of what lies before and behind it in its arc.
    sides: [f64; 2],
    /// That of its arc.
    half_width: f64,
}

impl Boundary {
    /// Share at the boundary of what lies behind it.
    fn middle(&self) -> f64 {
        // A ramp of slope 1 / (2 h) that is cut off at a share m has the integral h m^2.
        let cut = |side: f64| {
            let short = 1.0 - (side / self.half_width).sqrt();
            0.5 - 0.5 * short * short
        };
        let [before, behind] = self.sides;
        if behind < self.half_width {
            cut(behind)
        } else if before < self.half_width {
            1.0 - cut(before)
        } else {
            0.5
        }
    }

    /// Share of what lies behind, `beyond` the boundary.
    fn share(&self, beyond: f64) -> f64 {
        (self.middle() + 0.5 * beyond / self.half_width).clamp(0.0, 1.0)
    }

    /// Integral over the arc of the product of the shares before and behind.
    fn overlap(&self) -> f64 {
        let [from, to] = [self.share(-self.sides[0]), self.share(self.sides[1])];
        let integral = |share: f64| share * share * (0.5 - share / 3.0);
        2.0 * self.half_width * (integral(to) - integral(from))
    }
}

impl Arc {
    /// Its boundaries.
    pub(super) fn boundaries<'a>(&self, clusters: &'a [Cluster]) -> impl Iterator<Item = Boundary> + use<'a> {
        let (total, half_width, mut before) = (self.total, self.half_width, 0.0);
        (self.clusters.start..self.clusters.end - 1).map(move |cluster| {
            before += clusters[cluster].probability;
            Boundary { cluster, sides: [before, total - before], half_width }
        })
    }

    /// Calls `pair` with the numbers of two clusters and the integral over the arc of the product of their shares, for all
    /// pairs that overlap.
    pub(super) fn overlaps(&self, clusters: &[Cluster], mut pair: impl FnMut(usize, usize, f64)) {
        let mut boundaries = self.boundaries(clusters);
        if let (2, Some(only)) = (self.clusters.len(), boundaries.next()) {
            return pair(only.cluster, only.cluster + 1, only.overlap());
        }
        // Between the ends of ramps shares are straight lines, their products parabolas: Simpson's rule is exact.
        let boundaries: Vec<Boundary> = self.boundaries(clusters).collect();
        let ends = boundaries
            .iter()
            .flat_map(|b| [-b.middle(), 1.0 - b.middle()].map(|rest| b.sides[0] + 2.0 * b.half_width * rest));
        let mut knots: Vec<f64> = ends.chain([0.0, self.total]).map(|u| u.clamp(0.0, self.total)).collect();
        knots.sort_by(f64::total_cmp);
        let behind = |j: usize, u: f64| match j.checked_sub(1).map(|j| boundaries.get(j)) {
            None => 1.0,
            Some(boundary) => boundary.map_or(0.0, |b| b.share(u - b.sides[0])),
        };
        let share = |j: usize, u: f64| behind(j, u) - behind(j + 1, u);
        for j in 0..self.clusters.len() {
            for l in 0..j {
                let product = |u: f64| share(j, u) * share(l, u);
                let simpson = |piece: &[f64]| {
                    let (from, to) = (piece[0], piece[1]);
                    (to - from) / 6.0 * (product(from) + 4.0 * product(0.5 * (from + to)) + product(to))
                };
                let overlap: f64 = knots.windows(2).map(simpson).sum();
                if overlap > 0.0 {
                    pair(self.clusters.start + l, self.clusters.start + j, overlap);
                }
            }
        }
    }
}

/// Every arc of at least two clusters. `fades`: see [`super::SliceStatistics`].
pub(super) fn arcs(clusters: &[Cluster], fades: &[f32]) -> impl Iterator<Item = Arc> {
    // u has 24 bits: a band narrower than its last one is none.
    let linked = |k: usize| k + 1 < clusters.len() && fades.get(k).is_some_and(|f| *f > 1e-8);
    let mut next = 0;
    std::iter::from_fn(move || {
        let first = (next..fades.len()).find(|k| linked(*k))?;
        next = (first..).find(|k| !linked(*k))? + 1;
        let total: f64 = clusters[first..next].iter().map(|c| c.probability).sum();
        let least = fades[first..next - 1].iter().copied().fold(f32::INFINITY, f32::min);
        Some(Arc { clusters: first..next, total, half_width: f64::from(least).min(0.5 * total) })
    })
}

/// Ramps behind every cluster; empty without bands.
pub fn ramps(clusters: &[Cluster], fades: &[f32]) -> Vec<Ramp> {
    let mut ramps = vec![Ramp::default(); fades.len()];
    for boundary in arcs(clusters, fades).flat_map(|arc| arc.boundaries(clusters)) {
        let slope = (0.5 / boundary.half_width) as f32;
        ramps[boundary.cluster] = Ramp { slope, middle: boundary.middle() as f32 };
    }
    ramps
}
