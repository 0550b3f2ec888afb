//! What else a flake BTF is compressed by: raw slices, principal components, patches (Rump et al. 2008, section 6).

use super::clustering::{DRAWN_COLORS, excess};
use super::measure::{Curve, Effort, Head, Trial, curve_of_bytes};
use super::{CLUSTER_BYTES, Subject};
use crate::btf::FlakeBtf;
use crate::cluster::{BoxRule, DEFAULT_CLUSTERS, SliceStatistics, cluster_slice};
use crate::color::lab_from_rgb;
use crate::error::Result;
use crate::math::hash::pcg4d;
use crate::parallel::TryMap;
use crate::report::{energetic_slices, wasserstein};
use crate::rivals::{Grouping, Images, Patches, Pca};
use crate::sampler::Sampler;
use glam::DVec3;
use half::f16;
use rayon::prelude::*;
use std::f64::consts::PI;

const COMPONENTS: [usize; 3] = [4, 8, 16];
const PIECES: [usize; 2] = [32, 64];
/// Red, green and blue as half floats.
const TEXEL_BYTES: usize = 6;

/// What stands for the slices, and its bytes.
enum Made {
    /// Clusters.
    Statistics(Vec<(SliceStatistics, Sampler)>),
    /// Textures of the strongest slices.
    Textures(Vec<Vec<[f32; 3]>>, usize),
}

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let btf = &subject.chain.btf;
    let slices = energetic_slices(btf);
    let slices = &slices[..slices.len().min(if effort.quick { 3 } else { 10 })];
    // Flakes that show nothing.
    if slices.is_empty() {
        return Ok(Vec::new());
    }
    let mut trials = vec![
        Trial::new(format!("statistics, {DEFAULT_CLUSTERS} clusters"), true, move || statistics(btf)),
        Trial::new("raw half floats", false, move || Ok(raw(btf, slices))),
    ];
    trials.extend(COMPONENTS.map(|count| {
        Trial::new(format!("{count} components"), false, move || components(btf, slices, count))
    }));
    trials.extend(PIECES.into_iter().filter(|side| *side < btf.size[0].min(btf.size[1])).map(|side| {
        let seed = effort.seed;
        Trial::new(format!("patches of {side} x {side}"), false, move || patches(btf, slices, side, seed))
    }));
    let head = Head {
        stage: "Rivals",
        knob: "what is kept of the slices",
        error: "Wasserstein-1 distance of colors from texels above that of two draws of texels, Delta-E, the mean of the strongest slices",
        why: "Components and raw texels keep every flake of a small piece, whose end and repetition show, and grow with it; statistics are \
              smaller, have no end, and are what can be blended: components of two paints have nothing to do with each other.",
    };
    let judge = |made: &Made| match made {
        Made::Statistics(all) => {
            let clusters: usize = all.iter().map(|(statistics, _)| statistics.clusters.len()).sum();
            let errors = slices.iter().map(|k| {
                let (statistics, sampler) = &all[*k];
                excess(&btf.slices[*k].fluctuation, statistics, sampler, effort.seed.wrapping_add(*k as u32))
            });
            Ok((mean(&errors.collect::<Result<Vec<f64>>>()?), Some((CLUSTER_BYTES * clusters) as f64)))
        }
        Made::Textures(textures, bytes) => {
            let errors = slices.iter().zip(textures).map(|(k, texture)| {
                distance(&btf.slices[*k].fluctuation, texture, effort.seed.wrapping_add(*k as u32))
            });
            Ok((mean(&errors.collect::<Vec<f64>>()), Some(*bytes as f64)))
        }
    };
    Ok(vec![curve_of_bytes(head, &trials, *effort, judge)?])
}

fn statistics(btf: &FlakeBtf) -> Result<Made> {
    let all = btf.slices.par_iter().try_map(|slice| {
        let statistics = cluster_slice(&slice.fluctuation, DEFAULT_CLUSTERS, BoxRule::MomentMatched)?;
        let sampler = Sampler::exact(&statistics)?;
        Ok((statistics, sampler))
    })?;
    Ok(Made::Statistics(all))
}

fn raw(btf: &FlakeBtf, slices: &[usize]) -> Made {
    let half = |texel: &[f32; 3]| texel.map(|v| f16::from_f32(v).to_f32());
    let textures = slices.iter().map(|k| btf.slices[*k].fluctuation.iter().map(half).collect());
    Made::Textures(textures.collect(), btf.slices.len() * btf.size[0] * btf.size[1] * TEXEL_BYTES)
}

/// Of all slices together: simulated slices of equal theta_h are nearly alike.
fn components(btf: &FlakeBtf, slices: &[usize], count: usize) -> Result<Made> {
    let pca = Pca::new(btf, Grouping::All, Images::Color, count)?;
    let textures = slices.iter().filter_map(|k| pca.slice(*k, count)).collect();
    Ok(Made::Textures(textures, pca.bytes(count)))
}

/// A surface of the size of the slices out of a piece of them.
fn patches(btf: &FlakeBtf, slices: &[usize], side: usize, seed: u32) -> Result<Made> {
    let map = Patches::new([side; 2], btf.size, Patches::SIDE.min(side / 2), seed)?;
    let surface = |k: &usize| {
        let rows = btf.slices[*k].fluctuation.chunks_exact(btf.size[0]).take(side);
        map.surface(&rows.flat_map(|row| &row[..side]).copied().collect::<Vec<_>>())
    };
    let textures = slices.iter().filter_map(surface).collect();
    Ok(Made::Textures(textures, btf.slices.len() * side * side * TEXEL_BYTES + map.bytes()))
}

/// Of the colors of a texture from a slice, above that of the same texels of the slice: chance cancels where they are the same.
fn distance(source: &[[f32; 3]], made: &[[f32; 3]], seed: u32) -> f64 {
    let cloud = |texels: &[[f32; 3]], stream: u32| -> Vec<DVec3> {
        let pick = |k: u32| pcg4d([k, stream, 1, seed])[0] as usize % texels.len();
        (0..DRAWN_COLORS.points)
            .map(|k| lab_from_rgb(PI * DVec3::from(texels[pick(k)].map(f64::from))))
            .collect()
    };
    let repeats = DRAWN_COLORS.repeats;
    let once = |repeat: u32| {
        let texels = cloud(source, 2 * repeat);
        wasserstein(&cloud(made, 2 * repeat + 1), &texels)
            - wasserstein(&cloud(source, 2 * repeat + 1), &texels)
    };
    ((0..repeats).map(once).sum::<f64>() / f64::from(repeats)).max(0.0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
