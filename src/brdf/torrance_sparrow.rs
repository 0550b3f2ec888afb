//! The standard microfacet model that goniochromatic inks are compared with.
//!
//! Torrance and Sparrow's model with the distribution of Trowbridge and Reitz (Pranovich et al. 2024, eqs 2, 3) and Smith's
//! shadowing as Walter et al. 2007 give it (eqs 23, 34): `f = F G D / (4 cos_i cos_o)`. The paper takes its fitted spectrum rho
//! either as what multiplies the exact Fresnel term of titanium dioxide, or as the reflectance at normal incidence in Schlick's.

use super::LobeGeometry;
use super::goniochromatic::ggx;
use num_traits::{Float, FloatConst};

/// BRDF, 1/sr, of a Fresnel term; finite up to the horizon, 0 below it.
pub fn torrance_sparrow<F: Float + FloatConst>(g: &LobeGeometry<F>, roughness: F, fresnel: F) -> F {
    if g.cos_i < F::zero() || g.cos_o < F::zero() {
        return F::zero();
    }
    let shadowing = smith_over_cosine(g.cos_i, roughness) * smith_over_cosine(g.cos_o, roughness);
    fresnel * ggx(g.tan2_h, roughness) * shadowing
}

/// Smith's G of one direction over twice its cosine, in [0, 1] (Walter et al. 2007, eq. 34):
/// `1 / (cos + sqrt(cos^2 + alpha^2 sin^2))`, which nothing divides at the horizon.
pub fn smith_over_cosine<F: Float>(cos: F, roughness: F) -> F {
    let a2 = roughness * roughness;
    (cos + (a2 + (F::one() - a2) * cos * cos).sqrt()).recip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    /// What is visible of all facets is what the surface shows (Heitz 2014, eq. 9): `int D max(0, h.o) G1(o) dh = cos_o`.
    #[test]
    fn visible_facets_fill_the_projected_surface() {
        let (n, m) = (2000, 200);
        for alpha in [0.1, 0.19, 0.5, 1.0] {
            for theta in [0.0, 0.6, 1.2, 1.5] {
                let wo = spherical(theta, 0.0);
                let mut sum = 0.0;
                for a in 0..n {
                    let theta_h = (f64::from(a) + 0.5) * FRAC_PI_2 / f64::from(n);
                    let ring = ggx(theta_h.tan().powi(2), alpha) * theta_h.sin() * FRAC_PI_2 / f64::from(n);
                    for b in 0..m {
                        let phi = (f64::from(b) + 0.5) * TAU / f64::from(m);
                        sum += ring * wo.dot(spherical(theta_h, phi)).max(0.0) * TAU / f64::from(m);
                    }
                }
                // G1 is twice the cosine times the quotient; the corner at h.o = 0 costs the sum a few digits.
                let filled = sum * 2.0 * smith_over_cosine(theta.cos(), alpha);
                assert!((filled - 1.0).abs() < 1e-4, "{alpha} {theta}: {filled}");
            }
        }
    }

    #[test]
    fn it_is_reciprocal() {
        let (wi, wo) = (spherical(0.4, 0.3), spherical(1.3, 2.0));
        let both =
            [LobeGeometry::of(wi, wo), LobeGeometry::of(wo, wi)].map(|g| torrance_sparrow(&g, 0.3, 0.5));
        assert!((both[0] / both[1] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_quotient_is_smiths() {
        for alpha in [1e-3, 0.19, 1.0] {
            for theta in [0.0f64, 0.3, 1.2, 1.5] {
                let lambda = 0.5 * ((1.0 + (alpha * theta.tan()).powi(2)).sqrt() - 1.0);
                let expected = 1.0 / (1.0 + lambda) / (2.0 * theta.cos());
                let found = smith_over_cosine(theta.cos(), alpha);
                assert!((found / expected - 1.0).abs() < 1e-12, "{alpha} {theta}: {found} {expected}");
            }
        }
        let edge = LobeGeometry::of(spherical(FRAC_PI_2, 0.0), spherical(FRAC_PI_2, PI));
        assert!(torrance_sparrow(&edge, 1e-3, 1.0).is_finite());
    }
}
