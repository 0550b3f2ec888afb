//! The fit of diffuse, metallic lobes and gloss (Rump et al. 2008, section 5.1.2).
//!
//! Two sets of samples: around the mirror direction the clear coat's peak, elsewhere diffuse and glitter. The lobes are
//! fitted to the second set from several starts, then the gloss lobe to the first with the lobes fixed, and both in turn.
//! Where the first set ends is read off the data: as far as they rise above the lobes continued inwards.

use super::objective::{Fitted, Objective, Point, Range, Terms};
use super::samples::Sample;
use crate::brdf::{ClearCoat, Lobe};
use crate::error::Result;
use crate::math::hash::{pcg4d, unit};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Half-vector angle inside which gloss is looked for, radians: 10 degrees, half the width of the widest peak that is
/// still taken for gloss.
const WIDEST_GLOSS: f64 = 10.0 * PI / 180.0;
/// Width of the bins of the half-vector angle in that search, radians: half a degree.
const BIN: f64 = 0.5 * PI / 180.0;
/// Excess over the lobes that counts as gloss: above the scatter of real tables, below any clear coat.
const EXCESS: f64 = 1.5;
/// Samples of a fit: evenly drawn from all; four times as many change the error in the fourth digit.
const POINTS: usize = 6000;
/// Rounds of lobes and gloss in turn.
const ROUNDS: usize = 3;
/// Roughness of metallic lobes: from a lobe of 1 degree to wider than a hemisphere.
const METALLIC: Range = Range { roughness: (0.02, 3.0) };
/// Roughness of a gloss lobe: from below what any table resolves to 12 degrees.
const GLOSS: Range = Range { roughness: (5e-4, 0.2) };

/// Everything fitted to intensity.
pub(super) struct LobeFit {
    pub diffuse: f64,
    pub lobes: Vec<Lobe>,
    pub gloss: Option<Lobe>,
    /// Half-vector angle at which the gloss ends, radians; 0 without gloss.
    pub gloss_end: f64,
    /// Every start and what became of it.
    pub starts: Vec<Fitted>,
    /// The small constant of eq. 7.
    pub epsilon: f64,
}

/// Fits `count` lobes, and a gloss lobe if `coat` has no gloss of its own and the data do.
pub(super) fn fit(
    samples: &[Sample],
    coat: &ClearCoat,
    count: usize,
    starts: usize,
    seed: u32,
    tick: &(dyn Fn() + Sync),
) -> Result<LobeFit> {
    let epsilon = epsilon(samples);
    let ordered = order(samples);
    let mut gloss_end = if coat.gloss.is_none() && coat.mirror == 0.0 { WIDEST_GLOSS } else { 0.0 };
    let set = |end: f64, gloss: Option<Lobe>| base_points(samples, &ordered, end, gloss);
    let mut points = set(gloss_end, None);
    let tried = multi_start(&points, epsilon, &guesses(&points, count, starts, seed), METALLIC, tick)?;
    let mut base = best(&tried);
    // A narrower search range shows more of the lobes, and those show more of the gloss: a few turns settle it.
    for _ in 0..6 {
        let end = end_of_gloss(samples, &base, epsilon, gloss_end);
        if end == gloss_end {
            break;
        }
        gloss_end = end;
        points = set(gloss_end, None);
        base = refit(&points, epsilon, &base)?;
    }
    let mut candidates = guesses(&points, count, starts, seed);
    candidates.push(base);
    let starts = multi_start(&points, epsilon, &candidates, METALLIC, tick)?;
    base = best(&starts);
    let mut gloss = None;
    if gloss_end > 0.0 {
        for round in 0..ROUNDS {
            let peak = gloss_points(samples, &ordered, gloss_end, &base);
            let candidates = gloss.map_or_else(|| gloss_guesses(&peak, gloss_end), |g| vec![gloss_terms(g)]);
            gloss = best(&multi_start(&peak, epsilon, &candidates, GLOSS, tick)?).lobes.first().copied();
            if round + 1 < ROUNDS {
                base = refit(&set(gloss_end, gloss), epsilon, &base)?;
            }
        }
    }
    base.lobes.sort_by(|a, b| b.roughness.total_cmp(&a.roughness));
    let diffuse = base.diffuse.unwrap_or(0.0);
    Ok(LobeFit { diffuse, lobes: base.lobes, gloss, gloss_end, starts, epsilon })
}

