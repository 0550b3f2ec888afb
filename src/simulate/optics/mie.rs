//! Scattering by a homogeneous sphere in a medium that does not absorb: Mie's series.
//!
//! After Bohren & Huffman 1983, chapter 4: indices n + i k with k >= 0 absorbing, `x = 2 pi r n_medium / lambda`,
//! `m = n_particle / n_medium`. Every recurrence runs in its stable direction: the logarithmic derivative `D_n(m x)` and the
//! Bessel functions psi_n downwards, chi_n upwards. Wiscombe's number of terms, `x + 4.05 x^(1/3) + 2`, and a few more.

use crate::error::{Error, Result};
use nalgebra::Complex;
use std::f64::consts::PI;

type C = Complex<f64>;

/// A sphere's scattering at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct MieSphere {
    x: f64,
    absorbs: bool,
    /// Coefficients a_n and b_n, from n = 1.
    coefficients: Vec<(C, C)>,
}

impl MieSphere {
    /// Least and greatest size parameter.
    pub const SIZES: std::ops::RangeInclusive<f64> = 1e-4..=1e4;

    /// A sphere of size parameter `x` in [`MieSphere::SIZES`] and relative index `m`, real part 0.001 to 100, imaginary part
    /// 0 to 100.
    ///
    /// # Errors
    /// Values outside their range.
    pub fn new(x: f64, m: C) -> Result<Self> {
        if !Self::SIZES.contains(&x) {
            return Err(Error::invalid("", "size parameter x", x, "1e-4 to 1e4"));
        }
        if !(0.001..=100.0).contains(&m.re) || !(0.0..=100.0).contains(&m.im) {
            let found = format!("{} + {} i", m.re, m.im);
            return Err(Error::invalid("", "relative index", found, "real 0.001 to 100, imaginary 0 to 100"));
        }
        let terms = terms(x);
        let derivative = logarithmic_derivative(x * m, terms);
        let psi = psi(x, terms);
        let (mut chi_before, mut chi) = (-x.sin(), x.cos());
        let mut coefficients = Vec::with_capacity(terms);
        for n in 1..=terms {
            let order = n as f64;
            (chi_before, chi) = (chi, (2.0 * order - 1.0) / x * chi - chi_before);
            let (xi, xi_before) = (C::new(psi[n], -chi), C::new(psi[n - 1], -chi_before));
            let ratio = |factor: C| (factor * psi[n] - psi[n - 1]) / (factor * xi - xi_before);
            let d = derivative[n];
            coefficients.push((ratio(d / m + order / x), ratio(d * m + order / x)));
        }
        Ok(Self { x, absorbs: m.im > 0.0, coefficients })
    }

    /// Number of terms of the series: amplitudes are trigonometric polynomials of this degree in the scattering angle.
    pub fn degree(&self) -> usize {
        self.coefficients.len()
    }

    /// Efficiency of extinction, Q_ext: cross-section over pi r^2.
    pub fn extinction(&self) -> f64 {
        2.0 / self.x.powi(2) * self.numbered().map(|(n, a, b)| (2.0 * n + 1.0) * (a.re + b.re)).sum::<f64>()
    }

    /// Efficiency of scattering, Q_sca; without absorption that of extinction.
    pub fn scattering(&self) -> f64 {
        if !self.absorbs {
            return self.extinction();
        }
        let power = |(n, a, b): (f64, C, C)| (2.0 * n + 1.0) * (a.norm_sqr() + b.norm_sqr());
        2.0 / self.x.powi(2) * self.numbered().map(power).sum::<f64>()
    }

    /// Mean cosine g of the scattering angle; 0 of a sphere that does not scatter.
    pub fn asymmetry(&self) -> f64 {
        let scattering = self.scattering();
        if scattering == 0.0 {
            return 0.0;
        }
        let own = self.numbered().map(|(n, a, b)| (2.0 * n + 1.0) / (n * (n + 1.0)) * (a * b.conj()).re);
        let next = self
            .numbered()
            .zip(self.coefficients.iter().skip(1))
            .map(|((n, a, b), (a2, b2))| n * (n + 2.0) / (n + 1.0) * (a * a2.conj() + b * b2.conj()).re);
        4.0 / (self.x.powi(2) * scattering) * own.chain(next).sum::<f64>()
    }

    /// Amplitudes S_1 (electric field across the scattering plane) and S_2 (in it) at a scattering angle of cosine `cos`.
    pub fn amplitudes(&self, cos: f64) -> [C; 2] {
        let (mut pi_before, mut pi) = (0.0, 1.0);
        let mut sums = [C::new(0.0, 0.0); 2];
        for (n, a, b) in self.numbered() {
            let tau = n * cos * pi - (n + 1.0) * pi_before;
            let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
            sums[0] += (a * pi + b * tau) * weight;
            sums[1] += (a * tau + b * pi) * weight;
            (pi_before, pi) = (pi, ((2.0 * n + 1.0) * cos * pi - (n + 1.0) * pi_before) / n);
        }
        sums
    }

