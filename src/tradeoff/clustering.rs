//! Statistics of slices: clusters, rule of boxes, sampler, level of detail.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve, curve_of_bytes};
use crate::cluster::{BoxRule, DEFAULT_CLUSTERS, SliceStatistics, cluster_slice};
use crate::color::lab_from_rgb;
use crate::error::Result;
use crate::fit::{SliceMean, SmoothFit, residual};
use crate::math::hash::{pcg4d, unit};
use crate::report::{energetic_slices, wasserstein};
use crate::rivals::{k_means, wu};
use crate::sampler::{ReconstructionSamples, Sampler, color, reconstruction_error};
use glam::DVec3;
use half::f16;
use std::f64::consts::PI;

pub(super) const CLUSTERS: [usize; 7] = [16, 25, 50, 100, 200, 400, 1024];
const STEPS: [usize; 6] = [125, 250, 500, 1000, 2000, 4000];
/// Colors drawn at a time.
const DRAWS: u32 = 100_000;
/// Look-ups by which samplers are judged: all numbers that keep their last bit as the middle of a step.
const SPREAD: u32 = 1 << 20;
/// Colors by which roundings are judged.
const ROUNDED_DRAWS: u32 = 10_000;
/// Bytes of the corners of a box, as single floats.
const BOX_BYTES: usize = 24;
/// Colors on either side of a distance, and how many distances are averaged.
pub(super) const DRAWN_COLORS: ReconstructionSamples =
    ReconstructionSamples { draws: 1, points: 500, repeats: 4, seed: 0 };

/// Statistics of the slices, and what draws from them.
type Reduced = Vec<(SliceStatistics, Sampler)>;

/// Texels to at most so many clusters.
type Quantizer = fn(&[[f32; 3]], usize) -> Result<SliceStatistics>;

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let (chain, smooth) = (&subject.chain, SmoothFit::from(&subject.chain.paint));
    let slices = energetic_slices(&chain.btf).into_iter().take(if effort.quick { 3 } else { 10 });
    let texels =
        slices.map(|k| residual(&chain.btf, &smooth, SliceMean::Residual, k)).collect::<Result<Vec<_>>>()?;
    // Flakes that show nothing.
    if texels.is_empty() {
        return Ok(Vec::new());
    }
    let reduced = |cluster: &dyn Fn(&[[f32; 3]]) -> Result<SliceStatistics>| -> Result<Reduced> {
        let one = |texels: &Vec<[f32; 3]>| {
            let statistics = cluster(texels)?;
            let sampler = Sampler::exact(&statistics)?;
            Ok((statistics, sampler))
        };
        texels.iter().map(one).collect()
    };
    let reduce = |clusters: usize, rule: BoxRule| reduced(&|texels| cluster_slice(texels, clusters, rule));
    let judge = |reduced: &Reduced| {
        let (mut error, mut bytes) = (0.0, 0.0);
        for (k, (texels, (statistics, sampler))) in texels.iter().zip(reduced).enumerate() {
            error += excess(texels, statistics, sampler, effort.seed.wrapping_add(4 * k as u32))?;
            bytes += (BOX_BYTES * statistics.clusters.len() + sampler.bytes()) as f64;
        }
        Ok((error / texels.len() as f64, Some(bytes / texels.len() as f64)))
    };
    const ERROR: &str = "Wasserstein-1 distance of drawn colors from texels above that of two draws of texels, Delta-E, the mean of the strongest slices";
    let head = |knob, why| Head { stage: "Statistics", knob, error: ERROR, why };
    let moments = BoxRule::MomentMatched;
    let clusters = CLUSTERS.map(|clusters| {
        Trial::new(clusters, clusters == DEFAULT_CLUSTERS, move || reduce(clusters, moments))
    });
    let rules = [("moment-matched", moments), ("bounding", BoxRule::Bounding)]
        .map(|(name, rule)| Trial::new(name, rule == moments, move || reduce(DEFAULT_CLUSTERS, rule)));
    let others: [(&str, Quantizer); 2] = [("Wu", wu), ("k-means", k_means)];
    let others = others.map(|(name, quantizer)| {
        Trial::new(name, false, move || reduced(&|texels| quantizer(texels, DEFAULT_CLUSTERS)))
    });
    let quantizers: Vec<Trial<Reduced>> =
        std::iter::once(Trial::new("cells, cut and merged", true, || reduce(DEFAULT_CLUSTERS, moments)))
            .chain(others)
            .collect();
    Ok(vec![
        curve(
            head(
                "clusters a slice (--clusters)",
                "Fifty keep a slice in a kilobyte or two within a just noticeable difference of its texels; transport costs grow with \
                 the square of their number, and what more clusters add is below the scatter of draws.",
            ),
            &clusters,
            *effort,
            judge,
        )?,
        curve(
            head(
                "boxes around clusters (--boxes)",
                "Boxes of the members' mean and variance keep the contrast of a slice; bounding boxes, as published, draw colors \
                 that few texels have.",
            ),
            &rules,
            *effort,
            judge,
        )?,
        curve(
            head(
                "how clusters are found, fifty of them",
                "Cells of Lab, cut at their means and merged by what that adds to the sum of n sigma, keep the rare bright \
                 flakes; k-means and Wu's quantizer lessen squared errors, spend clusters on what most texels look like, and look at \
                 every texel again for every round or cut.",
            ),
            &quantizers,
            *effort,
            judge,
        )?,
        corners(&texels, *effort)?,
        samplers(&texels[0], *effort)?,
    ])
}

