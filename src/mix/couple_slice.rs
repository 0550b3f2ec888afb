//! One slice of several paints (Golla & Klein 2018, sections 4.1, 4.3).

use super::{Groups, MixSlice};
use crate::cluster::{SliceStatistics, deviation_of_draws};
use crate::error::Result;
use crate::transport::{Certificate, Cost, Problem, Solver, solve};
use glam::DVec3;

/// Largest errors of the problem behind a slice.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Quality {
    /// Duality gap over max(cost, 1e-3 of the mean edge).
    pub relative_gap: f64,
    pub row_error: f64,
    pub column_error: f64,
    /// Transport cost.
    pub cost: f64,
}

impl Quality {
    fn new(certificate: &Certificate, problem: &Problem) -> Self {
        // Identical paints have cost 0: there the gap is seen against the size of the problem.
        let scale = certificate.cost.max(1e-3 * problem.mean_cost()).max(f64::MIN_POSITIVE);
        Self {
            relative_gap: certificate.gap / scale,
            row_error: certificate.row_error,
            column_error: certificate.column_error,
            cost: certificate.cost,
        }
    }
}

impl MixSlice {
    /// A slice of one paint: an arc a cluster. Its bands, if it is a blend's, are not kept.
    pub(super) fn of(statistics: &SliceStatistics) -> Self {
        let clusters = &statistics.clusters;
        Self {
            probabilities: clusters.iter().map(|c| c.probability).collect(),
            boxes: vec![clusters.iter().map(|c| [c.min, c.max]).collect()],
            groups: vec![Groups::default(); clusters.len()],
            means: vec![statistics.mean_rgb()],
            deviations: vec![deviation(statistics)],
            gains: vec![statistics.gain],
            gap: 0.0,
        }
    }

    /// A slice of so many paints without flakes.
    pub(super) fn nothing(paints: usize) -> Self {
        Self {
            probabilities: vec![1.0],
            boxes: vec![vec![[[0.0; 3]; 2]]; paints],
            groups: vec![Groups::default()],
            ..Self::left_out(paints)
        }
    }

    /// A slice that was left out of one of so many paints.
    pub(super) fn left_out(paints: usize) -> Self {
        Self {
            probabilities: Vec::new(),
            boxes: vec![Vec::new(); paints],
            groups: Vec::new(),
            means: vec![DVec3::ZERO; paints],
            deviations: vec![DVec3::ZERO; paints],
            gains: vec![[1.0; 3]; paints],
            gap: 0.0,
        }
    }

    /// The slice with one more paint, coupled to the realization at equal weights of those before it; with a capped cost,
    /// to the nearest of the boxes among which probability is exchanged.
    pub(super) fn with(
        &self,
        statistics: &SliceStatistics,
        cost: Cost,
        threshold: f64,
        solver: Solver,
    ) -> Result<(Self, Quality)> {
        if self.is_left_out() || statistics.is_left_out() {
            return Ok((Self::left_out(self.boxes.len() + 1), Quality::default()));
        }
        let groups: Vec<Vec<DVec3>> = (0..self.groups.len()).map(|arc| self.group_centers(arc)).collect();
        let places: Vec<Vec<DVec3>> = match cost {
            Cost::Capped(_) => groups.clone(),
            Cost::Euclidean | Cost::Squared => (0..groups.len()).map(|arc| vec![self.center(arc)]).collect(),
        };
        let targets: Vec<(DVec3, f64)> =
            statistics.clusters.iter().map(|c| (c.center(), c.probability)).collect();
        let wanted: Vec<f64> = targets.iter().map(|t| t.1).collect();
        let problem = Problem::from_fn(&self.probabilities, &wanted, |i, j| {
            places[i].iter().map(|place| cost.between(*place, targets[j].0)).fold(f64::INFINITY, f64::min)
        })?;
        let plan = solve(&problem, solver)?;
        let quality = Quality::new(&plan.certificate, &problem);
        let mut next = self.extended(statistics, &plan.entries);
        next.gap = self.gap.max(plan.certificate.gap);
        for (groups_of_arc, (i, j, _)) in next.groups.iter_mut().zip(&plan.entries) {
            *groups_of_arc = joined(*groups_of_arc, self.boxes.len(), &groups[*i], targets[*j].0, threshold);
        }
        (0..next.groups.len()).for_each(|arc| next.number_groups(arc));
        Ok((next.sorted_by_lightness(), quality))
    }

