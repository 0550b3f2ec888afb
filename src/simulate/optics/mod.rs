//! What films, flakes and pigments do to light at one encounter.

pub(crate) mod bessel;
pub mod film_optics;
pub mod flake_areas;
pub mod flake_optics;
pub mod geometry;
pub mod interception;
pub mod materials;
pub mod mie;
pub mod orientation;
pub mod parallel_flakes;
pub mod piecewise;
pub mod pigment;
pub mod stack_classes;
pub mod thickness_spread;
pub mod thin_film;
