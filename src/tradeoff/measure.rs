//! Curves: settings of a knob, timed in turns, with their errors.

use crate::error::{Error, Result};
use serde::Serialize;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// How thoroughly is measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Effort {
    /// Fewer turns, smaller problems.
    pub quick: bool,
    /// Seed of everything random.
    pub seed: u32,
}

impl Effort {
    /// Most turns of a curve, and the time they may take together.
    fn turns(self) -> (usize, Duration) {
        if self.quick { (5, Duration::from_secs(3)) } else { (15, Duration::from_secs(12)) }
    }
}

/// What a curve weighs errors against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The time it takes.
    Time,
    /// The bytes that are kept.
    Bytes,
}

/// What a setting costs in time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cost {
    /// Middle one of the times, seconds.
    pub seconds: f64,
    /// Quartiles of the times, seconds.
    pub quartiles: [f64; 2],
    /// Middle one of the ratios to the default's time in the same turn.
    pub ratio: f64,
    /// How often it was timed.
    pub turns: usize,
}

/// A setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Its name.
    pub setting: String,
    /// The time it takes.
    pub cost: Cost,
    /// What it costs on the axis of its curve, the default's 1.
    pub relative: f64,
    /// How far it is from the truth, in the unit of its curve.
    pub error: f64,
    /// Bytes that it keeps, where settings differ in that.
    pub bytes: Option<f64>,
    /// Whether it is what users get unless they ask for another.
    pub is_default: bool,
    /// Whether no other setting is both as cheap and as near to the truth.
    pub is_on_front: bool,
}

/// The settings of a knob.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Stage of the chain.
    pub stage: &'static str,
    /// What is set, and by which option.
    pub knob: &'static str,
    /// What is weighed against the error.
    pub axis: Axis,
    /// What the error is, against which truth, and its unit.
    pub error: &'static str,
    /// Why the default is the default.
    pub why: &'static str,
    /// The settings, in the order of the knob.
    pub points: Vec<Point>,
}

/// What a curve is about.
pub(super) struct Head {
    pub stage: &'static str,
    pub knob: &'static str,
    pub error: &'static str,
    pub why: &'static str,
}

/// A setting that is to be timed.
pub(super) struct Trial<'a, T> {
    pub setting: String,
    pub is_default: bool,
    work: Box<Work<'a, T>>,
}

/// What is timed; it may say itself how long it took.
type Work<'a, T> = dyn Fn() -> Result<(T, Option<Duration>)> + 'a;

impl<'a, T> Trial<'a, T> {
    pub fn new(setting: impl ToString, is_default: bool, work: impl Fn() -> Result<T> + 'a) -> Self {
        let work = Box::new(move || Ok((work()?, None)));
        Self { setting: setting.to_string(), is_default, work }
    }

    /// Work that says itself how long it took, as that of another process does.
    pub fn timed(setting: impl ToString, work: impl Fn() -> Result<(T, Duration)> + 'a) -> Self {
        let work = Box::new(move || work().map(|(found, time)| (found, Some(time))));
        Self { setting: setting.to_string(), is_default: false, work }
    }
}

/// The error of a result, and the bytes it keeps.
pub(super) type Judged = (f64, Option<f64>);

/// Works that are shorter are repeated within a turn.
const SHORTEST: Duration = Duration::from_millis(2);

/// Times the trials, of which one is the default, and judges their results.
pub(super) fn curve<T>(
    head: Head,
    trials: &[Trial<T>],
    effort: Effort,
    judge: impl Fn(&T) -> Result<Judged>,
) -> Result<Curve> {
    measured(Axis::Time, head, trials, effort, judge)
}

/// The same, weighed against the bytes that are kept; the judge knows those of all.
pub(super) fn curve_of_bytes<T>(
    head: Head,
    trials: &[Trial<T>],
    effort: Effort,
    judge: impl Fn(&T) -> Result<Judged>,
) -> Result<Curve> {
    measured(Axis::Bytes, head, trials, effort, judge)
}

