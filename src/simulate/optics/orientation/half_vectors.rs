//! The density of half vectors that find a flake, and of the mirrors that a ray meets.

use super::{FlakeLobe, Orientation};
use crate::error::Result;
use crate::math::quadrature::{breaks, composite, panel};
use crate::simulate::optics::piecewise::Piecewise;
use std::f64::consts::{FRAC_PI_2, PI};

/// P, or P convolved with the lobe of a flake. One density for half vectors and for the areas that rays meet: what flakes
/// send back is what they take.
#[derive(Debug, Clone, PartialEq)]
pub enum HalfVectorDensity {
    /// Perfect mirrors: P itself.
    Mirror(Orientation),
    /// Flakes with a lobe: the convolution, tabulated over beta to 1e-10 of its peak.
    Lobe {
        /// The convolution over beta.
        table: Piecewise<1>,
        /// Panels on which it is smooth, radians.
        breaks: Vec<f64>,
        /// [`HalfVectorDensity::width`].
        width: f64,
    },
}

impl HalfVectorDensity {
    /// Tabulates the density for flakes of this orientation and lobe, in some milliseconds with a lobe.
    ///
    /// # Errors
    /// The table misses its tolerance ([`Piecewise::fit`]): not for widths that a composition may name.
    pub fn new(orientation: Orientation, lobe: Option<FlakeLobe>) -> Result<Self> {
        let Some(lobe) = lobe else { return Ok(Self::Mirror(orientation)) };
        let (panels, end) = lobe.panels(&orientation);
        let table = Piecewise::fit("density of half vectors", &panels, 1e-10, |beta| {
            [lobe.convolve(&orientation, beta)]
        })?;
        let breaks = breaks(0.0, end, panels);
        Ok(Self::Lobe { table, breaks, width: lobe.together(&orientation) })
    }

    /// Density, 1/sr, at beta in [0, pi/2], radians.
    pub fn eval(&self, beta: f64) -> f64 {
        match self {
            Self::Mirror(orientation) => orientation.density(beta),
            // Far out in the tail the interpolant may undershoot by its error.
            Self::Lobe { table, .. } => table.eval(beta)[0].max(0.0),
        }
    }

    /// Width, radians: of P, or what it has together with the lobe.
    pub fn width(&self) -> f64 {
        match self {
            Self::Mirror(orientation) => orientation.width(),
            Self::Lobe { width, .. } => *width,
        }
    }

    /// Panels on which the density is smooth, radians, up to where it is negligible.
    pub fn breaks(&self) -> Vec<f64> {
        match self {
            Self::Mirror(orientation) => orientation.breaks(),
            Self::Lobe { breaks, .. } => breaks.clone(),
        }
    }

    /// The average over all mirrors of `f(|cos alpha|) |cos alpha|` for a ray at polar angle `theta`, radians: the share of a
    /// mirror's area that such a ray meets, weighted by f (Ershov 2001, eq. 10). As a quadrature: `add(x, weight)` is called
    /// at every node, and the average is the sum of `weight * f(x)`.
    pub fn projected_average(&self, theta: f64, add: &mut dyn FnMut(f64, f64)) {
        let (sin_t, cos_t) = theta.sin_cos();
        // Up to this tilt every mirror is met from above; beyond, one can show either side.
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

    /// The mirrors of one tilt, all azimuths.
    fn ring(&self, beta: f64, weight: f64, cos_t: f64, sin_t: f64, add: &mut dyn FnMut(f64, f64)) {
        let (sin_b, cos_b) = beta.sin_cos();
        let (a, b) = (cos_b * cos_t, sin_b * sin_t);
        let weight = 2.0 * weight * self.eval(beta) * sin_b;
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
}

#[cfg(test)]
mod tests {
    use super::super::tests::tables;
    use super::*;
    use crate::math::half_difference::spherical;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn the_lobe_rounds_a_table_off() {
        for orientation in tables() {
            for width in [0.5f64, 6.5, 60.0] {
                let lobe = FlakeLobe::new(width.to_radians());
                let density = HalfVectorDensity::new(orientation.clone(), Some(lobe)).unwrap();
                let fine = breaks(0.0, FRAC_PI_2, (1..400).map(|k| f64::from(k) * FRAC_PI_2 / 400.0));
                let fine = breaks(0.0, FRAC_PI_2, fine.into_iter().chain(density.breaks()));
                let total: f64 =
                    composite(&fine).map(|(b, w)| 2.0 * PI * w * density.eval(b) * b.sin()).sum();
                // The table's tolerance, 1e-10 of the peak, over the angles that count.
                assert!((total - 1.0).abs() < 1e-8, "{width}: {total}");
                let own: f64 =
                    composite(&density.breaks()).map(|(b, w)| 2.0 * PI * w * density.eval(b) * b.sin()).sum();
                // Panels of the lobe's width or coarser: a 16-point rule on each.
                assert!((own - 1.0).abs() < 1e-6, "{width}: {own}");
            }
        }
    }

    #[test]
    fn the_convolution_integrates_to_one_and_is_tabulated_well() {
        for (sigma, width) in [(0.3f64, 6.5f64), (7.0, 0.1), (7.0, 6.5), (15.0, 20.0), (60.0, 90.0)] {
            let orientation = Orientation::new(sigma.to_radians());
            let lobe = FlakeLobe::new(width.to_radians());
            let density = HalfVectorDensity::new(orientation.clone(), Some(lobe)).unwrap();
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
    fn the_projected_area_is_that_of_sampled_flakes() {
        let gaussians = [(0.1f64, 1.2f64), (5.0, 0.0), (15.0, 1.5), (60.0, 1.0)]
            .map(|(degrees, theta)| (Orientation::new(degrees.to_radians()), theta));
        for (orientation, theta) in gaussians.into_iter().chain(tables().map(|table| (table, 1.3))) {
            let degrees = orientation.breaks().len();
            let density = HalfVectorDensity::Mirror(orientation.clone());
            let (mut area, mut weighted) = (0.0, 0.0);
            density.projected_average(theta, &mut |cos_alpha, weight| {
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
}
