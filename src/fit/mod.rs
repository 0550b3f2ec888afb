//! Fitting a paint's smooth part to a table of measured or simulated reflectance.
//!
//! [`fit_smooth`] follows Rump et al. 2008, section 5.1: diffuse, one to three metallic lobes and the clear coat's gloss
//! are fitted to the intensity `(R + G + B) / 3` by a logarithmic error, and color goes to a table of its own.

mod albedo;
mod colors;
mod evaluate;
mod field_correlation;
mod flakes;
mod lifetime;
mod lobes;
mod objective;
mod report;
mod samples;
mod smooth;

pub use albedo::albedo;
pub use evaluate::eval_cook_torrance_set;
pub use flakes::{FlakeOptions, SliceMean, fit_btf, fit_flakes, residual};
pub use lifetime::{Lifetime, knots};
pub use report::{ASPECULAR_DEG, Aspecular, FitReport, Spread, Start};
pub use samples::SampleCounts;
pub use smooth::{FitOptions, SmoothFit, fit_smooth};
