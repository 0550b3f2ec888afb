//! The chain with its costs and errors: what `demo` shows and `validate` judges.
//!
//! Every stage has a file of checks; a check is a measured error beside the bar it has to stay below. Truth is the analytic
//! model of the composition ([`crate::simulate::Model`] and the slices synthesized with it), never a stored picture.

mod angular;
mod blend;
mod capture;
mod chain;
mod coherence;
mod curves;
mod drawn;
mod interpolation;
mod lobes;
mod moments;
mod order;
mod physical_change;
mod picture;
mod samplers;
mod scales;
mod slices;
mod smooth;
mod solvers;
mod stage;
mod statistics;
mod synthesis;
mod transport;

pub use angular::{HalfWidth, Midway, half_widths, midway};
pub use capture::{
    AngleError, CaptureOptions, MeasuredPaint, RadianceError, SliceError, calibration_errors, color_errors,
    measure_paint, radiance_error, slice_errors,
};
pub use chain::{Chain, ChainOptions, run_chain};
pub use coherence::{Coherence, coherence};
pub use curves::{CurveAxis, CurvePoint, Curves, Setting, curve_ticks, curves};
pub use interpolation::{Interpolation, Interpolations, Method, interpolation_table};
pub use lobes::LobeError;
pub use order::{OrderDependence, order_dependence};
pub use physical_change::PhysicalChange;
pub use samplers::{SamplerCost, sampler_costs};
pub use scales::{Scale, scales};
pub use solvers::{SolverError, problem};
pub use stage::{Check, Stage, peak_memory_mib};
pub use statistics::{Reconstruction, SamplerKind, energetic_slices, reconstruction_table, wasserstein};

pub use blend::{checks as blend_checks, errors as blend_errors};
pub use picture::checks as picture_checks;
pub use transport::checks as transport_checks;
