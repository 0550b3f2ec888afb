//! Distributions of microfacets: sharper, or farther out, than a type can hold.

use super::extended::{Big, big, over, pi, relative, squared};
use super::{HardCase, pairs, worst};
use crate::brdf::cook_torrance::beckmann;
use crate::brdf::goniochromatic::ggx;
use crate::brdf::torrance_sparrow::smith_over_cosine;
use half::f16;

pub(super) fn cases() -> Vec<HardCase> {
    vec![beckmann_f32(), beckmann_f16(), ggx_f64(), ggx_f32(), ggx_grazing(), smith()]
}

/// Roughness of gloss and of metallic lobes, and squared tangents from the normal to the horizon.
fn lobes() -> Vec<(f32, f32)> {
    let tangents: Vec<f32> = (-14..=24).map(|k| 10f32.powi(k)).chain([0.0]).collect();
    pairs(&[1e-4, 0.002, 0.003, 0.03, 0.2, 1.3], &tangents)
}

/// Cosine of an angle given by its squared tangent.
fn cosine(tan2: f32) -> f32 {
    (1.0 + tan2).sqrt().recip()
}

/// Eq. 2 over its peak at the normal, `1 / alpha^2`; the cosine as it was rounded.
fn beckmann_over_peak((alpha, tan2): (f32, f32)) -> Big {
    // No f64 is left of it.
    if f64::from(tan2) > 2000.0 * f64::from(alpha).powi(2) {
        return big(0.0);
    }
    (-big(tan2) / squared(&big(alpha))).exp() / squared(&squared(&big(cosine(tan2))))
}

fn beckmann_f32() -> HardCase {
    let naive = |(alpha, tan2)| {
        let (cos2, alpha2): (f32, f32) = (cosine(tan2).powi(2), alpha * alpha);
        ((cos2 - 1.0) / (cos2 * alpha2)).exp() / (alpha2 * cos2 * cos2)
    };
    let error = |d: f32, case: (f32, f32)| {
        let peak = squared(&big(case.0)).to_f64().value();
        over(f64::from(d) * peak, &beckmann_over_peak(case), &big(1.0))
    };
    HardCase {
        name: "Beckmann of a gloss lobe in f32",
        formula: "exp((h.z^2 - 1) / (h.z^2 alpha^2)) / (alpha^2 h.z^4)",
        source: "Golla & Klein 2018, eq. 2; brdf::cook_torrance::beckmann",
        arguments: "alpha from 1e-4 to 1.3, tan^2 from 0 to 1e24; f32",
        measure: "over the peak",
        naive: worst(lobes(), |c| error(naive(c), c)),
        stable: worst(lobes(), |c| error(beckmann(c.1, cosine(c.1), c.0), c)),
        bar: 4.0 * f64::from(f32::EPSILON),
        why: "x exp(-x) is at most 0.4, x rounded twice; a square squared",
        worse: 1e3,
    }
}

fn beckmann_f16() -> HardCase {
    let gloss: Vec<(f32, f32)> = [0.0, 0.5, 1.0, 9.0].map(|x: f32| (0.002, 0.002 * 0.002 * x)).to_vec();
    let truth = |case: (f32, f32)| beckmann_over_peak(case) / squared(&big(case.0));
    HardCase {
        name: "Beckmann of a gloss lobe in f16",
        formula: "a lobe as a texture of half floats",
        source: "the lobe is kept as its three numbers; brdf::cook_torrance::beckmann",
        arguments: "alpha 0.002, from the peak of 2.5e5 to exp(-9) of it; f32 and f16",
        measure: "relative",
        naive: worst(gloss.clone(), |c| relative(f16::from_f64(truth(c).to_f64().value()), &truth(c))),
        stable: worst(gloss, |c| relative(beckmann(c.1, cosine(c.1), c.0), &truth(c))),
        bar: 24.0 * f64::from(f32::EPSILON),
        why: "an exponent of up to 9, rounded twice, and four products",
        worse: 1e3,
    }
}

/// Eq. 3 at a squared tangent.
fn trowbridge_reitz(alpha: f64, tan2: f64) -> Big {
    let (one, a2) = (big(1.0), squared(&big(alpha)));
    let root = (&a2 - &one) / (&one + big(tan2)) + &one;
    a2 / (pi() * squared(&root))
}

