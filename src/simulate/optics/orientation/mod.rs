//! How flakes are tilted: the density of their normals, with and without the finite angular lobe of a flake.
//!
//! `P(beta) = C exp(-beta^2 / (2 sigma^2))` per steradian on the upper hemisphere,
//! `2 pi int_0^(pi/2) P sin(beta) dbeta = 1` (Ershov 2001, section 5; the normalization of errata.md, section 0), or linear
//! between measured tilts.
//!
//! With the finite angular lobe of a flake ([`FlakeLobe`]) half vectors and rays find P convolved with it
//! ([`HalfVectorDensity`]).

mod half_vectors;
mod lobe;

pub use half_vectors::HalfVectorDensity;
pub use lobe::FlakeLobe;

use crate::error::{Error, Result};
use crate::math::quadrature::{breaks, composite, panel};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Multiples of a Gaussian's width between which a 16-point rule is exact to rounding; the last is exp(-50).
const STEPS: [f64; 7] = [1.0, 2.0, 3.0, 4.5, 6.0, 8.0, 10.0];

/// Distribution of flake normals over the upper hemisphere, the same at every azimuth.
#[derive(Debug, Clone, PartialEq)]
pub struct Orientation {
    shape: Shape,
    /// What a shape is multiplied by to integrate to one.
    scale: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// exp(-beta^2 / (2 sigma^2)).
    Gaussian { sigma: f64 },
    /// Linear between knots (beta, density), 0 outside.
    Table(Arc<[Knot]>),
}

/// A knot of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    beta: f64,
    density: f64,
    /// Share of all flakes tilted less than this; 1 at the last.
    below: f64,
}

impl Orientation {
    /// Most knots of a table.
    pub const MAX_KNOTS: usize = 1024;

    /// A Gaussian of width `sigma`, radians, above 0; a composition allows 0.1 to 89.9 degrees.
    pub fn new(sigma: f64) -> Self {
        Self::normalized(Shape::Gaussian { sigma })
    }

    /// Measured tilts: `[degrees, density per steradian]`, linear between and 0 outside, in any unit.
    ///
    /// # Errors
    /// Fewer than 2 knots or more than [`Orientation::MAX_KNOTS`]; tilts that do not ascend by 0.01 degrees or more, or lie
    /// outside 0 to 90; densities that are negative, not finite, or nowhere positive.
    pub fn tabulated(knots: &[[f64; 2]]) -> Result<Self> {
        if !(2..=Self::MAX_KNOTS).contains(&knots.len()) {
            return Err(Error::invalid("tilts", "knots", knots.len(), "2 to 1024"));
        }
        let mut last = -1.0;
        for [degrees, density] in knots {
            // Also refuses not-a-numbers.
            if !(0.0..=90.0).contains(degrees) || *degrees < last + 0.01 {
                return Err(Error::invalid(
                    "tilts",
                    "degrees",
                    degrees,
                    "0 to 90, ascending by 0.01 or more",
                ));
            }
            if !(0.0..=f64::MAX).contains(density) {
                return Err(Error::invalid("tilts", format!("density at {degrees}"), density, "0 or more"));
            }
            last = *degrees;
        }
        // Divided by the greatest: no scale of the input over- or underflows.
        let peak = knots.iter().map(|knot| knot[1]).fold(0.0, f64::max);
        if peak == 0.0 {
            return Err(Error::invalid("tilts", "densities", "all 0", "at least one positive"));
        }
        let knot = |[degrees, density]: &[f64; 2]| Knot {
            beta: degrees.to_radians().min(FRAC_PI_2),
            density: density / peak,
            below: 0.0,
        };
        let mut this = Self::normalized(Shape::Table(knots.iter().map(knot).collect()));
        let mut table: Vec<Knot> = this.table().to_vec();
        for k in 1..table.len() {
            let mass: f64 = panel(table[k - 1].beta, table[k].beta)
                .map(|(b, w)| 2.0 * PI * w * this.density(b) * b.sin())
                .sum();
            table[k].below = table[k - 1].below + mass;
        }
        this.shape = Shape::Table(table.into());
        Ok(this)
    }

