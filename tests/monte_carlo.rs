//! The full model against photons traced through the films: a code that shares no formula with it.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::math::half_difference::spherical;
use carpaint::math::quadrature::gauss_legendre;
use carpaint::simulate::Composition;
use carpaint::simulate::optics::film_optics::PaintOptics;
use carpaint::simulate::{Accuracy, FullModel};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Gray flakes: sigma in degrees, area density, reflectance, transmittance.
type Flakes = [f64; 4];

/// Gray film: index, optical thickness of the binder, flakes, and pigments as scattering, extinction, asymmetry.
struct Film {
    index: f64,
    absorption: f64,
    flakes: Vec<Flakes>,
    pigments: Vec<[f64; 3]>,
}

struct Paint {
    films: Vec<Film>,
    albedo: f64,
}

impl Paint {
    fn composition(&self) -> Composition {
        let mut text = format!("[substrate]\nalbedo = {}\n", self.albedo);
        for film in &self.films {
            // A thickness of 10 um: coefficients per millimetre are a hundred times those of the film.
            text += &format!(
                "[[film]]\nthickness_um = 10\nindex = {}\nabsorption_per_mm = {}\n",
                film.index,
                100.0 * film.absorption
            );
            for [sigma, density, r, t] in &film.flakes {
                text += &format!(
                    "[[film.flakes]]\narea_density = {density}\ndiameter_um = 10\nsigma_deg = {sigma}\n\
                     flake_lifetime_deg = 0\nmirror = {{ reflectance = {r}, transmittance = {t} }}\n"
                );
            }
            for [scattering, extinction, g] in &film.pigments {
                text += &format!(
                    "[[film.pigments]]\nhenyey_greenstein = {{ scattering_per_mm = {}, extinction_per_mm = {}, \
                     asymmetry = {g} }}\n",
                    100.0 * scattering,
                    100.0 * extinction
                );
            }
        }
        Composition::parse(&text).unwrap()
    }

    /// Direction in which a photon leaves that enters along `-wi` from air; `None` if it is absorbed, or if nothing but
    /// boundaries turned it, which a BRDF does not hold.
    fn trace(&self, wi: DVec3, rng: &mut Pcg64) -> Option<DVec3> {
        let mut w = -wi;
        // Number of the medium: 0 is the substrate, 1.. the films, the last is air.
        let mut medium = self.films.len() + 1;
        let index = |medium: usize| self.films.get(medium - 1).map_or(1.0, |film| film.index);
        let mut scattered = false;
        loop {
            // At a boundary, going up or down from `medium`.
            let next = if w.z > 0.0 { medium + 1 } else { medium - 1 };
            if medium == self.films.len() + 1 && w.z > 0.0 {
                return scattered.then_some(w);
            }
            if next == 0 {
                if rng.random::<f64>() >= self.albedo {
                    return None;
                }
                scattered = true;
                w = spherical(rng.random::<f64>().sqrt().asin(), 2.0 * PI * rng.random::<f64>());
            } else {
                match refract(w, index(medium), index(next), rng) {
                    Ok(through) => {
                        w = through;
                        medium = next;
                    }
                    Err(back) => w = back,
                }
                if medium == self.films.len() + 1 {
                    continue;
                }
            }
            let start = if w.z > 0.0 { 0.0 } else { 1.0 };
            let (out, turned) = self.films[medium - 1].cross(w, start, rng)?;
            (w, scattered) = (out, scattered || turned);
        }
    }
}

/// Unpolarized Fresnel reflection by chance: the refracted direction, or the mirrored one.
fn refract(w: DVec3, from: f64, to: f64, rng: &mut Pcg64) -> Result<DVec3, DVec3> {
    let mirrored = w.with_z(-w.z);
    let tangential = w.truncate() * (from / to);
    let rest = 1.0 - tangential.length_squared();
    if rest <= 0.0 {
        return Err(mirrored);
    }
    let (a, b) = (w.z.abs(), rest.sqrt());
    let s = (from * a - to * b) / (from * a + to * b);
    let p = (from * b - to * a) / (from * b + to * a);
    if rng.random::<f64>() < 0.5 * (s * s + p * p) {
        return Err(mirrored);
    }
    Ok(tangential.extend(b.copysign(w.z)))
}

