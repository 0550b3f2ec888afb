//! The paint simulator: composition in, appearance out.
//!
//! | step | what | where |
//! |---|---|---|
//! | [`Composition`] | the recipe: ground coat, films of flakes and pigments, surface | [`composition`] |
//! | [`PaintOptics`](optics::film_optics::PaintOptics) | what one encounter does to light: extinction, flakes, pigments, and the glitter of flakes that scatter once | [`optics`] |
//! | [`Model`] | the mean BRDF: glitter, and the rest from a model of one's choice; gloss apart | [`models`] |
//! | [`Synthesis`] | explicit flakes, slice by slice: the flake BTF whose mean that BRDF is | [`synthesis`] |
//!
//! Beside them: what an [`instrument`] reads off a model, and a [`goniospectrometer`] measures of it; [`sparkle`], the statistics of glints without any slice; and
//! single formulas of the papers, with which reference numbers are compared ([`mod@eval`]).

pub mod composition;
pub mod eval;
pub mod goniospectrometer;
pub mod models;
pub mod optics;
pub mod sparkle;
pub mod synthesis;

pub use crate::brdf::instrument::{self, Reading, flop_index};
pub use composition::Composition;
pub use eval::flake_layer::eval_flake_layer;
pub use eval::slab::eval_slab;
pub use goniospectrometer::Goniospectrometer;
pub use models::accuracy::Accuracy;
pub use models::full_model::{Energy, FullModel};
pub use models::model::{Model, ModelKind, ModelOptions};
pub use synthesis::panel::{LitFlake, Panel};
pub use synthesis::parallax::{ParallaxError, ParallaxRow};
pub use synthesis::phi_d::{PhiDError, PhiDRow, phi_d_error};
pub use synthesis::{DEFAULT_BINS, Synthesis, SynthesisOptions, synthesize};
