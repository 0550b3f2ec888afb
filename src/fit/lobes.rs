//! The fit of diffuse, metallic lobes and gloss (Rump et al. 2008, section 5.1.2).
//!
//! Two sets of samples: around the mirror direction the clear coat's peak, elsewhere diffuse and glitter. The lobes are
//! fitted to the second set from several starts, then the gloss lobe to the first with the lobes fixed, and both in turn.
//! Where the first set ends is read off the data: as far as they rise above the lobes continued inwards. Samples taken for the
//! gloss alone, as from images, serve it alone.

use super::choice::{Choice, criterion};
use super::objective::{LEAST_F0, Objective, Range, Terms};
use super::optimizer::{Fitted, Optimizer};
use super::points::Points;
use super::samples::{Sample, Samples};
use super::uncertainty::{self, Uncertainty};
use crate::brdf::Lobe;
use crate::brdf::fresnel::normal_reflectance;
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
/// The same over what the upper tenth of the samples beyond any gloss shows, for those that scatter more: lobes continued inwards
/// miss that much.
const EXCESS_OVER_SCATTER: f64 = 1.25;
/// Most samples of a fit: evenly drawn from all where there are more.
const SAMPLES: usize = 20_000;
/// Most samples that the starts race on; the best goes on with all.
const RACE: usize = 4_000;
/// Most points of light of a fit: what 20,000 samples under a four-point light have.
const LIGHTS: usize = 80_000;
/// Rounds of lobes and gloss in turn.
const ROUNDS: usize = 3;
/// Knee of the starts: below the noise of real tables, which is some 0.1.
const KNEE: f64 = 0.05;
/// Metallic lobes: from one of 1 degree to wider than a hemisphere.
const METALLIC: Range = Range { roughness: [0.02, 3.0], f0: [LEAST_F0, 1.0] };
/// A metallic lobe narrower than this share of the angle at which the gloss ends has fallen there to a tenth: nothing that was
/// measured outside tells it from the gloss.
const NARROWEST: f64 = 0.7;
/// A gloss lobe: from below what any table resolves to 12 degrees, of solids of index 1.33 or more.
const GLOSS: Range = Range { roughness: [5e-4, 0.2], f0: [0.02, 1.0] };
/// Coefficient of a lobe that mirrors all light at grazing angles: the convention leaves out a denominator of 4.
const ALL_LIGHT: f64 = 0.25;
/// How well the F0 of a coat of known index is known: it differs a little from Schlick's.
const KNOWN: f64 = 1e-3;

/// Everything fitted to intensity.
pub(super) struct LobeFit {
    pub diffuse: f64,
    pub lobes: Vec<Lobe>,
    pub gloss: Option<Lobe>,
    /// Half-vector angle at which the gloss ends, radians; 0 without gloss.
    pub gloss_end: f64,
    /// Every start and what became of it.
    pub starts: Vec<Fitted>,
    /// The numbers of lobes tried, if there was a choice.
    pub choices: Vec<Choice>,
    /// The small constant of eq. 7.
    pub epsilon: f64,
    /// How well the parameters are known, those of the gloss last.
    pub uncertainty: Uncertainty,
}

/// How lobes are looked for.
pub(super) struct Search<'a> {
    pub samples: &'a Samples<'a>,
    pub optimizer: Optimizer,
    pub starts: usize,
    pub seed: u32,
    pub tick: &'a (dyn Fn() + Sync),
    /// The small constant of eq. 7.
    epsilon: f64,
    /// Samples by bins of theta_h and theta_i, so that every so-manyth is an even draw.
    ordered: Vec<usize>,
}

impl<'a> Search<'a> {
    /// A search in `samples`; `tick` is called after every start.
    pub fn new(
        samples: &'a Samples<'a>,
        optimizer: Optimizer,
        starts: usize,
        seed: u32,
        tick: &'a (dyn Fn() + Sync),
    ) -> Self {
        let (epsilon, ordered) = (epsilon(&samples.list), order(&samples.list));
        Self { samples, optimizer, starts, seed, tick, epsilon, ordered }
    }

