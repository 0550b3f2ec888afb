//! How much light the flakes of one kind take from a slanted ray: `<(1 - t_p(alpha)) |cos alpha|>` over their tilts
//! (Ershov 2001, eq. 10).
//!
//! The average of `|cos alpha|` itself, a flake's projected area over its own, has a closed form but for the flakes that a ray
//! can meet from either side. With `a = cos(beta) cos(theta)`, `b = sin(beta) sin(theta)` a ring of flakes of one tilt
//! averages `|a + b cos(psi)|` to a where `a >= b`, so
//! `<|cos alpha|> = cos(theta) <cos beta> + 4 int P sin(beta) (s - a atan(s/a)) dbeta`, `s = sqrt(b^2 - a^2)`, the integral
//! over `beta > pi/2 - theta`: nothing for a steep ray and narrow P.

use super::film_optics::Preparation;
use super::flake_optics::FlakeOptics;
use super::orientation::HalfVectorDensity;
use super::piecewise::Piecewise;
use crate::color::BANDS;
use crate::error::Result;
use crate::math::quadrature::{breaks, composite};
use std::f64::consts::{FRAC_PI_2, PI};

/// Projected area of flakes over their own, for rays of any slant.
#[derive(Debug, Clone, PartialEq)]
pub struct ProjectedArea {
    density: HalfVectorDensity,
    /// `<cos beta>`.
    mean_cosine: f64,
}

impl ProjectedArea {
    /// For flakes of this density.
    pub fn new(density: &HalfVectorDensity) -> Self {
        let ring = |(b, w): (f64, f64)| 2.0 * PI * w * density.eval(b) * b.sin() * b.cos();
        let mean_cosine = composite(&density.breaks()).map(ring).sum();
        Self { density: density.clone(), mean_cosine }
    }

    /// `<|cos alpha|>` for a ray at polar angle `theta` inside the film, radians, 0 to pi/2.
    pub fn at(&self, theta: f64) -> f64 {
        let (sin_t, cos_t) = theta.sin_cos();
        let turn = FRAC_PI_2 - theta;
        let all = self.density.breaks();
        let end = all[all.len() - 1];
        let mut either_side = 0.0;
        if turn < end {
            // beta = turn + u^2: the integrand starts with a power 3/2 of the distance, a polynomial in u.
            let roots = all.iter().filter(|b| **b > turn).map(|b| (b - turn).sqrt());
            for (u, w) in composite(&breaks(0.0, (end - turn).sqrt(), roots)) {
                let beta = turn + u * u;
                let (sin_b, cos_b) = beta.sin_cos();
                let a = cos_b * cos_t;
                // b^2 - a^2 without the difference.
                let s = ((u * u).sin() * (cos_b * cos_t + sin_b * sin_t)).max(0.0).sqrt();
                either_side += 2.0 * u * w * self.density.eval(beta) * sin_b * (s - a * s.atan2(a));
            }
        }
        cos_t * self.mean_cosine + 4.0 * either_side
    }
}

/// What one kind of flakes takes from a ray.
#[derive(Debug, Clone)]
pub struct Interception {
    area: ProjectedArea,
    stack: Option<Stack>,
}

/// The share of a ray on a kind's stacks that passes, which depends on the angle.
#[derive(Debug, Clone)]
enum Stack {
    /// `<t_p |cos alpha|>` over theta.
    Table(Box<Piecewise<BANDS>>),
    /// `<t_p |cos alpha|> / <|cos alpha|>` over a few flakes.
    Few(Vec<Tilt>),
}

/// A flake that stands for many.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tilt {
    cosine: f64,
    sine: f64,
    weight: f64,
}

impl Interception {
    /// For flakes of this density and optics.
    ///
    /// # Errors
    /// The table of a stack misses its tolerance ([`Piecewise::fit`]).
    pub fn new(density: &HalfVectorDensity, optics: &FlakeOptics, preparation: Preparation) -> Result<Self> {
        let stack = match (optics, preparation) {
            (FlakeOptics::Mirror(_), _) => None,
            (FlakeOptics::Stack { .. }, Preparation::Direct) => Some(Stack::Few(few_tilts(density))),
            (FlakeOptics::Stack { transmittance, .. }, Preparation::Tables) => {
                // The average takes 16 nodes a width of P: fringes finer than those leave their grain in it.
                let ends = [0.0, 0.5 * FRAC_PI_2, FRAC_PI_2];
                let table = Piecewise::fit("extinction of stacks", &ends, 1e-4, |theta| {
                    transmittance.weighted_sum(|add| density.projected_average(theta, add))
                })?;
                Some(Stack::Table(Box::new(table)))
            }
        };
        Ok(Self { area: ProjectedArea::new(density), stack })
    }

    /// `<(1 - t_p) |cos alpha|>` at polar angle `theta` inside the film, radians; `optics` as given to
    /// [`Interception::new`].
    pub fn at(&self, theta: f64, optics: &FlakeOptics) -> [f64; BANDS] {
        let area = self.area.at(theta);
        match (&self.stack, optics) {
            (Some(Stack::Table(passed)), _) => passed.eval(theta).map(|passed| area - passed),
            (Some(Stack::Few(tilts)), FlakeOptics::Stack { transmittance, .. }) => {
                let mut sampled = 0.0;
                let passed = transmittance.weighted_sum(|add| {
                    sampled = rays(tilts, theta, add);
                });
                passed.map(|passed| area * (1.0 - passed / sampled))
            }
            _ => optics.transmittance(1.0).map(|t| area * (1.0 - t)),
        }
    }
}

