//! What is drawn from the clusters of a slice, as a series of Hermite polynomials of a normal number, orthonormal under its
//! law, times Legendre polynomials of the place inside the box: draws whose numbers correlate by r have the covariance
//! `sum a_n^2 r^n` (Mehler's formula).

use super::{Cluster, SliceStatistics};
use crate::color::{luminance, rgb_from_lab};
use crate::math::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Orders in the place inside a box: luminance is the cube of it.
const INSIDE: usize = 4;

/// A series in N Hermite polynomials, from order 0 on.
#[derive(Debug, Clone)]
pub(crate) struct Series<const N: usize> {
    /// Coefficients of He_n / sqrt(n!), for each Legendre polynomial of the place inside the box.
    pub coefficients: [[f64; INSIDE]; N],
    /// Of the luminance, 1/sr^2, all orders together.
    pub variance: f64,
}

impl<const N: usize> Series<N> {
    /// The luminance drawn from a slice, 1/sr, its gain left out. u = Phi(g) runs through the clusters in their order; `probit` is
    /// the inverse of Phi.
    pub fn of(statistics: &SliceStatistics, probit: impl Fn(f64) -> f64) -> Self {
        let nodes = gauss_legendre(INSIDE, 0.0, 1.0);
        let mut coefficients = [[0.0; INSIDE]; N];
        let (mut mean, mut square, mut sum) = (0.0, 0.0, 0.0);
        let mut before = [0.0; N];
        for cluster in &statistics.clusters {
            let inside = inside(cluster, &nodes);
            mean += cluster.probability * inside[0];
            square += cluster.probability * inside.iter().map(|c| c * c).sum::<f64>();
            sum += cluster.probability;
            let upper = integrals(sum, &probit);
            for (n, row) in coefficients.iter_mut().enumerate() {
                row.iter_mut()
                    .zip(inside)
                    .for_each(|(c, of_cluster)| *c += of_cluster * (upper[n] - before[n]));
            }
            before = upper;
        }
        Self { coefficients, variance: square - mean * mean }
    }

    /// The correlation of draws from two slices, by powers of the correlation of g. What hangs on the place in the box alone
    /// is always shared.
    pub fn correlation(&self, other: &Self) -> [f64; N] {
        let scale = (self.variance * other.variance).sqrt();
        std::array::from_fn(|n| {
            let products = self.coefficients[n].iter().zip(other.coefficients[n]).map(|(a, b)| a * b);
            // Less the product of the means.
            let sum: f64 = products.skip(usize::from(n == 0)).sum();
            if scale > 0.0 { sum / scale } else { 0.0 }
        })
    }
}

/// Luminance over a box: coefficients of orthonormal Legendre polynomials of the place along its lightness, on which alone
/// luminance depends.
fn inside(cluster: &Cluster, nodes: &[(f64, f64)]) -> [f64; INSIDE] {
    let mut coefficients = [0.0; INSIDE];
    for (x, weight) in nodes {
        let lightness = f64::from(cluster.min[0]) * (1.0 - x) + f64::from(cluster.max[0]) * x;
        let value = luminance(rgb_from_lab(DVec3::new(lightness, 0.0, 0.0))) * FRAC_1_PI;
        let t = 2.0 * x - 1.0;
        let legendre = [
            1.0,
            3f64.sqrt() * t,
            5f64.sqrt() * 0.5 * (3.0 * t * t - 1.0),
            7f64.sqrt() * 0.5 * t * (5.0 * t * t - 3.0),
        ];
        coefficients.iter_mut().zip(legendre).for_each(|(c, p)| *c += weight * value * p);
    }
    coefficients
}

/// Integrals of He_n / sqrt(n!) under the normal law up to the quantile of `p`: p, and -He_(n-1) phi / sqrt(n!).
fn integrals<const N: usize>(p: f64, probit: impl Fn(f64) -> f64) -> [f64; N] {
    let mut integrals = [0.0; N];
    integrals[0] = p;
    // Probabilities that sum to 1 but for rounding.
    if p >= 1.0 - 1e-12 {
        return integrals;
    }
    let x = probit(p);
    // Polynomials times the density.
    let (mut last, mut this) = (0.0, (-0.5 * x * x).exp() / TAU.sqrt());
    for (n, integral) in integrals.iter_mut().enumerate().skip(1) {
        *integral = -this / (n as f64).sqrt();
        (last, this) = (this, (x * this - ((n - 1) as f64).sqrt() * last) / (n as f64).sqrt());
    }
    integrals
}
