//! Exponentials: light through next to nothing, or next to everything, and the far ends of distributions.

use super::extended::{Big, big, pi, relative, squared};
use super::{HardCase, decades, pairs, worst};
use crate::math::normal;
use crate::simulate::models::transfer::film::{attenuation, mean_overlap};
use crate::simulate::models::transfer::kernel::Side;
use crate::simulate::optics::bessel::i0_scaled;
use crate::simulate::optics::film_optics::mean_attenuation;
use std::f64::consts::FRAC_1_SQRT_2;

pub(super) fn cases() -> Vec<HardCase> {
    vec![thin_layer(), two_events(), two_paths(), bessel(), normal_tail()]
}

fn thin_layer() -> HardCase {
    let all = [decades(-18..=4), vec![0.3, 3.0, 700.0, 745.0]].concat();
    let truth = |x: f64| (big(1.0) - (-big(x)).exp()) / big(x);
    HardCase {
        name: "mean attenuation of a thin layer",
        formula: "(1 - exp(-x)) / x",
        source: "Ershov et al. 2001, eq. 36; simulate::optics::film_optics::mean_attenuation",
        arguments: "x from 1e-18 to 1e4; f64",
        measure: "relative",
        naive: worst(all.clone(), |x| relative((1.0 - (-x).exp()) / x, &truth(x))),
        stable: worst(all, |x| relative(mean_attenuation(x), &truth(x))),
        bar: 2.0 * f64::EPSILON,
        why: "exp_m1 and a quotient",
        worse: 1e14,
    }
}

fn two_events() -> HardCase {
    let all = [decades(-18..=4), vec![0.5, 0.999, 1.0, 1.001, 3.0, 30.0]].concat();
    let truth = |t: f64| (big(t) - big(1.0) + (-big(t)).exp()) / squared(&big(t));
    HardCase {
        name: "two scattering events in a thin layer",
        formula: "(t - 1 + exp(-t)) / t^2",
        source: "Ershov et al. 2001, eq. 11, to second order; simulate::models::transfer::film::mean_overlap",
        arguments: "t from 1e-18 to 1e4; f64",
        measure: "relative",
        naive: worst(all.clone(), |t| relative((t - 1.0 + (-t).exp()) / (t * t), &truth(t))),
        stable: worst(all, |t| relative(mean_overlap(t), &truth(t))),
        bar: 8.0 * f64::EPSILON,
        why: "just above 1 a difference of 1 and 0.63, which leaves 0.37",
        worse: 1e14,
    }
}

fn two_paths() -> HardCase {
    let apart = [vec![0.0, 1.0, 30.0], decades(-16..=-1)].concat();
    let all: Vec<(f64, f64)> =
        pairs(&[1e-6, 0.1, 1.0, 30.0], &apart).into_iter().map(|(a, d)| (a, a * (1.0 + d))).collect();
    let truth = |(a, b): (f64, f64)| {
        let (a, b) = (big(a), big(b));
        if a == b { (-a).exp() } else { ((-&a).exp() - (-&b).exp()) / (b - a) }
    };
    let naive = |(a, b): (f64, f64)| ((-a).exp() - (-b).exp()) / (b - a);
    HardCase {
        name: "onward light along two nearly equal paths",
        formula: "(exp(-a) - exp(-b)) / (b - a)",
        source: "Ershov et al. 2001, eq. 12; simulate::models::transfer::film::attenuation",
        arguments: "a from 1e-6 to 30, b from a to 31 a; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |(a, b)| relative(attenuation(Side::Transmission, [a, b]), &truth((a, b)))),
        bar: 4.0 * f64::EPSILON,
        why: "an exponential, exp_m1, a quotient, a product",
        worse: 1e9,
    }
}

fn bessel() -> HardCase {
    let all = [1e-9, 0.1, 1.0, 10.0, 17.9, 18.1, 100.0, 700.0, 720.0, 1e3];
    // All terms are positive.
    let series = |x: f64| {
        let quarter = squared(&big(x)) / big(4.0);
        let (mut term, mut sum) = (big(1.0), big(1.0));
        for k in 1..=(2.0 * x) as u32 + 80 {
            term = term * &quarter / big(f64::from(k) * f64::from(k));
            sum += &term;
        }
        sum
    };
    let naive = |x: f64| {
        let quarter = 0.25 * x * x;
        let terms = (1..=(2.0 * x) as u32 + 80).scan(1.0, |term, k| {
            *term *= quarter / (f64::from(k) * f64::from(k));
            Some(*term)
        });
        (1.0 + terms.sum::<f64>()) * (-x).exp()
    };
    let truth = |x: f64| series(x) * (-big(x)).exp();
    HardCase {
        name: "a ring of narrow lobes",
        formula: "exp(-x) I_0(x)",
        source: "Abramowitz & Stegun 9.6.10, 9.7.1; simulate::optics::bessel::i0_scaled",
        arguments: "x from 1e-9 to 1e3; f64",
        measure: "relative",
        naive: worst(all, |x| relative(naive(x), &truth(x))),
        stable: worst(all, |x| relative(i0_scaled(x), &truth(x))),
        bar: 1e-13,
        why: "where series and asymptotic series meet, at 18, the latter ends at exp(-36)",
        worse: 1e3,
    }
}

fn normal_tail() -> HardCase {
    let all: Vec<f64> = (0..=36).map(|k| -0.25 * f64::from(k)).collect();
    // erfc(z) = 1 - 2 / sqrt(pi) sum (-1)^n z^(2 n + 1) / (n! (2 n + 1)); at z = 6.4 it loses 36 of the 77 digits.
    let truth = |x: f64| -> Big {
        let z2 = squared(&big(x)) / big(2.0);
        let (mut power, mut sum) = (z2.sqrt(), z2.sqrt());
        for n in 1..=300 {
            power = -power * &z2 / big(f64::from(n));
            sum += &power / big(f64::from(2 * n + 1));
        }
        big(0.5) - sum / pi().sqrt()
    };
    let naive = |x: f64| 0.5 * (1.0 + libm::erf(x * FRAC_1_SQRT_2));
    HardCase {
        name: "the tail of the normal distribution",
        formula: "(1 + erf(x / sqrt 2)) / 2",
        source: "Abramowitz & Stegun 26.2.29; math::normal::cdf",
        arguments: "x from -9 to 0; f64",
        measure: "relative",
        naive: worst(all.clone(), |x| relative(naive(x), &truth(x))),
        stable: worst(all, |x| relative(normal::cdf(x), &truth(x))),
        bar: 2e-14,
        why: "exp(-x^2 / 2) at x = -9: the argument, rounded twice, times 81",
        worse: 1e9,
    }
}