    /// Phase function of unpolarized light, 1/sr (its integral over the sphere is 1), at a scattering angle of cosine `cos`;
    /// uniform for a sphere that does not scatter.
    pub fn phase(&self, cos: f64) -> f64 {
        let scattering = self.scattering();
        // No contrast: what is left is rounding.
        if scattering < 1e-28 {
            return 0.25 / PI;
        }
        let total = 2.0 * PI * self.x.powi(2) * scattering;
        self.amplitudes(cos).iter().map(|s| s.norm_sqr()).sum::<f64>() / total
    }

    fn numbered(&self) -> impl Iterator<Item = (f64, C, C)> {
        self.coefficients.iter().enumerate().map(|(k, (a, b))| ((k + 1) as f64, *a, *b))
    }
}

/// Terms until the Bessel functions of argument `x` have died away.
fn terms(x: f64) -> usize {
    (x + 4.05 * x.cbrt() + 5.0) as usize
}

/// `D_n(z)`, the logarithmic derivative of psi_n, for n = 0 to `last`. Starts where it is known to all digits from anything.
fn logarithmic_derivative(z: C, last: usize) -> Vec<C> {
    let start = last.max(terms(z.norm())) + 20;
    let mut all = vec![C::new(0.0, 0.0); last + 1];
    let mut d = C::new(0.0, 0.0);
    for n in (1..=start).rev() {
        let quotient = n as f64 / z;
        d = quotient - (d + quotient).inv();
        if n <= last + 1 {
            all[n - 1] = d;
        }
    }
    all
}

/// `psi_n(x) = x j_n(x)` for n = 0 to `last`: Miller's downward recurrence, scaled to psi_0 or psi_1, whichever is no zero.
fn psi(x: f64, last: usize) -> Vec<f64> {
    let mut all = vec![0.0; last + 1];
    let (mut after, mut now) = (0.0, 1e-200);
    for n in (1..=last + 15).rev() {
        // From psi_n (now) and psi_(n+1) (after) to psi_(n-1).
        (after, now) = (now, (2 * n + 1) as f64 / x * now - after);
        if n <= last + 1 {
            all[n - 1] = now;
        }
    }
    let (sin, cos) = x.sin_cos();
    // psi_1 = sin x / x - cos x cancels for small x, where psi_0 is no zero.
    let scale = if sin.abs() > 0.5 || x < 1.0 { sin / all[0] } else { (sin / x - cos) / all[1] };
    all.iter_mut().for_each(|p| *p *= scale);
    all
}

/// A phase function over the angle, tabulated for many evaluations.
///
/// Equal steps in the scattering angle, 24 to a period of the fastest fringe, and between them a polynomial through the six
/// nearest: within 2e-6 of the largest value nearby, forward peak and glory included.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseTable {
    /// Mean cosine g of the scattering angle.
    pub asymmetry: f64,
    /// [`MieSphere::degree`].
    pub degree: usize,
    steps_per_radian: f64,
    /// From two steps before the forward direction to three behind the backward one, mirrored there.
    values: Vec<f64>,
}

impl PhaseTable {
    /// Tabulates a sphere's phase function.
    pub fn new(sphere: &MieSphere) -> Self {
        let steps = 24 * sphere.degree();
        let step = PI / steps as f64;
        let inner: Vec<f64> = (0..=steps).map(|k| sphere.phase((k as f64 * step).cos())).collect();
        let mirrored = |k: isize| {
            let k = k.unsigned_abs();
            inner[if k > steps { 2 * steps - k } else { k }]
        };
        let values = (-2..=steps as isize + 3).map(mirrored).collect();
        Self {
            asymmetry: sphere.asymmetry(),
            degree: sphere.degree(),
            steps_per_radian: steps as f64 / PI,
            values,
        }
    }

