//! Directions in proportion to a paint's BRDF times cosine: lobes, coat, color table and flakes' mean together.
//!
//! Metallic paint scatters much of its light far from the mirrored direction, and no lobe alone says how much (Rump et al. 2008,
//! section 6). So the whole BRDF is tabulated over half vectors, where it is narrow in one place only, for some directions to
//! the eye, and drawn from by adaptive numerical cumulative distributions (Lawrence et al. 2005): first the half vector's
//! elevation, then its azimuth. The ideal mirror of the coat is no function and is not in here.

use crate::math::adaptive_cdf::AdaptiveCdf;
use crate::render::paint::RenderPaint;
use crate::render::shade::shade_mean;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Directions to the eye for which there is a table, from the normal to the horizon.
const ROWS: usize = 33;
/// Cells of the half vector's elevation, in `v = 1 - cos theta_h`, and of its azimuth.
const ELEVATIONS: usize = 160;
const AZIMUTHS: usize = 48;
/// The first cell ends here: a lobe of roughness 1e-4 has all but a hundredth of its half vectors beyond.
const NARROWEST: f64 = 1e-10;
/// Largest error of a cumulative distribution.
const TOLERANCE: f64 = 1e-3;
/// Share of the cosine law: it bounds the weight of every direction.
const COSINE: f32 = 0.1;

/// Draws directions to the light.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Directions {
    /// None: black.
    rows: Vec<Option<Row>>,
}

/// Half vectors for one direction to the eye, that at azimuth 0.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// Over v.
    elevation: AdaptiveCdf,
    /// Over the azimuth, 0 to pi, once a piece of `elevation`: the other half mirrors it.
    azimuths: Vec<AdaptiveCdf>,
}

impl Directions {
    /// Tabulates a paint: some 250,000 values.
    pub fn new(paint: &RenderPaint) -> Self {
        let row = |k: usize| Row::new(paint, k as f64 * FRAC_PI_2 / (ROWS - 1) as f64);
        Self { rows: (0..ROWS).into_par_iter().map(row).collect() }
    }

    /// Direction for three numbers in (0, 1); it may lie below the horizon, where nothing comes from. `wo` and the result in the
    /// local frame, z = normal.
    pub fn sample(&self, wo: Vec3, [choice, along, around]: [f32; 3]) -> Vec3 {
        let (near, far, fraction) = place(wo);
        let rest = (choice - COSINE) / (1.0 - COSINE);
        let row = if rest < 1.0 - fraction { near } else { far };
        match &self.rows[row] {
            Some(row) if choice >= COSINE => {
                let half = row.sample(wo.as_dvec3(), f64::from(along), f64::from(around));
                (2.0 * wo.as_dvec3().dot(half) * half - wo.as_dvec3()).normalize().as_vec3()
            }
            _ => cosine(along, around),
        }
    }

    /// Density of [`Directions::sample`] at the unit vector `wi`, 1/sr.
    pub fn density(&self, wi: Vec3, wo: Vec3) -> f32 {
        let (near, far, fraction) = place(wo);
        let [wi, wo] = [wi, wo].map(|w| w.as_dvec3());
        let lambert = wi.z.max(0.0) as f32 * FRAC_1_PI;
        let of = |row: usize| self.rows[row].as_ref().map_or(lambert, |row| row.density(wi, wo) as f32);
        let tabulated =
            if fraction > 0.0 { (1.0 - fraction) * of(near) + fraction * of(far) } else { of(near) };
        COSINE * lambert + (1.0 - COSINE) * tabulated
    }
}

/// The rows about a direction to the eye, and how far it is on the way to the second.
fn place(wo: Vec3) -> (usize, usize, f32) {
    let angle = f64::from(wo.truncate().length().atan2(wo.z));
    let at = (angle / FRAC_PI_2).clamp(0.0, 1.0) * (ROWS - 1) as f64;
    let near = (at as usize).min(ROWS - 2);
    (near, near + 1, (at - near as f64) as f32)
}

/// Malley's method: a uniform disc, lifted.
fn cosine(square: f32, turn: f32) -> Vec3 {
    let (sin, cos) = (std::f32::consts::TAU * turn).sin_cos();
    Vec3::new(square.sqrt() * cos, square.sqrt() * sin, (1.0 - square).sqrt())
}

