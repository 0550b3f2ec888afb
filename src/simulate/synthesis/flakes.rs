//! Explicit flakes on a texture that repeats.
//!
//! A flake has a place, an area, a normal and a depth, independent of each other and of all other flakes; the number of
//! flakes is Poisson distributed about its mean, so that any part of the texture has the statistics of Ershov 2001,
//! section 7, whose count in a pixel is a Poisson deviate (a fixed total would correlate the texels).

use super::disc::cover_disc;
use crate::error::{Error, Result};
use crate::math::hash::{pcg4d, unit};
use crate::simulate::composition::FlakeKind;
use crate::simulate::optics::orientation::Orientation;
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
    /// Place, in texels, seen from straight above.
    pub center: [f64; 2],
    /// Radius, in texels.
    pub radius: f64,
    /// Which of its kind's classes of equal optics it belongs to.
    pub class: usize,
    /// End of its texels in the list.
    end: usize,
}

impl Flakes {
    /// Most flakes on a texture, all kinds together. A flake takes 72 bytes and 8 for each texel it covers or cuts: 1.2 GB for
    /// this many of 1.5 texels. As flakes cover the paint at most tenfold, 3 GB is never exceeded.
    pub const MAX: f64 = 1e7;

    /// Expected number of flakes of one kind on a texture of `size` texels of side `texel_um`.
    pub fn expected(kind: &FlakeKind, size: [usize; 2], texel_um: f64) -> f64 {
        kind.area_density * (size[0] as f64 * texel_um) * (size[1] as f64 * texel_um) / kind.mean_area_um2()
    }

    /// Draws the flakes of one kind on a texture of `size` texels of side `texel_um`; `classes` are the shares of its classes
    /// of equal optics (coating thicknesses), `stream` the seed and the number of the kind. Kinds and seeds are independent:
    /// the generator starts from a hash of both.
    ///
    /// # Errors
    /// More than [`Flakes::MAX`] flakes; flakes wider than a quarter of the texture, whose repetition would show.
    pub fn draw(
        kind: &FlakeKind,
        orientation: &Orientation,
        classes: &[f64],
        size: [usize; 2],
        texel_um: f64,
        stream: (u64, u32),
    ) -> Result<Self> {
        let sides = size.map(|n| n as f64 * texel_um);
        let widest = 0.25 * sides[0].min(sides[1]);
        if kind.diameter_um > widest {
            let legal = format!("up to {widest:.3} um, a quarter of the texture");
            return Err(Error::invalid("synthesis", "diameter_um of flakes", kind.diameter_um, legal));
        }
        let mean = Self::expected(kind, size, texel_um);
        Self::check_number(mean)?;
        let mut rng = generator(stream);
        // A Poisson law has a positive mean: no flakes need no draw.
        let count = Poisson::new(mean).map_or(0.0, |law| law.sample(&mut rng));
        let variance = kind.diameter_spread.powi(2).ln_1p();
        let log_diameter = (kind.diameter_um / texel_um).ln() - 0.5 * variance;
        let diameters = LogNormal::new(log_diameter, variance.sqrt())
            .map_err(|e| Error::invalid("synthesis", "diameter_spread", e, "0 to 1"))?;
        let mut all = Self { flakes: Vec::with_capacity(count as usize), cover: Vec::new() };
        for k in 0..count as u32 {
            let center = size.map(|n| n as f64 * rng.random::<f64>());
            let radius = 0.5 * diameters.sample(&mut rng);
            let depth = rng.random();
            let normal = orientation.sample(&mut rng);
            cover_disc(center, radius, size, &mut all.cover);
            // Its own hash: other classes leave places and normals as they are.
            let class = class(classes, f64::from(unit(hash(stream, k + 1)[0])));
            all.flakes.push(Flake { normal, depth, center, radius, class, end: all.cover.len() });
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

    /// Keeps the flakes alone: they may be moved afterwards.
    pub(super) fn forget_cover(&mut self) {
        self.cover = Vec::new();
        self.flakes.iter_mut().for_each(|flake| flake.end = 0);
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

impl Flake {
    /// Area, in texels.
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius
    }
}

/// Random numbers of one kind of flakes.
fn generator(stream: (u64, u32)) -> Pcg64 {
    // Streams of one state differ in their increment alone and stay related; a hash of both leaves nothing in common.
    let [a, b, ..] = hash(stream, 0);
    Pcg64::seed_from_u64(u64::from(a) << 32 | u64::from(b))
}

fn hash((seed, kind): (u64, u32), counter: u32) -> [u32; 4] {
    pcg4d([seed as u32, (seed >> 32) as u32, kind, counter])
}

/// The class that a random number in (0, 1) falls into.
pub(in crate::simulate) fn class(shares: &[f64], random: f64) -> usize {
    let mut left = random;
    let found = shares.iter().position(|share| {
        left -= share;
        left < 0.0
    });
    // Shares that sum to just below 1.
    found.unwrap_or(shares.len().saturating_sub(1))
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
                        let mut one = generator((seed, number));
                        let mut two = generator((seed + other.0, number.wrapping_add(other.1)));
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

    #[test]
    fn classes_are_drawn_by_their_shares() {
        let shares = [0.2, 0.0, 0.5, 0.3];
        let n = 100_000;
        let mut counts = [0.0; 4];
        (0..n).for_each(|k| counts[class(&shares, f64::from(unit(hash((1, 2), k)[0])))] += 1.0);
        for (count, share) in counts.iter().zip(shares) {
            let n = f64::from(n);
            // Four standard errors of a binomial count.
            assert!((count - n * share).abs() <= 4.0 * (n * share * (1.0 - share)).sqrt(), "{counts:?}");
        }
    }
}
