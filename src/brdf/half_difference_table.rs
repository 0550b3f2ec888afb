//! Tables over half and difference angles, as MERL and Guenther et al. 2005 keep them: 90 cells of theta_h, 90 of theta_d, 180 of
//! phi_d over half a turn. What a cell means, once for both.
//!
//! `d(wi) d(wo) = 4 cos(theta_d) d(h) d(d)` (Rusinkiewicz 1998) gives a cell its share of the two spheres.

use super::measurement::{Counts, Measurement};
use super::sample_set::{Bands, BrdfSample, SampleSet};
use crate::error::Result;
use crate::math::half_difference::directions;
use std::f64::consts::{FRAC_PI_2, PI};

/// Cells of theta_h and of theta_d.
pub(super) const THETA: usize = 90;
/// Cells of phi_d.
pub(super) const PHI: usize = 180;
/// All cells.
pub(super) const CELLS: usize = THETA * THETA * PHI;
/// Most samples taken of a table: every cell of theta_h and theta_d, and as many of phi_d (30 of 180) as fit. A sample takes 104
/// bytes, all 1,458,000 of them would take 150 MB, and a fit uses some 20,000.
const MAX_SAMPLES: usize = 1 << 18;

/// Samples at the cells' middles. `theta_h` gives the angle at a position of 0 to 90 in cells, `value` what cell
/// (theta_h, theta_d, phi_d) holds, None where that is marked as invalid; a value that is not finite is invalid, too.
pub(super) fn measurement(
    theta_h: impl Fn(f64) -> f64,
    value: impl Fn(usize, usize, usize) -> Option<[f64; 3]>,
) -> Result<Measurement> {
    let mut samples = SampleSet::new(Bands::Rgb)?;
    let mut counts = Counts { found: CELLS, ..Counts::default() };
    let stride = CELLS.div_ceil(MAX_SAMPLES);
    let theta_d = |position: f64| FRAC_PI_2 * position / THETA as f64;
    let bounds = |k: usize| (k as f64, k as f64 + 0.5, k as f64 + 1.0);
    for h in 0..THETA {
        let (from, middle, to) = bounds(h);
        let half_share = theta_h(from).cos() - theta_h(to).cos();
        let half = theta_h(middle);
        for d in 0..THETA {
            let (from, middle, to) = bounds(d);
            // The integral of sin cos over the cell; the factor 4 and the equal cells of phi_d drop out.
            let share = half_share * (theta_d(to).sin().powi(2) - theta_d(from).sin().powi(2));
            for p in 0..PHI {
                let (wi, wo) = directions(half, theta_d(middle), PI * (p as f64 + 0.5) / PHI as f64);
                let good = || value(h, d, p).filter(|rgb| rgb.iter().all(|c| c.is_finite()));
                if wi.z <= 0.0 || wo.z <= 0.0 {
                    counts.below_horizon += 1;
                } else if let Some(rgb) = good() {
                    if p % stride == stride / 2 {
                        samples.push(BrdfSample::new(wi, wo, share), &rgb)?;
                    } else {
                        counts.thinned += 1;
                    }
                } else {
                    counts.invalid += 1;
                }
            }
        }
    }
    // Light and eye exchanged turn phi_d by pi: half a turn is all the table knows.
    Measurement::new(samples, counts, None)
}