    fn normalized(shape: Shape) -> Self {
        let this = Self { shape, scale: 1.0 };
        let mass: f64 = composite(&this.breaks()).map(|(b, w)| w * this.density(b) * b.sin()).sum();
        Self { scale: 1.0 / (2.0 * PI * mass), ..this }
    }

    fn table(&self) -> &[Knot] {
        match &self.shape {
            Shape::Gaussian { .. } => &[],
            Shape::Table(knots) => knots,
        }
    }

    /// Width of the finest feature, radians: of the Gaussian, or, for a table, the least `sqrt(P_max / |P''|)`, which is the
    /// same for a Gaussian; a knot bends P over the mean of its two intervals.
    pub fn width(&self) -> f64 {
        let knots = match &self.shape {
            Shape::Gaussian { sigma } => return *sigma,
            Shape::Table(knots) => knots,
        };
        let peak = knots.iter().map(|knot| knot.density).fold(0.0, f64::max);
        let slope = |a: Knot, b: Knot| (b.density - a.density) / (b.beta - a.beta);
        let finest = knots.windows(3).map(|k| {
            let bend = (slope(k[1], k[2]) - slope(k[0], k[1])).abs() / (0.5 * (k[2].beta - k[0].beta));
            (peak / bend).sqrt()
        });
        finest.fold(FRAC_PI_2, f64::min)
    }

    /// Whether it is made of measured tilts: P bends at every knot.
    pub fn is_tabulated(&self) -> bool {
        !self.table().is_empty()
    }

    /// P(beta), 1/sr, for beta in [0, pi/2] radians.
    pub fn density(&self, beta: f64) -> f64 {
        let shape = match &self.shape {
            Shape::Gaussian { sigma } => (-0.5 * (beta / sigma).powi(2)).exp(),
            Shape::Table(knots) => interpolate(knots, beta),
        };
        self.scale * shape
    }

    /// Panels on which P is smooth, radians, ascending, from 0 up to where P ends or is negligible; narrow enough for
    /// [`composite`] to integrate P to rounding.
    pub fn breaks(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Gaussian { sigma } => {
                let end = FRAC_PI_2.min(STEPS[STEPS.len() - 1] * sigma);
                breaks(0.0, end, STEPS.map(|s| s * sigma))
            }
            Shape::Table(knots) => {
                // What lies before the first and after the last positive knot's neighbors is empty.
                let last =
                    knots.iter().rposition(|k| k.density > 0.0).map_or(0, |k| (k + 1).min(knots.len() - 1));
                breaks(0.0, knots[last].beta, knots.iter().map(|k| k.beta))
            }
        }
    }

    /// Mean of cos^2(beta).
    pub fn mean_squared_cosine(&self) -> f64 {
        composite(&self.breaks())
            .map(|(b, w)| 2.0 * PI * w * self.density(b) * b.sin() * b.cos().powi(2))
            .sum()
    }

    /// A flake normal, exactly after P, from some uniform numbers.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> DVec3 {
        use rand::RngExt;
        let beta = match &self.shape {
            Shape::Gaussian { sigma } => gaussian_tilt(*sigma, rng),
            Shape::Table(knots) => tabulated_tilt(knots, rng),
        };
        crate::math::half_difference::spherical(beta, 2.0 * PI * rng.random::<f64>())
    }
}

/// Density of a table, in its own unit.
fn interpolate(knots: &[Knot], beta: f64) -> f64 {
    let right = knots.partition_point(|knot| knot.beta < beta);
    if right == 0 || right == knots.len() {
        // The very first knot, or outside.
        return knots.get(right).filter(|knot| knot.beta == beta).map_or(0.0, |knot| knot.density);
    }
    let (a, b) = (knots[right - 1], knots[right]);
    a.density + (b.density - a.density) * ((beta - a.beta) / (b.beta - a.beta))
}

