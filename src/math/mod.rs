//! Directions, hashing, quadrature: mathematics that knows no paint.

pub mod half_difference;
pub mod hash;
pub mod normal;
pub mod quadrature;
