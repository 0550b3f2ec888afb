//! Directions, projection, hashing, quadrature: mathematics that knows no paint.

pub mod adaptive_cdf;
pub mod floor;
pub mod half_difference;
pub mod hash;
pub mod knots;
pub mod normal;
pub mod normal_f32;
pub mod projection;
pub mod quadrature;
