//! Angles so small that their cosine is 1.

use super::extended::{Big, big, relative, squared};
use super::{HardCase, decades, pairs, worst};
use crate::brdf::LobeGeometry;
use crate::brdf::goniochromatic::cos_mean_angle;
use crate::math::half_difference::{HalfDifference, directions, spherical};
use crate::simulate::optics::orientation::FlakeLobe;
use glam::DVec3;
use std::f64::consts::LN_2;

pub(super) fn cases() -> Vec<HardCase> {
    vec![half_angle(), difference_angle(), squared_tangent(), narrow_lobe(), mean_angle()]
}

/// The components, and the length of some of them.
fn exact(v: DVec3) -> [Big; 3] {
    v.to_array().map(big)
}

fn length(v: &[Big]) -> Big {
    v.iter().map(squared).fold(big(0.0), |sum, x| sum + x).sqrt()
}

fn plus(a: DVec3, b: DVec3) -> [Big; 3] {
    let ([ax, ay, az], [bx, by, bz]) = (exact(a), exact(b));
    [ax + bx, ay + by, az + bz]
}

/// Half vectors near the normal, for light and eye at several angles from it.
fn near_normal() -> Vec<(DVec3, DVec3)> {
    let angles = pairs(&decades(-12..=0), &[0.0, 0.3, 1.2]);
    angles.into_iter().map(|(theta_h, theta_i)| directions(theta_h, theta_i, 0.7)).collect()
}

fn half_angle() -> HardCase {
    let truth = |(wi, wo)| {
        let [x, y, z] = plus(wi, wo);
        length(&[x, y]).atan2(&z)
    };
    let naive = |(wi, wo): (DVec3, DVec3)| (wi + wo).normalize().z.min(1.0).acos();
    let stable = |(wi, wo)| HalfDifference::of(wi, wo).theta_h;
    HardCase {
        name: "half angle near the normal",
        formula: "theta_h = acos(h.z)",
        source: "Golla & Klein 2018, section 3.1; math::half_difference",
        arguments: "theta_h from 1e-12 to 1, theta_i 0, 0.3, 1.2; f64",
        measure: "relative",
        naive: worst(near_normal(), |w| relative(naive(w), &truth(w))),
        stable: worst(near_normal(), |w| relative(stable(w), &truth(w))),
        bar: 4.0 * f64::EPSILON,
        why: "a sum, a length, an arc tangent",
        worse: 1e12,
    }
}

fn difference_angle() -> HardCase {
    // Not below: directions of unit length to the last digit are so to 1e-16, and |wi - wo| has both of their errors.
    let all: Vec<_> = pairs(&decades(-7..=0), &[0.0, 0.3, 1.2])
        .into_iter()
        .map(|(theta_i, theta_h)| directions(theta_h, theta_i, 0.7))
        .collect();
    let truth = |(wi, wo): (DVec3, DVec3)| {
        let ([ax, ay, az], [bx, by, bz]) = (exact(wi), exact(wo));
        let cross = [&ay * &bz - &az * &by, &az * &bx - &ax * &bz, &ax * &by - &ay * &bx];
        let dot = &ax * &bx + &ay * &by + &az * &bz;
        length(&cross).atan2(&dot) / big(2.0)
    };
    let naive = |(wi, wo): (DVec3, DVec3)| (wi + wo).normalize().dot(wo).min(1.0).acos();
    let stable = |(wi, wo)| HalfDifference::of(wi, wo).theta_i;
    HardCase {
        name: "light and eye side by side",
        formula: "theta_i = acos(h . wo)",
        source: "Golla & Klein 2018, section 3.1; math::half_difference",
        arguments: "theta_i from 1e-7 to 1, theta_h 0, 0.3, 1.2; f64",
        measure: "relative",
        naive: worst(all.clone(), |w| relative(naive(w), &truth(w))),
        stable: worst(all, |w| relative(stable(w), &truth(w))),
        bar: 4.0 * f64::EPSILON,
        why: "two differences, two lengths, an arc tangent",
        worse: 1e10,
    }
}

