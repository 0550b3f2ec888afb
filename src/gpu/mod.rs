//! Paints and pictures on the GPU: the only module that names wgpu.
//!
//! The shaders are twins of the CPU renderer: a file of `shaders/shared/` holds the functions of one Rust file, under the
//! same names. What decides which cluster is drawn is integer arithmetic and our own polynomials on both sides.

mod constituents;
mod device;
mod evaluate;
mod frame;
mod mix_tables;
mod paint;
mod pass;
mod patterns;
mod prefilter;
mod print;
mod realize;
#[cfg(test)]
mod reflection;
mod render;
mod rival;
mod rows;
mod scene;
mod shader;
mod uniform;
mod view;

pub use device::Gpu;
pub use evaluate::{DiscQuery, Evaluator, GivenQuery, Query};
pub use frame::{FrameOptions, FrameRenderer};
pub use paint::GpuPaint;
pub use print::{GpuPrint, PrintRenderer, render_print};
pub use realize::GpuMix;
pub use render::{Renderer, render};
pub use rival::{RawSlices, Rival};
pub use shader::{evaluate_source, frame_source, picture_source, realize_source, rivals_source};
