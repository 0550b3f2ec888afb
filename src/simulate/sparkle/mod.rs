//! Sparkles: the light of single flakes, which a pixel shows as fluctuations about the mean glitter.
//!
//! Ershov, Khodulev & Kolchin 1999, section 5, and Ershov, Kolchin & Myszkowski 2001, section 7, as corrected. Under a small
//! light a flake is a sparkle if its normal lies in a narrow cone about the half vector ([`geometry`]); the number in a
//! pixel is a Poisson deviate ([`count`]); each has an area and a depth, hence a luminance ([`view`]). A [`model`] holds what
//! a renderer tabulates once for a paint and draws the sparkles of a pixel, the same on any number of threads; [`light`]
//! says what a parallel, point or spot light sends; [`combination`] joins them with the smooth part, and [`visibility`] says
//! how both fade with distance. [`brute_force`] counts flakes by exact refraction, without any of the formulas.
//!
//! The flakes are the papers': perfect mirrors, P itself. A flake with a lobe is the business of the flake BTF.

pub mod brute_force;
pub mod combination;
pub mod count;
pub mod geometry;
pub mod light;
pub mod model;
pub mod table;
pub mod view;
pub mod visibility;

pub use combination::Combination;
pub use geometry::SparkleGeometry;
pub use light::{Arrival, Light, Medium};
pub use model::{Pixel, PixelSparkles, SparkleModel};
pub use view::{Masking, SparkleView};