/// Rejection from a Rayleigh tilt.
fn gaussian_tilt(sigma: f64, rng: &mut impl rand::Rng) -> f64 {
    use rand::RngExt;
    loop {
        // 1 - u is in (0, 1]: the logarithm is finite.
        let beta = sigma * (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
        let accept: f64 = rng.random();
        if beta < FRAC_PI_2 && accept * beta <= beta.sin() {
            return beta;
        }
    }
}

/// A panel by its share, in it rejection from a uniform tilt: at least one in six is kept.
fn tabulated_tilt(knots: &[Knot], rng: &mut impl rand::Rng) -> f64 {
    use rand::RngExt;
    // Rounding may leave the last share below 1.
    let share = rng.random::<f64>() * knots[knots.len() - 1].below;
    let right = knots.partition_point(|knot| knot.below <= share).clamp(1, knots.len() - 1);
    let (a, b) = (knots[right - 1], knots[right]);
    let most = a.density.max(b.density) * b.beta.sin();
    loop {
        let beta = a.beta + (b.beta - a.beta) * rng.random::<f64>();
        let accept: f64 = rng.random();
        if accept * most <= interpolate(knots, beta) * beta.sin() {
            return beta;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::optics::piecewise::Piecewise;
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

    /// A ring of tilts, a distribution with a gap, and one that ends at the horizon.
    pub(super) fn tables() -> [Orientation; 3] {
        let ring: &[[f64; 2]] = &[[3.0, 0.0], [5.0, 4e9], [7.0, 0.0]];
        let gap: &[[f64; 2]] = &[[0.0, 1.0], [4.0, 0.0], [40.0, 0.0], [60.0, 0.1], [61.0, 0.0], [90.0, 0.0]];
        let wide: &[[f64; 2]] = &[[0.0, 1.0], [0.3, 2.0], [90.0, 1.0]];
        [ring, gap, wide].map(|knots| Orientation::tabulated(knots).unwrap())
    }

    #[test]
    fn tables_are_normalized_and_linear() {
        for orientation in tables() {
            let fine = breaks(0.0, FRAC_PI_2, (1..=180).map(|k| (0.5 * f64::from(k)).to_radians()));
            let fine = breaks(0.0, FRAC_PI_2, fine.into_iter().chain(orientation.breaks()));
            let total: f64 =
                composite(&fine).map(|(b, w)| 2.0 * PI * w * orientation.density(b) * b.sin()).sum();
            // Panels integrate to rounding.
            assert!((total - 1.0).abs() < 1e-13, "{total}");
        }
        let [ring, gap, wide] = tables();
        let at = |o: &Orientation, degrees: f64| o.density(degrees.to_radians());
        assert_eq!((at(&ring, 2.9), at(&ring, 7.1), at(&gap, 20.0)), (0.0, 0.0, 0.0));
        assert!((at(&ring, 4.0) / at(&ring, 5.0) - 0.5).abs() < 1e-12);
        assert!((at(&wide, 0.0) / at(&wide, 90.0) - 1.0).abs() < 1e-12);
        // The same table of a Gaussian, finely cut.
        let knots: Vec<_> =
            (0..=900).map(|k| 0.1 * f64::from(k)).map(|d| [d, (-0.5 * (d / 15.0).powi(2)).exp()]).collect();
        let (table, gaussian) =
            (Orientation::tabulated(&knots).unwrap(), Orientation::new(15f64.to_radians()));
        // A chord of a tenth of a degree: its square over eight times the curvature 1/15^2.
        assert!((at(&table, 10.0) / at(&gaussian, 10.0) - 1.0).abs() < 1e-5);
        assert!((table.mean_squared_cosine() / gaussian.mean_squared_cosine() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn samples_have_the_density() {
        let gaussians = [0.3f64, 7.0, 60.0].map(|degrees| Orientation::new(degrees.to_radians()));
        for orientation in gaussians.into_iter().chain(tables()) {
            let degrees = orientation.breaks().len();
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
}