/// The small constant of eq. 7: a hundredth of the median positive intensity. Errors in light that faint are not seen.
fn epsilon(samples: &[Sample]) -> f64 {
    let mut positive: Vec<f64> = samples.iter().map(Sample::intensity).filter(|i| *i > 0.0).collect();
    let middle = positive.len() / 2;
    if positive.is_empty() {
        return f64::MIN_POSITIVE;
    }
    0.01 * *positive.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Samples by bins of theta_h and theta_i, so that every so-manyth is an even draw.
fn order(samples: &[Sample]) -> Vec<usize> {
    let key = |k: &usize| {
        let a = samples[*k].angles;
        let bin = |angle: f64| (angle * 90.0 / PI) as u32;
        (bin(a.theta_h), bin(a.theta_i), *k)
    };
    let mut ordered: Vec<usize> = (0..samples.len()).collect();
    ordered.par_sort_unstable_by_key(key);
    ordered
}

/// About [`POINTS`] of the chosen samples.
fn draw(
    samples: &[Sample],
    ordered: &[usize],
    chosen: impl Fn(&Sample) -> bool,
    point: impl Fn(&Sample) -> Point,
) -> Vec<Point> {
    let inside: Vec<&Sample> = ordered.iter().map(|k| &samples[*k]).filter(|s| chosen(s)).collect();
    let stride = inside.len().div_ceil(POINTS).max(1);
    inside.into_iter().skip(stride / 2).step_by(stride).map(point).collect()
}

fn base_points(samples: &[Sample], ordered: &[usize], gloss_end: f64, gloss: Option<Lobe>) -> Vec<Point> {
    draw(
        samples,
        ordered,
        |s| s.outer_theta_h() >= gloss_end,
        |s| Point {
            geometry: s.geometry,
            transmittance: s.transmittance,
            rest: gloss.map_or(0.0, |g| g.eval(&s.outer)),
            intensity: s.intensity(),
        },
    )
}

fn gloss_points(samples: &[Sample], ordered: &[usize], gloss_end: f64, base: &Terms) -> Vec<Point> {
    draw(
        samples,
        ordered,
        |s| s.outer_theta_h() < gloss_end,
        |s| Point {
            geometry: s.outer,
            transmittance: 1.0,
            rest: s.transmittance * base.brightness(&s.geometry),
            intensity: s.intensity(),
        },
    )
}

/// Where the data stop rising above `base`: upper edge of the last bin in which a tenth of the samples does.
fn end_of_gloss(samples: &[Sample], base: &Terms, epsilon: f64, within: f64) -> f64 {
    let bins = (within / BIN).round() as usize;
    let mut ratios = vec![Vec::new(); bins];
    for s in samples {
        let bin = (s.outer_theta_h() / BIN) as usize;
        if bin < bins {
            let model = s.transmittance * base.brightness(&s.geometry);
            ratios[bin].push((s.intensity() + epsilon) / (model + epsilon));
        }
    }
    let exceeds = |bin: &mut Vec<f64>| {
        let tenth = bin.len() * 9 / 10;
        !bin.is_empty() && *bin.select_nth_unstable_by(tenth, f64::total_cmp).1 > EXCESS
    };
    ratios.iter_mut().rposition(exceeds).map_or(0.0, |last| (last + 1) as f64 * BIN)
}

fn multi_start(
    points: &[Point],
    epsilon: f64,
    starts: &[Terms],
    range: Range,
    tick: &(dyn Fn() + Sync),
) -> Result<Vec<Fitted>> {
    starts
        .par_iter()
        .map(|start| {
            let fitted = Objective::new(points, epsilon, start, range).fit(start);
            tick();
            fitted
        })
        .collect()
}

fn refit(points: &[Point], epsilon: f64, start: &Terms) -> Result<Terms> {
    Ok(Objective::new(points, epsilon, start, METALLIC).fit(start)?.terms)
}

/// The fit of least error; of equal ones the first.
fn best(fits: &[Fitted]) -> Terms {
    let least = fits.iter().min_by(|a, b| a.error.total_cmp(&b.error));
    least.map_or(Terms { diffuse: None, lobes: Vec::new() }, |f| f.terms.clone())
}

/// Starts of the metallic lobes: one with widths evenly spread, the rest at random around it.
fn guesses(points: &[Point], count: usize, starts: usize, seed: u32) -> Vec<Terms> {
    let mut intensities: Vec<f64> = points.iter().map(|p| p.intensity.max(0.0)).collect();
    intensities.sort_by(f64::total_cmp);
    let quantile = |q: f64| {
        let at = ((intensities.len() as f64 * q) as usize).min(intensities.len().saturating_sub(1));
        intensities.get(at).copied().unwrap_or(0.0).max(1e-6)
    };
    let (dark, bright) = (quantile(0.1), quantile(0.99));
    (0..starts)
        .map(|start| {
            // A factor between 1/e and e, none for the first start.
            let vary = |lobe: usize, kind: u32| {
                let draw = f64::from(unit(pcg4d([seed, start as u32, lobe as u32, kind])[0]));
                if start == 0 { 1.0 } else { (2.0 * draw - 1.0).exp() }
            };
            let lobes = (0..count)
                .map(|k| {
                    let roughness = 0.12 * 8f64.powf((k as f64 + 0.5) / count as f64) * vary(k, 0);
                    let f0 = 0.3 * vary(k, 1);
                    let peak = bright * PI * roughness * roughness / (count as f64 * f0);
                    Lobe { coefficient: peak * vary(k, 2), roughness, f0 }
                })
                .collect();
            Terms { diffuse: Some(0.5 * PI * dark * vary(0, 3)), lobes }
        })
        .collect()
}

/// Starts of the gloss lobe: three widths below the end of the peak, as high as the data.
fn gloss_guesses(points: &[Point], gloss_end: f64) -> Vec<Terms> {
    let top = points.iter().map(|p| p.intensity - p.rest).fold(1e-6, f64::max);
    [0.7, 0.3, 0.1]
        .into_iter()
        .map(|share| {
            let roughness = share * gloss_end;
            gloss_terms(Lobe { coefficient: top * PI * roughness * roughness / 0.1, roughness, f0: 0.05 })
        })
        .collect()
}

fn gloss_terms(lobe: Lobe) -> Terms {
    Terms { diffuse: None, lobes: vec![lobe] }
}
