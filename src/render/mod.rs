//! The CPU reference renderer: what a picture of a paint is by definition, in the arithmetic of a later shader.
//!
//! [`shade()`] is the BRDF, f32. A pixel is the mean over its samples of: lamps (BRDF times irradiance, and the lamp's disc
//! mirrored by the coat), the surroundings mirrored by the coat, and the surroundings integrated over the BRDF. Flakes
//! sparkle under both, the less the wider the light is.
//! Nothing is clamped before the pixel is complete.

mod cells;
mod difference;
mod disc;
mod draws;
mod flake_layout;
mod flakes;
mod flip;
mod footprint;
mod image;
mod lamp;
mod light_patches;
mod memory;
mod needs;
mod packed;
mod paint;
mod path;
mod picture;
mod print;
mod proposal;
mod shade;
mod slices;
mod surroundings;
mod surroundings_flakes;
mod tone_map;
mod truth;

pub use cells::Random;
pub use difference::PictureDifference;
pub use disc::{Disc, disc_radiance};
pub use draws::FlakeDraws;
pub use flake_layout::FlakeLayout;
pub use flakes::{DrawnSlice, RenderFlakes};
pub use footprint::Surface;
pub use image::{Options, render, render_truth, tick_count};
#[cfg(feature = "gpu")]
pub(crate) use image::{Stage, check};
pub use memory::Memory;
#[cfg(feature = "gpu")]
pub(crate) use needs::drawn_cells;
pub use needs::{needed_cells, needed_of_blend, needed_of_paint};
#[cfg(feature = "gpu")]
pub(crate) use packed::{pack_box, pack_ramp, unpack_box};
pub use paint::{RenderCoat, RenderPaint};
pub use path::{MAX_BOUNCES, Traced, trace};
pub use picture::Picture;
#[cfg(feature = "gpu")]
pub(crate) use print::print_stage;
pub use print::{
    Bands, InkBand, InkModel, Look, Paper, Print, PrintInks, Reflecting, lit_from_behind, own_inks,
    render_lit, render_print, render_print_rows,
};
pub use shade::{Geometry, gloss_widening, shade, shade_mean};
pub use slices::RenderSlices;
pub use surroundings_flakes::surroundings_sparkle;
pub use tone_map::ToneMap;
pub use truth::FlakeTruth;
