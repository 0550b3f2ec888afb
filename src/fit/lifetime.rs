//! How far the half vector turns until a flake has gone out, solved from the slices of a flake BTF.
//!
//! All slices of a BTF show the same flakes, so texels of two slices correlate as far as flakes seen in one are seen in the
//! other. A renderer draws Q(Phi(g)), Q the quantile function of a slice and g a Gaussian field over projected half vectors
//! ([`KnotLattice`](crate::math::knots::KnotLattice)), whose spacing of knots is to be such that draws correlate alike.
//! The correlation of draws needs no drawing: with Hermite polynomials, orthonormal under the normal law,
//! `cov(Q(Phi(g)), Q'(Phi(g'))) = sum_n a_n a'_n r^n` for a correlation r of g and g' (Mehler's formula).

use super::hermite::{ORDERS, Series};
use crate::brdf::projected_half;
use crate::btf::{AngleGrid, FlakeSlice, FlakeSource};
use crate::cluster::SliceStatistics;
use crate::color::luminance;
use crate::error::Result;
use crate::math::half_difference::directions;
use crate::math::knots::weights;
use glam::{DVec3, Vec2};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// What becomes of flakes as the half vector turns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Lifetime {
    /// They go out as those of the source do.
    #[default]
    Solve,
    /// They go out with knots of this spacing, see [`crate::paint::Flakes::knot_spacing`].
    Fixed(f64),
    /// They never go out.
    Endless,
}

/// Texels of a slice that are compared: enough for a correlation to within 0.01.
const TEXELS: usize = 1 << 16;
/// Farthest slices compared, as projected half vectors: 20 degrees inside the lacquer or more, three times a usual flake's
/// lobe.
const REACH: f32 = 0.35;
/// Spacings between which the solution lies.
const SPACINGS: [f64; 2] = [1e-3, 4.0];

/// Two slices of a row: how their texels correlate, and how draws would.
#[derive(Clone)]
struct Pair {
    /// Distance of their projected half vectors.
    distance: f64,
    /// Correlation of the texels.
    correlation: f64,
    weight: f64,
    /// Correlation of draws, as a series in the correlation of g.
    series: [f64; ORDERS],
}

/// The spacing of knots with which draws from `slices`, the statistics of the finest level, correlate as the texels do,
/// 1e-3 to 4; none where no two slices of a row hold flakes that are alike at all.
///
/// Solved by bisection on the mean difference of the correlations. It is weighted by the energy of the slices, and by
/// `c (1 - c)`, c the texels' correlation: largest half way down, where the width of the curve is read. Where the grid is so
/// coarse that flakes are out by the next slice, what little is left of them in it decides.
///
/// # Errors
/// Those of the source.
pub fn knot_spacing(btf: &dyn FlakeSource, slices: &[SliceStatistics]) -> Result<Option<f64>> {
    let rows: Vec<Vec<Pair>> = (0..btf.grid().rows().len())
        .into_par_iter()
        .map(|row| row_pairs(btf, slices, row))
        .collect::<Result<_>>()?;
    let pairs = rows.concat();
    let total: f64 = pairs.iter().map(|p| p.weight).sum();
    if total <= 0.0 {
        return Ok(None);
    }
    let field = FieldCorrelation::new();
    let excess = |spacing: f64| -> f64 {
        let of = |p: &Pair| p.weight * (field.sum(&p.series, p.distance / spacing) - p.correlation);
        pairs.iter().map(of).sum()
    };
    let [mut low, mut high] = SPACINGS.map(f64::ln);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if excess(middle.exp()) > 0.0 { &mut high } else { &mut low }) = middle;
    }
    Ok(Some((0.5 * (low + high)).exp()))
}

/// All pairs of slices of a row of the grid near enough to be compared.
fn row_pairs(btf: &dyn FlakeSource, slices: &[SliceStatistics], row: usize) -> Result<Vec<Pair>> {
    let grid = btf.grid();
    let numbers: Vec<usize> = (0..grid.rows()[row]).filter_map(|theta_h| grid.slice(theta_h, row)).collect();
    let sources: Vec<Texels> =
        numbers.iter().map(|k| Ok(Texels::of(&*btf.slice(*k)?))).collect::<Result<_>>()?;
    let series: Vec<Series> = numbers.iter().map(|k| Series::of(&slices[*k])).collect();
    let halves: Vec<Vec2> = numbers.iter().map(|k| half(grid, *k)).collect();
    let mut pairs = Vec::new();
    for one in 0..numbers.len() {
        for two in one + 1..numbers.len() {
            let distance = halves[one].distance(halves[two]);
            // The next slice is always looked at.
            if two > one + 1 && distance > REACH {
                break;
            }
            let correlation = sources[one].correlation(&sources[two]);
            let energy = sources[one].deviation * sources[two].deviation;
            let weight = energy * (correlation * (1.0 - correlation)).max(0.0);
            if weight > 0.0 {
                let series = series[one].correlation(&series[two]);
                pairs.push(Pair { distance: distance.into(), correlation, weight, series });
            }
        }
    }
    Ok(pairs)
}

