//! How a Gaussian field of knots forgets with the distance.

use super::lifetime::ORDERS;
use crate::math::knots::weights;
use glam::Vec2;
use rayon::prelude::*;

/// Mean powers of the correlation of a field of knots at two places, over all positions and turns of the lattice: row by
/// row for distances in steps of a [`FieldCorrelation::STEPS`]th of the spacing.
pub(super) struct FieldCorrelation {
    powers: Vec<[f64; ORDERS]>,
}

impl FieldCorrelation {
    const STEPS: usize = 40;
    /// Farther than the diagonals of two squares nothing is left.
    const REACH: usize = 3;
    const OFFSETS: u16 = 10;
    /// Turns over an eighth of a circle: the lattice is its own mirror image.
    const TURNS: u16 = 5;

    pub fn new() -> Self {
        let powers = (0..=Self::STEPS * Self::REACH).into_par_iter().map(|k| {
            let distance = k as f32 / Self::STEPS as f32;
            let mut sum = [0.0; ORDERS];
            for turn in 0..Self::TURNS {
                let angle = (f32::from(turn) + 0.5) / f32::from(Self::TURNS) * std::f32::consts::FRAC_PI_4;
                for place in 0..Self::OFFSETS * Self::OFFSETS {
                    let [x, y] = [place % Self::OFFSETS, place / Self::OFFSETS];
                    let from = (Vec2::new(x.into(), y.into()) + 0.5) / f32::from(Self::OFFSETS);
                    let r = correlation(from, from + Vec2::from_angle(angle) * distance);
                    sum.iter_mut().fold(1.0, |power, s| {
                        *s += power;
                        power * r
                    });
                }
            }
            let count = f64::from(Self::TURNS * Self::OFFSETS * Self::OFFSETS);
            sum.map(|s| s / count)
        });
        Self { powers: powers.collect() }
    }

    /// Sum of a series in E r^n at a distance in spacings.
    pub fn sum(&self, series: &[f64; ORDERS], distance: f64) -> f64 {
        let at = (distance * Self::STEPS as f64).min((self.powers.len() - 1) as f64);
        let row = (at as usize).min(self.powers.len() - 2);
        let of = |row: usize| series.iter().zip(&self.powers[row]).map(|(a, power)| a * power).sum::<f64>();
        let part = at - row as f64;
        (1.0 - part) * of(row) + part * of(row + 1)
    }
}

/// Correlation of the field at two places of an upright lattice: knots that both use.
fn correlation(one: Vec2, two: Vec2) -> f64 {
    let (here, there) = (one.floor(), two.floor());
    let (near, far) = (weights(one - here), weights(two - there));
    let step = [there.x - here.x, there.y - here.y].map(|c| c as i32);
    let mut sum = 0.0;
    for k in 0..4i32 {
        let [x, y] = [(k & 1) - step[0], (k >> 1) - step[1]];
        if (0..2).contains(&x) && (0..2).contains(&y) {
            sum += near[k as usize] * far[(x + 2 * y) as usize];
        }
    }
    sum.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::pcg4d;
    use crate::math::knots::KnotLattice;

    const DRAWS: u32 = 100_000;

    #[test]
    fn the_table_of_powers_is_that_of_the_field() {
        let field = FieldCorrelation::new();
        for distance in [0.0, 0.37, 0.8, 1.3, 2.9] {
            let (mut first, mut second) = (0.0, 0.0);
            for k in 0..DRAWS {
                let lattice = KnotLattice::new(pcg4d([k, 4, 5, 6]));
                let at = |x: f32| f64::from(lattice.value(Vec2::new(x, 0.3)));
                let (a, b) = (at(-0.2), at(-0.2 + distance));
                first += a * b / f64::from(DRAWS);
                // E He_2(a) He_2(b) = 2 r^2.
                second += (a * a - 1.0) * (b * b - 1.0) / (2.0 * f64::from(DRAWS));
            }
            let exact = |n: usize| {
                let mut series = [0.0; ORDERS];
                series[n] = 1.0;
                field.sum(&series, distance.into())
            };
            // Four standard errors: products deviate by up to 1.4, of squares by up to 7 / 2.
            assert!((first - exact(1)).abs() < 0.018, "{distance}: {first} {}", exact(1));
            assert!((second - exact(2)).abs() < 0.045, "{distance}: {second} {}", exact(2));
        }
    }
}