fn ggx_f64() -> HardCase {
    let all = pairs(&[1e-4, 0.01, 0.19, 1.0], &[0.0, 1e-16, 1e-9, 1e-4, 1.0, 1e4, 1e16]);
    let naive = |(alpha, tan2): (f64, f64)| {
        let (a2, cos2) = (alpha * alpha, (1.0 + tan2).recip());
        a2 / (std::f64::consts::PI * ((a2 - 1.0) * cos2 + 1.0).powi(2))
    };
    HardCase {
        name: "GGX of a smooth surface",
        formula: "alpha^2 / (pi ((alpha^2 - 1) cos^2 + 1)^2)",
        source: "Pranovich et al. 2024, eq. 3; brdf::goniochromatic::ggx",
        arguments: "alpha from 1e-4 to 1, tan^2 from 0 to 1e16; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &trowbridge_reitz(c.0, c.1))),
        stable: worst(all, |(alpha, tan2)| relative(ggx(tan2, alpha), &trowbridge_reitz(alpha, tan2))),
        bar: 8.0 * f64::EPSILON,
        why: "a square of a sum of a quotient",
        worse: 1e5,
    }
}

fn ggx_f32() -> HardCase {
    let all = pairs(&[1e-4f32, 0.002, 0.01, 0.19, 1.0], &[0.0f32, 1e-9, 1e-4, 1.0, 1e4, 1e16]);
    let naive = |(alpha, tan2): (f32, f32)| {
        let (a2, cos2) = (alpha * alpha, (1.0 + tan2).recip());
        a2 / (std::f32::consts::PI * ((a2 - 1.0) * cos2 + 1.0).powi(2))
    };
    let truth = |(alpha, tan2): (f32, f32)| trowbridge_reitz(alpha.into(), tan2.into());
    HardCase {
        name: "GGX of a smooth surface in f32",
        formula: "alpha^2 / (pi ((alpha^2 - 1) cos^2 + 1)^2)",
        source: "Pranovich et al. 2024, eq. 3; brdf::goniochromatic::ggx",
        arguments: "alpha from 1e-4 to 1, tan^2 from 0 to 1e16; f32",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |c| relative(ggx(c.1, c.0), &truth(c))),
        bar: 8.0 * f64::from(f32::EPSILON),
        why: "a square of a sum of a quotient",
        worse: 1e3,
    }
}

fn ggx_grazing() -> HardCase {
    let all = pairs(&[1e-4f64, 0.19, 1.0], &[1e30f64, 1e100, 1e300, f64::INFINITY]);
    let naive = |(alpha, tan2): (f64, f64)| {
        let cos2 = (1.0 + tan2).recip();
        alpha * alpha / (std::f64::consts::PI * cos2 * cos2 * (alpha * alpha + tan2).powi(2))
    };
    let truth = |alpha: f64| squared(&big(alpha)) / pi();
    HardCase {
        name: "GGX at the horizon",
        formula: "alpha^2 / (pi cos^4 (alpha^2 + tan^2)^2)",
        source: "Walter et al. 2007, eq. 33; brdf::goniochromatic::ggx",
        arguments: "alpha from 1e-4 to 1, tan^2 from 1e30 to infinity; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c.0))),
        stable: worst(all, |(alpha, tan2)| relative(ggx(tan2, alpha), &truth(alpha))),
        bar: 4.0 * f64::EPSILON,
        why: "two products",
        worse: 1e9,
    }
}

fn smith() -> HardCase {
    let all = pairs(&[1e-4, 0.19, 1.0], &[0.0, 1e-300, 1e-18, 1e-6, 0.5, 1.0]);
    let truth = |(alpha, cos): (f64, f64)| {
        let (a2, c2) = (squared(&big(alpha)), squared(&big(cos)));
        big(1.0) / (big(cos) + (&a2 + (big(1.0) - &a2) * c2).sqrt())
    };
    let naive = |(alpha, cos): (f64, f64)| {
        let tan2 = (1.0 - cos * cos) / (cos * cos);
        2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt()) / (2.0 * cos)
    };
    HardCase {
        name: "shadowing over the cosine at the horizon",
        formula: "2 / (1 + sqrt(1 + alpha^2 tan^2)) / (2 cos)",
        source: "Walter et al. 2007, eq. 34; brdf::torrance_sparrow::smith_over_cosine",
        arguments: "alpha from 1e-4 to 1, cosines from 0 to 1; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |(alpha, cos)| relative(smith_over_cosine(cos, alpha), &truth((alpha, cos)))),
        bar: 4.0 * f64::EPSILON,
        why: "a root of a sum, a sum, a quotient",
        worse: 1e9,
    }
}
