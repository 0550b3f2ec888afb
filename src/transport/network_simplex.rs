//! Exact network simplex on the complete bipartite graph.
//!
//! All arithmetic is on whole numbers. Masses are exact multiples of a common power of two ([`super::mass`]); costs are
//! cut to fixed point of at least 47 bits, 52 for 300 clusters. So there is no tolerance to choose: the tree it ends with
//! is optimal for the cut costs, its flows are those of the masses, and only writing them as f64 rounds. Where plans cost
//! so little beside the dearest move that the cut could show in the gap, pivots go on with what the costs exceed the
//! duals by, in units 2^-24 as large.
//!
//! **No cycling.** Every mass is perturbed by less than its last bit: each supply by +1, each demand by -1, the largest
//! demand by what balances (Orden 1956; the strongly feasible trees of Cunningham 1976 are its symbolic form). Then
//! every arc of every feasible tree carries a positive flow, every pivot lowers the cost, and the arc that leaves is
//! unique. Rounding a flow to the unit of the masses takes the perturbation away.
//!
//! **Coincident points** are one, and their plan is then dealt out in their order ([`super::coincident`]).
//!
//! **Ties.** Many plans may cost the same: two distributions on a line (gray paints) have a continuum of them, and under
//! a capped cost all far moves tie. Among the plans within a tenth of the promised gap the one with the least
//! `sum w^2 x` is taken: nearby moves rather than a long one and a short one, the monotone plan on a line. Among those it
//! is the one that is most nearly monotone in the order of the sources and the targets ([`super::tie`]). Without
//! degeneracy the duals of each of these stages are unique, and so are the arcs that the next one may use; the stages end
//! when those are a tree, which carries but one plan. So the plan is a function of the problem: it does not depend on
//! where the pivots begin or how they are chosen. Where costs and squares alone decide, as for centers in general
//! position, neither does it depend on the order of the clusters.

use super::certificate::Potentials;
use super::coincident::{Points, deal};
use super::dense::{Arcs, Dense};
use super::few;
use super::fixed_point::FixedPoint;
use super::mass::{Mass, Scale, Wide};
use super::problem::Problem;
use super::start::{Shipment, start};
use super::sum::Sum;
use super::tie::Objective;
use super::tree::{Duals, Tree};

/// Plans that cost at most this much more, relative to max(cost, mean cost / 1000), are tied: a tenth of the promised
/// gap of 1e-12.
const TIE: f64 = 1e-13;

/// An optimal plan and the duals that prove it.
pub(super) struct Optimum {
    pub entries: Vec<(usize, usize, f64)>,
    /// Rounded, and what rounding took from them.
    pub potentials: [Potentials; 2],
}

/// Solves a problem.
pub(super) fn solve(problem: &Problem) -> Optimum {
    let live = Live::new(problem);
    let total = problem.supply().iter().sum();
    let scale = Scale::new(live.supplies().chain(live.demands()), total, live.points());
    if scale.bits <= <u64 as Mass>::BITS {
        live.solve::<u64>(scale, start)
    } else if scale.bits <= <u128 as Mass>::BITS {
        live.solve::<u128>(scale, start)
    } else {
        live.solve::<Wide>(scale, start)
    }
}

/// Makes a feasible spanning tree of supplies, demands and costs.
type Start<M> = fn(Vec<M>, Vec<M>, &Dense) -> Vec<Shipment<M>>;

/// The sources and targets that have mass, and what moves between their places cost.
struct Live<'a> {
    problem: &'a Problem,
    sources: Points,
    targets: Points,
    fixed: FixedPoint,
    costs: Dense,
}

impl<'a> Live<'a> {
    fn new(problem: &'a Problem) -> Self {
        let positive =
            |masses: &[f64]| (0..masses.len()).filter(|&k| masses[k] > 0.0).collect::<Vec<usize>>();
        let (sources, targets) = (positive(problem.supply()), positive(problem.demand()));
        let fixed = FixedPoint::new(problem, sources.len().min(targets.len()));
        let costs = |sources: &[usize], targets: &[usize]| {
            Dense::new(sources.len(), targets.len(), |source, scaled| {
                let row = problem.cost_row(sources[source]);
                if row.len() == targets.len() {
                    scaled.extend(row.iter().map(|&cost| fixed.scale(cost)));
                } else {
                    scaled.extend(targets.iter().map(|&j| fixed.scale(row[j])));
                }
            })
        };
        let all = costs(&sources, &targets);
        let sources = Points::new(&sources, &all.row_means, |a, b| all.row(a) == all.row(b));
        let targets = Points::new(&targets, &all.column_means, |a, b| all.column(a).eq(all.column(b)));
        let costs = if (sources.len(), targets.len()) == all.shape() {
            all
        } else {
            let firsts = |points: &Points| points.firsts().collect::<Vec<_>>();
            costs(&firsts(&sources), &firsts(&targets))
        };
        Self { problem, sources, targets, fixed, costs }
    }

