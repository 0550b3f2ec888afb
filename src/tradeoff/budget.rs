//! A budget: the settings of a knob are tried from the cheapest on, on the job's own input, until one is near enough, or the next too
//! slow.
//!
//! The settings are those of the report's curves. How far one is from the truth is told by the next one, which is nearer to it.

use crate::btf::FlakeSource;
use crate::cluster::{BoxRule, SliceStatistics, cluster_slice};
use crate::color::{delta_e_2000, luminance};
use crate::error::{Error, Result};
use crate::fit::{FitOptions, SmoothFit};
use crate::render::{Options, Picture, PictureDifference};
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::simulate::{Composition, Model, ModelKind, ModelOptions};
use glam::DVec3;
use std::time::{Duration, Instant};

use super::clustering::{CLUSTERS, excess};
use super::fitting::STARTS;
use super::model::{lab, lab_of_fit};

/// What a job may cost, or how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budget {
    /// Largest error, Delta-E, above 0: 2000 where two colors are compared, Wasserstein-1 in Lab where many are.
    Error(f64),
    /// Longest time of what the knob governs.
    Time(Duration),
}

/// A setting that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Tried {
    /// Its name, as the command line has it.
    pub setting: String,
    /// Seconds that the whole job is expected to take with it.
    pub seconds: f64,
    /// How far it is off, Delta-E; of the last one, which nothing tells, at most what the one before was.
    pub error: f64,
}

/// What was picked.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice<K> {
    /// The setting.
    pub knob: K,
    /// All that were tried, cheapest first.
    pub tried: Vec<Tried>,
    /// Which of them was picked.
    pub picked: usize,
    /// Whether it keeps the budget; otherwise it is the nearest to it that there is.
    pub keeps: bool,
}

/// What tries a setting: its result, and the seconds of the whole job.
type Try<'a, K, T> = &'a dyn Fn(&K) -> Result<(T, f64)>;

/// Tries settings, cheapest first. `error` compares a result with that of the next setting.
fn climb<K: Clone, T>(
    settings: &[(String, K)],
    budget: Budget,
    run: Try<K, T>,
    error: impl Fn(&T, &T) -> f64,
) -> Result<Choice<K>> {
    let mut tried: Vec<Tried> = Vec::new();
    let mut before: Option<T> = None;
    let (mut picked, mut keeps) = (0, false);
    for (k, (setting, knob)) in settings.iter().enumerate() {
        let (found, seconds) = run(knob)?;
        if let (Some(before), Some(last)) = (&before, tried.last_mut()) {
            last.error = error(before, &found);
        }
        let bound = tried.last().map_or(f64::INFINITY, |last| last.error);
        tried.push(Tried { setting: setting.clone(), seconds, error: bound });
        before = Some(found);
        match budget {
            Budget::Error(most) if bound <= most => {
                (picked, keeps) = (k - 1, true);
                break;
            }
            Budget::Time(most) if seconds > most.as_secs_f64() => break,
            Budget::Time(_) => (picked, keeps) = (k, true),
            Budget::Error(_) => picked = k,
        }
    }
    match settings.get(picked) {
        Some((_, knob)) => Ok(Choice { knob: knob.clone(), tried, picked, keeps }),
        None => Err(Error::invalid("budget", "settings", "none", "one or more")),
    }
}

/// The model and its tolerance, by the colors at the geometries of multi-angle instruments (ASTM E2194, E2539).
///
/// # Errors
/// Those of the models.
pub fn pick_model(composition: &Composition, budget: Budget) -> Result<Choice<ModelOptions>> {
    let fast = ModelOptions { kind: ModelKind::Fast, ..ModelOptions::default() };
    let full = [0.1, 0.01, 1e-3, 1e-4].map(|error| ModelOptions { kind: ModelKind::Full, error });
    let mut settings = Vec::new();
    // The fast model has no pigments and one film.
    if Model::new(composition, fast).is_ok() {
        settings.push(("--model fast".to_owned(), fast));
    }
    settings.extend(full.map(|options| (format!("--model full --tolerance {}", options.error), options)));
    let run = |options: &ModelOptions| {
        let start = Instant::now();
        let model = Model::new(composition, *options)?;
        let colors = lab(&model);
        Ok((colors, start.elapsed().as_secs_f64()))
    };
    climb(&settings, budget, &run, |a, b| largest(a, b))
}

/// Random starts of the optimizer, by the colors that fits have at the same geometries. `fit` fits; the job is one fit.
///
/// # Errors
/// Those of the fit.
pub fn pick_starts(
    options: &FitOptions,
    budget: Budget,
    fit: impl Fn(&FitOptions) -> Result<SmoothFit>,
) -> Result<Choice<usize>> {
    let settings = STARTS.map(|starts| (format!("--starts {starts}"), starts));
    let run = |starts: &usize| {
        let start = Instant::now();
        let found = fit(&FitOptions { starts: *starts, ..options.clone() })?;
        Ok((lab_of_fit(&found), start.elapsed().as_secs_f64()))
    };
    climb(&settings, budget, &run, |a, b| largest(a, b))
}

/// Slices that are looked at for the strongest ones, and how many of these are reduced.
const SEEN: usize = 40;
const REDUCED: usize = 3;
/// All levels of detail have so many texels for one of the finest.
const LEVELS: f64 = 4.0 / 3.0;

