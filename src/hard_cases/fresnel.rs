//! Smooth boundaries and thin films: grazing light, indices near each other, total reflection, opaque metal.

use super::extended::{Big, absolute, big, relative, squared};
use super::{HardCase, decades, larger, pairs, worst};
use crate::brdf::ClearCoat;
use crate::brdf::fresnel::{dielectric, refracted_cosine, transmitted};
use crate::simulate::optics::geometry::Geometry;
use crate::simulate::optics::thin_film::{FilmLayer, stack_power};
use glam::DVec3;
use nalgebra::Complex;
use std::f64::consts::PI;

pub(super) fn cases() -> Vec<HardCase> {
    vec![grazing(), coat(), near_indices(), total_reflection(), film_of_air(), opaque_metal()]
}

/// Textbook reflectance; 1 in total reflection.
fn reflectance(cos_i: f64, eta: f64) -> Big {
    let (c, eta) = (big(cos_i), big(eta));
    let cos2_t = big(1.0) - (big(1.0) - squared(&c)) / squared(&eta);
    if cos2_t <= Big::ZERO {
        return big(1.0);
    }
    let t = cos2_t.sqrt();
    let s = (&c - &eta * &t) / (&c + &eta * &t);
    let p = (&eta * &c - &t) / (&eta * &c + &t);
    (squared(&s) + squared(&p)) / big(2.0)
}

/// The same in f64.
fn textbook(cos_i: f64, eta: f64) -> f64 {
    let t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    let s = (cos_i - eta * t) / (cos_i + eta * t);
    let p = (eta * cos_i - t) / (eta * cos_i + t);
    0.5 * (s * s + p * p)
}

/// Cosines from grazing to the normal, with indices of lacquers and beyond.
fn boundaries() -> Vec<(f64, f64)> {
    pairs(&[decades(-18..=-1), vec![0.5, 1.0]].concat(), &[1.1, 1.5, 4.0])
}

fn grazing() -> HardCase {
    let truth = |(c, eta)| big(1.0) - reflectance(c, eta);
    HardCase {
        name: "light that enters at grazing angles",
        formula: "1 - (r_s^2 + r_p^2) / 2",
        source: "Born & Wolf 1.5; brdf::fresnel::transmitted",
        arguments: "cosines from 1e-18 to 1, eta 1.1, 1.5, 4; f64",
        measure: "relative",
        naive: worst(boundaries(), |c| relative(1.0 - textbook(c.0, c.1), &truth(c))),
        stable: worst(boundaries(), |c| relative(transmitted(c.0, c.1), &truth(c))),
        bar: 8.0 * f64::EPSILON,
        why: "a refracted cosine, two squared sums, four products",
        worse: 1e12,
    }
}

fn coat() -> HardCase {
    let all = pairs(&boundaries(), &[1e-9, 0.3]);
    let truth = |((c, eta), other): ((f64, f64), f64)| {
        (big(1.0) - reflectance(c, eta)) * (big(1.0) - reflectance(other, eta))
    };
    let naive =
        |((c, eta), other): ((f64, f64), f64)| (1.0 - textbook(c, eta)) * (1.0 - textbook(other, eta));
    let stable = |case: ((f64, f64), f64)| {
        let ((c, eta), other) = case;
        let slanted = |cos: f64| DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let binder = Geometry::new(slanted(c), slanted(other), eta).map_or(f64::NAN, |g| g.transmission);
        let coat = ClearCoat::ideal(eta, false).transmittance(c, other);
        larger(relative(coat, &truth(case)), relative(binder, &truth(case)))
    };
    HardCase {
        name: "losses of a clear coat at grazing angles",
        formula: "(1 - F(w_i)) (1 - F(w_o))",
        source: "Golla & Klein 2018, section 3.1; brdf::ClearCoat::transmittance, simulate::optics::geometry",
        arguments: "cosines from 1e-18 to 1 with 1e-9 and 0.3, eta 1.1, 1.5, 4; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, stable),
        bar: 16.0 * f64::EPSILON,
        why: "twice that of light that enters, and a product",
        worse: 1e12,
    }
}

fn near_indices() -> HardCase {
    let apart: Vec<f64> = (10..=50).step_by(5).map(|k| 1.0 + f64::from(-k).exp2()).collect();
    let all = pairs(&[decades(-12..=-1), vec![0.5, 1.0]].concat(), &apart);
    let truth = |(c, eta): (f64, f64)| (big(1.0) - (big(1.0) - squared(&big(c))) / squared(&big(eta))).sqrt();
    let naive = |(c, eta): (f64, f64)| (1.0 - (1.0 - c * c) / (eta * eta)).sqrt();
    HardCase {
        name: "refraction between nearly equal indices",
        formula: "cos_t = sqrt(1 - sin^2 / eta^2)",
        source: "Ershov et al. 2001, eq. 24; brdf::fresnel::refracted_cosine",
        arguments: "cosines from 1e-12 to 1, eta - 1 from 2^-50 to 2^-10; f64",
        measure: "relative",
        naive: worst(all.clone(), |c| relative(naive(c), &truth(c))),
        stable: worst(all, |c| relative(refracted_cosine(c.0, c.1), &truth(c))),
        bar: 4.0 * f64::EPSILON,
        why: "half of what a sum of products, a quotient and a square make, and a root",
        worse: 1e6,
    }
}

