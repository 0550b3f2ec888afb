//! The window of `carpaint view`: a designer looks, drags, and looks again.
//!
//! What is shown is [`state`](self), plain values and functions that no window is needed for: weights, eye, lamp, surroundings,
//! object. Panels draw it and change it; a picture is drawn anew when what it depends on has changed. What takes long (reading,
//! coupling, simulating, saving) is done by a thread that says how far it is, while the window goes on with what it has.

mod beside;
mod choices;
mod demo;
mod desk;
mod document;
mod frame_times;
mod held;
mod job;
mod keys;
mod kind;
mod kitchen;
mod light;
mod measure;
mod orbit;
mod panels;
mod picture;
mod places;
mod proof;
mod recipe;
mod save;
mod shelf;
mod stage;
mod staged;
mod start;
mod state;
mod waker;
mod weights;
mod window;
mod worn;

pub use start::Start;

use crate::error::Result;

/// Opens the window of paints, or that of a print, and returns when it is closed.
///
/// # Errors
/// What [`Start::check`] and [`Start::image`] find, an image or inks that cannot be read; no display, no adapter that can do what is
/// needed, devices that are lost again and again.
pub fn open(start: Start) -> Result<()> {
    match start.image()? {
        Some(image) => proof::open(&start, image),
        None => window::open(&start),
    }
}