impl Row {
    fn new(paint: &RenderPaint, theta_o: f64) -> Option<Self> {
        // At the horizon itself nothing is seen.
        let (sin, cos) = theta_o.min(0.999 * FRAC_PI_2).sin_cos();
        let wo = DVec3::new(sin, 0.0, cos);
        let growth = (1.0 / NARROWEST).powf(1.0 / (ELEVATIONS - 1) as f64);
        let edges: Vec<f64> =
            [0.0].into_iter().chain((0..ELEVATIONS).map(|k| NARROWEST * growth.powi(k as i32))).collect();
        let turns: Vec<f64> = (0..=AZIMUTHS).map(|k| k as f64 * PI / AZIMUTHS as f64).collect();
        let cells: Vec<Vec<f64>> = edges
            .windows(2)
            .map(|v| {
                turns
                    .windows(2)
                    .map(|t| value(paint, wo, middle(v), middle(t)) * (v[1] - v[0]) * (t[1] - t[0]))
                    .collect()
            })
            .collect();
        let masses: Vec<f64> = cells.iter().map(|row| row.iter().sum()).collect();
        let elevation = AdaptiveCdf::new(&edges, &masses, TOLERANCE)?;
        let azimuths = elevation
            .knots()
            .windows(2)
            .map(|piece| {
                let inside = |k: &usize| middle(&edges[*k..*k + 2]) > piece[0] && edges[*k] < piece[1];
                let rows: Vec<usize> = (0..ELEVATIONS).filter(inside).collect();
                let sum = |t: usize| rows.iter().map(|k| cells[*k][t]).sum::<f64>();
                let masses: Vec<f64> = (0..AZIMUTHS).map(sum).collect();
                // A piece without light is never drawn from.
                AdaptiveCdf::new(&turns, &masses, TOLERANCE)
                    .or_else(|| AdaptiveCdf::new(&[0.0, PI], &[1.0], TOLERANCE))
            })
            .collect::<Option<Vec<_>>>()?;
        Some(Self { elevation, azimuths })
    }

    /// Half vector in the frame of `wo`, for two numbers in (0, 1).
    fn sample(&self, wo: DVec3, along: f64, around: f64) -> DVec3 {
        let (piece, v) = self.elevation.sample(along);
        let side = if around < 0.5 { 1.0 } else { -1.0 };
        let (_, azimuth) = self.azimuths[piece].sample((2.0 * around).fract());
        half_vector(v, wo.y.atan2(wo.x) + side * azimuth)
    }

    /// Density over directions to the light, 1/sr.
    fn density(&self, wi: DVec3, wo: DVec3) -> f64 {
        let sum = wi + wo;
        let half = sum.normalize_or_zero();
        if half.z <= 0.0 {
            return 0.0;
        }
        // 1 - cos without cancellation.
        let v = half.truncate().length_squared() / (1.0 + half.z);
        let azimuth = wo.truncate().perp_dot(half.truncate()).atan2(wo.truncate().dot(half.truncate()));
        let (piece, elevation) = self.elevation.density(v);
        let (_, around) = self.azimuths[piece].density(azimuth.abs());
        0.5 * elevation * around / (2.0 * sum.length()).max(f64::MIN_POSITIVE)
    }
}

fn middle(cell: &[f64]) -> f64 {
    0.5 * (cell[0] + cell[1])
}

fn half_vector(v: f64, azimuth: f64) -> DVec3 {
    let sine = (v * (2.0 - v)).sqrt();
    let (sin, cos) = azimuth.rem_euclid(TAU).sin_cos();
    DVec3::new(sine * cos, sine * sin, 1.0 - v)
}

