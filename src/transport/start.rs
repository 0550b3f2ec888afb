//! The plan that the network simplex starts from.

use super::dense::{Dense, cheapest, stride};
use super::lanes;
use super::mass::Mass;

/// A step of the construction: what `used_up` still holds goes to or comes from `partner`, which keeps a rest. Both are
/// nodes: sources, then targets.
pub(super) struct Shipment<M> {
    pub used_up: usize,
    pub partner: usize,
    pub flow: M,
}

/// A feasible spanning tree: always by the open arc that is cheapest against the means of its row and its column.
///
/// The means are a first guess of the duals (of the squared distance, the exact part of them), so that outlying sources
/// and targets are served while there is choice: a third to a half of the pivots that the cheapest arc by itself leaves.
/// Without degeneracy each shipment uses up either its source or its target, so there are as many as arcs in a tree.
pub(super) fn greedy<M: Mass>(mut supply: Vec<M>, mut demand: Vec<M>, costs: &Dense) -> Vec<Shipment<M>> {
    let (sources, targets) = (supply.len(), demand.len());
    let mut offsets = costs.column_means();
    offsets.iter_mut().for_each(|mean| *mean = -*mean);
    let means: Vec<f64> = (0..sources).map(|i| lanes::sum(costs.row(i)) / targets as f64).collect();
    let best_of = |i: usize, offsets: &[f64]| {
        let (j, above) = cheapest(costs.padded_row(i), offsets);
        (j, above - means[i])
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
        let (i, _) = cheapest(&best, &zeros);
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