/// Azimuths of a ring of flakes, on one half: the trapezoid rule.
const AZIMUTHS: usize = 8;
/// Rings of flakes.
const RINGS: usize = 6;

/// Rings whose tilts carry P as a Gauss rule does, exact for polynomials of degree `2 RINGS - 1` in `cos(beta)`.
fn few_tilts(density: &HalfVectorDensity) -> Vec<Tilt> {
    // A fine rule for P, then the Gauss rule of the same moments: Lanczos on its nodes, eigenvalues of the Jacobi matrix
    // (Golub & Welsch 1969). In 1 - cos(beta), so that narrow P keeps its digits.
    let fine: Vec<(f64, f64)> = composite(&density.breaks())
        .map(|(b, w)| (2.0 * (0.5 * b).sin().powi(2), 2.0 * PI * w * density.eval(b) * b.sin()))
        .collect();
    let total: f64 = fine.iter().map(|x| x.1).sum();
    let mut jacobi = nalgebra::SMatrix::<f64, RINGS, RINGS>::zeros();
    let mut before = vec![0.0; fine.len()];
    let mut now = vec![total.sqrt().recip(); fine.len()];
    let mut beta = 0.0;
    for k in 0..RINGS {
        let alpha: f64 = fine.iter().zip(&now).map(|((x, w), p)| w * x * p * p).sum();
        jacobi[(k, k)] = alpha;
        let next: Vec<f64> = fine
            .iter()
            .zip(now.iter().zip(&before))
            .map(|((x, _), (p, before))| (x - alpha) * p - beta * before)
            .collect();
        beta = fine.iter().zip(&next).map(|((_, w), p)| w * p * p).sum::<f64>().sqrt();
        if k + 1 < RINGS {
            jacobi[(k, k + 1)] = beta;
            jacobi[(k + 1, k)] = beta;
        }
        before = std::mem::replace(&mut now, next.iter().map(|p| p / beta).collect());
    }
    let eigen = jacobi.symmetric_eigen();
    (0..RINGS)
        .map(|k| {
            let rise = eigen.eigenvalues[k];
            let weight = total * eigen.eigenvectors[(0, k)].powi(2) / AZIMUTHS as f64;
            Tilt { cosine: 1.0 - rise, sine: (rise * (2.0 - rise)).max(0.0).sqrt(), weight }
        })
        .collect()
}

/// Calls `add(|cos alpha|, weight |cos alpha|)` for every flake, and returns the sum of the weights.
fn rays(tilts: &[Tilt], theta: f64, add: &mut dyn FnMut(f64, f64)) -> f64 {
    let (sin_t, cos_t) = theta.sin_cos();
    let mut sum = 0.0;
    for tilt in tilts {
        for k in 0..AZIMUTHS {
            let azimuth = PI * (k as f64 + 0.5) / AZIMUTHS as f64;
            let cos_alpha = (tilt.cosine * cos_t + tilt.sine * sin_t * azimuth.cos()).abs();
            add(cos_alpha, tilt.weight * cos_alpha);
            sum += tilt.weight * cos_alpha;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::optics::orientation::{FlakeLobe, Orientation};

    /// Gaussians of these widths with lobes of those, degrees; 0 for mirrors.
    fn densities<const N: usize>(widths: [[f64; 2]; N]) -> [HalfVectorDensity; N] {
        widths.map(|[sigma, lobe]| {
            let lobe = (lobe > 0.0).then(|| FlakeLobe::new(lobe.to_radians()));
            HalfVectorDensity::new(Orientation::new(sigma.to_radians()), lobe).unwrap()
        })
    }

    #[test]
    fn the_closed_form_is_the_average_over_flakes() {
        let mirrors = [0.1, 1.0, 8.0, 15.0, 60.0, 89.9].map(|sigma| [sigma, 0.0]);
        let lobes = [[0.1, 6.5], [8.0, 6.5], [15.0, 60.0]];
        for density in densities(mirrors).into_iter().chain(densities(lobes)) {
            let area = ProjectedArea::new(&density);
            for k in 0..=90 {
                let theta = FRAC_PI_2 * f64::from(k) / 90.0;
                let mut sum = 0.0;
                density.projected_average(theta, &mut |_, weight| sum += weight);
                // Both integrate to rounding, but for the kink where flakes turn, which 16 nodes see as a square root, and
                // the table of a lobe.
                let tolerance = if matches!(density, HalfVectorDensity::Mirror(_)) { 1e-11 } else { 1e-9 };
                assert!((area.at(theta) - sum).abs() < tolerance, "{} {k}: {sum}", density.width());
            }
        }
    }

    #[test]
    fn a_few_flakes_have_the_moments_of_all() {
        for density in densities([[0.1, 0.0], [8.0, 0.0], [60.0, 0.0], [8.0, 6.5]]) {
            let tilts = few_tilts(&density);
            for power in 0..8 {
                let few: f64 = tilts.iter().map(|t| AZIMUTHS as f64 * t.weight * t.cosine.powi(power)).sum();
                let all: f64 = composite(&density.breaks())
                    .map(|(b, w)| 2.0 * PI * w * density.eval(b) * b.sin() * b.cos().powi(power))
                    .sum();
                // A Gauss rule of six nodes is exact to degree eleven: rounding.
                assert!((few - all).abs() < 1e-12, "{} {power}: {few} {all}", density.width());
            }
        }
    }
}