    /// Number of points, coincident ones counted each.
    fn points(&self) -> usize {
        self.sources.numbers().len() + self.targets.numbers().len()
    }

    fn supplies(&self) -> impl Iterator<Item = f64> {
        self.sources.numbers().iter().map(|&i| self.problem.supply()[i])
    }

    fn demands(&self) -> impl Iterator<Item = f64> {
        self.targets.numbers().iter().map(|&j| self.problem.demand()[j])
    }

    /// From the tree of any feasible plan: what it ends with does not depend on it.
    fn solve<M: Mass>(&self, scale: Scale, start: Start<M>) -> Optimum {
        let (supply, demand) = self.masses::<M>(scale);
        let (at_sources, at_targets) = (self.sources.sums(&supply), self.targets.sums(&demand));
        let mut tree =
            Tree::grow(at_sources.len(), at_targets.len(), &start(at_sources, at_targets, &self.costs));
        tree.price(|i, j| self.costs.cost(i, j));
        let origin = self.origin();
        let mut finer = Duals { source: vec![0; self.sources.len()], target: vec![0; self.targets.len()] };
        let slack = |tree: &Tree<M>| {
            let [potentials, _] = self.potentials(&tree.duals(origin), &finer);
            self.slack(&potentials)
        };
        let mut tied = self.costs.optimize(&mut tree, |tree| slack(tree) as i64);
        let (whole, slack) = (tree.duals(origin), slack(&tree));
        if slack < 1.0 {
            // What cutting took from the costs could exceed it, and so the promised gap.
            let rest = self.costs.beyond(&tree, FixedPoint::FINER, libm::ldexp(1.0, self.fixed.bits));
            tree.price(|i, j| rest.cost(i, j));
            tied = rest.optimize(&mut tree, |_| (slack * FixedPoint::FINER) as i64);
            finer = tree.duals(origin);
        }
        self.break_ties(tied, &mut tree);
        let mut flows: Vec<_> = tree.arcs().collect();
        flows.sort_unstable_by_key(|&(i, j, _)| (i, j));
        let mut entries: Vec<_> = deal(&flows, (&self.sources, supply), (&self.targets, demand))
            .into_iter()
            .map(|(i, j, flow)| (i, j, scale.decode(flow)))
            .filter(|entry| entry.2 > 0.0)
            .collect();
        entries.sort_unstable_by_key(|&(i, j, _)| (i, j));
        Optimum { entries, potentials: self.potentials(&whole, &finer) }
    }

    /// Perturbed supplies and demands, place by place; the largest demand takes what balances the two sides.
    fn masses<M: Mass>(&self, scale: Scale) -> (Vec<M>, Vec<M>) {
        let (zero, one) = (M::shifted(0, 0), M::shifted(1, 0));
        let supply: Vec<M> = self.supplies().map(|mass| scale.encode::<M>(mass) + one).collect();
        let mut demand: Vec<M> = self.demands().map(|mass| scale.encode::<M>(mass) - one).collect();
        let largest = (0..demand.len()).rev().max_by_key(|&j| demand[j]).unwrap_or(0);
        demand[largest] = zero;
        let add = |sum: M, mass: &M| sum + *mass;
        demand[largest] = supply.iter().fold(zero, add) - demand.iter().fold(zero, add);
        (supply, demand)
    }

    /// Where the largest demand is: v is 0 there, as what it bears of the imbalance costs nothing.
    fn origin(&self) -> usize {
        let demands = self.targets.placed().map(|(j, place)| (self.problem.demand()[j], place));
        demands.reduce(|most, next| if next.0 > most.0 { next } else { most }).map_or(0, |(_, place)| place)
    }

    /// Duals of all sources and targets, rounded, and what rounding takes from them.
    fn potentials(&self, whole: &Duals, finer: &Duals) -> [Potentials; 2] {
        let side = |points: &Points, count: usize, whole: &[i64], finer: &[i64]| {
            let (mut rounded, mut rest) = (vec![f64::NAN; count], vec![0.0; count]);
            for (number, place) in points.placed() {
                (rounded[number], rest[number]) = self.fixed.decode(whole[place], finer[place]);
            }
            (rounded, rest)
        };
        let (mut source, rest_of_source) =
            side(&self.sources, self.problem.supply().len(), &whole.source, &finer.source);
        let (mut target, rest_of_target) =
            side(&self.targets, self.problem.demand().len(), &whole.target, &finer.target);
        // Without mass any feasible dual will do: as low as others can be high, with room for their rounding.
        let low = |others: &[f64]| {
            -(1.0 + 2.0 * f64::EPSILON) * others.iter().fold(0.0, |most: f64, dual| most.max(dual.abs()))
        };
        let lowest = [low(&target), low(&source)];
        for (duals, low) in [&mut source, &mut target].into_iter().zip(lowest) {
            duals.iter_mut().filter(|dual| dual.is_nan()).for_each(|dual| *dual = low);
        }
        [Potentials { source, target }, Potentials { source: rest_of_source, target: rest_of_target }]
    }