    /// Fits `count` lobes, or where there is a `choice` fewer if those say as much; and a gloss lobe if the coat has no gloss of
    /// its own and the data do.
    pub fn fit(&self, count: usize, choice: bool) -> Result<LobeFit> {
        let coat = &self.samples.coat;
        let sought = coat.gloss.is_none() && coat.mirror == 0.0;
        let (mut base, gloss_end) = self.split(count, if sought { WIDEST_GLOSS } else { 0.0 })?;
        let points = self.base_points(gloss_end, None, SAMPLES);
        let range = metallic(gloss_end);
        let (mut starts, mut choices) = (Vec::new(), Vec::<Choice>::new());
        for lobes in (if choice { 1 } else { count }..=count).rev() {
            let known = (lobes == count).then(|| base.clone());
            let raced = self.race(&self.base_points(gloss_end, None, RACE), lobes, known, range)?;
            let fitted = self.polish(&points, &best(&raced), range)?;
            let criterion = criterion(fitted.error, lobes, points.len());
            if choices.iter().all(|other| criterion < other.criterion) {
                (base, starts) = (fitted.terms, raced);
            }
            choices.push(Choice { lobes, error: fitted.error, criterion });
        }
        let gloss = if gloss_end > 0.0 { self.in_turn(&mut base, gloss_end)? } else { None };
        base.lobes.sort_by(|a, b| b.roughness.total_cmp(&a.roughness));
        let uncertainty = self.uncertainty(&base, gloss, gloss_end)?;
        let diffuse = base.diffuse.unwrap_or(0.0);
        let Self { epsilon, .. } = *self;
        Ok(LobeFit { diffuse, lobes: base.lobes, gloss, gloss_end, starts, choices, epsilon, uncertainty })
    }

    /// Lobes, and where the gloss ends that rises above them. A narrower range of the gloss shows more of the lobes, and those
    /// show more of the gloss: a few turns settle it.
    fn split(&self, count: usize, widest: f64) -> Result<(Terms, f64)> {
        let mut end = widest;
        let mut base = best(&self.race(&self.base_points(end, None, RACE), count, None, METALLIC)?);
        for _ in 0..6 {
            let next = self.end_of_gloss(&base, end);
            if next == end {
                break;
            }
            end = next;
            base = self.run(&self.base_points(end, None, RACE), &base, METALLIC, KNEE)?.terms;
        }
        Ok((base, end))
    }

    /// The gloss lobe, lobes and gloss fitted in turn.
    fn in_turn(&self, base: &mut Terms, gloss_end: f64) -> Result<Option<Lobe>> {
        let mut gloss = None;
        for round in 0..ROUNDS {
            let peak = self.gloss_points(gloss_end, base);
            let candidates = gloss.map_or_else(|| gloss_guesses(&peak, gloss_end), |g| vec![gloss_terms(g)]);
            let tried = self.all(&peak, &candidates, self.gloss_range())?;
            gloss = self.polish(&peak, &best(&tried), self.gloss_range())?.terms.lobes.first().copied();
            gloss = gloss.map(|lobe| if self.samples.coat.ior == 1.0 { plausible(lobe) } else { lobe });
            if round + 1 < ROUNDS {
                let points = self.base_points(gloss_end, gloss, SAMPLES);
                *base = self.polish(&points, base, metallic(gloss_end))?.terms;
            }
        }
        Ok(gloss)
    }

    /// That of any gloss, or of the gloss of the coat, if its index is known.
    fn gloss_range(&self) -> Range {
        let coat = &self.samples.coat;
        if coat.ior == 1.0 {
            return GLOSS;
        }
        let f0 = normal_reflectance(coat.ior);
        Range { f0: [f0 * (1.0 - KNOWN), f0 * (1.0 + KNOWN)], ..GLOSS }
    }

    fn race(&self, points: &Points, count: usize, known: Option<Terms>, range: Range) -> Result<Vec<Fitted>> {
        let mut candidates = guesses(points, count, self.starts, self.seed);
        candidates.extend(known);
        self.all(points, &candidates, range)
    }

