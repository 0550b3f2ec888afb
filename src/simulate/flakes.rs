//! Explicit flakes on a texture that repeats.
//!
//! A flake has a place, an area, a normal and a depth, independent of each other and of all other flakes; the number of
//! flakes is Poisson distributed about its mean, so that any part of the texture has the statistics of Ershov 2001,
//! section 7, whose count in a pixel is a Poisson deviate (a fixed total would correlate the texels).

use super::composition::FlakeKind;
use super::disc::cover_disc;
use super::orientation::Orientation;
use crate::error::{Error, Result};
use crate::math::hash::pcg4d;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, LogNormal, Poisson};
use rand_pcg::Pcg64;

/// All flakes of one kind.
#[derive(Debug, Clone)]
pub struct Flakes {
    /// The flakes, in the order drawn.
    pub flakes: Vec<Flake>,
    /// Texel and covered share, flake after flake.
    cover: Vec<(u32, f32)>,
}

/// One flake.
#[derive(Debug, Clone, Copy)]
pub struct Flake {
    /// Unit normal, upper hemisphere.
    pub normal: DVec3,
    /// Depth below the surface over the film's thickness, in [0, 1).
    pub depth: f64,
    /// Area, in texels.
    pub area: f64,
    /// End of its texels in the list.
    end: usize,
}

impl Flakes {
    /// Most flakes on a texture, all kinds together. A flake takes 48 bytes and 8 for each texel it covers or cuts: 1 GB for
    /// this many of 1.5 texels. As flakes cover the paint at most tenfold, 3 GB is never exceeded.
    pub const MAX: f64 = 1e7;

    /// Expected number of flakes of one kind on a texture of `size` texels of side `texel_um`.
    pub fn expected(kind: &FlakeKind, size: [usize; 2], texel_um: f64) -> f64 {
        kind.area_density * (size[0] as f64 * texel_um) * (size[1] as f64 * texel_um) / kind.mean_area_um2()
    }

    /// Draws the flakes of one kind on a texture of `size` texels of side `texel_um`; `number` is that of the kind. Kinds
    /// and seeds are independent: the generator starts from a hash of both.
    ///
    /// # Errors
    /// More than [`Flakes::MAX`] flakes; flakes wider than a quarter of the texture, whose repetition would show.
    pub fn draw(
        kind: &FlakeKind,
        orientation: &Orientation,
        size: [usize; 2],
        texel_um: f64,
        seed: u64,
        number: u32,
    ) -> Result<Self> {
        let sides = size.map(|n| n as f64 * texel_um);
        let widest = 0.25 * sides[0].min(sides[1]);
        if kind.diameter_um > widest {
            let legal = format!("up to {widest:.3} um, a quarter of the texture");
            return Err(Error::invalid("synthesis", "diameter_um of flakes", kind.diameter_um, legal));
        }
        let mean = Self::expected(kind, size, texel_um);
        Self::check_number(mean)?;
        let mut rng = generator(seed, number);
        // A Poisson law has a positive mean: no flakes need no draw.
        let count = Poisson::new(mean).map_or(0.0, |law| law.sample(&mut rng));
        let variance = kind.diameter_spread.powi(2).ln_1p();
        let log_diameter = (kind.diameter_um / texel_um).ln() - 0.5 * variance;
        let diameters = LogNormal::new(log_diameter, variance.sqrt())
            .map_err(|e| Error::invalid("synthesis", "diameter_spread", e, "0 to 1"))?;
        let mut all = Self { flakes: Vec::with_capacity(count as usize), cover: Vec::new() };
        for _ in 0..count as u64 {
            let center = size.map(|n| n as f64 * rng.random::<f64>());
            let radius = 0.5 * diameters.sample(&mut rng);
            let depth = rng.random();
            let normal = orientation.sample(&mut rng);
            cover_disc(center, radius, size, &mut all.cover);
            let area = std::f64::consts::PI * radius * radius;
            all.flakes.push(Flake { normal, depth, area, end: all.cover.len() });
        }
        Ok(all)
    }

    /// Refuses more than [`Flakes::MAX`] expected flakes.
    ///
    /// # Errors
    /// The number and the legal range.
    pub fn check_number(expected: f64) -> Result<()> {
        if expected <= Self::MAX {
            return Ok(());
        }
        let legal = format!("0 to {}: fewer or smaller texels", Self::MAX);
        Err(Error::invalid("synthesis", "flakes on the texture, all kinds", expected.round(), legal))
    }

    /// Every flake with the texels it covers and the share of each.
    pub fn iter(&self) -> impl Iterator<Item = (&Flake, &[(u32, f32)])> {
        let mut start = 0;
        self.flakes.iter().map(move |flake| {
            let texels = &self.cover[start..flake.end];
            start = flake.end;
            (flake, texels)
        })
    }
}

/// Random numbers of one kind of flakes.
fn generator(seed: u64, number: u32) -> Pcg64 {
    // Streams of one state differ in their increment alone and stay related; a hash of both leaves nothing in common.
    let [a, b, ..] = pcg4d([seed as u32, (seed >> 32) as u32, number, 0]);
    Pcg64::seed_from_u64(u64::from(a) << 32 | u64::from(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_and_seeds_are_independent() {
        let n = 1 << 14;
        // The next kind, the next seed, the next seed's kind before, the seed's other half.
        for other in [(0, 1), (1, 0), (1, u32::MAX), (1 << 32, 0)] {
            for step in [1, 4] {
                let covariance: f64 = (0..n)
                    .map(|k| {
                        let (seed, number) = (k / 4, (k % 4) as u32);
                        let mut one = generator(seed, number);
                        let mut two = generator(seed + other.0, number.wrapping_add(other.1));
                        let draw =
                            |rng: &mut Pcg64| (0..step).map(|_| rng.random::<f64>()).last().unwrap() - 0.5;
                        draw(&mut one) * draw(&mut two)
                    })
                    .sum();
                // Each product has variance 1/144: four standard errors.
                assert!(covariance.abs() < 4.0 * (n as f64).sqrt() / 12.0, "{other:?} {step}: {covariance}");
            }
        }
    }
}
