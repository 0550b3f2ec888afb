//! The virtual dome: a simulated panel photographed by many cameras under many flashes (Rump et al. 2008, section 4).
//!
//! | step | what | where |
//! |---|---|---|
//! | [`DomeOptions`] | what stands where: `DOME.toml` | [`options`] |
//! | [`Stand`] | the true cameras, lenses, flashes and sensors, and the nominal ones a measurement is told | [`stand`] |
//! | [`Dome::radiance`] | what a camera receives of the panel under one flash | [`radiance`] |
//! | [`Sensor`](sensor::Sensor) | what it says: noise, clipping, response curve, bits | [`sensor`] |
//! | [`Dome::write`] | all pictures in a capture folder, resumable | `capture` |
//!
//! The measurement side ([`crate::measure`]) sees the pictures and the nominal numbers; the truth goes to a file of its own, with
//! which results are compared.

#[cfg(feature = "files")]
mod capture;
pub mod leds;
pub mod options;
pub mod radiance;
pub mod sensor;
pub mod stand;

#[cfg(feature = "files")]
pub use capture::{MadeOf, Written, truth_path};
pub use options::DomeOptions;
pub use radiance::Dome;
pub use stand::{Stand, Truth};