    fn all(&self, points: &Points, starts: &[Terms], range: Range) -> Result<Vec<Fitted>> {
        starts
            .par_iter()
            .map(|start| {
                let fitted = self.run(points, start, range, KNEE);
                (self.tick)();
                fitted
            })
            .collect()
    }

    /// Goes on from near a minimum: with the knee of the starts, then with knees ever farther inside of the residuals left, until
    /// what is least is eq. 7 itself.
    fn polish(&self, points: &Points, start: &Terms, range: Range) -> Result<Fitted> {
        let mut best = self.run(points, start, range, KNEE)?;
        // SR1 knows no knee.
        let shares: &[f64] = if self.optimizer == Optimizer::Sr1 { &[] } else { &[0.2, 0.02, 0.002] };
        for share in shares {
            let finer = self.run(points, &best.terms, range, inner_knee(*share, best.error))?;
            if finer.error < best.error {
                best = finer;
            }
        }
        Ok(best)
    }

    fn run(&self, points: &Points, start: &Terms, range: Range, knee: f64) -> Result<Fitted> {
        self.optimizer.fit(&Objective::new(points, start, range), start, knee)
    }

    fn uncertainty(&self, base: &Terms, gloss: Option<Lobe>, gloss_end: f64) -> Result<Uncertainty> {
        let points = self.base_points(gloss_end, gloss, SAMPLES);
        let metallic = uncertainty::of(&Objective::new(&points, base, metallic(gloss_end)), base, "lobe");
        let Some(lobe) = gloss else { return Ok(metallic) };
        let peak = self.gloss_points(gloss_end, base);
        let terms = gloss_terms(lobe);
        Ok(metallic.and(uncertainty::of(&Objective::new(&peak, &terms, self.gloss_range()), &terms, "gloss")))
    }

    /// The samples that hold no gloss, less what `gloss` explains; at most `most`, evenly drawn.
    fn base_points(&self, gloss_end: f64, gloss: Option<Lobe>, most: usize) -> Points {
        let chosen = self.draw(most, |_, s| !s.apart && s.outer_theta_h() >= gloss_end);
        self.points(&chosen, |points, s| {
            let rest = gloss
                .map_or(0.0, |lobe| self.samples.outside(s).map(|(g, share)| share * lobe.eval(&g)).sum());
            points.push(s.intensity, rest, self.samples.inside(s));
        })
    }

    /// The samples that hold the gloss, less what `base` explains: those taken for it alone, which may see no more than its top,
    /// and all others up to where it ends, which know how wide it is. Drawn by their cosines, as their light counts: towards grazing,
    /// where a gloss outshines all, surfaces keep to no one law, and a lobe that fits there is wrong where it is looked at.
    fn gloss_points(&self, gloss_end: f64, base: &Terms) -> Points {
        let lights = self.samples.list.iter().map(|s| s.lights.len()).max().unwrap_or(0).max(1);
        let most = SAMPLES.min(LIGHTS / lights).max(1);
        let counts = |k: usize, s: &Sample| {
            let draw = unit(pcg4d([k as u32, (k as u64 >> 32) as u32, self.seed, 1])[0]);
            f64::from(draw) < s.outer.cos_i * s.outer.cos_o
        };
        let chosen = self.draw(most, |k, s| (s.apart || s.outer_theta_h() < gloss_end) && counts(k, s));
        self.points(&chosen, |points, s| {
            let rest =
                self.samples.inside(s).into_iter().map(|(g, weight)| weight * base.brightness(&g)).sum();
            points.push(s.intensity, rest, self.samples.outside(s));
        })
    }

    fn points(&self, chosen: &[&Sample], push: impl Fn(&mut Points, &Sample)) -> Points {
        let mut points = Points::new(self.epsilon);
        chosen.iter().for_each(|s| push(&mut points, s));
        points
    }

