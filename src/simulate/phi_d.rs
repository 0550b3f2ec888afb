//! What it costs that one slice stands for every azimuth phi_d of the difference vector.
//!
//! Slices are synthesized at phi_d = 90 degrees (DESIGN, section 3). At other azimuths the two polar angles differ, and with
//! them cosines, Fresnel losses and depths, and the half vector inside the binder.

use super::SmoothModel;
use super::geometry::Geometry;
use crate::btf::AngleGrid;
use crate::color::luminance;
use crate::math::half_difference::directions;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// Azimuths and their shares in a mean over phi_d: the trapezoid rule over a quarter turn, which stands for all four.
const AZIMUTHS: [(f64, f64); 4] =
    [(0.0, 1.0 / 6.0), (PI / 6.0, 1.0 / 3.0), (PI / 3.0, 1.0 / 3.0), (FRAC_PI_2, 1.0 / 6.0)];

/// Relative errors, rms over light: `sqrt(sum w (g' - g)^2 / sum w g^2)`, g the luminance of the glitter at phi_d, g' what the
/// slice says, w the share of a cell's pairs of directions with both cosines.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PhiDError {
    /// With the glitter at phi_d = 90 degrees taken as it is.
    pub plain: f64,
    /// With the cosines, by whose product glitter is divided, taken out at 90 degrees and put back in at phi_d:
    /// `g' = g(90) (wi.z wo.z)(90) / (wi.z wo.z)(phi_d)`.
    pub without_cosines: f64,
}

/// The error of a model's glitter at phi_d of 0, 30, 60 and 90 degrees over the cells of `grid`; azimuths with a direction
/// below the horizon are left out. 0 without glitter.
pub fn phi_d_error(model: &SmoothModel, grid: &AngleGrid) -> PhiDError {
    let glitter = |theta_h: f64, theta_i: f64, phi_d: f64| {
        let (wi, wo) = directions(theta_h, theta_i, phi_d);
        let g = Geometry::new(wi, wo, model.index())?;
        Some((luminance(model.glitter(&g).linear_rgb()), wi.z * wo.z))
    };
    let (mut plain, mut without, mut light) = (0.0, 0.0, 0.0);
    for (theta_h, theta_i) in (0..grid.len()).map(|k| grid.angles(k)) {
        let Some((stored, stored_cosines)) = glitter(theta_h, theta_i, FRAC_PI_2) else { continue };
        // d wi d wo = 4 cos(theta_i) dh dd, the element of half and difference vectors on their spheres.
        let element = theta_h.sin() * theta_i.sin() * theta_i.cos();
        for (phi_d, share) in AZIMUTHS {
            let Some((exact, cosines)) = glitter(theta_h, theta_i, phi_d) else { continue };
            let weight = share * element * cosines;
            plain += weight * (stored - exact).powi(2);
            without += weight * (stored * stored_cosines / cosines - exact).powi(2);
            light += weight * exact * exact;
        }
    }
    let relative = |sum: f64| if light > 0.0 { (sum / light).sqrt() } else { 0.0 };
    PhiDError { plain: relative(plain), without_cosines: relative(without) }
}