/// Clusters a slice, by the colors drawn from the strongest of some slices. The job is the reduction of all, on as many threads as
/// there are.
///
/// # Errors
/// Those of the source and of the reduction.
pub fn pick_clusters(source: &dyn FlakeSource, boxes: BoxRule, budget: Budget) -> Result<Choice<usize>> {
    let count = source.grid().len();
    let mut seen = Vec::new();
    for k in (0..count).step_by(count.div_ceil(SEEN)) {
        let texels = source.slice(k)?.into_owned().fluctuation;
        let energy: f64 = texels.iter().map(|t| luminance(DVec3::from(t.map(f64::from))).powi(2)).sum();
        seen.push((energy, texels));
    }
    seen.sort_by(|a, b| b.0.total_cmp(&a.0));
    seen.truncate(REDUCED);
    let share = LEVELS * count as f64 / (seen.len() * rayon::current_num_threads()).max(1) as f64;
    let settings = CLUSTERS.map(|clusters| (format!("--clusters {clusters}"), clusters));
    let run = |clusters: &usize| {
        let start = Instant::now();
        let reduced: Vec<SliceStatistics> =
            seen.iter().map(|(_, texels)| cluster_slice(texels, *clusters, boxes)).collect::<Result<_>>()?;
        let seconds = share * start.elapsed().as_secs_f64();
        let mut error = 0.0;
        for (seed, ((_, texels), statistics)) in (1..).zip(seen.iter().zip(&reduced)) {
            error += excess(texels, statistics, &Sampler::exact(statistics)?, seed)? / seen.len() as f64;
        }
        Ok((error, seconds))
    };
    // The texels themselves are the truth.
    climb(&settings, budget, &run, |error, _| *error)
}

/// Rays a pixel that are tried.
const SAMPLES: [usize; 11] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];
/// Pixels of the picture that they are tried on, at most.
const PIXELS: f64 = 10_000.0;

/// Rays a pixel, by the smooth part of a smaller picture of the same scene; each try has a seed of its own. `render` renders as the job
/// will; `tiles`: how many pictures side by side it is.
///
/// # Errors
/// Those of the renderer.
pub fn pick_samples(
    scene: &Scene,
    options: &Options,
    budget: Budget,
    render: impl Fn(&Scene, &Options) -> Result<Picture>,
) -> Result<Choice<usize>> {
    let pixels = (scene.size[0] * scene.size[1]) as f64;
    let shrink = (PIXELS / pixels).sqrt().min(1.0);
    let small = Scene { size: scene.size.map(|n| ((n as f64 * shrink) as usize).max(1)), ..scene.clone() };
    let share = pixels / (small.size[0] * small.size[1]) as f64;
    // What is loaded and compiled once is no part of a ray.
    render(&small, &Options { samples: 1, ..*options })?;
    let settings = SAMPLES.map(|samples| (format!("--samples {samples}"), samples));
    let run = |samples: &usize| {
        let start = Instant::now();
        let sparkling = render(&small, &Options { samples: *samples, ..*options })?;
        let seconds = share * start.elapsed().as_secs_f64();
        drop(sparkling);
        let seed = options.seed.wrapping_add(*samples as u32);
        let smooth = render(&small, &Options { samples: *samples, flakes: false, seed, ..*options })?;
        Ok((exposed(smooth, scene.exposure_stops), seconds))
    };
    climb(&settings, budget, &run, |a, b| {
        PictureDifference::of(a, b).map_or(f64::INFINITY, |d| d.delta_e_2000)
    })
}

fn exposed(mut picture: Picture, stops: f64) -> Picture {
    let gain = stops.exp2() as f32;
    picture.pixels.iter_mut().flatten().for_each(|value| *value *= gain);
    picture
}

fn largest(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| delta_e_2000(*a, *b)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Settings whose errors are halved and whose times are doubled from one to the next.
    fn climbed(budget: Budget) -> Choice<i32> {
        let settings: Vec<(String, i32)> = (0..5).map(|k| (k.to_string(), k)).collect();
        // A result is its own error against a truth of 0.
        let run = |k: &i32| Ok((0.5f64.powi(*k), 2.0f64.powi(*k)));
        climb(&settings, budget, &run, |a, b| a - b).unwrap()
    }

    #[test]
    fn the_cheapest_that_is_near_enough_is_picked() {
        let choice = climbed(Budget::Error(0.25));
        assert_eq!((choice.knob, choice.keeps, choice.tried.len()), (1, true, 3));
        assert_eq!(choice.tried[1].error, 0.25);
        let none = climbed(Budget::Error(1e-3));
        assert_eq!((none.knob, none.keeps), (4, false), "the best there is");
    }

    #[test]
    fn the_best_that_is_fast_enough_is_picked() {
        let choice = climbed(Budget::Time(Duration::from_secs(4)));
        assert_eq!(
            (choice.knob, choice.keeps, choice.tried.len()),
            (2, true, 4),
            "slower ones are not tried"
        );
        assert_eq!(choice.tried[choice.picked].error, 0.125, "told by the next one");
        let none = climbed(Budget::Time(Duration::from_millis(1)));
        assert_eq!((none.knob, none.keeps), (0, false), "the cheapest there is");
        assert_eq!(climbed(Budget::Time(Duration::from_secs(100))).knob, 4);
    }
}