fn measured<T>(
    axis: Axis,
    head: Head,
    trials: &[Trial<T>],
    effort: Effort,
    judge: impl Fn(&T) -> Result<Judged>,
) -> Result<Curve> {
    let default = trials.iter().position(|trial| trial.is_default);
    let default =
        default.ok_or_else(|| Error::invalid(head.knob, "default", "none", "one of the settings"))?;
    let (mut judged, mut repeats) = (Vec::new(), Vec::new());
    for trial in trials {
        let start = Instant::now();
        judged.push(judge(&black_box((trial.work)()?).0)?);
        // Judging is no part of the work, but of this estimate: what is slow to judge is not repeated.
        repeats
            .push((SHORTEST.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-9)).ceil().max(1.0) as u32);
    }
    let times = in_turns(trials, &repeats, effort)?;
    let points = trials.iter().enumerate().map(|(k, trial)| {
        let ratios: Vec<f64> = times[k].iter().zip(&times[default]).map(|(a, b)| a / b).collect();
        let ratio = quantile(&ratios, 0.5);
        let bytes = |k: usize| judged[k].1.unwrap_or(f64::NAN);
        Point {
            setting: trial.setting.clone(),
            cost: Cost {
                seconds: quantile(&times[k], 0.5),
                quartiles: [0.25, 0.75].map(|share| quantile(&times[k], share)),
                ratio,
                turns: ratios.len(),
            },
            relative: if axis == Axis::Time { ratio } else { bytes(k) / bytes(default) },
            error: judged[k].0,
            bytes: judged[k].1,
            is_default: trial.is_default,
            is_on_front: false,
        }
    });
    let Head { stage, knob, error, why } = head;
    let mut points: Vec<Point> = points.collect();
    mark_front(&mut points);
    Ok(Curve { stage, knob, axis, error, why, points })
}

/// Seconds of each trial, one a turn, all trials as often.
fn in_turns<T>(trials: &[Trial<T>], repeats: &[u32], effort: Effort) -> Result<Vec<Vec<f64>>> {
    let (most, budget) = effort.turns();
    let start = Instant::now();
    let mut times = vec![Vec::new(); trials.len()];
    for turn in 0..most {
        let so_far = start.elapsed();
        if turn > 0 && so_far + so_far / turn as u32 > budget {
            break;
        }
        for ((trial, times), repeats) in trials.iter().zip(&mut times).zip(repeats) {
            let mut spent = Duration::ZERO;
            for _ in 0..*repeats {
                let start = Instant::now();
                let (found, own) = black_box((trial.work)()?);
                spent += own.unwrap_or_else(|| start.elapsed());
                drop(found);
            }
            times.push(spent.as_secs_f64() / f64::from(*repeats));
        }
    }
    Ok(times)
}

/// The value below which this share of the others lies, the nearest one.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((share * (sorted.len() - 1) as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Marks the Pareto front: cost and error.
fn mark_front(points: &mut [Point]) {
    let all: Vec<[f64; 2]> = points.iter().map(|point| [point.relative, point.error]).collect();
    for (point, [cost, error]) in points.iter_mut().zip(&all) {
        let beats = |[c, e]: &[f64; 2]| c <= cost && e <= error && (c < cost || e < error);
        point.is_on_front = !all.iter().any(beats);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    const HEAD: Head = Head { stage: "stage", knob: "knob", error: "error", why: "because" };
    const EFFORT: Effort = Effort { quick: true, seed: 1 };

    #[test]
    fn what_is_neither_cheap_nor_right_is_off_the_front() {
        let point = |ratio: f64, error: f64| Point {
            setting: String::new(),
            cost: Cost { seconds: ratio, quartiles: [ratio; 2], ratio, turns: 1 },
            relative: ratio,
            error,
            bytes: None,
            is_default: false,
            is_on_front: false,
        };
        let mut points =
            [point(1.0, 0.5), point(2.0, 0.5), point(3.0, 0.1), point(0.5, 0.9), point(0.5, 0.9)];
        mark_front(&mut points);
        assert_eq!(points.map(|p| p.is_on_front), [true, false, true, true, true]);
    }

    #[test]
    fn every_setting_is_run_as_often_and_judged_once() {
        let runs = [const { Cell::new(0) }; 2];
        let judged = Cell::new(0);
        let trial = |k: usize| {
            let runs = &runs;
            Trial::new(k, k == 1, move || {
                runs[k].set(runs[k].get() + 1);
                std::thread::sleep(SHORTEST);
                Ok(k)
            })
        };
        let found = curve(HEAD, &[trial(0), trial(1)], EFFORT, |k| {
            judged.set(judged.get() + 1);
            Ok((*k as f64, None))
        })
        .unwrap();
        assert_eq!(judged.get(), 2);
        assert_eq!(runs[0].get(), runs[1].get());
        assert_eq!(found.points[1].cost.ratio, 1.0);
        assert_eq!((found.points[0].error, found.points[0].cost.turns), (0.0, 5));
        let none: [Trial<usize>; 1] = [Trial::new("a", false, || Ok(1))];
        assert!(curve(HEAD, &none, EFFORT, |_| Ok((0.0, None))).is_err());
    }

    #[test]
    fn quantiles_are_values() {
        assert_eq!([0.0, 0.5, 1.0].map(|share| quantile(&[3.0, 1.0, 2.0], share)), [1.0, 2.0, 3.0]);
    }
}
