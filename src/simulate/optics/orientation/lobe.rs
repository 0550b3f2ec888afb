//! The finite angular lobe of a flake.
//!
//! A real flake is no perfect mirror: it stays visible while the half vector moves through a few degrees. That lobe is a
//! von Mises-Fisher kernel on the sphere of normals,
//! `K(delta) = kappa / (2 pi (1 - exp(-2 kappa))) exp(-2 kappa sin^2(delta/2))`,
//! as if a flake were many small mirrors whose normals spread so about its own. The mirrors of many such flakes have P
//! convolved with K. Normals n and -n are the same mirror, so the part of K below the horizon is folded back: the convolution
//! again integrates to 1.

use super::{Orientation, STEPS, Shape};
use crate::math::quadrature::{breaks, composite};
use crate::simulate::optics::bessel::i0_scaled;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, LN_2, PI};

/// Multiples of a lobe's width between which a 16-point rule is exact to rounding; the last is exp(-50).
const REACH: [f64; 3] = [2.5, 5.5, 10.0];

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

    /// Squared distance between half vector and the nearer of `normal` and `-normal`, on which the density hangs.
    pub fn distance(&self, normal: DVec3, half: DVec3) -> f64 {
        (normal - half).length_squared().min((normal + half).length_squared())
    }

    /// That distance where the density has fallen to a share of its peak.
    pub fn reach(&self, share: f64) -> f64 {
        -2.0 * share.ln() / self.kappa
    }

    /// Panels over [0, pi/2] on which P convolved with the lobe is smooth, and where it becomes negligible.
    pub(super) fn panels(&self, orientation: &Orientation) -> (Vec<f64>, f64) {
        let narrow = self.kappa.sqrt().recip();
        match &orientation.shape {
            Shape::Gaussian { sigma } => {
                let width = sigma.hypot(narrow);
                let end = FRAC_PI_2.min(STEPS[STEPS.len() - 1] * width);
                (breaks(0.0, FRAC_PI_2, STEPS.map(|s| s * width)), end)
            }
            Shape::Table(_) => {
                // Every kink is rounded off over the lobe's width.
                let own = orientation.breaks();
                let end = FRAC_PI_2.min(own[own.len() - 1] + STEPS[STEPS.len() - 1] * narrow);
                let around = own.iter().flat_map(|b| [b - 2.0 * narrow, *b, b + 2.0 * narrow]);
                let mut panels = breaks(0.0, FRAC_PI_2, around.chain([end]));
                panels.dedup_by(|b, a| *b - *a < 0.5 * narrow && *b < FRAC_PI_2);
                (panels, end)
            }
        }
    }

    /// Width of P convolved with the lobe, radians.
    pub(super) fn together(&self, orientation: &Orientation) -> f64 {
        orientation.width().hypot(self.kappa.sqrt().recip())
    }

    /// P convolved with the lobe, at `beta`.
    pub(super) fn convolve(&self, orientation: &Orientation, beta: f64) -> f64 {
        let width = self.kappa.sqrt().recip();
        let own = orientation.breaks();
        let end = own[own.len() - 1];
        let around = REACH.iter().flat_map(|s| [beta - s * width, beta + s * width]).chain([beta]);
        let reach = width * REACH[REACH.len() - 1];
        let [from, to] = [(beta - reach).max(0.0), (beta + reach).min(end)];
        if from >= to {
            return 0.0;
        }
        let all = match &orientation.shape {
            // Panels fine enough for the narrower of the two are so for the product.
            Shape::Gaussian { sigma } if *sigma < width => own,
            Shape::Gaussian { .. } => breaks(from, to, around),
            Shape::Table(_) => breaks(from, to, own.into_iter().chain(around)),
        };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;

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
