//! Laws of the whole chain for random legal recipes: nothing panics, nothing is no number, and no light is made.
//!
//! The cases are the same in every run. `PROPTEST_CASES=500 PROPTEST_RNG_SEED=7` tries more, and others; a failure prints the recipe.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "properties/compositions.rs"]
mod compositions;
#[path = "properties/end_points.rs"]
mod end_points;
#[path = "properties/light.rs"]
mod light;
#[path = "mix/paints.rs"]
mod paints;

use carpaint::brdf::TabulatedBrdf;
use carpaint::btf::{AngleGrid, FlakeBtf};
use carpaint::fit::{FitOptions, FlakeOptions, fit_btf};
use carpaint::math::half_difference::spherical;
use carpaint::mix::{BlendOptions, Channels, CoupleOptions, LobePath, Mix, Path, couple};
use carpaint::render::{Options, Random, RenderPaint, render, shade_mean};
use carpaint::scene::Scene;
use carpaint::simulate::{Composition, Model, ModelKind, ModelOptions, Synthesis, SynthesisOptions};
use carpaint::{Paint, Result};
use compositions::{Shown, any_paint, drawn_paint};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::{RngSeed, TestCaseError, TestRunner};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::time::Instant;

/// Loose: what these laws ask for does not depend on it, and it takes a tenth of the time of the default.
const ERROR: f64 = 0.05;

/// What the random recipes came to.
#[derive(Default)]
struct Tally(Mutex<BTreeMap<String, usize>>);

impl Tally {
    fn count(&self, outcome: &str) {
        *self.0.lock().unwrap().entry(outcome.to_owned()).or_default() += 1;
    }

    /// What was made; of what is refused the error must say why, for a reason that is known.
    fn accepted<T>(
        &self,
        made: Result<T>,
        reasons: &[&str],
    ) -> std::result::Result<Option<T>, TestCaseError> {
        match made {
            Ok(made) => Ok(Some(made)),
            Err(error) => {
                let message = error.to_string();
                let reason = reasons.iter().find(|reason| message.contains(**reason));
                let Some(reason) = reason else {
                    return Err(TestCaseError::fail(format!("refused: {message}")));
                };
                prop_assert!(message.contains("found") && message.contains("expected"), "{message}");
                self.count(reason);
                Ok(None)
            }
        }
    }
}

/// Runs a law on cases, `few` unless the environment asks for more, and says what came of them: at least a quarter must not be refused (a case
/// of two recipes is if either is).
fn hold<S: Strategy>(
    few: u32,
    cases: S,
    law: impl Fn(&Tally, S::Value) -> std::result::Result<(), TestCaseError>,
) {
    let asked = ProptestConfig::default();
    let config = ProptestConfig {
        cases: if std::env::var_os("PROPTEST_CASES").is_some() { asked.cases } else { few },
        rng_seed: if asked.rng_seed == RngSeed::Random { RngSeed::Fixed(1) } else { asked.rng_seed },
        failure_persistence: None,
        // A smaller recipe that fails is looked for on demand: each takes a second.
        max_shrink_iters: if asked.max_shrink_iters == u32::MAX { 0 } else { asked.max_shrink_iters },
        ..asked
    };
    let number = config.cases as usize;
    let tally = Tally::default();
    let run = |case| {
        let (started, shown) = (Instant::now(), format!("{case:?}"));
        let outcome = law(&tally, case);
        // With --nocapture; no law, but what one would like to know.
        if started.elapsed().as_secs() >= 5 {
            println!("{:.1} s: {shown}", started.elapsed().as_secs_f64());
        }
        outcome
    };
    TestRunner::new(config).run(&cases, run).unwrap_or_else(|e| panic!("{e}"));
    let counts = tally.0.into_inner().unwrap();
    println!("{number} cases: {counts:?}");
    assert!(4 * counts.get("held").copied().unwrap_or(0) >= number, "most are refused: {counts:?}");
}

fn kinds() -> impl Strategy<Value = ModelKind> {
    select(vec![ModelKind::Fast, ModelKind::FastCorrected, ModelKind::Full, ModelKind::Auto])
}

