//! What is drawn from the clusters of a slice, as a series of Hermite polynomials of a normal number.

use crate::cluster::{Cluster, SliceStatistics};
use crate::color::{luminance, rgb_from_lab};
use crate::math::normal::probit;
use crate::math::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Orders of the series, from 0 on: correlations of up to 0.95 lose nothing of weight.
pub(super) const ORDERS: usize = 64;
/// Orders in the place inside a box: luminance is the cube of it.
const INSIDE: usize = 4;

/// A series in Hermite polynomials.
pub(super) struct Series {
    /// Coefficients of He_n / sqrt(n!), for each Legendre polynomial of the place inside the box.
    coefficients: [[f64; INSIDE]; ORDERS],
    /// Of the luminance.
    variance: f64,
}

impl Series {
    /// The luminance drawn from a slice. u = Phi(g) runs through the clusters in their order.
    pub fn of(statistics: &SliceStatistics) -> Self {
        let mut coefficients = [[0.0; INSIDE]; ORDERS];
        let (mut mean, mut square, mut sum) = (0.0, 0.0, 0.0);
        let mut before = [0.0; ORDERS];
        for cluster in &statistics.clusters {
            let inside = inside(cluster);
            mean += cluster.probability * inside[0];
            square += cluster.probability * inside.iter().map(|c| c * c).sum::<f64>();
            sum += cluster.probability;
            let upper = integrals(sum);
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
    pub fn correlation(&self, other: &Self) -> [f64; ORDERS] {
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
fn inside(cluster: &Cluster) -> [f64; INSIDE] {
    let mut coefficients = [0.0; INSIDE];
    for (x, weight) in gauss_legendre(INSIDE, 0.0, 1.0) {
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
fn integrals(p: f64) -> [f64; ORDERS] {
    let mut integrals = [0.0; ORDERS];
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
