//! Exact network simplex on the complete bipartite graph.
//!
//! All arithmetic is on whole numbers. Masses are exact multiples of a common power of two ([`super::mass`]); costs are
//! cut once to fixed point of at least 47 bits, 52 for 300 clusters. So there is no tolerance to choose: the tree it
//! ends with is optimal for the cut costs, its flows are those of the masses, and only writing them as f64 rounds.
//!
//! **No cycling.** Every mass is perturbed by less than its last bit: each supply by +1, each demand by -1, the largest
//! demand by what balances (Orden 1956; the strongly feasible trees of Cunningham 1976 are its symbolic form). Then
//! every arc of every feasible tree carries a positive flow, every pivot lowers the cost, and the arc that leaves is
//! unique. Rounding a flow to the unit of the masses takes the perturbation away.
//!
//! **Ties.** Many plans may cost the same: two distributions on a line (gray paints) have a continuum of them. Among
//! the plans within a tenth of the promised gap the one with the least `sum w^2 x` is taken: nearby moves rather than
//! a long one and a short one, the monotone plan on a line. What still ties, coincident centers above all, is decided by
//! the order of the sources and targets, since pivots follow that order from a start that does.

use super::certificate::Potentials;
use super::mass::{Mass, Scale, Wide};
use super::problem::Problem;
use super::tree::{Shipment, Tree};

/// Plans that cost at most this much more, relative to max(cost, mean cost / 1000), are tied: a tenth of the promised
/// gap of 1e-12.
const TIE: f64 = 1e-13;

/// Fixed-point cost of an arc that must not enter: above every reduced cost, and sums of it with potentials stay in i64.
const FORBIDDEN: i64 = 1 << 62;

/// An optimal plan and the duals that prove it.
pub(super) struct Optimum {
    pub entries: Vec<(usize, usize, f64)>,
    pub potentials: Potentials,
}

/// Solves a problem.
pub(super) fn solve(problem: &Problem) -> Optimum {
    let live = Live::new(problem);
    let masses = || live.sources.iter().map(|&i| problem.supply()[i]).chain(live.demands(problem));
    let total = problem.supply().iter().sum();
    let scale = Scale::new(masses(), total, live.sources.len() + live.targets.len());
    if scale.bits <= <u128 as Mass>::BITS {
        live.solve::<u128>(problem, scale)
    } else {
        live.solve::<Wide>(problem, scale)
    }
}

/// The sources and targets that have mass.
struct Live {
    sources: Vec<usize>,
    targets: Vec<usize>,
}

impl Live {
    fn new(problem: &Problem) -> Self {
        let positive = |masses: &[f64]| (0..masses.len()).filter(|&k| masses[k] > 0.0).collect();
        Self { sources: positive(problem.supply()), targets: positive(problem.demand()) }
    }

    fn demands(&self, problem: &Problem) -> impl Iterator<Item = f64> {
        self.targets.iter().map(|&j| problem.demand()[j])
    }

    fn solve<M: Mass>(&self, problem: &Problem, scale: Scale) -> Optimum {
        let fixed = FixedPoint::new(problem, self.sources.len().min(self.targets.len()));
        let costs = self.costs(problem, |cost| fixed.encode(cost));
        let (supply, demand, largest) = self.masses::<M>(problem, scale);
        let mut tree = Tree::grow(supply.len(), demand.len(), &greedy(supply, demand, &costs));
        tree.price(&costs);
        tree.optimize(&costs);
        let potentials = self.potentials(problem, &tree, fixed, largest);
        self.break_ties(problem, scale, fixed, &costs, &mut tree);
        let mut entries: Vec<_> = tree
            .arcs()
            .map(|(i, j, flow)| (self.sources[i], self.targets[j], scale.decode(flow)))
            .filter(|entry| entry.2 > 0.0)
            .collect();
        entries.sort_unstable_by_key(|&(i, j, _)| (i, j));
        Optimum { entries, potentials }
    }

    fn costs(&self, problem: &Problem, encode: impl Fn(f64) -> i64) -> Vec<i64> {
        let mut costs = Vec::with_capacity(self.sources.len() * self.targets.len());
        for &i in &self.sources {
            let row = problem.cost_row(i);
            costs.extend(self.targets.iter().map(|&j| encode(row[j])));
        }
        costs
    }

    /// Perturbed supplies and demands, and which demand is the largest: it takes what balances the two sides.
    fn masses<M: Mass>(&self, problem: &Problem, scale: Scale) -> (Vec<M>, Vec<M>, usize) {
        let (zero, one) = (M::shifted(0, 0), M::shifted(1, 0));
        let supply: Vec<M> =
            self.sources.iter().map(|&i| scale.encode::<M>(problem.supply()[i]) + one).collect();
        let mut demand: Vec<M> = self.demands(problem).map(|mass| scale.encode::<M>(mass) - one).collect();
        let largest = (0..demand.len()).rev().max_by_key(|&j| demand[j]).unwrap_or(0);
        demand[largest] = zero;
        let add = |sum: M, mass: &M| sum + *mass;
        demand[largest] = supply.iter().fold(zero, add) - demand.iter().fold(zero, add);
        (supply, demand, largest)
    }