    /// Arcs of the plan's entries, with the groups of those they come from.
    fn extended(&self, statistics: &SliceStatistics, entries: &[(usize, usize, f64)]) -> Self {
        let own = |boxes: &Vec<[[f32; 3]; 2]>| entries.iter().map(|(i, ..)| boxes[*i]).collect();
        let new = |j: usize| [statistics.clusters[j].min, statistics.clusters[j].max];
        let added = entries.iter().map(|(_, j, _)| new(*j)).collect();
        Self {
            probabilities: entries.iter().map(|(.., p)| *p).collect(),
            boxes: self.boxes.iter().map(own).chain([added]).collect(),
            groups: entries.iter().map(|(i, ..)| self.groups[*i]).collect(),
            means: self.means.iter().copied().chain([statistics.mean_rgb()]).collect(),
            deviations: self.deviations.iter().copied().chain([deviation(statistics)]).collect(),
            gains: self.gains.iter().copied().chain([statistics.gain]).collect(),
            gap: self.gap,
        }
    }

    fn box_center(&self, paint: usize, arc: usize) -> DVec3 {
        let [min, max] = self.boxes[paint][arc].map(|c| DVec3::from(c.map(f64::from)));
        0.5 * (min + max)
    }

    /// Center of an arc's box at equal weights, Lab.
    fn center(&self, arc: usize) -> DVec3 {
        (0..self.boxes.len()).map(|k| self.box_center(k, arc)).sum::<DVec3>() / self.boxes.len() as f64
    }

    /// Centers of the groups' boxes at equal weights, Lab.
    fn group_centers(&self, arc: usize) -> Vec<DVec3> {
        let (groups, paints) = (self.groups[arc], self.boxes.len());
        let center = |group: usize| {
            let members = (0..paints).filter(|k| groups.of(*k) == group);
            let (sum, n) =
                members.fold((DVec3::ZERO, 0.0), |(s, n), k| (s + self.box_center(k, arc), n + 1.0));
            sum / n
        };
        (0..groups.count(paints)).map(center).collect()
    }

    /// Numbers the groups of an arc by ascending lightness of their centers.
    fn number_groups(&mut self, arc: usize) {
        let paints = self.boxes.len();
        let centers = self.group_centers(arc);
        let mut order: Vec<usize> = (0..centers.len()).collect();
        order.sort_by(|a, b| centers[*a].x.total_cmp(&centers[*b].x));
        let rank = |group: usize| order.iter().position(|g| *g == group).unwrap_or_default();
        self.groups[arc] = Groups::new((0..paints).map(|k| rank(self.groups[arc].of(k))));
    }

    /// Arcs in ascending L, then a, b and the boxes themselves, so that the order depends on nothing but the arcs.
    fn sorted_by_lightness(self) -> Self {
        let mut order: Vec<usize> = (0..self.probabilities.len()).collect();
        order.sort_by_cached_key(|arc| {
            let center = self.center(*arc).to_array().map(total_order);
            let corners = self.boxes.iter().flat_map(|b| b[*arc].as_flattened().iter());
            (center, corners.map(|x| total_order(f64::from(*x))).collect::<Vec<u64>>())
        });
        Self {
            probabilities: order.iter().map(|k| self.probabilities[*k]).collect(),
            boxes: self.boxes.iter().map(|b| order.iter().map(|k| b[*k]).collect()).collect(),
            groups: order.iter().map(|k| self.groups[*k]).collect(),
            ..self
        }
    }
}

/// The groups of an arc that a box joins: that of the nearest center, or its own where all are farther than `threshold`.
fn joined(groups: Groups, paints: usize, centers: &[DVec3], new: DVec3, threshold: f64) -> Groups {
    let distances = centers.iter().map(|c| c.distance(new)).enumerate();
    let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, d)| *d <= threshold);
    let group = nearest.map_or(centers.len(), |(group, _)| group);
    Groups::new((0..paints).map(|k| groups.of(k)).chain([group]))
}

/// Standard deviation of the draws before the gain; bands between the clusters of a blend are left out.
fn deviation(statistics: &SliceStatistics) -> DVec3 {
    deviation_of_draws(&statistics.clusters, &[])
}

/// A finite number as an integer in the same order (IEEE 754 total order).
fn total_order(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}
