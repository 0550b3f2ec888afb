//! The costs of all arcs of a problem, and the network simplex on them.
//!
//! Pricing is by f64, two lanes at a time; what it proposes is decided in whole numbers, and so is whether the tree is
//! optimal.

use super::lanes;
use super::mass::Mass;
use super::tree::Tree;

/// Arcs are priced in blocks of this many.
const BLOCK: usize = 8;

/// A bound of the rounding in the f64 form of a reduced cost: potentials and costs are below 2^61, so each rounds by at most
/// 2^7, each of two sums of them by at most 2^9, and a cost is cut by less than 1.
const ROUNDING: i64 = 1 << 11;

/// Source and target of some arcs.
pub(super) type Arcs = Vec<(u32, u32)>;

/// Costs in units of the fixed point, not cut yet, source by source.
pub(super) struct Dense {
    targets: usize,
    /// Length of a row: whole blocks, filled up by costs beyond all others.
    stride: usize,
    costs: Vec<f64>,
    /// Mean cost of each source.
    pub row_means: Vec<f64>,
    /// Mean cost of each target, in whole blocks.
    pub column_means: Vec<f64>,
}

impl Dense {
    /// Of so many sources and targets, the row of each source appended by `extend`.
    pub fn new(sources: usize, targets: usize, extend: impl Fn(usize, &mut Vec<f64>)) -> Self {
        let stride = stride(targets);
        let mut costs = Vec::with_capacity(sources * stride);
        let mut row_means = Vec::with_capacity(sources);
        let mut column_means = vec![0.0; stride];
        for source in 0..sources {
            let start = costs.len();
            extend(source, &mut costs);
            let row = &costs[start..];
            row_means.push(lanes::sum(row) / targets as f64);
            column_means.iter_mut().zip(row).for_each(|(mean, cost)| *mean += cost);
            costs.resize(start + stride, f64::INFINITY);
        }
        column_means.iter_mut().for_each(|mean| *mean /= sources as f64);
        Self { targets, stride, costs, row_means, column_means }
    }

    /// What is left of the costs beyond the duals of an optimal tree, in units finer by `unit`, up to a `limit`.
    pub fn beyond<M: Mass>(&self, tree: &Tree<M>, unit: f64, limit: f64) -> Self {
        Self::new(self.sources(), self.targets, |source, row| {
            row.extend(self.row(source).iter().enumerate().map(|(target, cost)| {
                let whole = tree.reduced_cost(source, target, *cost as i64) as f64;
                ((whole + cost.fract()) * unit).min(limit)
            }));
        })
    }

    /// Number of sources and of targets.
    pub fn shape(&self) -> (usize, usize) {
        (self.sources(), self.targets)
    }

    fn sources(&self) -> usize {
        self.row_means.len()
    }

    /// Costs of a source, one a target.
    pub fn row(&self, source: usize) -> &[f64] {
        &self.costs[source * self.stride..][..self.targets]
    }

    /// Costs of a target, one a source.
    pub fn column(&self, target: usize) -> impl Iterator<Item = f64> {
        self.costs[target..].iter().step_by(self.stride).copied()
    }

    /// Costs of a source in whole blocks.
    pub fn padded_row(&self, source: usize) -> &[f64] {
        &self.costs[source * self.stride..][..self.stride]
    }

    /// Cost of an arc in fixed point.
    pub fn cost(&self, source: usize, target: usize) -> i64 {
        self.uncut(source, target) as i64
    }

    /// Cost of an arc in units of the fixed point.
    pub fn uncut(&self, source: usize, target: usize) -> f64 {
        self.costs[source * self.stride + target]
    }

    /// Pivots until the tree is optimal; then the arcs whose reduced cost is at most `slack` of the tree.
    pub fn optimize<M: Mass>(&self, tree: &mut Tree<M>, slack: impl Fn(&Tree<M>) -> i64) -> Arcs {
        loop {
            self.pivot(tree);
            if let Some(arcs) = self.within(tree, slack(tree)) {
                return arcs;
            }
        }
    }

    /// Pivots while the cheapest arc of some source in f64 has a negative reduced cost. The sources take turns.
    fn pivot<M: Mass>(&self, tree: &mut Tree<M>) {
        let sources = self.sources();
        let (mut source, mut idle) = (0, 0);
        while idle < sources {
            let row = self.padded_row(source);
            let (from, to) = tree.rounded_potentials();
            let least = least_sum(row, to);
            idle += 1;
            if least < from[source] {
                let target = place_of(least, row, to);
                let reduced_cost = tree.reduced_cost(source, target, row[target] as i64);
                if reduced_cost < 0 {
                    tree.pivot(source, target, reduced_cost);
                    idle = 0;
                }
            }
            source = if source + 1 == sources { 0 } else { source + 1 };
        }
    }

    /// The arcs of reduced cost up to `slack`; none if some are negative, of which the first of each source is brought in.
    fn within<M: Mass>(&self, tree: &mut Tree<M>, slack: i64) -> Option<Arcs> {
        let mut arcs = Arcs::with_capacity(tree.len() - 1);
        let mut optimal = true;
        for source in 0..self.sources() {
            let (from, to) = tree.rounded_potentials();
            let most = from[source] + (slack + ROUNDING) as f64;
            for (target, (cost, potential)) in self.row(source).iter().zip(to).enumerate() {
                if cost + potential <= most {
                    let reduced_cost = tree.reduced_cost(source, target, *cost as i64);
                    if reduced_cost < 0 {
                        tree.pivot(source, target, reduced_cost);
                        optimal = false;
                        break;
                    }
                    if reduced_cost <= slack {
                        arcs.push((source as u32, target as u32));
                    }
                }
            }
        }
        optimal.then_some(arcs)
    }
}

/// Length of a row of so many targets.
pub(super) fn stride(targets: usize) -> usize {
    targets.next_multiple_of(BLOCK)
}

/// The least sum. Both slices are whole blocks.
pub(super) fn least_sum(costs: &[f64], potentials: &[f64]) -> f64 {
    let min = |a: f64, b: f64| if a < b { a } else { b };
    let mut lanes = [f64::INFINITY; BLOCK];
    for (costs, potentials) in costs.as_chunks::<BLOCK>().0.iter().zip(potentials.as_chunks::<BLOCK>().0) {
        lanes = std::array::from_fn(|k| min(costs[k] + potentials[k], lanes[k]));
    }
    // Halves against each other, so that lanes work side by side to the end.
    let [a, b, c, d] = std::array::from_fn(|k| min(lanes[k], lanes[k + 4]));
    min(min(a, c), min(b, d))
}

/// The first place where the sum is what it is somewhere.
pub(super) fn place_of(sum: f64, costs: &[f64], potentials: &[f64]) -> usize {
    let (costs, potentials) = (costs.as_chunks::<BLOCK>().0, potentials.as_chunks::<BLOCK>().0);
    let is_sum = |block: usize, k: usize| costs[block][k] + potentials[block][k] == sum;
    let found = |&block: &usize| (0..BLOCK).fold(false, |found, k| found | is_sum(block, k));
    let block = (0..costs.len().min(potentials.len())).find(found).unwrap_or(0);
    block * BLOCK + (0..BLOCK).find(|&k| is_sum(block, k)).unwrap_or(0)
}