    /// How much dearer than its duals an arc of a tied plan can be, in units of the fixed point.
    ///
    /// From the duals rather than the flows: they are the same whichever of the tied plans the pivots came to.
    fn slack(&self, potentials: &Potentials) -> f64 {
        let mut bound = Sum::default();
        for (masses, duals) in
            [(self.problem.supply(), &potentials.source), (self.problem.demand(), &potentials.target)]
        {
            masses.iter().zip(duals).for_each(|(mass, dual)| bound.add_product(*mass, *dual));
        }
        let mean_move = bound.value() / self.problem.supply().iter().sum::<f64>();
        self.fixed.scale(TIE * mean_move.max(1e-3 * self.problem.mean_cost()))
    }

    /// Moves from an optimal tree to the canonical one of those on tied arcs.
    fn break_ties<M: Mass>(&self, mut tied: Arcs, tree: &mut Tree<M>) {
        for objective in Objective::sequence(self.sources.len(), self.targets.len(), self.fixed.bits) {
            if tied.len() < tree.len() {
                // A tree alone carries but one plan: it is proved that no other is as good.
                return;
            }
            tied = few::optimize(&tied, |i, j| objective.cost(i, j, self.costs.uncut(i, j)) as i64, tree);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::start::monotone;
    use crate::transport::{Solver, solve};

    /// Source by source to target by target, whatever that costs.
    fn north_west_corner<M: Mass>(supply: Vec<M>, demand: Vec<M>, _: &Dense) -> Vec<Shipment<M>> {
        let order = [supply.len(), demand.len()].map(|count| (0..count).collect());
        monotone(supply, demand, &order)
    }

    #[test]
    fn the_plan_does_not_depend_on_the_start() {
        let mut next =
            (0_u32..).map(|k| f64::from(crate::math::hash::pcg4d([k, 0, 0, 0])[0]) / f64::from(u32::MAX));
        let mut next = move || next.next().expect("endless");
        for n in [1, 2, 5, 17, 40] {
            let random: Vec<f64> = (0..n * n).map(|_| next()).collect();
            let whole: Vec<f64> = random.iter().map(|cost| (4.0 * cost).floor()).collect();
            let place: Vec<f64> = (0..2 * n).map(|_| 10.0 * next()).collect();
            let on_a_line = |i: usize, j: usize| (place[i] - place[n + j]).abs();
            // Generic, assignment with ties, gray paints, capped costs nearly all of which tie, and nothing but ties.
            let families: [&dyn Fn(usize, usize) -> f64; 5] = [
                &|i, j| random[i * n + j],
                &|i, j| whole[i * n + j],
                &on_a_line,
                &|i, j| on_a_line(i, j).min(1.0),
                &|_, _| 3.0,
            ];
            let uneven: Vec<f64> = (0..n).map(|_| 1.0 + (3.0 * next()).floor()).collect();
            let reversed: Vec<f64> = uneven.iter().rev().copied().collect();
            for (cost, (p, q)) in families.iter().flat_map(|cost| {
                [(*cost, (vec![1.0; n], vec![1.0; n])), (*cost, (uneven.clone(), reversed.clone()))]
            }) {
                let problem = Problem::from_fn(&p, &q, cost).expect("legal");
                let scale = Scale::new(p.into_iter().chain(q), n as f64, 2 * n);
                let live = Live::new(&problem);
                let (a, b) = (live.solve::<u64>(scale, start), live.solve::<u64>(scale, north_west_corner));
                assert_eq!(a.entries, b.entries, "n = {n}");
                assert_eq!(a.potentials, b.potentials, "n = {n}");
                assert_eq!(a.entries, solve_exactly(&problem), "n = {n}");
            }
        }
    }

    fn solve_exactly(problem: &Problem) -> Vec<(usize, usize, f64)> {
        solve(problem, Solver::NetworkSimplex).expect("solvable").entries
    }

    /// Where all moves cost the same, first goes to first and last to last.
    #[test]
    fn what_ties_altogether_is_coupled_in_order() {
        let problem = Problem::from_fn(&[0.5, 0.25, 0.25], &[0.25, 0.5, 0.25], |_, _| 30.0).expect("legal");
        let expected = [(0, 0, 0.25), (0, 1, 0.25), (1, 1, 0.25), (2, 2, 0.25)];
        assert_eq!(solve_exactly(&problem), expected);
    }

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
