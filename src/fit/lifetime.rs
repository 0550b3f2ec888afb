//! How far the half vector turns until a flake has gone out, solved from the slices of a flake BTF.
//!
//! All slices of a BTF show the same flakes, so texels of two slices correlate as far as flakes seen in one are seen in the
//! other. A renderer draws Q(Phi(g)), Q the quantile function of a slice and g a Gaussian field over projected half vectors
//! ([`KnotLattice`](crate::math::knots::KnotLattice)), whose knots are to lie such that draws correlate alike.
//! The correlation of draws needs no drawing: with Hermite polynomials, orthonormal under the normal law,
//! `cov(Q(Phi(g)), Q'(Phi(g'))) = sum_n a_n a'_n r^n` for a correlation r of g and g' (Mehler's formula).

use super::cells::Cells;
use super::field_correlation::FieldCorrelation;
use crate::brdf::projected_half;
use crate::btf::FlakeSlice;
use crate::cluster::{Series, SliceStatistics};
use crate::color::luminance;
use crate::error::Result;
use crate::math::normal::probit;
use crate::paint::Knots;
use crate::parallel::TryMap;
use glam::{DVec3, Vec2};
use rayon::prelude::*;

/// What becomes of flakes as the half vector turns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Lifetime {
    /// They go out as those of the source do.
    #[default]
    Solve,
    /// They go out with knots of this spacing and the usual compression, see [`Knots`].
    Fixed(f64),
    /// They never go out.
    Endless,
}

/// Orders of the series, from 0 on: correlations of up to 0.95 lose nothing of weight.
pub(super) const ORDERS: usize = 64;
/// Texels of a slice that are compared: enough for a correlation to within 0.01.
const TEXELS: usize = 1 << 16;
/// Farthest slices compared, as projected half vectors: 22 degrees inside the lacquer, three times a usual flake's lobe.
const REACH: f32 = 0.39;
/// Spacings and compressions between which the solution lies; the presets have 0.08 to 0.1 and 2.2 to 6.1.
const SPACINGS: [f64; 2] = [1e-3, 4.0];
const COMPRESSIONS: [f64; 2] = [0.0, 16.0];
/// A compression is solved from pairs beyond so many times the mean square of the half vectors' distance from the normal,
const FAR: f64 = 2.0;
/// whose lit texels are this many: their correlation is known to within a tenth.
const LEAST_LIT: f64 = 100.0;

/// Two slices of a row: how their texels correlate, and how draws would.
#[derive(Clone)]
struct Pair {
    /// Their projected half vectors.
    halves: [Vec2; 2],
    /// Correlation of the texels.
    correlation: f64,
    /// `c (1 - c)`, c the correlation, 0 or more: largest half way down, where the width of the curve is read.
    slope: f64,
    energy: f64,
    /// How many texels share the light.
    lit_texels: f64,
    /// Correlation of draws, as a series in the correlation of g.
    series: [f64; ORDERS],
}

impl Pair {
    /// Square of the distance of the half vectors' middle from the normal.
    fn square(&self) -> f64 {
        f64::from((0.5 * (self.halves[0] + self.halves[1])).length_squared())
    }

    /// By how much more draws correlate than the texels.
    fn excess(&self, field: &FieldCorrelation, knots: &Knots) -> f64 {
        let [one, two] = self.halves.map(|half| knots.map().place(half));
        field.sum(&self.series, one.distance(two).into()) - self.correlation
    }
}

/// The knots with which draws from `slices`, the statistics of the finest level, correlate as the texels do; none where no two
/// slices of a row hold flakes that are alike at all. The spacing is 1e-3 to 4, the compression 0 to 16.
///
/// Both are solved by bisection on a mean difference of the correlations. For the spacing, it is weighted by the energy of the
/// slices: those that are seen count. Where the grid is so coarse that flakes are out by the next slice, what little is left
/// of them in it decides. For the compression, which says how lifetimes change from there to the slices far from the normal,
/// these are weighted by their lit texels, as precisely as each is known; if hardly any are lit, it is the usual.
///
/// # Errors
/// Those of the source.
pub(super) fn knots(cells: &Cells, slices: &[SliceStatistics]) -> Result<Option<Knots>> {
    let rows = (0..cells.grid().rows().len()).into_par_iter().try_map(|row| row_pairs(cells, slices, row))?;
    let pairs = rows.concat();
    let weight = |p: &Pair| p.energy * p.slope;
    let total: f64 = pairs.iter().map(weight).sum();
    if total <= 0.0 {
        return Ok(None);
    }
    let field = FieldCorrelation::new();
    let spaced = |compression: f64| {
        let [low, high] = SPACINGS.map(f64::ln);
        let spacing = bisected(low, high, 32, |s| {
            let knots = Knots { spacing: s.exp(), compression };
            pairs.iter().map(|p| weight(p) * p.excess(&field, &knots)).sum()
        });
        Knots { spacing: spacing.exp(), compression }
    };
    let mean_square = pairs.iter().map(|p| weight(p) * p.square()).sum::<f64>() / total;
    let far: Vec<&Pair> = pairs.iter().filter(|p| p.square() > FAR * mean_square).collect();
    let lit: f64 = far.iter().map(|p| p.lit_texels * p.slope).sum();
    if lit < LEAST_LIT {
        return Ok(Some(spaced(Knots::USUAL_COMPRESSION)));
    }
    let [low, high] = COMPRESSIONS;
    Ok(Some(spaced(bisected(low, high, 16, |compression| {
        let knots = spaced(compression);
        far.iter().map(|p| p.lit_texels * p.slope * p.excess(&field, &knots)).sum()
    }))))
}

