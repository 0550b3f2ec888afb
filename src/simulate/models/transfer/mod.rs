//! Radiative transfer through films by doubling and adding (Ershov, Kolchin & Myszkowski 2001, sections 2-5).
//!
//! Light is sorted by its transverse wavenumber `kappa = eta sin(theta)`, the same in every film by Snell's law, and by its
//! azimuth mode m. With nodes kappa_j, weights `g_j` of `kappa dkappa` and the amplitude `v_j = power_j / sqrt(g_j)`, a BRDF f
//! inside a medium of index eta acts as the symmetric matrix
//!
//! `sqrt(g_i g_j) f_m(i, j) / eta^2`, `f_m = int f exp(-i m phi) dphi`,
//!
//! composition of operators is the plain product, a Fresnel boundary is the diagonal r (and 1 - r) without any Jacobian,
//! and outside `f_m = A_ij / sqrt(g_i g_j)`, `f(phi) = (f_0 + 2 sum f_m cos(m phi)) / (2 pi)`.
//!
//! Light that was not scattered stays on a diagonal beside the dense matrix ([`operator::Operator`]): no delta function is
//! ever put on the nodes.

pub mod doubling;
pub mod film;
pub mod film_kernel;
pub mod flake_kernel;
pub mod ground;
pub mod interpolation;
pub mod kernel;
pub mod layer;
pub mod nodes;
pub mod operator;
pub mod phase_kernel;