/// What no model solves, what the fast one does not know, and stacks whose fringes no table follows.
const NO_MODEL: &[&str] =
    &["fast model", "too thick", "thickness_spread", "reflectance of a stack", "extinction of stacks"];

fn model(composition: &Composition, kind: ModelKind) -> Result<Model> {
    Model::new(composition, ModelOptions { kind, error: ERROR })
}

#[test]
fn brdfs_are_numbers_reciprocal_and_make_no_light() {
    hold(16, (any_paint(), kinds(), 0.0..89.9f64), |tally, (Shown(composition), kind, incidence)| {
        // As a file holds it.
        let text = serde_json::to_string(&composition).unwrap();
        prop_assert_eq!(&serde_json::from_str::<Composition>(&text).unwrap(), &composition);
        let Some(model) = tally.accepted(model(&composition, kind), NO_MODEL)? else { return Ok(()) };
        light::numbers_and_reciprocity(&model)?;
        for incidence in [0.0, 60.0, incidence] {
            light::none_is_made(&model, f64::to_radians(incidence))?;
        }
        tally.count("held");
        Ok(())
    });
}

const GRID: usize = 3;
/// Polar and azimuthal cells of the smooth table.
const SMOOTH: [usize; 2] = [12, 16];

/// A small flake BTF.
fn synthesized(model: &Model, seed: u64, parallax: bool) -> Result<FlakeBtf> {
    let grid = AngleGrid::triangle(GRID)?;
    let options = SynthesisOptions {
        size: [16; 2],
        texel_mm: Some(0.02),
        seed,
        parallax,
        ..SynthesisOptions::new(grid)
    };
    let synthesis = Synthesis::new(model, &options)?;
    Ok(FlakeBtf {
        slices: (0..options.grid.len()).map(|k| synthesis.slice(k)).collect(),
        smooth: TabulatedBrdf::from_fn(SMOOTH[0], SMOOTH[1], |wi, wo| model.brdf_rgb(wi, wo))?,
        coat: model.coat(),
        provenance: serde_json::Value::Null,
        grid: options.grid.clone(),
        size: options.size,
        texel_mm: synthesis.texel_mm(),
    })
}

fn fitted(btf: &FlakeBtf, lobes: usize, clusters: usize) -> Result<Paint> {
    let options =
        FitOptions { lobes, starts: 1, coat: Some(btf.coat), table_size: [8, 8], ..FitOptions::default() };
    let statistics = FlakeOptions { clusters, ..FlakeOptions::default() };
    Ok(fit_btf(btf, &options, &statistics, &|| ())?.0)
}

/// A paint of a recipe, with the way in which it is made.
#[derive(Debug, Clone)]
struct Recipe {
    composition: Shown,
    kind: ModelKind,
    seed: u64,
    parallax: bool,
    lobes: usize,
    clusters: usize,
}

fn recipes() -> impl Strategy<Value = Recipe> {
    (drawn_paint(), kinds(), any::<u64>(), any::<bool>(), 1..=3usize, 1..=20usize).prop_map(
        |(composition, kind, seed, parallax, lobes, clusters)| Recipe {
            composition,
            kind,
            seed,
            parallax,
            lobes,
            clusters,
        },
    )
}

impl Recipe {
    fn paint(&self, tally: &Tally) -> std::result::Result<Option<Paint>, TestCaseError> {
        let made = tally.accepted(model(&self.composition.0, self.kind), NO_MODEL)?;
        let Some(model) = made else { return Ok(None) };
        let btf =
            synthesized(&model, self.seed, self.parallax).map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert!(btf.validate().is_ok());
        // What reflects nothing at all has no lobe that a fit could find.
        let black = btf.smooth.values().iter().all(|color| color.iter().all(|c| *c <= 0.0));
        let reasons: &[&str] = if black { &["no positive intensity"] } else { &[] };
        let paint = tally.accepted(fitted(&btf, self.lobes, self.clusters), reasons)?;
        if let Some(paint) = &paint {
            look(paint)?;
        }
        Ok(paint)
    }
}