/// Where a rising function is 0, or the end that is nearer to it, after so many halvings.
fn bisected(mut low: f64, mut high: f64, halvings: u32, excess: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        *(if excess(middle) > 0.0 { &mut high } else { &mut low }) = middle;
    }
    0.5 * (low + high)
}

/// All pairs of slices of a row of the grid near enough to be compared.
fn row_pairs(cells: &Cells, slices: &[SliceStatistics], row: usize) -> Result<Vec<Pair>> {
    let grid = cells.grid();
    let numbers: Vec<usize> = (0..grid.rows()[row]).filter_map(|theta_h| grid.slice(theta_h, row)).collect();
    let sources: Vec<Texels> =
        numbers.iter().map(|k| Ok(Texels::of(&*cells.slice(*k)?))).collect::<Result<_>>()?;
    let series: Vec<_> = numbers.iter().map(|k| Series::<ORDERS>::of(&slices[*k], probit)).collect();
    let halves: Vec<Vec2> = numbers.iter().map(|k| half(cells, *k)).collect();
    let mut pairs = Vec::new();
    for one in 0..numbers.len() {
        for two in one + 1..numbers.len() {
            // The next slice is always looked at.
            if two > one + 1 && halves[one].distance(halves[two]) > REACH {
                break;
            }
            let correlation = sources[one].correlation(&sources[two]);
            let slope = correlation * (1.0 - correlation);
            if slope > 0.0 {
                pairs.push(Pair {
                    halves: [halves[one], halves[two]],
                    correlation,
                    slope,
                    energy: sources[one].deviation * sources[two].deviation,
                    lit_texels: (sources[one].lit_texels * sources[two].lit_texels).sqrt(),
                    series: series[one].correlation(&series[two]),
                });
            }
        }
    }
    Ok(pairs)
}

/// Projected half vector of a cell.
fn half(cells: &Cells, k: usize) -> Vec2 {
    let (wi, wo) = cells.outer(k);
    projected_half(wi.as_vec3(), wo.as_vec3())
}

/// Luminances of a slice less their mean.
struct Texels {
    values: Vec<f32>,
    /// Root of the mean square.
    deviation: f64,
    /// How many share the light evenly, n m_2^2 / m_4 by the central moments m: to one over its root a correlation is known.
    lit_texels: f64,
}

impl Texels {
    fn of(slice: &FlakeSlice) -> Self {
        let luminances = slice.fluctuation.iter().take(TEXELS);
        let values: Vec<f64> = luminances.map(|t| luminance(DVec3::from(t.map(f64::from)))).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let moment = |power: i32| values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / n;
        // What differs in the last places of f32 only is even.
        let is_even = moment(2).sqrt() <= 1e-6 * mean.abs();
        let [square, fourth] = if is_even { [0.0; 2] } else { [moment(2), moment(4)] };
        Self {
            values: values.iter().map(|v| (v - mean) as f32).collect(),
            deviation: square.sqrt(),
            lit_texels: if fourth > 0.0 { n * square * square / fourth } else { 0.0 },
        }
    }

    /// 0 where one has no contrast.
    fn correlation(&self, other: &Self) -> f64 {
        let products = self.values.iter().zip(&other.values).map(|(a, b)| f64::from(*a) * f64::from(*b));
        let scale = self.deviation * other.deviation * self.values.len() as f64;
        if scale > 0.0 { products.sum::<f64>() / scale } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::Cluster;
    use crate::math::hash::{pcg4d, unit};
    use crate::math::normal::{cdf, probit};
    use crate::sampler::{Sampler, color};

    const DRAWS: u32 = 100_000;

    #[test]
    fn what_differs_in_the_last_places_of_f32_has_no_contrast() {
        let of = |step: f32| {
            let fluctuation = (0..64).map(|k| [0.3 + step * (k % 2) as f32; 3]).collect();
            Texels::of(&FlakeSlice { fluctuation, expectation: [0.0; 3] })
        };
        for step in [0.0, 3e-8] {
            assert_eq!((of(step).deviation, of(step).lit_texels), (0.0, 0.0));
        }
        // Two equal halves share the light evenly.
        assert!((of(1e-3).lit_texels - 64.0).abs() < 1e-3);
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
        let series = Series::<ORDERS>::of(&slices[0], probit).correlation(&Series::of(&slices[1], probit));
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
