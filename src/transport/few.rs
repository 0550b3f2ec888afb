//! The network simplex on a few arcs: those that tied plans may use.

use super::dense::Arcs;
use super::mass::Mass;
use super::tree::Tree;

/// Pivots a tree of these arcs, sorted by source, until it is optimal for other costs of them; then those of reduced
/// cost 0.
pub(super) fn optimize<M: Mass>(arcs: &Arcs, cost: impl Fn(usize, usize) -> i64, tree: &mut Tree<M>) -> Arcs {
    tree.price(&cost);
    let arcs: Vec<(usize, usize, i64)> = arcs
        .iter()
        .map(|&(source, target)| (source as usize, target as usize))
        .map(|(source, target)| (source, target, cost(source, target)))
        .collect();
    // The sources take turns.
    let by_source = arcs.chunk_by(|a, b| a.0 == b.0);
    let (sources, mut idle) = (by_source.clone().count(), 0);
    for row in by_source.cycle() {
        let least =
            row.iter().min_by_key(|(source, target, cost)| tree.reduced_cost(*source, *target, *cost));
        let Some(&(source, target, cost)) = least else { break };
        let reduced_cost = tree.reduced_cost(source, target, cost);
        if reduced_cost < 0 {
            tree.pivot(source, target, reduced_cost);
            idle = 0;
        } else {
            idle += 1;
        }
        if idle == sources {
            break;
        }
    }
    let free = |(source, target, cost): &(usize, usize, i64)| tree.reduced_cost(*source, *target, *cost) == 0;
    arcs.iter().filter(|arc| free(arc)).map(|arc| (arc.0 as u32, arc.1 as u32)).collect()
}
