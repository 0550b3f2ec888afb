//! Fitting a paint's smooth part to measured or simulated reflectance.
//!
//! [`fit_samples`] and [`fit_smooth`] follow Rump et al. 2008, section 5.1: diffuse, one to three metallic lobes and the clear
//! coat's gloss are fitted to the intensity, the mean of the bands, by a logarithmic error, and color goes to a table of its own.
//! [`fit_ink`] fits goniochromatic inks to spectra (Pranovich et al. 2024).

mod albedo;
mod cells;
mod choice;
mod color_errors;
mod colors;
mod evaluate;
mod explained;
mod field_correlation;
mod flakes;
mod ink;
mod lifetime;
mod lobes;
mod objective;
mod observer;
mod optimizer;
mod points;
mod report;
mod samples;
mod separable;
mod smooth;
mod spectral;
mod trust_region;
mod uncertainty;

pub use albedo::albedo;
pub use choice::Choice;
pub use color_errors::ColorErrors;
pub use evaluate::eval_cook_torrance_set;
pub use flakes::{FlakeOptions, SliceMean, fit_btf, fit_flakes, residual};
pub use ink::{BandFit, IncidenceFit, InkOptions, InkReport, InkWeights, fit_ink};
pub use lifetime::Lifetime;
pub use observer::ink_of_observer;
pub use optimizer::Optimizer;
pub use report::{ASPECULAR_DEG, Aspecular, Errors, FitReport, Spread, Start};
pub use samples::SampleCounts;
pub use smooth::{
    Compared, FitOptions, SmoothFit, compare, compare_samples, fit_measured, fit_samples, fit_smooth,
};
pub use spectral::SpectralColors;
pub use uncertainty::{Direction, Parameter, Uncertainty};
