//! What decides between plans of equal cost.

use crate::math::hash::pcg4d;

/// A second cost, over the arcs that tied plans may use.
pub(super) enum Objective {
    /// The square of the cost: nearby moves rather than a long one and a short one, the monotone plan on a line.
    Square {
        /// One over the bound of all costs.
        unit: f64,
    },
    /// Minus the product of the ranks of source and target: first to first, last to last.
    ///
    /// On a complete graph the plan that is monotone in both orders is the only optimum. So that it is on others too, ranks
    /// are moved by hashed parts of their spacing, less than half of it.
    Order {
        /// Rank of each source.
        source: Vec<f64>,
        /// Rank of each target from behind, so that products are positive.
        target: Vec<f64>,
    },
}

impl Objective {
    /// Rounds of hashed ranks. One nearly always does: two plans tie in it with a probability near 2^-25 an arc.
    const ROUNDS: u32 = 8;

    /// The objectives in turn, for costs below 2^bits.
    pub fn sequence(sources: usize, targets: usize, bits: i32) -> impl Iterator<Item = Self> {
        let end = libm::ldexp(1.0, bits / 2);
        let order = move |round| {
            let rank = |k: usize, n: usize, side: u32| {
                let moved = f64::from(pcg4d([k as u32, side, round, 0])[0]) / f64::from(u32::MAX) / 2.0;
                (k as f64 + moved) / n as f64 * end
            };
            Self::Order {
                source: (0..sources).map(|i| rank(i, sources, 0)).collect(),
                target: (0..targets).map(|j| end - rank(j, targets, 1)).collect(),
            }
        };
        std::iter::once(Self::Square { unit: libm::ldexp(1.0, -bits) }).chain((0..Self::ROUNDS).map(order))
    }

    /// In units of the fixed point, up to 2^bits, as is the arc's own `cost`.
    pub fn cost(&self, source: usize, target: usize, cost: f64) -> f64 {
        match self {
            Self::Square { unit } => cost * cost * unit,
            Self::Order { source: ranks, target: from_behind } => ranks[source] * from_behind[target],
        }
    }
}