impl Film {
    /// Follows a photon inside the film from a height, 0 to 1, until it reaches a face: its direction there, and whether
    /// anything turned it.
    fn cross(&self, mut w: DVec3, mut height: f64, rng: &mut Pcg64) -> Option<(DVec3, bool)> {
        let mut turned = false;
        let flakes: f64 = self.flakes.iter().map(|f| f[1]).sum();
        let pigments: f64 = self.pigments.iter().map(|p| p[1]).sum();
        // Flakes are met at most as often as if all faced the ray: tentative events, some of them void.
        let most = flakes + pigments + self.absorption;
        loop {
            let path = if most > 0.0 { -(1.0 - rng.random::<f64>()).ln() / most } else { f64::INFINITY };
            height += path * w.z;
            if !(0.0..=1.0).contains(&height) {
                return Some((w, turned));
            }
            let mut what = rng.random::<f64>() * most;
            if what < self.absorption {
                return None;
            }
            what -= self.absorption;
            if what < pigments {
                let kind = self.pigments.iter().find(|p| {
                    what -= p[1];
                    what < 0.0
                })?;
                if rng.random::<f64>() * kind[1] >= kind[0] {
                    return None;
                }
                w = henyey_greenstein(w, kind[2], rng);
                turned = true;
                continue;
            }
            what -= pigments;
            let [sigma, _, r, t] = *self.flakes.iter().find(|f| {
                what -= f[1];
                what < 0.0
            })?;
            let normal = tilt(sigma.to_radians(), rng);
            let cos = normal.dot(w);
            if rng.random::<f64>() >= cos.abs() {
                continue;
            }
            let chance = rng.random::<f64>();
            if chance < r {
                w = (w - 2.0 * cos * normal).normalize();
                turned = true;
            } else if chance >= r + t {
                return None;
            }
        }
    }
}

/// A normal of density exp(-beta^2/(2 sigma^2)) on the upper hemisphere.
fn tilt(sigma: f64, rng: &mut Pcg64) -> DVec3 {
    loop {
        // Uniform in the cosine out to eight widths, thinned by the density.
        let least = (8.0 * sigma).min(FRAC_PI_2).cos();
        let cos = least + (1.0 - least) * rng.random::<f64>();
        let beta = cos.acos();
        if rng.random::<f64>() < (-0.5 * (beta / sigma).powi(2)).exp() {
            return spherical(beta, 2.0 * PI * rng.random::<f64>());
        }
    }
}

fn henyey_greenstein(w: DVec3, g: f64, rng: &mut Pcg64) -> DVec3 {
    let u = rng.random::<f64>();
    let cos = if g == 0.0 {
        2.0 * u - 1.0
    } else {
        ((1.0 + g * g) - ((1.0 - g * g) / (1.0 - g + 2.0 * g * u)).powi(2)) / (2.0 * g)
    };
    let (a, b) = w.any_orthonormal_pair();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let azimuth = 2.0 * PI * rng.random::<f64>();
    (w * cos + (a * azimuth.cos() + b * azimuth.sin()) * sin).normalize()
}

/// Bins of the outgoing direction: polar, and azimuth from the mirror side, folded.
const BINS: [usize; 2] = [9, 6];

fn bin(wo: DVec3, wi: DVec3) -> usize {
    let theta = wo.truncate().length().atan2(wo.z);
    let side = (-wi).truncate().to_angle();
    let phi = (wo.truncate().to_angle() - side + 5.0 * PI).rem_euclid(2.0 * PI) - PI;
    let pick = |share: f64, n: usize| ((share * n as f64) as usize).min(n - 1);
    pick(theta / FRAC_PI_2, BINS[0]) * BINS[1] + pick(phi.abs() / PI, BINS[1])
}

/// Share of the photons by bin.
fn trace_all(paint: &Paint, wi: DVec3, photons: u64) -> Vec<f64> {
    const CHUNKS: u64 = 64;
    let counts = (0..CHUNKS)
        .into_par_iter()
        .map(|chunk| {
            let mut rng = Pcg64::seed_from_u64(chunk);
            let mut counts = vec![0u64; BINS[0] * BINS[1]];
            for _ in 0..photons / CHUNKS {
                if let Some(wo) = paint.trace(wi, &mut rng) {
                    counts[bin(wo, wi)] += 1;
                }
            }
            counts
        })
        .collect::<Vec<_>>();
    let total = (photons / CHUNKS * CHUNKS) as f64;
    (0..BINS[0] * BINS[1]).map(|k| counts.iter().map(|c| c[k]).sum::<u64>() as f64 / total).collect()
}

