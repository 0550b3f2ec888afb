//! Directions of practice: where the error of a model is taken.

use carpaint::math::half_difference::spherical;
use glam::DVec3;

/// Unit directions to light and to detector: the multi-angle instruments (ASTM E2194, E2539: 45 and 15 degrees of incidence,
/// aspecular angles -15 to 110) and a 10 degree grid of both polar angles and the azimuth difference.
pub fn of_practice() -> Vec<(DVec3, DVec3)> {
    let mut pairs = Vec::new();
    for incidence in [45.0f64, 15.0] {
        for aspecular in [-15.0, 15.0, 25.0, 45.0, 75.0, 110.0] {
            // Mirror direction at -incidence; aspecular angles count towards the light.
            let out: f64 = aspecular - incidence;
            if out.abs() < 90.0 {
                let azimuth = if out < 0.0 { std::f64::consts::PI } else { 0.0 };
                pairs.push((
                    spherical(incidence.to_radians(), 0.0),
                    spherical(out.abs().to_radians(), azimuth),
                ));
            }
        }
    }
    for i in 0..9 {
        for o in 0..=i {
            for phi in 0..19 {
                let [i, o, phi] = [i, o, phi].map(|k| f64::from(k * 10).to_radians());
                pairs.push((spherical(i, 0.0), spherical(o, phi)));
            }
        }
    }
    pairs
}

/// Largest `|a - b| / max(b, 1e-3 of b's peak)` over directions and wavelengths, the peak of each wavelength; `a` and `b` are
/// spectra at the same directions.
pub fn error(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let bands = b[0].len();
    let mut worst = 0.0f64;
    for k in 0..bands {
        let peak = b.iter().map(|row| row[k]).fold(0.0, f64::max);
        for (x, y) in a.iter().zip(b) {
            worst = worst.max((x[k] - y[k]).abs() / y[k].max(1e-3 * peak));
        }
    }
    worst
}