    fn draw(&self, most: usize, wanted: impl Fn(usize, &Sample) -> bool) -> Vec<&Sample<'_>> {
        let list = &self.samples.list;
        let inside: Vec<_> =
            self.ordered.iter().filter(|k| wanted(**k, &list[**k])).map(|k| &list[*k]).collect();
        if inside.len() <= most {
            return inside;
        }
        (0..most).map(|k| inside[(2 * k + 1) * inside.len() / (2 * most)]).collect()
    }

    /// Where the data stop rising above `base`: upper edge of the last bin in which surely more than a tenth of the samples does, by
    /// more than the same share of those beyond any gloss. Samples of few flakes scatter widely, and mostly upwards.
    fn end_of_gloss(&self, base: &Terms, within: f64) -> f64 {
        let mut ratios = vec![Vec::new(); (within / BIN).round() as usize];
        let mut beyond = Vec::new();
        for s in &self.samples.list {
            let theta_h = s.outer_theta_h();
            let model = s.transmittance * base.brightness(&s.geometry);
            let ratio = (s.intensity + self.epsilon) / (model + self.epsilon);
            if let Some(bin) = ratios.get_mut((theta_h / BIN) as usize) {
                bin.push(ratio);
            } else if (WIDEST_GLOSS..2.0 * WIDEST_GLOSS).contains(&theta_h) {
                beyond.push(ratio);
            }
        }
        let tenth = beyond.len() * 9 / 10;
        let scatter =
            if beyond.is_empty() { 0.0 } else { *beyond.select_nth_unstable_by(tenth, f64::total_cmp).1 };
        let last = ratios.iter().rposition(|bin| exceeds(bin, EXCESS.max(EXCESS_OVER_SCATTER * scatter)));
        last.map_or(0.0, |last| (last + 1) as f64 * BIN)
    }
}

/// Whether more than a tenth of the ratios lie above the bar, and more by three standard deviations than a tenth gives by chance.
fn exceeds(ratios: &[f64], bar: f64) -> bool {
    let (n, above) = (ratios.len() as f64, ratios.iter().filter(|r| **r > bar).count() as f64);
    above > 0.1 * n + 3.0 * (0.09 * n).sqrt()
}

/// The same gloss about the normal, giving back no more light than it gets at grazing angles: where samples are near the normal,
/// F0 and coefficient are known by their product alone.
fn plausible(lobe: Lobe) -> Lobe {
    let f0 = lobe.f0.max((lobe.coefficient * lobe.f0 / ALL_LIGHT).min(1.0));
    Lobe { coefficient: lobe.coefficient * lobe.f0 / f0, f0, ..lobe }
}

/// Roughness of metallic lobes beside a gloss that ends at this half-vector angle, radians.
fn metallic(gloss_end: f64) -> Range {
    let [least, most] = METALLIC.roughness;
    Range { roughness: [least.max(NARROWEST * gloss_end.tan()), most], ..METALLIC }
}

/// A knee inside of residuals whose mean is `error`.
pub(super) fn inner_knee(share: f64, error: f64) -> f64 {
    (share * error).clamp(1e-7, KNEE)
}

/// The small constant of eq. 7: a hundredth of the median positive intensity. Errors in light that faint are not seen.
fn epsilon(samples: &[Sample]) -> f64 {
    let mut positive: Vec<f64> = samples.iter().map(|s| s.intensity).filter(|i| *i > 0.0).collect();
    let middle = positive.len() / 2;
    if positive.is_empty() {
        return f64::MIN_POSITIVE;
    }
    0.01 * *positive.select_nth_unstable_by(middle, f64::total_cmp).1
}

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

/// The fit of least error; of equal ones the first.
fn best(fits: &[Fitted]) -> Terms {
    let least = fits.iter().min_by(|a, b| a.error.total_cmp(&b.error));
    least.map_or(Terms { diffuse: None, lobes: Vec::new() }, |f| f.terms.clone())
}

/// Starts of the metallic lobes: one with widths evenly spread, the rest at random around it.
fn guesses(points: &Points, count: usize, starts: usize, seed: u32) -> Vec<Terms> {
    let mut intensities: Vec<f64> = (0..points.len()).map(|k| points.intensity(k)).collect();
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
fn gloss_guesses(points: &Points, gloss_end: f64) -> Vec<Terms> {
    let top = (0..points.len()).map(|k| points.intensity(k) - points.rest[k]).fold(1e-6, f64::max);
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
