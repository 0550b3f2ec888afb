//! The paint simulator: composition in, appearance out.
//!
//! A [`Composition`] is a recipe; [`SmoothModel`] is its mean BRDF; [`synthesize`] draws explicit flakes and gives the
//! flake BTF whose mean that BRDF is.

mod bessel;
pub mod composition;
mod disc;
pub mod fast_model;
pub mod flake_optics;
pub mod flakes;
pub mod geometry;
pub mod materials;
pub mod orientation;
pub mod parallel_flakes;
pub mod phi_d;
pub mod piecewise;
pub mod sparkle;
mod spectrum_text;
pub mod substrate_return;
pub mod synthesis;
pub mod thin_film;

pub use composition::Composition;
pub use phi_d::{PhiDError, phi_d_error};
pub use synthesis::{DEFAULT_BINS, SynthesisOptions, synthesize};

/// The model that gives the smooth part of a paint.
pub type SmoothModel = fast_model::FastModel;
