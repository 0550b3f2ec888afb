//! Directional albedo of a Cook-Torrance lobe.

use crate::brdf::Lobe;
use crate::brdf::fresnel::schlick;
use crate::math::quadrature::{breaks, composite};
use std::f64::consts::{FRAC_PI_2, PI};

/// Half-vector slope over roughness beyond which Beckmann's distribution is nothing in f64.
const REACH: f64 = 7.0;

/// Share of the light from `theta_i` (radians, in [0, pi/2)) that a lobe sends back: the integral of f cos(theta_o) over the
/// hemisphere of wo. Relative accuracy 1e-9 for any roughness; may exceed 1, for this Cook-Torrance is not normalized.
///
/// Over half vectors, `d wo = 4 (h.i) dh`, with slope = roughness * x, D dh becomes `x exp(-x^2) / cos(theta_h) dx dphi`: the
/// narrowest lobe is as smooth as the widest. The shadowing term is only piecewise smooth: its three faces and the horizon
/// meet where h.i has known values, and these meet the plane of incidence at known angles; both integrals are cut there.
pub fn albedo(lobe: &Lobe, theta_i: f64) -> f64 {
    let quarter = FRAC_PI_2;
    let cuts = [theta_i, quarter - theta_i, (quarter + theta_i) / 3.0, (quarter - theta_i) / 3.0]
        .into_iter()
        .chain([(quarter + theta_i) / 2.0, (quarter - theta_i) / 2.0])
        .map(|theta_h| theta_h.tan() / lobe.roughness);
    let even = (1..28).map(|k| REACH * f64::from(k) / 28.0);
    let over_slope: f64 = composite(&breaks(0.0, REACH, cuts.chain(even)))
        .map(|(x, weight)| weight * x * (-x * x).exp() * ring(lobe, theta_i, lobe.roughness * x))
        .sum();
    lobe.coefficient / PI * 8.0 * over_slope / theta_i.cos()
}

/// Integral over half the azimuth of `(h.i) F G / cos(theta_h)` at half vectors of slope `slope`.
fn ring(lobe: &Lobe, theta_i: f64, slope: f64) -> f64 {
    let (sin_i, cos_i) = theta_i.sin_cos();
    let cos_h = 1.0 / slope.hypot(1.0);
    let sin_h = slope * cos_h;
    let (middle, swing) = (cos_h * cos_i, sin_h * sin_i);
    // h.i where the horizon and the faces of the shadowing term meet.
    let edges = [
        cos_i / (2.0 * cos_h),
        2.0 * cos_h * cos_i / (4.0 * cos_h * cos_h - 1.0),
        2.0 * cos_h * cos_i,
        cos_i / cos_h,
    ];
    let cuts = edges.into_iter().map(|u| (u - middle) / swing).filter(|c| c.abs() < 1.0).map(f64::acos);
    let integrand = |phi: f64| {
        let cos_d = middle + swing * phi.cos();
        let cos_o = 2.0 * cos_d * cos_h - cos_i;
        if cos_d <= 0.0 || cos_o <= 0.0 {
            return 0.0;
        }
        let shadow = 1f64.min(2.0 * cos_h * cos_o / cos_d).min(2.0 * cos_h * cos_i / cos_d);
        cos_d * schlick(lobe.f0, cos_d) * shadow / cos_h
    };
    composite(&breaks(0.0, PI, cuts.chain([FRAC_PI_2]))).map(|(phi, weight)| weight * integrand(phi)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::LobeGeometry;
    use crate::math::half_difference::spherical;

    #[test]
    fn agrees_with_a_plain_sum_over_directions() {
        let lobe = Lobe { coefficient: 0.3, roughness: 0.5, f0: 0.2 };
        for theta_i in [0.0, 0.5, 1.2] {
            let wi = spherical(theta_i, 0.0);
            let n = 600;
            let mut sum = 0.0;
            for a in 0..n {
                for b in 0..n {
                    let theta = FRAC_PI_2 * (f64::from(a) + 0.5) / f64::from(n);
                    let wo = spherical(theta, PI * (f64::from(b) + 0.5) / f64::from(n));
                    sum += lobe.eval(&LobeGeometry::of(wi, wo)) * wo.z * theta.sin();
                }
            }
            let plain = sum * PI * PI / f64::from(n * n);
            // The midpoint rule across the kinks of the shadowing term: (pi / 600)^2 times slopes near 1.
            assert!((albedo(&lobe, theta_i) / plain - 1.0).abs() < 3e-5, "{theta_i}");
        }
    }
}
