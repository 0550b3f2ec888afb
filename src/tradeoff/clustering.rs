//! Statistics of slices: clusters, rule of boxes, sampler, level of detail.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::cluster::{BoxRule, DEFAULT_CLUSTERS, SliceStatistics, cluster_slice};
use crate::error::Result;
use crate::fit::{SliceMean, SmoothFit, residual};
use crate::math::hash::{pcg4d, unit};
use crate::report::{energetic_slices, wasserstein};
use crate::sampler::{ReconstructionSamples, Sampler, color, reconstruction_error};

const CLUSTERS: [usize; 7] = [16, 25, 50, 100, 200, 400, 1024];
const STEPS: [usize; 6] = [125, 250, 500, 1000, 2000, 4000];
/// Colors drawn at a time.
const DRAWS: u32 = 100_000;
/// Bytes of the corners of a box.
const BOX_BYTES: usize = 24;

/// Statistics of the slices, and what draws from them.
type Reduced = Vec<(SliceStatistics, Sampler)>;

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let (chain, smooth) = (&subject.chain, SmoothFit::from(&subject.chain.paint));
    let slices = energetic_slices(&chain.btf).into_iter().take(if effort.quick { 3 } else { 10 });
    let texels =
        slices.map(|k| residual(&chain.btf, &smooth, SliceMean::Residual, k)).collect::<Result<Vec<_>>>()?;
    // Flakes that show nothing.
    if texels.is_empty() {
        return Ok(Vec::new());
    }
    let reduce = |clusters: usize, rule: BoxRule| -> Result<Reduced> {
        let one = |texels: &Vec<[f32; 3]>| {
            let statistics = cluster_slice(texels, clusters, rule)?;
            let sampler = Sampler::exact(&statistics)?;
            Ok((statistics, sampler))
        };
        texels.iter().map(one).collect()
    };
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
        samplers(&texels, *effort, excess)?,
    ])
}

/// Samplers of the strongest slice, by the time of a color.
fn samplers(
    texels: &[Vec<[f32; 3]>],
    effort: Effort,
    judge: impl Fn(&[[f32; 3]], &SliceStatistics, &Sampler, u32) -> Result<f64>,
) -> Result<Curve> {
    let statistics = cluster_slice(&texels[0], DEFAULT_CLUSTERS, BoxRule::MomentMatched)?;
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
        error: "Wasserstein-1 distance of drawn colors from texels above that of two draws of texels, Delta-E, the strongest slice",
        why: "The exact look-up by a guide table draws every cluster by its own probability, at the cost of a table's; an inverse CDF, as \
              published, loses clusters that weigh less than a step, and takes kilobytes.",
    };
    curve(head, &trials, effort, |k| {
        let sampler = &samplers[*k].1;
        Ok((judge(&texels[0], &statistics, sampler, effort.seed)?, Some(sampler.bytes() as f64)))
    })
}

/// Wasserstein distance above its floor, mean of four repeats; by chance below 0 where nothing is left to see, which counts as 0.
fn excess(texels: &[[f32; 3]], statistics: &SliceStatistics, sampler: &Sampler, seed: u32) -> Result<f64> {
    let samples = ReconstructionSamples { draws: 1, points: 500, repeats: 4, seed };
    reconstruction_error(texels, statistics, sampler, samples, wasserstein)
        .map(|error| error.excess().max(0.0))
}