    /// Density of scattered light, 1/sr, at a scattering angle of cosine `cos` (1 is forward).
    pub fn eval(&self, cos: f64) -> f64 {
        let position = cos.clamp(-1.0, 1.0).acos() * self.steps_per_radian;
        // At the backward direction itself rounding may land one step behind.
        let first = (position as usize).min(self.values.len() - 6);
        let t = position - first as f64;
        // Lagrange's polynomial through the points -2, ..., 3.
        let d = [t + 2.0, t + 1.0, t, t - 1.0, t - 2.0, t - 3.0];
        let (left, right) = (d[0] * d[1] * d[2], d[3] * d[4] * d[5]);
        let weights = [
            -d[1] * d[2] * right / 120.0,
            d[0] * d[2] * right / 24.0,
            -d[0] * d[1] * right / 12.0,
            left * d[4] * d[5] / 12.0,
            -left * d[3] * d[5] / 24.0,
            left * d[3] * d[4] / 120.0,
        ];
        let sum: f64 = weights.iter().zip(&self.values[first..first + 6]).map(|(w, v)| w * v).sum();
        // Next to a dark fringe the polynomial may undershoot by its error.
        sum.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::composite;

    fn sphere(x: f64, re: f64, im: f64) -> MieSphere {
        MieSphere::new(x, C::new(re, im)).unwrap()
    }

    /// Integral over the sphere of directions of `f(cos) * phase`, by panels finer than the fringes.
    fn integral(sphere: &MieSphere, phase: impl Fn(f64) -> f64, f: impl Fn(f64) -> f64) -> f64 {
        let panels: Vec<f64> =
            (0..=sphere.degree()).map(|k| PI * k as f64 / sphere.degree() as f64).collect();
        composite(&panels).map(|(t, w)| 2.0 * PI * w * t.sin() * f(t.cos()) * phase(t.cos())).sum()
    }

    const SPHERES: [(f64, f64, f64); 6] = [
        (1e-3, 1.5, 0.0),
        (0.5, 0.4, 3.0),
        (3.0, 1.8, 0.0),
        (12.0, 1.2, 0.01),
        (40.0, 2.2, 0.0),
        (100.0, 1.3, 0.5),
    ];

    #[test]
    fn the_phase_function_integrates_to_one_and_its_mean_cosine_is_g() {
        for (x, re, im) in SPHERES {
            let sphere = sphere(x, re, im);
            let exact = |c: f64| sphere.phase(c);
            // Rounding of the series at large x.
            assert!((integral(&sphere, exact, |_| 1.0) - 1.0).abs() < 1e-11, "{x}");
            let error = integral(&sphere, exact, |c| c) - sphere.asymmetry();
            assert!(error.abs() < 1e-11, "{x}: {error:e}");
        }
    }

    #[test]
    fn tables_follow_the_phase_function() {
        for (x, re, im) in SPHERES {
            let sphere = sphere(x, re, im);
            let table = PhaseTable::new(&sphere);
            let total = integral(&sphere, |c| table.eval(c), |_| 1.0);
            assert!((total - 1.0).abs() < 2e-6, "{x}: {total}");
            let fringe = PI / sphere.degree() as f64;
            for k in 0..=3000 {
                let angle = PI * f64::from(k) / 3000.0;
                let near = (-4..=4).map(|j| sphere.phase((angle + 0.25 * f64::from(j) * fringe).cos()));
                let most = near.fold(0.0, f64::max);
                let error = (table.eval(angle.cos()) - sphere.phase(angle.cos())).abs();
                // Six points, 24 to a fringe.
                assert!(error < 2e-6 * most, "{x} {angle}: {:e}", error / most);
            }
        }
    }

    #[test]
    fn small_spheres_scatter_like_rayleigh() {
        let error = |x: f64| {
            let sphere = sphere(x, 1.6, 0.0);
            let rayleigh = 8.0 / 3.0 * x.powi(4) * ((1.6f64.powi(2) - 1.0) / (1.6f64.powi(2) + 2.0)).powi(2);
            let shape = (sphere.phase(0.3) / (3.0 / (16.0 * PI) * (1.0 + 0.09)) - 1.0).abs();
            (sphere.scattering() / rayleigh - 1.0).abs().max(shape)
        };
        // The next term of the series is the square of x.
        for x in [0.08, 0.04, 0.02] {
            let ratio = error(x) / error(0.5 * x);
            assert!((ratio - 4.0).abs() < 0.05, "{x}: {ratio}");
        }
    }

    #[test]
    fn large_spheres_take_twice_their_shadow_and_clear_ones_absorb_nothing() {
        for (x, re, im) in [(1000.0, 1.5, 0.1), (9999.0, 1.33, 0.1)] {
            let extinction = sphere(x, re, im).extinction();
            // The edge adds some 2 x^(-2/3).
            assert!((extinction - 2.0) * x.powf(2.0 / 3.0) > 1.0, "{x}: {extinction}");
            assert!((extinction - 2.0) * x.powf(2.0 / 3.0) < 3.0, "{x}: {extinction}");
        }
        for x in [0.01, 1.0, 31.4, 1000.0] {
            let clear = sphere(x, 1.7, 0.0);
            let power = |(n, a, b): (f64, C, C)| (2.0 * n + 1.0) * (a.norm_sqr() + b.norm_sqr());
            let scattered: f64 = 2.0 / (x * x) * clear.numbered().map(power).sum::<f64>();
            // Optical theorem, to rounding of a thousand terms.
            assert!((scattered / clear.extinction() - 1.0).abs() < 1e-12, "{x}");
        }
        assert_eq!(sphere(1.0, 1.0, 0.0).phase(0.5), 0.25 / PI);
    }

    #[test]
    fn sizes_and_indices_out_of_range_are_refused() {
        for (x, re, im) in
            [(0.0, 1.5, 0.0), (f64::NAN, 1.5, 0.0), (1e5, 1.5, 0.0), (1.0, 0.0, 1.0), (1.0, 1.5, -0.1)]
        {
            assert!(MieSphere::new(x, C::new(re, im)).is_err(), "{x} {re} {im}");
        }
    }
}
