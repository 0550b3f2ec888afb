//! The plan that the network simplex starts from.

use super::dense::{Dense, least_sum, place_of, stride};
use super::mass::Mass;

/// A step of the construction: what `used_up` still holds goes to or comes from `partner`, which keeps a rest. Both are
/// nodes: sources, then targets.
pub(super) struct Shipment<M> {
    pub used_up: usize,
    pub partner: usize,
    pub flow: M,
}

/// A feasible spanning tree that is cheap: on a line (gray paints) the monotone one, which ties are broken to, so that no
/// pivot is left, or few.
pub(super) fn start<M: Mass>(supply: Vec<M>, demand: Vec<M>, costs: &Dense) -> Vec<Shipment<M>> {
    let (sources, targets) = costs.shape();
    if sources < 2 || targets < 2 || !may_be_lengths_on_a_line(costs) {
        return greedy(supply, demand, costs);
    }
    let square = |i: usize, j: usize| costs.uncut(i, j) * costs.uncut(i, j);
    // Linear along the line: falling with the sources towards target 0, and with the targets towards source 0.
    let of_source = |i: usize| square(i, 0) - square(i, 1);
    let of_target = |j: usize| square(0, j) - square(1, j);
    let forwards = if of_source(0) < of_source(1) { 1.0 } else { -1.0 };
    let sorted = |count: usize, key: &dyn Fn(usize) -> f64| {
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
        order
    };
    let order = [sorted(sources, &|i| forwards * of_source(i)), sorted(targets, &of_target)];
    monotone(supply, demand, &order)
}

/// Source by source to target by target, in these orders.
pub(super) fn monotone<M: Mass>(
    mut supply: Vec<M>,
    mut demand: Vec<M>,
    [sources, targets]: &[Vec<usize>; 2],
) -> Vec<Shipment<M>> {
    let nodes = supply.len() + demand.len();
    let (mut from, mut to) = (0, 0);
    let mut shipments = Vec::with_capacity(nodes - 1);
    while shipments.len() < nodes - 1 {
        let (i, j) = (sources[from], targets[to]);
        let target = supply.len() + j;
        if supply[i] < demand[j] {
            shipments.push(Shipment { used_up: i, partner: target, flow: supply[i] });
            demand[j] = demand[j] - supply[i];
            from += 1;
        } else {
            shipments.push(Shipment { used_up: target, partner: i, flow: demand[j] });
            supply[i] = supply[i] - demand[j];
            to += 1;
        }
    }
    shipments
}

/// Whether the first two sources and each target keep the law of three points on a line: the way between the sources is
/// the difference of those to the target, or their sum.
fn may_be_lengths_on_a_line(costs: &Dense) -> bool {
    let pairs = || costs.row(0).iter().zip(costs.row(1));
    let difference = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let sum = pairs().map(|(a, b)| a + b).fold(f64::INFINITY, f64::min);
    // Far above rounding, far below what colors differ by.
    let keeps =
        |(a, b): (&f64, &f64)| (a - b).abs() >= difference - 1e-9 * (a + b) || a + b <= sum * (1.0 + 1e-9);
    pairs().all(keeps)
}

/// Always by the open arc that is cheapest against the means of its row and its column.
///
/// The means are a first guess of the duals (of the squared distance, the exact part of them), so that outlying sources
/// and targets are served while there is choice: a third to a half of the pivots that the cheapest arc by itself leaves.
/// Without degeneracy each shipment uses up either its source or its target, so there are as many as arcs in a tree.
fn greedy<M: Mass>(mut supply: Vec<M>, mut demand: Vec<M>, costs: &Dense) -> Vec<Shipment<M>> {
    let (sources, targets) = (supply.len(), demand.len());
    let mut offsets: Vec<f64> = costs.column_means.iter().map(|mean| -mean).collect();
    let best_of = |i: usize, offsets: &[f64]| {
        let row = costs.padded_row(i);
        let least = least_sum(row, offsets);
        (place_of(least, row, offsets), least - costs.row_means[i])
    };
    // The best arc of each source; a used up target stands in it until its turn comes.
    let mut best_target = vec![0; sources];
    let mut best = vec![f64::INFINITY; stride(sources)];
    for i in 0..sources {
        (best_target[i], best[i]) = best_of(i, &offsets);
    }
    let zeros = vec![0.0; best.len()];
    let mut shipments = Vec::with_capacity(sources + targets - 1);
    while shipments.len() < sources + targets - 1 {
        let i = place_of(least_sum(&best, &zeros), &best, &zeros);
        let j = best_target[i];
        if offsets[j] == f64::INFINITY {
            (best_target[i], best[i]) = best_of(i, &offsets);
        } else if supply[i] < demand[j] {
            shipments.push(Shipment { used_up: i, partner: sources + j, flow: supply[i] });
            demand[j] = demand[j] - supply[i];
            best[i] = f64::INFINITY;
        } else {
            shipments.push(Shipment { used_up: sources + j, partner: i, flow: demand[j] });
            supply[i] = supply[i] - demand[j];
            offsets[j] = f64::INFINITY;
        }
    }
    shipments
}