    /// Duals of all sources and targets, 0 for the largest demand: what it bears of the imbalance costs nothing.
    fn potentials<M: Mass>(
        &self,
        problem: &Problem,
        tree: &Tree<M>,
        fixed: FixedPoint,
        largest: usize,
    ) -> Potentials {
        let (u, v) = tree.duals(largest);
        let mut source = vec![f64::INFINITY; problem.supply().len()];
        let mut target = vec![f64::NEG_INFINITY; problem.demand().len()];
        self.sources.iter().zip(u).for_each(|(&i, u)| source[i] = fixed.decode(u));
        self.targets.iter().zip(v).for_each(|(&j, v)| target[j] = fixed.decode(v));
        // Without mass any feasible dual will do.
        for i in (0..source.len()).filter(|&i| problem.supply()[i] == 0.0) {
            source[i] =
                problem.cost_row(i).iter().zip(&target).map(|(w, v)| w - v).fold(f64::INFINITY, f64::min);
        }
        for j in (0..target.len()).filter(|&j| problem.demand()[j] == 0.0) {
            target[j] =
                source.iter().enumerate().map(|(i, u)| problem.cost(i, j) - u).fold(f64::INFINITY, f64::min);
        }
        Potentials { source, target }
    }

    /// Moves from an optimal tree to the one of least squared cost among the tied ones.
    fn break_ties<M: Mass>(
        &self,
        problem: &Problem,
        scale: Scale,
        fixed: FixedPoint,
        costs: &[i64],
        tree: &mut Tree<M>,
    ) {
        let moved = |(i, j, flow): (usize, usize, M)| {
            scale.decode(flow) * problem.cost(self.sources[i], self.targets[j])
        };
        let total: f64 = problem.supply().iter().sum();
        let mean_move = tree.arcs().map(moved).sum::<f64>() / total;
        let slack = fixed.encode(TIE * mean_move.max(1e-3 * problem.mean_cost()));
        let arcs = self.sources.len() + self.targets.len() - 1;
        if tree.reduced_costs(costs).filter(|&reduced| reduced <= slack).count() > arcs {
            let squares = self.costs(problem, |cost| fixed.encode_square(cost));
            let tied = tree.reduced_costs(costs).zip(squares);
            let tied: Vec<i64> =
                tied.map(|(reduced, square)| if reduced <= slack { square } else { FORBIDDEN }).collect();
            tree.price(&tied);
            tree.optimize(&tied);
        }
    }
}

/// A feasible spanning tree: source by source, to the cheapest targets left.
///
/// Without degeneracy each shipment uses up either its source or its target, so there are as many as arcs in a tree.
fn greedy<M: Mass>(mut supply: Vec<M>, mut demand: Vec<M>, costs: &[i64]) -> Vec<Shipment<M>> {
    let zero = M::shifted(0, 0);
    let (sources, targets) = (supply.len(), demand.len());
    let mut shipments = Vec::with_capacity(sources + targets - 1);
    let mut open: Vec<usize> = (0..targets).collect();
    for (i, row) in costs.chunks_exact(targets).enumerate() {
        while supply[i] > zero {
            let Some(k) = (0..open.len()).min_by_key(|&k| (row[open[k]], open[k])) else { break };
            let j = open[k];
            if supply[i] < demand[j] {
                shipments.push(Shipment { used_up: i, partner: sources + j, flow: supply[i] });
                demand[j] = demand[j] - supply[i];
                supply[i] = zero;
            } else {
                shipments.push(Shipment { used_up: sources + j, partner: i, flow: demand[j] });
                supply[i] = supply[i] - demand[j];
                open.swap_remove(k);
            }
        }
    }
    shipments
}

/// Costs as whole numbers.
#[derive(Clone, Copy)]
struct FixedPoint {
    /// Costs are below 2^exponent,
    exponent: i32,
    /// which becomes 2^bits.
    bits: i32,
    /// `2^(bits - exponent)`, which may exceed f64, as a product.
    factors: [f64; 2],
}

impl FixedPoint {
    /// A potential is an alternating sum along a path, on which each sign occurs at most `smaller_side` times: all stay
    /// below 2^61 in absolute value.
    fn new(problem: &Problem, smaller_side: usize) -> Self {
        let exponent = libm::frexp(problem.largest_cost()).1;
        let bits = 60 - smaller_side.ilog2() as i32;
        let shift = bits - exponent;
        Self { exponent, bits, factors: [shift / 2, shift - shift / 2].map(|shift| libm::ldexp(1.0, shift)) }
    }

