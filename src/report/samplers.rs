//! Samplers of one slice side by side: cost, size and error.

use super::statistics::wasserstein;
use crate::cluster::SliceStatistics;
use crate::error::Result;
use crate::math::hash::{pcg4d, unit};
#[cfg(feature = "files")]
use crate::sampler::QuantileRow;
use crate::sampler::{ReconstructionError, ReconstructionSamples, Sampler, color, reconstruction_error_of};
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// One sampler of a slice.
#[derive(Debug, Clone, Serialize)]
pub struct SamplerCost {
    /// Which, and of how many steps.
    pub sampler: String,
    /// Time of a color, nanoseconds: look-up, box and conversion to RGB, one thread.
    pub nanoseconds: f64,
    /// Bytes of its tables.
    pub bytes: usize,
    /// Bytes of what else a color needs: the corners of the boxes, or nothing.
    pub box_bytes: usize,
    /// Half the sum of the differences between the probabilities of the clusters and those of its draws.
    pub total_variation: Option<f64>,
    /// Clusters that it never draws.
    pub lost: Option<usize>,
    /// Errors of its draws.
    pub error: ReconstructionError,
}

/// The exact sampler, the forward CDF, inverse CDFs and (with the feature `files`) rows of colors, of `steps` each, for the
/// statistics of these texels (linear Rec.709, 1/sr).
///
/// # Errors
/// A slice that was left out; steps outside 1-65,535; no texels.
pub fn sampler_costs(
    texels: &[[f32; 3]],
    statistics: &SliceStatistics,
    steps: &[usize],
    samples: ReconstructionSamples,
) -> Result<Vec<SamplerCost>> {
    let mut samplers = vec![
        ("guide table".to_owned(), Sampler::exact(statistics)?),
        ("forward CDF".to_owned(), Sampler::forward_cdf(statistics)?),
    ];
    for n in steps {
        samplers.push((format!("inverse CDF {n}"), Sampler::inverse_cdf(statistics, *n)?));
    }
    let mut table = Vec::new();
    for (name, sampler) in samplers {
        let draw = |u: f32, random: [f32; 3]| color(statistics, &sampler, u, random);
        let drawn = probabilities(statistics.clusters.len(), |u| sampler.lookup(u));
        let differences = drawn.iter().zip(&statistics.clusters).map(|(p, c)| (p - c.probability).abs());
        table.push(SamplerCost {
            sampler: name,
            nanoseconds: nanoseconds(draw),
            bytes: sampler.bytes(),
            box_bytes: 24 * statistics.clusters.len(),
            total_variation: Some(0.5 * differences.sum::<f64>()),
            lost: Some(drawn.iter().filter(|p| **p == 0.0).count()),
            error: reconstruction_error_of(texels, statistics, draw, samples, wasserstein)?,
        });
    }
    #[cfg(feature = "files")]
    for n in steps {
        let rows = [
            ("expected", QuantileRow::expected(statistics, *n)?),
            ("realized", QuantileRow::realized(statistics, *n, samples.seed)?),
        ];
        for (name, row) in rows {
            let draw = |u: f32, _: [f32; 3]| row.lookup(u);
            table.push(SamplerCost {
                sampler: format!("colors, {name} {n}"),
                nanoseconds: nanoseconds(draw),
                bytes: 6 * row.colors().len(),
                box_bytes: 0,
                total_variation: None,
                lost: None,
                error: reconstruction_error_of(texels, statistics, draw, samples, wasserstein)?,
            });
        }
    }
    Ok(table)
}

/// How often each cluster is drawn, by all u that a hash can give (2^23 of them).
fn probabilities(clusters: usize, lookup: impl Fn(f32) -> usize) -> Vec<f64> {
    const DRAWS: u32 = 1 << 23;
    let mut counts = vec![0u32; clusters];
    for k in 0..DRAWS {
        counts[lookup((k as f32 + 0.5) / DRAWS as f32)] += 1;
    }
    counts.into_iter().map(|n| f64::from(n) / f64::from(DRAWS)).collect()
}

/// Shortest of five means over some thousand draws.
fn nanoseconds(draw: impl Fn(f32, [f32; 3]) -> [f32; 3]) -> f64 {
    let random: Vec<[f32; 4]> = (0..16_384).map(|k| pcg4d([k, 3, 1, 4]).map(unit)).collect();
    let run = || {
        let start = Instant::now();
        for [u, r0, r1, r2] in &random {
            black_box(draw(*u, [*r0, *r1, *r2]));
        }
        1e9 * start.elapsed().as_secs_f64() / random.len() as f64
    };
    (0..5).map(|_| run()).fold(f64::INFINITY, f64::min)
}