/// Projected half vector of a slice.
fn half(grid: &AngleGrid, slice: usize) -> Vec2 {
    let (theta_h, theta_i) = grid.angles(slice);
    let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
    projected_half(wi.as_vec3(), wo.as_vec3())
}

/// Luminances of a slice less their mean.
struct Texels {
    values: Vec<f32>,
    /// Root of the mean square.
    deviation: f64,
}

impl Texels {
    fn of(slice: &FlakeSlice) -> Self {
        let luminances = slice.fluctuation.iter().take(TEXELS);
        let values: Vec<f64> = luminances.map(|t| luminance(DVec3::from(t.map(f64::from)))).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        Self { values: values.iter().map(|v| (v - mean) as f32).collect(), deviation: square.sqrt() }
    }

    /// 0 where one has no contrast.
    fn correlation(&self, other: &Self) -> f64 {
        let products = self.values.iter().zip(&other.values).map(|(a, b)| f64::from(*a) * f64::from(*b));
        let scale = self.deviation * other.deviation * self.values.len() as f64;
        if scale > 0.0 { products.sum::<f64>() / scale } else { 0.0 }
    }
}

/// Mean powers of the correlation of a field of knots at two places, over all positions and turns of the lattice: row by
/// row for distances in steps of a [`FieldCorrelation::STEPS`]th of the spacing.
struct FieldCorrelation {
    powers: Vec<[f64; ORDERS]>,
}

impl FieldCorrelation {
    const STEPS: usize = 40;
    /// Farther than the diagonals of two squares nothing is left.
    const REACH: usize = 3;
    const OFFSETS: u16 = 10;
    /// Turns over an eighth of a circle: the lattice is its own mirror image.
    const TURNS: u16 = 5;

    fn new() -> Self {
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
    fn sum(&self, series: &[f64; ORDERS], distance: f64) -> f64 {
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
    use crate::cluster::Cluster;
    use crate::math::hash::{pcg4d, unit};
    use crate::math::knots::KnotLattice;
    use crate::math::normal::{cdf, probit};
    use crate::sampler::{Sampler, color};

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

    #[test]
    fn the_series_is_the_correlation_of_draws() {
        let slice = |bright: f64, lightness: f32| {
            let cluster = |probability, l: f32, half: f32| Cluster {
                probability,
                min: [l - half, -3.0, 0.0],
                max: [l + half, 5.0, 1.0],
            };
            let clusters = vec![
                cluster(0.6, 5.0, 5.0),
                cluster(0.4 - bright, 30.0, 4.0),
                cluster(bright, lightness, 20.0),
            ];
            SliceStatistics::new(clusters, [0.1, 0.2, 0.3])
        };
        let slices = [slice(0.05, 150.0), slice(0.15, 90.0)];
        let series = Series::of(&slices[0]).correlation(&Series::of(&slices[1]));
        let samplers = slices.each_ref().map(|s| Sampler::exact(s).unwrap());
        for r in [0.0, 0.4, 0.85] {
            let pairs = (0..DRAWS).map(|k| {
                let [a, b, x, y] = pcg4d([k, 1, 2, 3]).map(unit);
                let g = probit(a.into());
                let other = r * g + (1.0 - r * r).sqrt() * probit(b.into());
                [(0, g), (1, other)].map(|(n, g)| {
                    let drawn = color(&slices[n], &samplers[n], cdf(g) as f32, [x, y, 0.5]);
                    luminance(DVec3::from(drawn.map(f64::from))) as f32
                })
            });
            let (one, two): (Vec<f32>, Vec<f32>) = pairs.map(|[a, b]| (a, b)).unzip();
            let texels = |values: Vec<f32>| {
                Texels::of(&FlakeSlice {
                    fluctuation: values.into_iter().map(|v| [v; 3]).collect(),
                    expectation: [0.0; 3],
                })
            };
            let seen = texels(one).correlation(&texels(two));
            let exact: f64 = series.iter().enumerate().map(|(n, a)| a * f64::powi(r, n as i32)).sum();
            // 65,536 pairs with a kurtosis of about 15: four standard errors.
            assert!((seen - exact).abs() < 0.03, "{r}: {seen} {exact}");
        }
    }
}