fn squared_tangent() -> HardCase {
    let truth = |(wi, wo)| {
        let [x, y, z] = plus(wi, wo);
        (squared(&x) + squared(&y)) / squared(&z)
    };
    let naive = |(wi, wo): (DVec3, DVec3)| {
        let cos2 = (wi + wo).normalize().z.powi(2);
        (1.0 - cos2) / cos2
    };
    let stable = |(wi, wo)| LobeGeometry::of(wi, wo).tan2_h;
    HardCase {
        name: "tangent of the half angle",
        formula: "tan^2 = (1 - h.z^2) / h.z^2",
        source: "Golla & Klein 2018, eq. 2; brdf::cook_torrance::LobeGeometry",
        arguments: "theta_h from 1e-12 to 1, theta_i 0, 0.3, 1.2; f64",
        measure: "relative",
        naive: worst(near_normal(), |w| relative(naive(w), &truth(w))),
        stable: worst(near_normal(), |w| relative(stable(w), &truth(w))),
        bar: 8.0 * f64::EPSILON,
        why: "sums that are squared, and a quotient",
        worse: 1e12,
    }
}

fn narrow_lobe() -> HardCase {
    let all = pairs(&decades(-6..=-1), &[0.2, 0.7, 1.5]);
    let seen = |(width, widths): (f64, f64)| (spherical(0.4, 0.3), spherical(0.4 + widths * width, 0.3));
    // Over its peak: exp(-kappa (1 - cos delta)) with 1 - cos delta = |n - h|^2 / 2 for unit vectors.
    let truth = |case: (f64, f64)| {
        let kappa = big(LN_2) / (big(2.0) * squared(&(big(0.25) * big(case.0)).sin()));
        let (n, h) = seen(case);
        let apart = length(&plus(n, -h));
        (big(-0.5) * kappa * squared(&apart)).exp()
    };
    let naive = |case: (f64, f64)| {
        let kappa = LN_2 / (1.0 - (0.5 * case.0).cos());
        let (n, h) = seen(case);
        (-kappa * (1.0 - n.dot(h))).exp()
    };
    let stable = |case: (f64, f64)| {
        let lobe = FlakeLobe::new(case.0);
        let (n, h) = seen(case);
        lobe.density(n, h) / lobe.density(n, n)
    };
    HardCase {
        name: "1 - cos in a narrow flake lobe",
        formula: "exp(-kappa (1 - cos delta))",
        source: "von Mises-Fisher; simulate::optics::orientation::FlakeLobe",
        arguments: "full widths from 1e-6 to 0.1 rad, 0.2 to 1.5 of them off the peak; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |c| relative(stable(c), &truth(c))),
        bar: 32.0 * f64::EPSILON,
        why: "an exponent of up to 6 with some six roundings",
        worse: 1e8,
    }
}

fn mean_angle() -> HardCase {
    let cosines = [decades(-18..=-1), vec![0.5, 0.99, 1.0]].concat();
    let all = pairs(&cosines, &cosines);
    let truth = |(a, b)| {
        let (one, a, b) = (big(1.0), big(a), big(b));
        let outer = ((&one + &a) * (&one + &b)).sqrt();
        let inner = ((&one - &a) * (&one - &b)).sqrt();
        (outer - inner) / big(2.0)
    };
    let naive = |(a, b): (f64, f64)| 0.5 * (((1.0 + a) * (1.0 + b)).sqrt() - ((1.0 - a) * (1.0 - b)).sqrt());
    HardCase {
        name: "mean of two grazing angles",
        formula: "(sqrt((1+a)(1+b)) - sqrt((1-a)(1-b))) / 2",
        source: "Pranovich et al. 2024, eq. 6; brdf::goniochromatic::cos_mean_angle",
        arguments: "cosines a, b from 1e-18 to 1; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |(a, b)| relative(cos_mean_angle(a, b), &truth((a, b)))),
        bar: 4.0 * f64::EPSILON,
        why: "two products of sums, roots, a sum, a quotient",
        worse: 1e14,
    }
}
