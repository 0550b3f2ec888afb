//! Costs as whole numbers.

use super::problem::Problem;

/// How the costs of one problem are cut to whole numbers.
#[derive(Clone, Copy)]
pub(super) struct FixedPoint {
    /// Costs are below 2^exponent,
    exponent: i32,
    /// which becomes 2^bits.
    pub bits: i32,
    /// `2^(bits - exponent)`, which may exceed f64, as a product.
    factors: [f64; 2],
}

impl FixedPoint {
    /// A potential is an alternating sum along a path, on which each sign occurs at most `smaller_side` times: all stay
    /// below 2^61 in absolute value.
    pub fn new(problem: &Problem, smaller_side: usize) -> Self {
        let exponent = libm::frexp(problem.largest_cost()).1;
        let bits = 60 - smaller_side.ilog2() as i32;
        let shift = bits - exponent;
        Self { exponent, bits, factors: [shift / 2, shift - shift / 2].map(|shift| libm::ldexp(1.0, shift)) }
    }

    /// A cost in units of the fixed point, below 2^bits; the whole number is what truncation leaves of it.
    pub fn scale(self, cost: f64) -> f64 {
        cost * self.factors[0] * self.factors[1]
    }

    /// A difference of costs as a number in their own unit.
    pub fn decode(self, cost: i64) -> f64 {
        libm::ldexp(cost as f64, self.exponent - self.bits)
    }
}
