//! Measured metallic car paint.

pub mod brdf;
pub mod btf;
pub mod cluster;
pub mod color;
pub mod error;
pub mod file;
pub mod fit;
pub mod math;
pub mod mix;
pub mod paint;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod simulate;
pub mod transport;

pub use error::{Error, Result};
pub use paint::Paint;
