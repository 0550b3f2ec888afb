//! Costs as whole numbers.

use super::problem::Problem;

/// How the costs of one problem are cut to whole numbers.
#[derive(Clone, Copy)]
pub(super) struct FixedPoint {
    /// Costs are below 2^bits.
    pub bits: i32,
    /// What takes a cost there, which may exceed f64, as a product.
    factors: [f64; 2],
}

impl FixedPoint {
    /// The finer unit of what cutting has left, 2^-24 of the other: together they tell costs of 2^-72 of the largest.
    pub const FINER: f64 = (1 << 24) as f64;

    /// A potential is an alternating sum along a path, on which each sign occurs at most `smaller_side` times: all stay
    /// below 2^61 in absolute value.
    pub fn new(problem: &Problem, smaller_side: usize) -> Self {
        let bits = 60 - smaller_side.ilog2() as i32;
        let shift = bits - libm::frexp(problem.largest_cost()).1;
        Self { bits, factors: [shift / 2, shift - shift / 2].map(|shift| libm::ldexp(1.0, shift)) }
    }

    /// A cost in units of the fixed point, below 2^bits; the whole number is what truncation leaves of it.
    pub fn scale(self, cost: f64) -> f64 {
        cost * self.factors[0] * self.factors[1]
    }

    /// A difference of costs, of whole and of finer units, in the costs' own unit: rounded, and what rounding takes.
    pub fn decode(self, whole: i64, finer: i64) -> (f64, f64) {
        let decode = |units: f64| units / self.factors[0] / self.factors[1];
        let rounded = whole as f64;
        let rest = (whole - rounded as i64) as f64 + finer as f64 / Self::FINER;
        (decode(rounded), decode(rest))
    }
}
