//! How flakes are tilted: the density of their normals, with and without the finite angular lobe of a flake.
//!
//! `P(beta) = C exp(-beta^2 / (2 sigma^2))` per steradian on the upper hemisphere,
//! `2 pi int_0^(pi/2) P sin(beta) dbeta = 1` (Ershov 2001, section 5; the normalization of errata.md, section 0).
//!
//! A real flake is no perfect mirror: it stays visible while the half vector moves through a few degrees. That lobe is a
//! von Mises-Fisher kernel on the sphere of normals,
//! `K(delta) = kappa / (2 pi (1 - exp(-2 kappa))) exp(-2 kappa sin^2(delta/2))`,
//! and what the mean of many such flakes shows is P convolved with K. Normals n and -n are the same flake, so the part of
//! K below the horizon is folded back: the convolution again integrates to 1.

use super::bessel::i0_scaled;
use super::piecewise::Piecewise;
use crate::error::Result;
use crate::math::quadrature::{breaks, composite, panel};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, PI};

/// Multiples of a Gaussian's width between which a 16-point rule is exact to rounding; the last is exp(-50).
const STEPS: [f64; 7] = [1.0, 2.0, 3.0, 4.5, 6.0, 8.0, 10.0];

/// Gaussian distribution of flake normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orientation {
    sigma: f64,
    peak: f64,
}

impl Orientation {
    /// Width `sigma` of the Gaussian, radians, above 0; a composition allows 0.1 to 89.9 degrees.
    pub fn new(sigma: f64) -> Self {
        let shape = Self { sigma, peak: 1.0 };
        let mass: f64 = composite(&shape.breaks()).map(|(b, w)| w * shape.density(b) * b.sin()).sum();
        Self { sigma, peak: 1.0 / (2.0 * PI * mass) }
    }

    /// Width of the Gaussian, radians.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// P(beta), 1/sr, for beta in [0, pi/2] radians; P(0) is the constant C.
    pub fn density(&self, beta: f64) -> f64 {
        self.peak * (-0.5 * (beta / self.sigma).powi(2)).exp()
    }

    /// Panels on which P is smooth, up to where it is negligible.
    fn breaks(&self) -> Vec<f64> {
        let end = FRAC_PI_2.min(STEPS[STEPS.len() - 1] * self.sigma);
        breaks(0.0, end, STEPS.map(|s| s * self.sigma))
    }

    /// The average over all flakes of `f(|cos alpha|) |cos alpha|` for a ray at polar angle `theta`, radians: the share of a
    /// flake's area that such a ray meets, weighted by f (Ershov 2001, eq. 10). As a quadrature: `add(x, weight)` is called
    /// at every node, and the average is the sum of `weight * f(x)`.
    pub fn projected_average(&self, theta: f64, add: &mut dyn FnMut(f64, f64)) {
        let (sin_t, cos_t) = theta.sin_cos();
        // Up to this tilt every flake is met from above; beyond, a flake can show either side.
        let turn = (FRAC_PI_2 - theta).max(0.0);
        let all = self.breaks();
        let end = all[all.len() - 1];
        let below = breaks(0.0, end.min(turn), all.iter().copied());
        for (beta, w) in composite(&below) {
            self.ring(beta, w, cos_t, sin_t, add);
        }
        if turn < end {
            // beta = turn + u^2: the integrand starts with a power 3/2 of the distance, a polynomial in u.
            let roots = all.iter().filter(|b| **b > turn).map(|b| (b - turn).sqrt());
            for (u, w) in composite(&breaks(0.0, (end - turn).sqrt(), roots)) {
                self.ring(turn + u * u, 2.0 * u * w, cos_t, sin_t, add);
            }
        }
    }

    /// The flakes of one tilt, all azimuths.
    fn ring(&self, beta: f64, weight: f64, cos_t: f64, sin_t: f64, add: &mut dyn FnMut(f64, f64)) {
        let (sin_b, cos_b) = beta.sin_cos();
        let (a, b) = (cos_b * cos_t, sin_b * sin_t);
        let weight = 2.0 * weight * self.density(beta) * sin_b;
        let flip = if b > a { (-a / b).acos() } else { PI };
        let mut arc = |from: f64, to: f64| {
            for (azimuth, w) in panel(from, to) {
                let cos_alpha = (a + b * azimuth.cos()).abs();
                add(cos_alpha, weight * w * cos_alpha);
            }
        };
        arc(0.0, flip);
        if flip < PI {
            arc(flip, PI);
        }
    }