/// A file of the paint gives it back, and a picture of it holds numbers.
fn look(paint: &Paint) -> std::result::Result<(), TestCaseError> {
    let checked = paint.validate();
    prop_assert!(checked.is_ok(), "{checked:?}");
    let file = tempfile::Builder::new().suffix(".paint.exr").tempfile().unwrap();
    paint.write(file.path()).unwrap();
    prop_assert_eq!(&Paint::read(file.path()).unwrap(), paint, "from its file");
    let worn = RenderPaint::new(paint).map_err(|e| TestCaseError::fail(e.to_string()))?;
    for (theta_i, theta_o, phi) in [(0.0, 0.0, 0.0), (0.7, 0.7, 3.1), (0.2, 1.5, 1.0), (1.57, 1.57, 0.1)] {
        let seen = shade_mean(&worn, spherical(theta_i, 0.0).as_vec3(), spherical(theta_o, phi).as_vec3());
        prop_assert!(seen.is_finite(), "{theta_i} {theta_o} {phi}: {seen}");
    }
    let scene = Scene { size: [8, 10], ..Scene::default() };
    let options = Options { samples: 2, directions: 4, seed: 1, flakes: true, random: Random::Hash };
    let picture =
        render(&scene, &[worn], &options, &|| ()).map_err(|e| TestCaseError::fail(e.to_string()))?;
    let bad = picture.pixels.iter().position(|pixel| !pixel.iter().all(|c| c.is_finite()));
    prop_assert!(bad.is_none(), "pixel {bad:?}: {:?}", picture.pixels[bad.unwrap_or(0)]);
    Ok(())
}

/// A weight of the second paint: inside, or extrapolated.
fn weights() -> impl Strategy<Value = f64> {
    prop_oneof![3 => 0.0..=1.0, 2 => -1.0..=2.0, 1 => select(vec![-1.0, 2.0, 0.5, 1e-9])]
}

fn blends() -> impl Strategy<Value = BlendOptions> {
    (select(Path::ALL.to_vec()), select(Channels::ALL.to_vec()), 0..2usize, select(LobePath::ALL.to_vec()))
        .prop_map(|(path, channels, source, lobes)| BlendOptions {
            path: Some(path),
            channels,
            source,
            lobes,
        })
}

#[test]
fn the_chain_holds_for_any_two_paints() {
    let cases = (recipes(), recipes(), select(Path::ALL.to_vec()), blends(), weights());
    hold(8, cases, |tally, (a, b, path, blend, weight)| {
        let (Some(a), Some(b)) = (a.paint(tally)?, b.paint(tally)?) else { return Ok(()) };
        let options = CoupleOptions { path, ..CoupleOptions::default() };
        let named = [("a".to_owned(), &a), ("b".to_owned(), &b)];
        let (mix, report) =
            couple(&named, &options, &|| ()).map_err(|e| TestCaseError::fail(e.to_string()))?;
        // Proved but for roundings.
        prop_assert!(report.worst_relative_gap < 1e-9, "{}", report.worst_relative_gap);
        stored(&mix)?;
        for (end, weights) in [(&a, [1.0, 0.0]), (&b, [0.0, 1.0])] {
            end_points::same(&mix.blend(&weights).unwrap(), end)?;
        }
        let weights = [1.0 - weight, weight];
        for options in [BlendOptions::default(), blend] {
            let blended =
                mix.blend_with(&weights, &options).map_err(|e| TestCaseError::fail(e.to_string()))?;
            look(&blended)?;
        }
        tally.count("held");
        Ok(())
    });
}

/// A file of the mix gives it back.
fn stored(mix: &Mix) -> std::result::Result<(), TestCaseError> {
    let file = tempfile::Builder::new().suffix(".paint.exr").tempfile().unwrap();
    mix.write(file.path()).unwrap();
    prop_assert!(&Mix::read(file.path()).unwrap() == mix, "from its file");
    Ok(())
}