/// The mean BRDF times cosine per solid angle of half vectors, all channels together; 0 where it is negative.
fn value(paint: &RenderPaint, wo: DVec3, v: f64, azimuth: f64) -> f64 {
    let half = half_vector(v, azimuth);
    let cos_d = wo.dot(half);
    let wi = (2.0 * cos_d * half - wo).normalize();
    if cos_d <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let [wi, wo] = [wi, wo].map(|w| w.as_vec3());
    let reflected = shade_mean(paint, wi, wo) + paint.coat.gloss(wi, wo, 0.0);
    let value = f64::from(reflected.element_sum()) * f64::from(wi.z) * 4.0 * cos_d;
    if value.is_finite() { value.max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{ClearCoat, ColorTable, Lobe};
    use crate::math::hash::{pcg4d, unit};
    use crate::paint::Paint;

    fn paint(roughness: f64, refracts: bool) -> RenderPaint {
        let gloss = Lobe { coefficient: 0.02, roughness: 0.01, f0: 1.0 };
        RenderPaint::new(&Paint {
            coat: ClearCoat { gloss: Some(gloss), ..ClearCoat::ideal(1.5, refracts) },
            diffuse: 0.1,
            lobes: vec![Lobe { coefficient: 0.15, roughness, f0: 0.6 }],
            colors: ColorTable::white(),
            flakes: None,
            provenance: serde_json::Value::Null,
        })
        .unwrap()
    }

    fn numbers(k: u32) -> [f32; 3] {
        let [a, b, c, _] = pcg4d([k, 5, 6, 7]);
        [a, b, c].map(unit)
    }

    /// Weights f cos / density of n directions: mean, and standard deviation over it.
    fn weights(paint: &RenderPaint, wo: Vec3, draw: impl Fn(u32) -> (Vec3, f32), n: u32) -> (f64, f64) {
        let (mut sum, mut squares) = (0.0, 0.0);
        for k in 0..n {
            let (wi, density) = draw(k);
            let f = shade_mean(paint, wi, wo) + paint.coat.gloss(wi, wo, 0.0);
            let weight = if wi.z > 0.0 { f64::from(f.x * wi.z / density) } else { 0.0 };
            sum += weight;
            squares += weight * weight;
        }
        let mean = sum / f64::from(n);
        (mean, (squares / f64::from(n) - mean * mean).max(0.0).sqrt() / mean)
    }

    #[test]
    fn albedos_are_those_of_the_cosine_law_and_weights_are_even() {
        for (roughness, refracts) in [(0.3, false), (0.2, true), (1e-4, false)] {
            let paint = paint(roughness, refracts);
            let directions = Directions::new(&paint);
            for angle in [0.02f32, 0.7, 1.2] {
                let wo = Vec3::new(-0.6 * angle.sin(), 0.8 * angle.sin(), angle.cos());
                let n = 40_000;
                let whole = |k| {
                    let wi = directions.sample(wo, numbers(k));
                    (wi, directions.density(wi, wo))
                };
                let (mean, spread) = weights(&paint, wo, whole, n);
                assert!(mean.is_finite() && spread < 0.6, "{roughness} {angle}: {spread}");
                if roughness < 0.1 {
                    continue;
                }
                // Narrow gloss is seldom hit by the cosine law: leave it out of the comparison.
                let dull = RenderPaint {
                    coat: crate::render::RenderCoat { gloss: None, ..paint.coat },
                    ..paint.clone()
                };
                let (mean, spread) = weights(&dull, wo, whole, n);
                let lambert = |k| {
                    let [_, a, b] = numbers(k);
                    let wi = cosine(a, b);
                    (wi, wi.z * FRAC_1_PI)
                };
                let (expected, scatter) = weights(&dull, wo, lambert, n);
                // Four standard errors.
                let error = 4.0 * spread.hypot(scatter) / f64::from(n).sqrt();
                assert!((mean / expected - 1.0).abs() < error, "{roughness} {angle}: {mean} {expected}");
            }
        }
    }

    #[test]
    fn densities_integrate_to_the_share_above_the_horizon() {
        let paint = paint(0.25, true);
        let directions = Directions::new(&paint);
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let n = 200_000;
        let lambert = |k| cosine(numbers(k)[1], numbers(k)[2]);
        let integral: f64 = (0..n)
            .map(|k| {
                let wi = lambert(k);
                f64::from(directions.density(wi, wo) / (wi.z * FRAC_1_PI)) / f64::from(n)
            })
            .sum();
        let above =
            (0..n).filter(|k| directions.sample(wo, numbers(*k)).z > 0.0).count() as f64 / f64::from(n);
        // The gloss lobe, a twentieth of the draws, is rarely met by the cosine law: its weights scatter by some hundred.
        assert!((integral - above).abs() < 0.05, "{integral} {above}");
    }

    #[test]
    fn a_black_paint_falls_back_to_the_cosine_law() {
        let mut black = paint(0.3, false);
        black.diffuse = 0.0;
        black.lobes.clear();
        black.coat.gloss = None;
        let directions = Directions::new(&black);
        let wo = Vec3::new(0.0, 0.6, 0.8);
        let wi = directions.sample(wo, [0.5, 0.3, 0.9]);
        assert!((directions.density(wi, wo) - wi.z * FRAC_1_PI).abs() < 1e-6);
    }
}