    /// A flake normal from three uniform numbers at a time: rejection from a Rayleigh tilt, exact for P.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> DVec3 {
        use rand::RngExt;
        loop {
            // 1 - u is in (0, 1]: the logarithm is finite.
            let beta = self.sigma * (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
            let accept: f64 = rng.random();
            if beta < FRAC_PI_2 && accept * beta <= beta.sin() {
                return crate::math::half_difference::spherical(beta, 2.0 * PI * rng.random::<f64>());
            }
        }
    }
}

/// The angular lobe of a flake on the sphere of normals: von Mises-Fisher, folded at the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeLobe {
    kappa: f64,
    peak: f64,
}

impl FlakeLobe {
    /// A lobe of full width at half maximum `width`, radians, above 0 up to pi, as the half vector moves inside the binder.
    pub fn new(width: f64) -> Self {
        let kappa = LN_2 / (2.0 * (0.25 * width).sin().powi(2));
        Self { kappa, peak: kappa / (2.0 * PI * -(-2.0 * kappa).exp_m1()) }
    }

    /// Density, 1/sr, at half vector `half` of a flake with normal `normal` or `-normal`.
    pub fn density(&self, normal: DVec3, half: DVec3) -> f64 {
        // 2 - 2 cos(delta) = |n - h|^2 without the cancellation.
        let near = (-0.5 * self.kappa * (normal - half).length_squared()).exp();
        let far = (-0.5 * self.kappa * (normal + half).length_squared()).exp();
        self.peak * (near + far)
    }

    /// Least `|n . h|` at which the density is above 1e-10 of its peak; -1 if it is everywhere.
    pub fn cutoff(&self) -> f64 {
        (1.0 - 10.0 * std::f64::consts::LN_10 / self.kappa).max(-1.0)
    }

    /// P convolved with the lobe, at `beta`.
    fn convolve(&self, orientation: &Orientation, beta: f64) -> f64 {
        let width = self.kappa.sqrt().recip();
        let own = orientation.breaks();
        let end = own[own.len() - 1];
        let around = STEPS.iter().flat_map(|s| [beta - s * width, beta + s * width]).chain([beta]);
        let all = breaks(0.0, end, own.iter().copied().chain(around));
        let sum: f64 = composite(&all)
            .map(|(b, w)| {
                let near = (-2.0 * self.kappa * (0.5 * (beta - b)).sin().powi(2)).exp();
                let far = (-2.0 * self.kappa * (0.5 * (beta + b)).cos().powi(2)).exp();
                let ring = i0_scaled(self.kappa * beta.sin() * b.sin());
                w * orientation.density(b) * b.sin() * (near + far) * ring
            })
            .sum();
        2.0 * PI * self.peak * sum
    }
}

/// The density of half vectors that find a flake: P, or P convolved with the lobe.
#[derive(Debug, Clone, PartialEq)]
pub enum HalfVectorDensity {
    /// Perfect mirrors: P itself.
    Mirror(Orientation),
    /// Flakes with a lobe: the convolution, tabulated over beta to 1e-10 of its peak.
    Lobe {
        /// The convolution over beta.
        table: Piecewise<1>,
        /// Its width, radians.
        width: f64,
    },
}

impl HalfVectorDensity {
    /// Tabulates the density for flakes of this orientation and lobe.
    ///
    /// # Errors
    /// The table misses its tolerance ([`Piecewise::fit`]): not for widths that a composition may name.
    pub fn new(orientation: Orientation, lobe: Option<FlakeLobe>) -> Result<Self> {
        let Some(lobe) = lobe else { return Ok(Self::Mirror(orientation)) };
        let width = orientation.sigma.hypot(lobe.kappa.sqrt().recip());
        let all = breaks(0.0, FRAC_PI_2, STEPS.map(|s| s * width));
        let table = Piecewise::fit("density of half vectors", &all, 1e-10, |beta| {
            [lobe.convolve(&orientation, beta)]
        })?;
        Ok(Self::Lobe { table, width })
    }

