//! What it costs that one slice stands for every azimuth phi_d of the difference vector.
//!
//! Slices are synthesized at phi_d = 90 degrees (DESIGN, section 3). At other azimuths the two polar angles differ, and with
//! them cosines, Fresnel losses and depths, and the half vector inside the binder.

use crate::btf::AngleGrid;
use crate::color::luminance;
use crate::math::half_difference::directions;
use crate::simulate::Model;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// Azimuths and their shares in a mean over phi_d: the trapezoid rule over a quarter turn, which stands for all four.
const AZIMUTHS: [(f64, f64); 4] =
    [(0.0, 1.0 / 6.0), (PI / 6.0, 1.0 / 3.0), (PI / 3.0, 1.0 / 3.0), (FRAC_PI_2, 1.0 / 6.0)];

/// Relative errors, rms over light: `sqrt(sum w (g' - g)^2 / sum w g^2)`, g the luminance of the glitter at phi_d, g' what the
/// slice says, w the share of a cell's pairs of directions with both cosines, from edge to edge of the cell; 0 without light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhiDError {
    /// With the glitter at phi_d = 90 degrees taken as it is.
    pub plain: f64,
    /// With the cosines, by whose product glitter is divided, taken out at 90 degrees and put back in at phi_d:
    /// `g' = g(90) (wi.z wo.z)(90) / (wi.z wo.z)(phi_d)`.
    pub without_cosines: f64,
    /// The same over the cells of one theta_h each.
    pub rows: Vec<PhiDRow>,
}

/// The errors of all cells of one theta_h.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhiDRow {
    /// Angle between half vector and normal, degrees.
    pub theta_h_deg: f64,
    /// The row's share of all light, `sum w g^2`.
    pub share: f64,
    /// As [`PhiDError::plain`].
    pub plain: f64,
    /// As [`PhiDError::without_cosines`].
    pub without_cosines: f64,
}

/// Weighted squares: of both errors, and of the light itself.
#[derive(Clone, Copy, Default)]
struct Squares {
    plain: f64,
    without: f64,
    light: f64,
}

impl Squares {
    fn add(&mut self, other: Self) {
        self.plain += other.plain;
        self.without += other.without;
        self.light += other.light;
    }

    /// Both errors relative to the light; 0 without light.
    fn relative(self) -> [f64; 2] {
        [self.plain, self.without].map(|sum| if self.light > 0.0 { (sum / self.light).sqrt() } else { 0.0 })
    }
}

/// The error of a model's glitter at phi_d of 0, 30, 60 and 90 degrees over the cells of `grid`; azimuths with a direction
/// below the horizon are left out.
pub fn phi_d_error(model: &Model, grid: &AngleGrid) -> PhiDError {
    let mut sums = vec![Squares::default(); grid.rows().iter().copied().max().unwrap_or(0)];
    for slice in 0..grid.len() {
        sums[grid.bins_of(slice).0].add(cell(model, grid.angles(slice), grid.width()));
    }
    let mut total = Squares::default();
    sums.iter().for_each(|row| total.add(*row));
    let row = |(k, sum): (usize, &Squares)| {
        let [plain, without_cosines] = sum.relative();
        let share = if total.light > 0.0 { sum.light / total.light } else { 0.0 };
        PhiDRow { theta_h_deg: (k as f64 * grid.width()).to_degrees(), share, plain, without_cosines }
    };
    let [plain, without_cosines] = total.relative();
    PhiDError { plain, without_cosines, rows: sums.iter().enumerate().map(row).collect() }
}

/// The squares of one cell, `width` wide about its angles.
fn cell(model: &Model, (theta_h, theta_i): (f64, f64), width: f64) -> Squares {
    // Luminance of the glitter and the product of the cosines; none below the horizon.
    let glitter = |phi_d: f64| {
        let (wi, wo) = directions(theta_h, theta_i, phi_d);
        let above = wi.z > 0.0 && wo.z > 0.0;
        above.then(|| (luminance(model.glitter(wi, wo).linear_rgb()), wi.z * wo.z))
    };
    let mut sum = Squares::default();
    let Some((stored, stored_cosines)) = glitter(FRAC_PI_2) else { return sum };
    // d wi d wo = 4 cos(theta_i) dh dd, the element of half and difference vectors on their spheres: the cap about 0 counts too.
    let edges = |theta: f64| [(theta - 0.5 * width).max(0.0), (theta + 0.5 * width).min(FRAC_PI_2)];
    let solid_angle = |theta: f64| edges(theta)[0].cos() - edges(theta)[1].cos();
    let element = solid_angle(theta_h) * solid_angle(theta_i) * theta_i.cos();
    for (phi_d, share) in AZIMUTHS {
        let Some((exact, cosines)) = glitter(phi_d) else { continue };
        let weight = share * element * cosines;
        sum.add(Squares {
            plain: weight * (stored - exact).powi(2),
            without: weight * (stored * stored_cosines / cosines - exact).powi(2),
            light: weight * exact * exact,
        });
    }
    sum
}
