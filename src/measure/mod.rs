//! From the pictures of a camera dome to samples and slices of a paint (Rump et al. 2008, sections 4 and 5).
//!
//! | step | what | where |
//! |---|---|---|
//! | [`Rig`], [`Images`] | what is known of the dome before it is calibrated, and its pictures, one at a time | [`rig`], [`images`] |
//! | [`calibrate::calibrate`], [`Calibrated`] | places, lenses, responses; linear pictures in white balance | [`mod@calibrate`] |
//! | [`PairGeometry`], [`Sheet`] | directions at every place of the sample; from perspective to texels | [`pair`], [`rectify`] |
//! | [`extract`] | samples of the homogeneous BRDF: one set for diffuse and glitter, one for gloss | [`samples`], [`highlight`], [`blemishes`] |
//! | [`cut_slices`] | what the fitted BRDF leaves, as a flake BTF | [`slices`] |
//!
//! Nothing here knows a simulator: real captures and virtual ones come in the same folder.

pub mod blemishes;
pub mod calibrate;
mod calibrated;
#[cfg(feature = "files")]
mod folder;
pub mod highlight;
pub mod images;
pub mod pair;
pub mod rectify;
pub mod rig;
pub mod samples;
pub mod slices;

pub use blemishes::Blemishes;
pub use calibrated::Calibrated;
#[cfg(feature = "files")]
pub use folder::{CaptureFolder, picture_path};
pub use images::{Images, Picture, Shot};
pub use pair::PairGeometry;
pub use rectify::Sheet;
pub use rig::{Exposure, Flash, Rig, WhiteTarget};
pub use samples::{Extraction, ExtractionReport, HighlightCheck, Pairs, SamplingOptions, extract};
pub use slices::{Homogeneous, SliceOptions, SliceReport, cut_slices};
