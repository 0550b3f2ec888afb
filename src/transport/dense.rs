//! The costs of all arcs of a problem, and the network simplex on them.
//!
//! Pricing is by f64, two lanes at a time; what it proposes is decided in whole numbers, and so is whether the tree is
//! optimal.

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
}

impl Dense {
    pub fn new<'a>(
        rows: impl ExactSizeIterator<Item = impl Iterator<Item = f64> + 'a>,
        targets: usize,
    ) -> Self {
        let stride = stride(targets);
        let mut costs = Vec::with_capacity(rows.len() * stride);
        for row in rows {
            costs.extend(row);
            costs.resize(costs.len().next_multiple_of(stride), f64::INFINITY);
        }
        Self { targets, stride, costs }
    }

    /// The same size with these arcs only, at other costs.
    pub fn restricted(&self, arcs: &Arcs, cost: impl Fn(usize, usize, f64) -> f64) -> Self {
        let mut costs = vec![f64::INFINITY; self.costs.len()];
        for &(source, target) in arcs {
            let (source, target) = (source as usize, target as usize);
            let place = source * self.stride + target;
            costs[place] = cost(source, target, self.costs[place]);
        }
        Self { costs, ..*self }
    }

    pub fn sources(&self) -> usize {
        self.costs.len() / self.stride
    }

    /// Costs of a source, one a target.
    pub fn row(&self, source: usize) -> &[f64] {
        &self.costs[source * self.stride..][..self.targets]
    }

    /// Costs of a source in whole blocks.
    pub fn padded_row(&self, source: usize) -> &[f64] {
        &self.costs[source * self.stride..][..self.stride]
    }

    /// Mean cost of each target, in whole blocks.
    pub fn column_means(&self) -> Vec<f64> {
        let mut means = vec![0.0; self.stride];
        for row in self.costs.chunks_exact(self.stride) {
            means.iter_mut().zip(row).for_each(|(mean, cost)| *mean += cost);
        }
        let sources = self.sources() as f64;
        means.iter_mut().for_each(|mean| *mean = if mean.is_finite() { *mean / sources } else { 0.0 });
        means
    }

    /// Cost of an arc in fixed point.
    pub fn cost(&self, source: usize, target: usize) -> i64 {
        self.costs[source * self.stride + target] as i64
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
            let (target, _) = cheapest(row, tree.rounded_potentials().1);
            let reduced_cost = tree.reduced_cost(source, target, row[target] as i64);
            if reduced_cost < 0 {
                tree.pivot(source, target, reduced_cost);
                idle = 0;
            } else {
                idle += 1;
            }
            source = (source + 1) % sources;
        }
    }

    /// The arcs of reduced cost up to `slack`; if one is negative, which rounding has hidden, it is brought in instead.
    fn within<M: Mass>(&self, tree: &mut Tree<M>, slack: i64) -> Option<Arcs> {
        let mut arcs = Arcs::with_capacity(tree.len() - 1);
        for source in 0..self.sources() {
            let (from, to) = tree.rounded_potentials();
            let most = from[source] + (slack + ROUNDING) as f64;
            for (target, (cost, potential)) in self.row(source).iter().zip(to).enumerate() {
                if cost + potential <= most {
                    let reduced_cost = tree.reduced_cost(source, target, *cost as i64);
                    if reduced_cost < 0 {
                        tree.pivot(source, target, reduced_cost);
                        return None;
                    }
                    if reduced_cost <= slack {
                        arcs.push((source as u32, target as u32));
                    }
                }
            }
        }
        Some(arcs)
    }
}

/// Length of a row of so many targets.
pub(super) fn stride(targets: usize) -> usize {
    targets.next_multiple_of(BLOCK)
}

/// The first place where the sum is least, and that sum. Both slices are whole blocks.
pub(super) fn cheapest(costs: &[f64], potentials: &[f64]) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for (block, (costs, potentials)) in
        costs.as_chunks::<BLOCK>().0.iter().zip(potentials.as_chunks::<BLOCK>().0).enumerate()
    {
        let above: [f64; BLOCK] = std::array::from_fn(|k| costs[k] + potentials[k]);
        let least = least(above);
        if least < best.1 {
            best = (block, least);
        }
    }
    let start = best.0 * BLOCK;
    let above = costs[start..].iter().zip(&potentials[start..]).map(|(cost, potential)| cost + potential);
    (start + above.take(BLOCK).position(|above| above == best.1).unwrap_or(0), best.1)
}

/// Least of a block, halves against each other so that lanes work side by side.
fn least(x: [f64; BLOCK]) -> f64 {
    let min = |a: f64, b: f64| if a < b { a } else { b };
    let [a, b, c, d] = std::array::from_fn(|k| min(x[k], x[k + 4]));
    min(min(a, c), min(b, d))
}
