//! What holds of the light of a mean BRDF.

use carpaint::brdf::fresnel::dielectric;
use carpaint::color::BANDS;
use carpaint::math::half_difference::spherical;
use carpaint::math::quadrature::{composite, gauss_legendre};
use carpaint::simulate::{Model, ModelKind};
use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use std::f64::consts::{FRAC_PI_2, PI};

/// Polar angles at which a BRDF is looked at, radians: straight above, usual, and all but grazing.
const POLAR: [f64; 5] = [0.0, 1e-4, 0.6, 1.2, 1.5706];

/// Values are finite, 0 or more, and the same there and back.
pub fn numbers_and_reciprocity(model: &Model) -> Result<(), TestCaseError> {
    let pairs = POLAR.iter().flat_map(|a| POLAR.map(|b| (*a, b)));
    for (i, o, phi) in pairs.flat_map(|(a, b)| [0.0, 1.0, PI].map(|phi| (a, b, phi))) {
        let (wi, wo) = (spherical(i, 0.0), spherical(o, phi));
        let (there, back) = (model.brdf(wi, wo), model.brdf(wo, wi));
        for (k, (a, b)) in there.0.iter().zip(&back.0).enumerate() {
            prop_assert!(a.is_finite() && *a >= 0.0, "{i} {o} {phi}, band {k}: {a}");
            // Sums in another order.
            prop_assert!((a - b).abs() <= 1e-9 * (a + 1e-3), "{i} {o} {phi}, band {k}: {a} {b}");
        }
        let rgb = model.brdf_rgb(wi, wo);
        prop_assert!(rgb.is_finite(), "{i} {o} {phi}: {rgb}");
        prop_assert!(model.gloss(wi, wo).is_finite() && model.gloss(wi, wo) >= 0.0, "gloss at {i} {o} {phi}");
    }
    Ok(())
}

/// Azimuths of half a turn; BRDFs are even in it.
const AZIMUTHS: usize = 24;
/// What the rule below is off for a BRDF of 1/pi, the most of any incidence, where the horizon cuts through it.
const RULE: f64 = 0.01;

/// Directions out with their weights for light from `wi`, by half vectors: panels double from 1e-4 radians on, so that a bell of
/// any width about the normal, which is where flakes mirror, is met by several nodes.
fn outgoing(wi: DVec3) -> Vec<(DVec3, f64)> {
    let mut breaks: Vec<f64> = (0..15).map(|k| FRAC_PI_2 * 0.5f64.powi(14 - k)).collect();
    breaks.insert(0, 0.0);
    let turns = gauss_legendre(AZIMUTHS, 0.0, PI);
    let mut all = Vec::new();
    for (tilt, weight) in composite(&breaks) {
        for (turn, share) in &turns {
            let h = spherical(tilt, *turn);
            let cosine = wi.dot(h);
            let wo = 2.0 * cosine * h - wi;
            if cosine > 0.0 && wo.z > 0.0 {
                // d omega_o = 4 (wi . h) d omega_h; both halves of the turn.
                all.push((wo, 2.0 * share * weight * tilt.sin() * 4.0 * cosine * wo.z));
            }
        }
    }
    all
}

/// What comes back of light at `theta`, radians, by quadrature of the BRDF, and by the account that the model keeps, is at most what
/// the surface let in.
pub fn none_is_made(model: &Model, theta: f64) -> Result<(), TestCaseError> {
    let wi = spherical(theta, 0.0);
    let gloss = dielectric(wi.z, model.optics().top().index);
    let (mut albedo, mut peak) = ([0.0; BANDS], [0.0f64; BANDS]);
    for (wo, weight) in outgoing(wi) {
        let f = model.brdf(wi, wo);
        for k in 0..BANDS {
            albedo[k] += weight * f.0[k];
            peak[k] = peak[k].max(f.0[k]);
        }
    }
    let error = model.missed_error().unwrap_or(super::ERROR);
    for k in 0..BANDS {
        // An error target is relative to the value or to a thousandth of the peak.
        let allowed = 1.0 - gloss + RULE + error * (albedo[k] + 1e-3 * PI * peak[k]);
        prop_assert!(albedo[k] <= allowed, "{theta}: band {k}: {} of {}", albedo[k], 1.0 - gloss);
    }
    if model.kind() != ModelKind::Fast {
        let energy = model.energy(theta).map_err(|e| TestCaseError::fail(e.to_string()))?;
        for k in 0..BANDS {
            let parts = [energy.reflected.0[k], energy.substrate.0[k], energy.films.0[k]];
            let sum = energy.gloss + parts.iter().sum::<f64>();
            // The books are balanced, and interpolation undershoots what is almost 0 by the error target's thousandth of the peak,
            // which is 1 at the most.
            prop_assert!((sum - 1.0).abs() < 1e-9, "{theta}: band {k}: {sum}");
            prop_assert!(parts.iter().all(|p| *p > -1e-3 * error), "{theta}: band {k}: {parts:?}");
        }
    }
    Ok(())
}

#[test]
fn the_rule_is_as_good_as_it_says() {
    for theta in [0.0f64, 0.3, 0.8, 1.2, 1.5] {
        let sum: f64 = outgoing(spherical(theta, 0.0)).iter().map(|(_, weight)| weight / PI).sum();
        assert!((sum - 1.0).abs() < RULE, "{theta}: {sum}");
    }
}
