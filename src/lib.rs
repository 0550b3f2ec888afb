//! Measured metallic car paint.

pub mod brdf;
pub mod btf;
pub mod cluster;
pub mod color;
pub mod error;
pub mod file;
pub mod math;
pub mod sampler;
pub mod transport;

pub use error::{Error, Result};