fn total_reflection() -> HardCase {
    let eta = 1.0 / 1.5;
    let critical = (1.0f64 - eta * eta).sqrt();
    let near = decades(-15..=-1).into_iter().flat_map(|d| [critical * (1.0 - d), critical * (1.0 + d)]);
    let all: Vec<f64> = near.chain([0.0, critical, critical.next_up(), critical.next_down(), 1.0]).collect();
    HardCase {
        name: "reflection about the critical angle",
        formula: "cos_t = sqrt(1 - sin^2 / eta^2)",
        source: "Born & Wolf 1.5; brdf::fresnel::dielectric",
        arguments: "cosines on both sides of the critical one down to the next number, eta 1/1.5; f64",
        measure: "absolute",
        naive: worst(all.clone(), |c| absolute(textbook(c, eta), &reflectance(c, eta))),
        stable: worst(all, |c| absolute(dielectric(c, eta), &reflectance(c, eta))),
        bar: 2.0 * f64::EPSILON.sqrt(),
        why: "F ends in a root, whose slope is infinite: a rounding moves it by its root",
        worse: 1e3,
    }
}

fn film_of_air() -> HardCase {
    let cosines: Vec<f64> = (42..90).map(|d| f64::from(d).to_radians().cos()).chain([1e-6]).collect();
    let all = pairs(&cosines, &[1.0, 100.0, 1e4, 1e6]);
    let one = Complex::new(1.0, 0.0);
    let stable = |(cos, thickness_nm): (f64, f64)| {
        let film = FilmLayer { index: one, thickness_nm };
        let power = stack_power(1.5, &[film], one * 1.5, cos, 550.0);
        let lost = |p: usize| (power.reflectance[p] + power.transmittance[p] - 1.0).abs();
        larger(lost(0), lost(1))
    };
    // Airy's formula, s polarization, with Snell's law in real numbers.
    let naive = |(cos, thickness_nm): (f64, f64)| {
        let inside = (1.0 - 2.25 * (1.0 - cos * cos)).sqrt();
        let r = (1.5 * cos - inside) / (1.5 * cos + inside);
        let turn = (4.0 * PI * inside * thickness_nm / 550.0).cos();
        let power = 2.0 * r * r * (1.0 - turn) / (1.0 + r.powi(4) - 2.0 * r * r * turn);
        (power - power.clamp(0.0, 1.0)).abs()
    };
    HardCase {
        name: "total reflection inside a film",
        formula: "cos_1 = sqrt(1 - (n_0 sin_0 / n_1)^2)",
        source: "Macleod, chapter 2; simulate::optics::thin_film::stack_power",
        arguments: "air between glass, 42 to 90 degrees, 1 nm to 1 mm; f64",
        measure: "R + T = 1, off by",
        naive: worst(all.clone(), naive),
        stable: worst(all, stable),
        bar: 64.0 * f64::EPSILON,
        why: "products of complex matrices, quotients, squares",
        worse: 1e3,
    }
}

fn opaque_metal() -> HardCase {
    let index = Complex::new(0.2, 3.5);
    let all = [1e4, 1e5, 1e6, 1e9];
    let truth = || {
        let [n0, n, k] = [1.5, index.re, index.im].map(big);
        (squared(&(&n0 - &n)) + squared(&k)) / (squared(&(&n0 + &n)) + squared(&k))
    };
    let naive = |thickness: f64| {
        let delta = index * (2.0 * PI * thickness / 550.0);
        let (cos, i_sin) = (delta.cos(), Complex::<f64>::i() * delta.sin());
        // On glass again.
        let (b, c) = (cos - i_sin * 1.5 / index, cos * 1.5 - i_sin * index);
        let reflected: Complex<f64> = (b * 1.5 - c) / (b * 1.5 + c);
        reflected.norm_sqr()
    };
    let stable = |thickness_nm: f64| {
        let film = FilmLayer { index, thickness_nm };
        stack_power(1.5, &[film], Complex::new(1.5, 0.0), 1.0, 550.0).unpolarized_reflectance()
    };
    HardCase {
        name: "a metal that lets nothing through",
        formula: "B = cos(delta) + ..., delta = 2 pi N d / lambda",
        source: "Macleod, chapter 2; simulate::optics::thin_film::stack_power",
        arguments: "index 0.2 + 3.5i in glass, 10 um to 1 m; f64",
        measure: "relative to the bulk metal",
        naive: worst(all, |d| relative(naive(d), &truth())),
        stable: worst(all, |d| relative(stable(d), &truth())),
        bar: 16.0 * f64::EPSILON,
        why: "a product of complex matrices and a quotient of their sums",
        worse: 1e3,
    }
}
