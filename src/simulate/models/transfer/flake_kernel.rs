//! Flakes as scatterers: `K = (D<S>h / 4) r_p(alpha) P(beta)` per steradian, backwards and onwards (eqs 9, 13 corrected).
//!
//! With travel directions of polar angles theta, theta' and azimuth difference phi, `q` the horizontal and `v` the vertical
//! part of their difference (corrected eq. 14 in a form without cancellation):
//!
//! `q^2 = (sin - sin')^2 + 4 sin sin' sin^2(phi/2)`, `v = cos + cos'` backwards, `|cos - cos'|` onwards,
//! `tan(beta) = q / v`, `cos(alpha) = sqrt(q^2 + v^2) / 2`.
//!
//! beta grows with phi, so the azimuths where it crosses the multiples of the width of P are known, and Gauss panels between
//! them resolve the onward ridge at grazing angles, however narrow, with a few dozen nodes where a transform over equidistant
//! azimuths needs thousands (4,096 at 85 degrees for a width of 5). That is why the series is not taken by an FFT here.

use super::kernel::{Extent, SIDES, Side};
use super::nodes::Direction;
use crate::math::quadrature::gauss_legendre;
use crate::simulate::optics::film_optics::KindOptics;
use crate::simulate::optics::flake_optics::FlakeOptics;
use crate::simulate::optics::orientation::HalfVectorDensity;
use std::f64::consts::{FRAC_PI_2, PI};

/// Widest breaks of a density that reaches the horizon are continued in steps of this factor of tan(beta).
const STEP_TO_HORIZON: f64 = 3.0;

/// Quadrature over azimuth for one kind of flakes.
pub struct FlakeKernel<'a> {
    kind: &'a KindOptics,
    density: HalfVectorDensity,
    /// tan(beta) at the ends of panels, ascending from above 0; infinity last if P reaches the horizon.
    breaks: Vec<f64>,
    /// Nodes of a panel too short for any mode to turn.
    base: usize,
    /// Gauss rules on [0, 1] by number of nodes.
    rules: Vec<Vec<(f64, f64)>>,
}

/// One azimuth of the quadrature.
struct Azimuth {
    phi: f64,
    /// Weight over the full circle.
    weight: f64,
    mirror: Mirroring,
}

/// The flake that mirrors one direction into another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirroring {
    /// Angle of its normal to that of the paint, 0 to pi/2.
    pub beta: f64,
    /// Cosine of the angle of incidence on it.
    pub cos_alpha: f64,
}

impl Mirroring {
    /// For travel directions at an azimuth difference phi.
    pub fn new(side: Side, a: Direction, b: Direction, phi: f64) -> Self {
        let v = vertical(side, a, b);
        let q = ((a.sin - b.sin).powi(2) + 4.0 * a.sin * b.sin * (0.5 * phi).sin().powi(2)).sqrt();
        // Straight on the flake is met edge-on.
        let beta = if v == 0.0 { FRAC_PI_2 } else { q.atan2(v) };
        Self { beta, cos_alpha: (0.5 * q.hypot(v)).min(1.0) }
    }
}

fn vertical(side: Side, a: Direction, b: Direction) -> f64 {
    match side {
        Side::Reflection => a.cos + b.cos,
        Side::Transmission => (a.cos - b.cos).abs(),
    }
}

impl<'a> FlakeKernel<'a> {
    /// Prepares a kind; P is left out where it is below `cutoff` of its peak, and panels have `base` nodes and more for high
    /// `modes`. `density` is P as the nodes can resolve it.
    pub fn new(
        kind: &'a KindOptics,
        density: HalfVectorDensity,
        cutoff: f64,
        base: usize,
        modes: usize,
    ) -> Self {
        let all = density.breaks();
        let peak = all.iter().map(|beta| density.eval(*beta)).fold(0.0, f64::max);
        // P may vanish between two bumps: the last break above the cutoff, and one more.
        let last = all.iter().rposition(|beta| density.eval(*beta) >= cutoff * peak).unwrap_or(0);
        let end = (last + 2).min(all.len());
        let tangent = |beta: &f64| if *beta >= FRAC_PI_2 { f64::INFINITY } else { beta.tan() };
        let breaks: Vec<f64> = all.get(1..end).unwrap_or(&[]).iter().map(tangent).collect();
        // The whole circle at the highest mode: 2 M nodes at least; one turn of a mode takes about pi of them.
        let most = base + 2 + modes * 2;
        Self { kind, density, breaks, base, rules: (1..=most).map(|n| gauss_legendre(n, 0.0, 1.0)).collect() }
    }

