//! The CPU reference renderer: what a picture of a paint is by definition, in the arithmetic of a later shader.
//!
//! [`shade()`] is the BRDF, f32. A pixel is the mean over its samples of: lamps (BRDF times irradiance, and the lamp's disc
//! mirrored by the coat), the surroundings mirrored by the coat, and the surroundings integrated over the BRDF. Under
//! lamps flakes sparkle; under the surroundings, which are many directions at once, they count with their mean.
//! Nothing is clamped before the pixel is complete.

mod cells;
mod difference;
mod draws;
mod flake_layout;
mod flakes;
mod flip;
mod footprint;
mod image;
mod lamp;
mod needs;
mod paint;
mod picture;
mod proposal;
mod shade;
mod surroundings;
mod tone_map;

pub use cells::Random;
pub use difference::PictureDifference;
pub use draws::FlakeDraws;
pub use flake_layout::FlakeLayout;
pub use flakes::RenderFlakes;
pub use footprint::Surface;
#[cfg(feature = "gpu")]
pub(crate) use image::check;
pub use image::{Options, render, tick_count};
pub use needs::{needed_cells, needed_of_blend, needed_of_paint};
pub use paint::{RenderCoat, RenderPaint};
pub use picture::Picture;
pub use shade::{Geometry, gloss_widening, shade};
pub use tone_map::ToneMap;