    fn encode(self, cost: f64) -> i64 {
        (cost * self.factors[0] * self.factors[1]) as i64
    }

    fn encode_square(self, cost: f64) -> i64 {
        let fraction = libm::ldexp(cost, -self.exponent);
        libm::ldexp(fraction * fraction, self.bits) as i64
    }

    fn decode(self, cost: i64) -> f64 {
        libm::ldexp(cost as f64, self.exponent - self.bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Solver, solve};

    /// Masses over the whole range of f64 that leave through the same column.
    #[test]
    fn the_smallest_masses_are_not_lost() {
        let p = [0.5, 1e-300, 0.25, 5e-324, 0.25, 1e-17];
        let q = [0.375, 1e-310, 0.625, 3e-17, 1e-200];
        let problem = Problem::from_fn(&p, &q, |i, j| ((7 * i + 5 * j) % 11) as f64).expect("legal");
        let plan = solve(&problem, Solver::NetworkSimplex).expect("solvable");
        // Exact flows: each entry and each addition of a sum rounds once.
        assert!(plan.certificate.row_error <= 8.0 * f64::EPSILON, "{plan:?}");
        assert!(plan.certificate.column_error <= 8.0 * f64::EPSILON, "{plan:?}");
        assert!((0..p.len()).all(|i| plan.entries.iter().any(|entry| entry.0 == i)));
        assert!((0..q.len()).all(|j| plan.entries.iter().any(|entry| entry.1 == j)));
    }

    /// On a line every plan that never moves mass backwards is optimal: the tie rule takes the sorted one.
    #[test]
    fn ties_on_a_line_give_the_monotone_plan() {
        let n = 40;
        let p: Vec<f64> = (0..n).map(|k| f64::from(1 + k % 7)).collect();
        let mut q = p.clone();
        q.reverse();
        // All targets lie beyond all sources, at distances that rounding makes unequal.
        let at = |k: usize| 0.1 * k as f64;
        let problem = Problem::from_fn(&p, &q, |i, j| 100.0 / 3.0 + at(j) - at(i)).expect("legal");
        let plan = solve(&problem, Solver::NetworkSimplex).expect("solvable");
        assert!(plan.entries.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{:?}", plan.entries);
        assert!(plan.certificate.gap <= 1e-12 * plan.certificate.cost);
    }

    #[test]
    fn masses_of_zero_have_feasible_duals_and_no_flow() {
        let problem =
            Problem::from_fn(&[0.0, 2.0, 0.0], &[1.5, 0.0, 0.5], |i, j| (i + 3 * j) as f64).expect("legal");
        let plan = solve(&problem, Solver::NetworkSimplex).expect("solvable");
        assert_eq!(plan.entries, [(1, 0, 1.5), (1, 2, 0.5)]);
        assert_eq!(plan.certificate.gap, 0.0);
        assert_eq!(plan.certificate.worst_reduced_cost, 0.0);
    }

    #[test]
    fn free_moves_cost_nothing() {
        let problem = Problem::from_fn(&[0.3, 0.7], &[0.6, 0.4], |_, _| 0.0).expect("legal");
        let plan = solve(&problem, Solver::NetworkSimplex).expect("solvable");
        assert_eq!((plan.certificate.cost, plan.certificate.gap), (0.0, 0.0));
    }

    /// The scale of masses and costs does not matter, up to powers of two.
    #[test]
    fn extreme_units_change_nothing() {
        let (p, q) = ([0.25, 0.5, 0.25], [0.125, 0.125, 0.75]);
        let w = |i: usize, j: usize| ((5 * i + 3 * j) % 7) as f64;
        let plain =
            solve(&Problem::from_fn(&p, &q, w).expect("legal"), Solver::NetworkSimplex).expect("solvable");
        for (mass_exponent, cost_exponent) in [(-900, 0), (450, 450), (0, -1060), (-1060, 490), (450, -1060)]
        {
            let mass = |x: &f64| libm::ldexp(*x, mass_exponent);
            let (p, q) = (p.each_ref().map(mass), q.each_ref().map(mass));
            let problem =
                Problem::from_fn(&p, &q, |i, j| libm::ldexp(w(i, j), cost_exponent)).expect("legal");
            let plan = solve(&problem, Solver::NetworkSimplex).expect("solvable");
            let expected: Vec<_> = plain.entries.iter().map(|(i, j, x)| (*i, *j, mass(x))).collect();
            assert_eq!(plan.entries, expected, "{mass_exponent} {cost_exponent}");
        }
    }
}
