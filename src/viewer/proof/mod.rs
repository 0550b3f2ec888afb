//! The window of a print: an image as it would look printed in inks of structural color, turned in the hand under a lamp.
//!
//! What is set ([`state`]) and what is open ([`desk`]) say at every frame what the pictures show; when that differs from before, a
//! thread ([`press`], [`printer`]) makes anew what depends on the difference (dots, inks, pictures or only their codes) and hands pictures over:
//! coarse ones first where they take long. On a GPU that is not software they are drawn by [`crate::gpu::PrintRenderer`], else by
//! the reference renderer.

mod desk;
mod engine;
mod ink_set;
mod made;
mod opened;
mod panel;
mod press;
mod printer;
mod request;
mod save;
mod screen;
mod stages;
mod state;
mod window;

pub use window::open;
