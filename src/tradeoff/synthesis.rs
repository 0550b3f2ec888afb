//! Synthesis of slices: texels and angles.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::btf::{AngleGrid, FlakeBtf};
use crate::color::luminance;
use crate::error::Result;
use crate::fit::{FlakeOptions, SliceMean, SmoothFit, fit_flakes};
use crate::paint::Flakes;
use crate::report::{energetic_slices, midway};
use crate::simulate::{DEFAULT_BINS, Synthesis, SynthesisOptions, synthesize};
use glam::DVec3;

const SIDES: [usize; 5] = [16, 32, 64, 128, 256];
const DEFAULT_SIDE: usize = 128;
/// Side of the truth.
const SIDE_OF_TRUTH: usize = 1024;
/// Slices of other flakes each: all slices of one synthesis show the same ones.
const REPEATS: u32 = 8;
const BINS: [usize; 5] = [6, 8, 12, 16, DEFAULT_BINS];
/// Side of the slices whose angles are compared, twice that without --quick.
const SMALL: usize = 64;

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let slices = energetic_slices(&subject.chain.btf);
    // Flakes that show nothing.
    if slices.is_empty() {
        return Ok(Vec::new());
    }
    Ok(vec![texels(subject, effort, &slices)?, angles(subject, effort)?])
}

/// Standard deviations of the luminance of slices.
fn texels(subject: &Subject, effort: &Effort, slices: &[usize]) -> Result<Curve> {
    let slices = &slices[..slices.len().min(if effort.quick { 3 } else { 10 })];
    let deviations = |side: usize, seed: u32| -> Result<Vec<f64>> {
        let seed = u64::from(effort.seed.wrapping_add(seed));
        let options = SynthesisOptions { size: [side; 2], seed, ..subject.options.synthesis()? };
        let synthesis = Synthesis::new(&subject.chain.model, &options)?;
        Ok(slices.iter().map(|k| deviation(&synthesis.slice(*k).fluctuation)).collect())
    };
    let truth = deviations(if effort.quick { SIDE_OF_TRUTH / 2 } else { SIDE_OF_TRUTH }, 0)?;
    let deviations =
        |side: usize| -> Result<Vec<Vec<f64>>> { (1..=REPEATS).map(|seed| deviations(side, seed)).collect() };
    let trials = SIDES.map(|side| Trial::new(side, side == DEFAULT_SIDE, move || deviations(side)));
    let head = Head {
        stage: "Synthesis",
        knob: "texels along a side of a slice (simulate --size)",
        error: "standard deviation of the luminance, relative, against other flakes on slices of 1024 (512 with --quick), root mean \
                square over the strongest",
        why: "What is left at 128 is chance: so many flakes lie on such a slice. Four times the texels halve it, and every later stage \
              but the statistics, whose size they do not change, takes four times as long.",
    };
    let judge = |found: &Vec<Vec<f64>>| {
        let errors = found.iter().flat_map(|one| one.iter().zip(&truth)).map(|(a, b)| (a / b - 1.0).powi(2));
        let count = truth.len() * found.len();
        Ok(((errors.sum::<f64>() / count as f64).sqrt(), None))
    };
    curve(head, &trials, *effort, judge)
}

/// What is drawn between slices.
fn angles(subject: &Subject, effort: &Effort) -> Result<Curve> {
    let (model, smooth) = (&subject.chain.model, SmoothFit::from(&subject.chain.paint));
    let side = if effort.quick { SMALL } else { 2 * SMALL };
    let options = |bins: usize| -> Result<SynthesisOptions> {
        let grid = AngleGrid::triangle(bins)?;
        Ok(SynthesisOptions { grid, size: [side; 2], ..subject.options.synthesis()? })
    };
    let reduced = |bins: usize| -> Result<Flakes> {
        let btf: FlakeBtf = synthesize(model, &options(bins)?, &|| ())?;
        fit_flakes(&btf, &smooth, SliceMean::Residual, &FlakeOptions::default(), &|| ())
    };
    let trials = BINS.map(|bins| Trial::new(bins, bins == DEFAULT_BINS, move || reduced(bins)));
    let head = Head {
        stage: "Synthesis",
        knob: "angle bins a quarter turn (simulate --bins)",
        error: "standard deviation of the luminance midway between slices, relative, against slices simulated there, root mean square",
        why: "Slices of 24 bins lie 3.75 degrees apart, less than the lobe of well aligned flakes is wide; their number, and with it every \
              later cost, grows with the square of the bins.",
    };
    let judge = |flakes: &Flakes| {
        let found = midway(model, &options(flakes.grid.bins())?, flakes)?;
        let errors: Vec<f64> = (found.iter().filter(|m| m.source > 0.0))
            .map(|midway| (midway.drawn / midway.source - 1.0).powi(2))
            .collect();
        let clusters: usize = flakes.levels[0].slices.iter().map(|slice| slice.clusters.len()).sum();
        Ok((
            (errors.iter().sum::<f64>() / errors.len().max(1) as f64).sqrt(),
            Some((super::CLUSTER_BYTES * clusters) as f64),
        ))
    };
    curve(head, &trials, *effort, judge)
}

fn deviation(texels: &[[f32; 3]]) -> f64 {
    let y = texels.iter().map(|t| luminance(DVec3::from(t.map(f64::from))));
    let n = texels.len().max(1) as f64;
    let mean = y.clone().sum::<f64>() / n;
    (y.map(|y| (y - mean).powi(2)).sum::<f64>() / n).sqrt()
}