/// The same shares from a BRDF.
fn integrate(wi: DVec3, brdf: &(dyn Fn(DVec3) -> f64 + Sync)) -> Vec<f64> {
    let step = [FRAC_PI_2 / BINS[0] as f64, PI / BINS[1] as f64];
    (0..BINS[0] * BINS[1])
        .into_par_iter()
        .map(|k| {
            let (i, j) = ((k / BINS[1]) as f64, (k % BINS[1]) as f64);
            let mut sum = 0.0;
            for (theta, a) in gauss_legendre(16, i * step[0], (i + 1.0) * step[0]) {
                for (phi, b) in gauss_legendre(16, j * step[1], (j + 1.0) * step[1]) {
                    let side = (-wi).truncate().to_angle();
                    // Two sides of the plane of incidence.
                    sum += 2.0 * a * b * theta.sin() * theta.cos() * brdf(spherical(theta, side + phi));
                }
            }
            sum
        })
        .collect()
}

/// `off`: what a bin may be off beside noise, as a share of it.
fn compare(name: &str, paint: &Paint, theta: f64, off: f64) {
    let optics = PaintOptics::new(&paint.composition()).unwrap();
    let full = FullModel::new(&optics, &Accuracy { error: 1e-3 }).unwrap();
    let wi = spherical(theta, 0.4);
    let photons = 1 << 20;
    let traced = trace_all(paint, wi, photons);
    let model = integrate(wi, &|wo| optics.glitter(wi, wo).0[20] + full.rest(wi, wo).0[20]);
    let mut squares = 0.0;
    for (k, (ours, theirs)) in model.iter().zip(&traced).enumerate() {
        let error = (ours.max(*theirs) / photons as f64).sqrt() + off * ours;
        let z = (ours - theirs) / error;
        squares += z * z;
        // One of a few hundred bins in all; beyond 4.5 once in 150,000.
        assert!(z.abs() < 4.5, "{name} {theta} bin {k}: {ours} {theirs} z {z}");
    }
    let total: [f64; 2] = [model.iter().sum(), traced.iter().sum()];
    let error = (total[1] * (1.0 - total[1]) / photons as f64).sqrt();
    println!(
        "{name} {theta}: rms z {:.2}, total {total:?} +- {error:.1e}",
        (squares / model.len() as f64).sqrt()
    );
    // Beside four standard errors.
    assert!((total[0] - total[1]).abs() < 4.0 * error + off * total[1], "{name} {theta}: {total:?} {error}");
}

#[test]
fn one_film_with_flakes_and_pigments() {
    let paint = Paint {
        films: vec![Film {
            index: 1.5,
            absorption: 0.1,
            flakes: vec![[12.0, 0.7, 0.6, 0.3]],
            pigments: vec![[0.5, 0.6, 0.5]],
        }],
        albedo: 0.5,
    };
    compare("one film", &paint, 0.8, 1e-3);
}

#[test]
fn films_of_rising_and_falling_index() {
    let film = |index: f64, flakes: Vec<Flakes>, pigments: Vec<[f64; 3]>| Film {
        index,
        absorption: 0.05,
        flakes,
        pigments,
    };
    let flakes = || vec![[10.0, 0.5, 0.5, 0.4], [20.0, 0.3, 0.8, 0.0]];
    let pigments = || vec![[0.4, 0.5, 0.3], [0.2, 0.2, -0.2]];
    for (name, indices) in
        [("rising", [1.7, 1.5, 1.3]), ("falling", [1.3, 1.5, 1.7]), ("mixed", [1.4, 1.7, 1.5])]
    {
        let paint = Paint {
            films: vec![
                film(indices[0], flakes(), vec![]),
                film(indices[1], vec![], pigments()),
                film(indices[2], vec![[15.0, 0.4, 0.6, 0.4]], vec![]),
            ],
            albedo: 0.6,
        };
        compare(name, &paint, 0.5, 1e-3);
    }
}

#[test]
fn a_lossless_paint_of_two_films_returns_everything() {
    let film = |index: f64| Film {
        index,
        absorption: 0.0,
        flakes: vec![[20.0, 1.0, 0.7, 0.3]],
        pigments: vec![[0.5, 0.5, 0.4]],
    };
    let paint = Paint { films: vec![film(1.6), film(1.45)], albedo: 1.0 };
    compare("lossless", &paint, 1.1, 1e-3);
}

#[test]
fn pigments_that_scatter_onwards_are_those_of_a_similar_wider_law() {
    // Films of one index: what a boundary between them mirrors of the onward peak counts as mirrored, not as scattered.
    for g in [0.94, 0.99] {
        let paint = Paint {
            films: vec![
                Film { index: 1.5, absorption: 0.05, flakes: vec![[15.0, 0.5, 0.6, 0.3]], pigments: vec![] },
                Film { index: 1.5, absorption: 0.05, flakes: vec![], pigments: vec![[2.0, 2.1, g]] },
            ],
            albedo: 0.5,
        };
        compare(&format!("g = {g}"), &paint, 0.5, 5e-3);
    }
}