    /// Adds the modes of a pair of directions, for these bands, to `sums` (side, mode, band).
    pub fn add(&self, a: Direction, b: Direction, extent: Extent, bands: &[usize], sums: &mut [f64]) {
        let block = extent.modes * extent.bands;
        for (side, sums) in SIDES.into_iter().zip(sums.chunks_exact_mut(block)) {
            self.add_side(side, a, b, extent, bands, sums);
        }
    }

    fn add_side(
        &self,
        side: Side,
        a: Direction,
        b: Direction,
        extent: Extent,
        bands: &[usize],
        sums: &mut [f64],
    ) {
        let azimuths = self.azimuths(side, a, b, extent.modes);
        let factor = 0.25 * self.kind.area_density;
        match &self.kind.optics {
            FlakeOptics::Mirror(mirror) => {
                let mut modes = vec![0.0; extent.modes];
                for azimuth in &azimuths {
                    let value = factor * azimuth.weight * self.density.eval(azimuth.mirror.beta);
                    cosines(azimuth.phi, extent.modes, |m, c| modes[m] += value * c);
                }
                for (row, mode) in sums.chunks_exact_mut(extent.bands).zip(modes) {
                    row.iter_mut().zip(bands).for_each(|(s, k)| *s += mode * mirror.reflectance.0[*k]);
                }
            }
            FlakeOptics::Stack { reflectance, .. } => {
                let mut spectrum = vec![0.0; extent.bands];
                for azimuth in &azimuths {
                    let value = factor * azimuth.weight * self.density.eval(azimuth.mirror.beta);
                    let all = reflectance.eval(azimuth.mirror.cos_alpha);
                    spectrum.iter_mut().zip(bands).for_each(|(s, k)| *s = value * all[*k]);
                    cosines(azimuth.phi, extent.modes, |m, c| {
                        let row = &mut sums[m * extent.bands..(m + 1) * extent.bands];
                        row.iter_mut().zip(&spectrum).for_each(|(s, r)| *s += c * r);
                    });
                }
            }
        }
    }

    /// The quadrature for a pair of directions; empty where there are no flakes to mirror one into the other.
    fn azimuths(&self, side: Side, a: Direction, b: Direction, modes: usize) -> Vec<Azimuth> {
        let v = vertical(side, a, b);
        let near = (a.sin - b.sin).powi(2);
        let span = 4.0 * a.sin * b.sin;
        let at = |phi: f64, weight: f64| Azimuth { phi, weight, mirror: Mirroring::new(side, a, b, phi) };
        let mut azimuths = Vec::new();
        let mut from = 0.0;
        let mut panel = |to: f64| {
            let turn = 0.5 * (modes - 1) as f64 * (to - from);
            let n = (self.base + (0.75 * turn).ceil() as usize).min(self.rules.len());
            for (x, w) in &self.rules[n - 1] {
                azimuths.push(at(from + (to - from) * x, 2.0 * (to - from) * w));
            }
            from = to;
        };
        // Where tan(beta) = t.
        let crossing = |t: f64| {
            let u = ((t * v).powi(2) - near) / span;
            if u < 1.0 { 2.0 * u.max(0.0).sqrt().asin() } else { PI }
        };
        let mut last = 0.0;
        for tan in &self.breaks {
            let steps = std::iter::successors(Some(f64::max(last, 0.5) * STEP_TO_HORIZON), |t| {
                Some(t * STEP_TO_HORIZON)
            });
            if tan.is_infinite() && v > 0.0 {
                for step in steps.skip_while(|t| *t <= last) {
                    let phi = crossing(step);
                    if phi >= PI || phi.is_nan() {
                        break;
                    }
                    if phi > 0.0 {
                        panel(phi);
                    }
                }
            }
            let phi = if tan.is_infinite() { PI } else { crossing(*tan) };
            // At normal incidence beta is the same all around.
            let phi = if span == 0.0 {
                if tan * v > near.sqrt() || tan.is_infinite() { PI } else { 0.0 }
            } else {
                phi
            };
            if phi > 0.0 {
                panel(phi);
            }
            if phi == PI {
                break;
            }
            last = *tan;
        }
        azimuths
    }
}

/// Calls `f` with cos(m phi) for the first modes.
fn cosines(phi: f64, modes: usize, mut f: impl FnMut(usize, f64)) {
    let (mut before, mut now) = (phi.cos(), 1.0);
    let twice = 2.0 * before;
    for m in 0..modes {
        f(m, now);
        (before, now) = (now, twice * now - before);
    }
}