    /// Density, 1/sr, at beta in [0, pi/2], radians.
    pub fn eval(&self, beta: f64) -> f64 {
        match self {
            Self::Mirror(orientation) => orientation.density(beta),
            // Far out in the tail the interpolant may undershoot by its error.
            Self::Lobe { table, .. } => table.eval(beta)[0].max(0.0),
        }
    }

    /// Panels on which the density is smooth, up to where it is negligible.
    pub fn breaks(&self) -> Vec<f64> {
        match self {
            Self::Mirror(orientation) => orientation.breaks(),
            Self::Lobe { width, .. } => {
                let end = FRAC_PI_2.min(STEPS[STEPS.len() - 1] * width);
                breaks(0.0, end, STEPS.map(|s| s * width))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn the_gaussian_is_normalized() {
        // 08_ershov_fast_model.json gives both constants.
        for (degrees, constant) in [(5.0f64, 20.952_099_848_122_177), (15.0, 2.375_648_538_497_925)] {
            let peak = Orientation::new(degrees.to_radians()).density(0.0);
            // Panels integrate to rounding.
            assert!((peak / constant - 1.0).abs() < 1e-13, "{degrees}: {peak}");
        }
    }

    #[test]
    fn samples_have_the_density() {
        for degrees in [0.3f64, 7.0, 60.0] {
            let orientation = Orientation::new(degrees.to_radians());
            let mut rng = Pcg64::seed_from_u64(3);
            let n = 40_000;
            let bins = 20;
            let mut counts = vec![0.0f64; bins];
            // Equal shares of tilt: the distribution function at each sample.
            let cdf = Piecewise::fit("cdf", &orientation.breaks(), 1e-9, |end| {
                let sum: f64 = composite(&breaks(0.0, end.max(1e-300), orientation.breaks()))
                    .map(|(b, w)| 2.0 * PI * w * orientation.density(b) * b.sin())
                    .sum();
                [sum]
            })
            .unwrap();
            let mut azimuth = DVec3::ZERO;
            for _ in 0..n {
                let normal = orientation.sample(&mut rng);
                assert!((normal.length() - 1.0).abs() < 1e-14 && normal.z > 0.0);
                let u = cdf.eval(normal.truncate().length().atan2(normal.z))[0];
                counts[((u * bins as f64) as usize).min(bins - 1)] += 1.0;
                azimuth += (normal.with_z(0.0) / normal.truncate().length()).with_z(0.0);
            }
            let expected = f64::from(n) / bins as f64;
            let chi2: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
            // 99.9 % quantile of chi-square with 19 degrees of freedom.
            assert!(chi2 < 43.8, "{degrees}: {chi2}");
            // Each component has variance n/2: four standard errors.
            assert!(azimuth.length() < 4.0 * f64::from(n).sqrt(), "{degrees}: {azimuth}");
        }
    }

    #[test]
    fn the_projected_area_is_that_of_sampled_flakes() {
        for (degrees, theta) in [(0.1f64, 1.2f64), (5.0, 0.0), (15.0, 1.5), (60.0, 1.0)] {
            let orientation = Orientation::new(degrees.to_radians());
            let (mut area, mut weighted) = (0.0, 0.0);
            orientation.projected_average(theta, &mut |cos_alpha, weight| {
                area += weight;
                weighted += weight * cos_alpha;
            });
            let ray = spherical(theta, 0.0);
            let mut rng = Pcg64::seed_from_u64(11);
            let n = 40_000;
            let draws: Vec<f64> = (0..n).map(|_| orientation.sample(&mut rng).dot(ray).abs()).collect();
            for (ours, power) in [(area, 1), (weighted, 2)] {
                let mean = draws.iter().map(|c| c.powi(power)).sum::<f64>() / f64::from(n);
                let square = draws.iter().map(|c| c.powi(2 * power)).sum::<f64>() / f64::from(n);
                let error = ((square - mean * mean) / f64::from(n)).sqrt();
                // Four standard errors, and rounding where the flakes are all but parallel.
                assert!(
                    (ours - mean).abs() < 4.0 * error + 1e-12,
                    "{degrees} {theta}: {ours} {mean} {error}"
                );
            }
        }
    }

    #[test]
    fn the_convolution_integrates_to_one_and_is_tabulated_well() {
        for (sigma, width) in [(0.3f64, 6.5f64), (7.0, 0.1), (7.0, 6.5), (15.0, 20.0), (60.0, 90.0)] {
            let orientation = Orientation::new(sigma.to_radians());
            let lobe = FlakeLobe::new(width.to_radians());
            let density = HalfVectorDensity::new(orientation, Some(lobe)).unwrap();
            let fine = breaks(0.0, FRAC_PI_2, (1..200).map(|k| f64::from(k) * FRAC_PI_2 / 200.0));
            let fine = breaks(0.0, FRAC_PI_2, fine.into_iter().chain(density.breaks()));
            let total: f64 = composite(&fine).map(|(b, w)| 2.0 * PI * w * density.eval(b) * b.sin()).sum();
            // The table's tolerance, 1e-10 of the peak, over the few widths that count.
            assert!((total - 1.0).abs() < 1e-8, "{sigma} {width}: {total}");
            let peak = density.eval(0.0);
            for k in 0..500 {
                let beta = FRAC_PI_2 * f64::from(k) / 499.0;
                let error = (density.eval(beta) - lobe.convolve(&orientation, beta)).abs() / peak;
                // Ten times the tolerance of the three points tested while tabulating.
                assert!(error < 1e-9, "{sigma} {width} {beta}: {error:e}");
            }
        }
    }

    #[test]
    fn the_convolution_is_that_of_the_lobe_over_the_sphere() {
        // Wide enough for a plain product rule, and for the fold at the horizon to matter.
        let orientation = Orientation::new(0.5);
        let lobe = FlakeLobe::new(0.9);
        for beta in [0.0, 0.4, 1.2, FRAC_PI_2] {
            let half = spherical(beta, 0.0);
            let n = 64;
            let mut sum = 0.0;
            for (b, w) in composite(&breaks(0.0, FRAC_PI_2, (1..8).map(|k| 0.2 * f64::from(k)))) {
                for k in 0..n {
                    let normal = spherical(b, 2.0 * PI * f64::from(k) / f64::from(n));
                    let ring = w * b.sin() * 2.0 * PI / f64::from(n);
                    sum += ring * orientation.density(b) * lobe.density(normal, half);
                }
            }
            let ours = lobe.convolve(&orientation, beta);
            // Both rules converge exponentially: rounding.
            assert!((ours / sum - 1.0).abs() < 1e-11, "{beta}: {ours} {sum}");
        }
    }

    #[test]
    fn half_a_lifetime_off_the_lobe_is_at_half_its_peak() {
        let lobe = FlakeLobe::new(6.5f64.to_radians());
        let at = |degrees: f64| lobe.density(DVec3::Z, spherical(degrees.to_radians(), 1.0));
        assert!((at(3.25) / at(0.0) - 0.5).abs() < 1e-13);
        let normal = spherical(lobe.cutoff().acos(), 0.3);
        assert!(lobe.density(normal, DVec3::Z) < 1.01e-10 * at(0.0));
    }

    #[test]
    fn the_convolution_tends_to_the_gaussian_with_the_square_of_the_lobe() {
        let orientation = Orientation::new(7f64.to_radians());
        let error = |width: f64| {
            let lobe = FlakeLobe::new(width.to_radians());
            (lobe.convolve(&orientation, 0.1) / orientation.density(0.1) - 1.0).abs()
        };
        for width in [1.0, 0.5, 0.25] {
            let ratio = error(width) / error(0.5 * width);
            // Four, up to the next order of a small width.
            assert!((ratio - 4.0).abs() < 0.05, "{width}: {ratio}");
        }
        assert!(error(0.1) < 1e-4);
    }
}
