//! Measured metallic car paint: simulate it, fit it, reduce it to statistics, couple paints by optimal transport, and
//! interpolate between them.
//!
//! The look of a metallic or pearlescent paint is measured, not tuned by hand: a clear coat, a multi-lobe Cook-Torrance
//! brightness, a 2-D color table over half and difference angle, and a flake BTF of many texture slices. This crate turns
//! that into a small statistical paint, finds the optimal transport between the slices of two or more paints, and gives back
//! the paint at any weights, inside and outside the simplex.
//!
//! # Three artefacts, one verb between each two
//!
//! | artefact | what it is | where from |
//! |---|---|---|
//! | [`btf::FlakeBtf`] | raw slices over an angle grid, signed, with the smooth BRDF they fluctuate about | [`simulate`]: composition, optics, model, slices; [`measure`]: pictures of a camera dome, which [`dome`] can take |
//! | [`paint::Paint`] | what is rendered: coat, diffuse, lobes, color table, statistics of every slice | [`fit`], [`mix::Mix::blend`] |
//! | [`mix::Mix`] | two to eight paints, coupled | [`mix::couple`] |
//!
//! ```no_run
//! use carpaint::{btf::AngleGrid, fit, mix, simulate};
//! # fn main() -> carpaint::Result<()> {
//! let tick = || ();
//! let mut paints = Vec::new();
//! for name in ["brown_metallic", "blue_metallic"] {
//!     let path = format!("fixtures/compositions/{name}.toml");
//!     let composition = simulate::Composition::read(path.as_ref())?;
//!     let model = simulate::Model::new(&composition, Default::default())?;
//!     let options = simulate::SynthesisOptions::new(AngleGrid::triangle(24)?);
//!     let btf = simulate::synthesize(&model, &options, &tick)?;
//!     let options = fit::FitOptions { coat: Some(btf.coat), ..Default::default() };
//!     let (paint, _report) = fit::fit_btf(&btf, &options, &Default::default(), &tick)?;
//!     paints.push((name.to_owned(), paint));
//! }
//! let named: Vec<_> = paints.iter().map(|(name, paint)| (name.clone(), paint)).collect();
//! let (mix, _report) = mix::couple(&named, &mix::CoupleOptions::default(), &tick)?;
//! let half_way = mix.blend(&[0.5, 0.5])?;
//! let beyond_blue = mix.blend(&[-0.5, 1.5])?;
//! # let _ = (half_way, beyond_blue); Ok(()) }
//! ```
//!
//! # Conventions
//!
//! * Directions point away from the surface; local frame, z = normal. `h = normalize(wi + wo)`, `theta_h = acos(h.z)`,
//!   `theta_i = acos(h . wi)`: see [`math::half_difference`].
//! * Functions return the BRDF, 1/sr, **without** the cosine. Lab is taken of the reflectance factor pi f, so that L* = 100 is
//!   the perfect diffuser; it is continued to negative light, see [`color`].
//! * Cook-Torrance lobes follow the AxF-style convention, four times the usual microfacet form: see [`brdf::cook_torrance`].
//! * Slices are signed: the smooth part carries the mean, glitter included, and a slice what that does not explain: see
//!   [`btf::FlakeBtf`].
//! * Angles are radians, lengths millimetres. f64 where numbers are made (simulate, fit, transport), f32 where they are shown
//!   (texels, render).
//! * What is random takes a seed, and gives the same bits on any number of threads.
//!
//! # Papers
//!
//! Golla & Klein 2018 (the statistical paint, transport, interpolation); Ershov, Kolchin & Myszkowski 2001 and Ershov,
//! Khodulev & Kolchin 1999 (the simulator, with its misprints corrected); Rump et al. 2008 (fit and color table); Pranovich et
//! al. 2024 (goniochromatic inks, [`brdf::ink`], and soft proofs, [`proof`]). Formulas cite them by equation number.
//!
//! # Features
//!
//! `cli` (default) is the program; `files` reads and writes paints, flake BTFs and pictures; `gpu` (default) evaluates paints
//! on a GPU. Without them the library builds with no image codec, no window and no GPU code.

pub mod brdf;
pub mod btf;
mod check;
pub mod cluster;
pub mod color;
pub mod dome;
pub mod error;
pub mod file;
pub mod fit;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "cli")]
pub mod hard_cases;
pub mod math;
pub mod measure;
pub mod mix;
pub mod paint;
mod parallel;
pub mod proof;
pub mod render;
pub mod report;
#[cfg(feature = "files")]
pub mod rivals;
pub mod sampler;
pub mod scene;
pub mod simulate;
#[cfg(feature = "cli")]
pub mod tradeoff;
pub mod transport;
#[cfg(feature = "viewer")]
pub mod viewer;

pub use error::{Error, Result};
pub use paint::Paint;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
