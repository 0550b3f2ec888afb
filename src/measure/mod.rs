//! From the pictures of a camera dome to samples and slices of a paint (Rump et al. 2008, sections 4 and 5).
//!
//! | step | what | where |
//! |---|---|---|
//! | [`Rig`], [`Images`] | what is known of the dome before it is calibrated, and its pictures, one at a time | [`rig`], [`images`] |
//!
//! Nothing here knows a simulator: real captures and virtual ones come in the same folder.

#[cfg(feature = "files")]
mod folder;
pub mod images;
pub mod rig;

#[cfg(feature = "files")]
pub use folder::{CaptureFolder, picture_path};
pub use images::{Images, Picture, Shot};
pub use rig::{Exposure, Flash, Rig, WhiteTarget};