/// Single and half floats as corners of boxes.
fn corners(texels: &[Vec<[f32; 3]>], effort: Effort) -> Result<Curve> {
    let single = texels
        .iter()
        .map(|texels| cluster_slice(texels, DEFAULT_CLUSTERS, BoxRule::MomentMatched))
        .collect::<Result<Vec<SliceStatistics>>>()?;
    let sampled = |half: bool| -> Result<Reduced> {
        let one = |statistics: &SliceStatistics| {
            let mut statistics = statistics.clone();
            if half {
                let corners = statistics.clusters.iter_mut().flat_map(|c| [&mut c.min, &mut c.max]);
                corners.flatten().for_each(|corner| *corner = f16::from_f32(*corner).to_f32());
            }
            let sampler = Sampler::exact(&statistics)?;
            Ok((statistics, sampler))
        };
        single.iter().map(one).collect()
    };
    let trials = [("single floats", false), ("half floats", true)]
        .map(|(name, half)| Trial::new(name, !half, move || sampled(half)));
    let head = Head {
        stage: "Statistics",
        knob: "corners of boxes in memory",
        error: "Wasserstein-1 distance of colors drawn from rounded boxes from those of single floats with the same random numbers: mean \
                distance in Lab, Delta-E, the mean of the strongest slices",
        why: "Half floats would save 12 bytes a cluster for roundings of up to 0.03 on L* of 100, which no eye sees; but blends \
              extrapolate by up to tens of weights, and multiply them, so that single floats stay.",
    };
    let judge = |reduced: &Reduced| {
        let of = |(exact, (rounded, sampler)): (&SliceStatistics, &(SliceStatistics, Sampler))| {
            let apart = (0..ROUNDED_DRAWS).map(|n| {
                let [u, r0, r1, r2] = pcg4d([n, effort.seed, 6, 1]).map(unit);
                let [a, b] = [exact, rounded].map(|statistics| {
                    let color = color(statistics, sampler, u, [r0, r1, r2]);
                    lab_from_rgb(PI * DVec3::from(color.map(f64::from)))
                });
                a.distance(b)
            });
            apart.sum::<f64>() / f64::from(ROUNDED_DRAWS)
        };
        let error = single.iter().zip(reduced).map(of).sum::<f64>() / single.len() as f64;
        let is_half = single.iter().zip(reduced).any(|(a, (b, _))| a != b);
        let corner = if is_half { BOX_BYTES / 2 } else { BOX_BYTES };
        let bytes = reduced.iter().map(|(s, sampler)| (corner * s.clusters.len() + sampler.bytes()) as f64);
        Ok((error, Some(bytes.sum::<f64>() / single.len() as f64)))
    };
    curve_of_bytes(head, &trials, effort, judge)
}

/// Samplers of the strongest slice, by the time of a color.
fn samplers(texels: &[[f32; 3]], effort: Effort) -> Result<Curve> {
    let statistics = cluster_slice(texels, DEFAULT_CLUSTERS, BoxRule::MomentMatched)?;
    let mut samplers = vec![("exact".to_owned(), Sampler::exact(&statistics)?)];
    samplers.push(("forward CDF".to_owned(), Sampler::forward_cdf(&statistics)?));
    for steps in STEPS {
        samplers.push((format!("inverse CDF, {steps}"), Sampler::inverse_cdf(&statistics, steps)?));
    }
    let draw = |sampler: &Sampler| -> [f32; 3] {
        let colors = (0..DRAWS).map(|n| {
            let [u, r0, r1, r2] = pcg4d([n, effort.seed, 5, 1]).map(unit);
            color(&statistics, sampler, u, [r0, r1, r2])
        });
        colors.fold([0.0; 3], |sum, color| [0, 1, 2].map(|c| sum[c] + color[c]))
    };
    let trials: Vec<Trial<usize>> = (samplers.iter().enumerate())
        .map(|(k, (name, sampler))| {
            let work = move || {
                std::hint::black_box(draw(sampler));
                Ok(k)
            };
            Trial::new(name, k == 0, work)
        })
        .collect();
    let head = Head {
        stage: "Sampler",
        knob: "look-up of clusters (--steps is that of the table for engines)",
        error: "share of evenly spread draws that go to another cluster than its probability says, the strongest slice",
        why: "The exact look-up by a guide table draws every cluster by its own probability, at the cost of a table's; an inverse CDF, as \
              published, loses clusters that weigh less than a step, and takes kilobytes.",
    };
    curve(head, &trials, effort, |k| {
        let sampler = &samplers[*k].1;
        Ok((misplaced(&statistics, sampler), Some(sampler.bytes() as f64)))
    })
}

/// Half the sum of the differences between how often clusters are found and their probabilities.
fn misplaced(statistics: &SliceStatistics, sampler: &Sampler) -> f64 {
    let mut found = vec![0u32; statistics.clusters.len()];
    for k in 0..SPREAD {
        if let Some(count) = found.get_mut(sampler.lookup((k as f32 + 0.5) / SPREAD as f32)) {
            *count += 1;
        }
    }
    let off = found.iter().zip(&statistics.clusters);
    0.5 * off.map(|(n, c)| (f64::from(*n) / f64::from(SPREAD) - c.probability).abs()).sum::<f64>()
}

/// Wasserstein distance above its floor, mean of four repeats; by chance below 0 where nothing is left to see, which counts as 0.
pub(super) fn excess(
    texels: &[[f32; 3]],
    statistics: &SliceStatistics,
    sampler: &Sampler,
    seed: u32,
) -> Result<f64> {
    let samples = ReconstructionSamples { seed, ..DRAWN_COLORS };
    reconstruction_error(texels, statistics, sampler, samples, wasserstein)
        .map(|error| error.excess().max(0.0))
}
