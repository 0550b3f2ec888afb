//! Reflectance: Fresnel, Cook-Torrance lobes, the color table, the clear coat, tabulated and scattered
//! measurements.
//!
//! Functions return the BRDF in 1/sr without the cosine; the cosine is multiplied where light is summed.

mod base;
pub mod clear_coat;
pub mod color_table;
pub mod cook_torrance;
pub mod deviation_neighbors;
pub mod fresnel;
pub mod goniochromatic;
pub mod goniospectra;
pub mod half_angle;
mod half_difference_table;
pub mod ink;
pub mod instrument;
pub mod mbsdf;
pub mod measured;
pub mod measurement;
pub mod merl;
pub mod multi_angle;
mod multi_angle_header;
mod multi_angle_writer;
pub mod nbrdf;
pub mod projected_half;
pub mod reciprocity;
pub mod rgl;
pub mod sample_set;
pub mod tabulated;
pub mod torrance_sparrow;

pub use base::base;
pub use clear_coat::ClearCoat;
pub use color_table::ColorTable;
pub use cook_torrance::{Lobe, LobeGeometry};
pub use deviation_neighbors::DeviationNeighbors;
pub use goniospectra::{Goniospectra, Goniospectrum, WHITE_REFLECTANCE};
pub use ink::Ink;
pub use measured::{Measured, read_measured, read_samples};
pub use measurement::{Counts, Measurement};
pub use multi_angle_writer::multi_angle_text;
pub use nbrdf::{NeuralBrdf, read_nbrdf};
pub use projected_half::{LACQUER_INDEX, half_stretch, projected_half};
pub use sample_set::{Bands, BrdfSample, LightPoint, SampleSet};
pub use tabulated::TabulatedBrdf;
