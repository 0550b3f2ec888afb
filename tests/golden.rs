//! Numbers of every stage of the chain against those in `fixtures/golden/chain.json`, on any machine and with any compiler.
//!
//! `CARPAINT_BLESS=1 cargo test --test golden` writes the file anew; a commit that does says which number moved, and why. Each
//! tolerance is for what machines differ in, last digits of sines and logarithms, and for how far that goes in its stage.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::Paint;
use carpaint::brdf::LobeGeometry;
use carpaint::brdf::ink::Ink;
use carpaint::btf::{AngleGrid, FlakeBtf};
use carpaint::cluster::{BoxRule, SliceStatistics, cluster_slice};
use carpaint::color::{lab_from_rgb, luminance};
use carpaint::fit::{FitOptions, FlakeOptions, fit_btf};
use carpaint::mix::{CoupleOptions, couple};
use carpaint::render::{Options, RenderPaint, render};
use carpaint::scene::Scene;
use carpaint::simulate::{
    Composition, Model, ModelKind, ModelOptions, Reading, SynthesisOptions, synthesize,
};
use carpaint::transport::{Cost, Problem, Solver, solve};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// A number with how far another machine's may be from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Number {
    name: String,
    value: f64,
    tolerance: f64,
    why: String,
}

/// The numbers of the chain, stage after stage.
#[derive(Default)]
struct Numbers(Vec<Number>);

impl Numbers {
    fn push(&mut self, name: impl Into<String>, value: f64, tolerance: f64, why: &str) {
        self.0.push(Number { name: name.into(), value, tolerance, why: why.to_owned() });
    }

    fn relative(&mut self, name: impl Into<String>, value: f64, share: f64, why: &str) {
        self.push(name, value, share * value.abs(), why);
    }
}

const TABLES: &str = "tables are good to 1e-9 of the peak, and L*a*b* has numbers up to a hundred";
const TEXELS: &str = "texels are f32; sums of a thousand of them";
const OPTIMUM: &str =
    "an optimizer ends where steps get small, elsewhere in a flat valley: what it lowers agrees far better";
const FITTED: &str = "follows the fit, whose colors move by less than a hundredth";
const FORMULA: &str = "a formula: last digits";

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name)
}

fn model(name: &str, kind: ModelKind) -> Model {
    let composition = Composition::read(&fixture(&format!("compositions/{name}.toml"))).unwrap();
    Model::new(&composition, ModelOptions { kind, error: 0.05 }).unwrap()
}

/// Colors of presets at an instrument's angles, from the fast and from the full model, and where the light goes.
fn simulated(all: &mut Numbers) {
    let presets = [
        ("silver_metallic", ModelKind::Fast),
        ("green_blue_flip_flop", ModelKind::Fast),
        ("blue_metallic", ModelKind::Full),
        ("solid_red", ModelKind::Full),
    ];
    for (name, kind) in presets {
        let model = model(name, kind);
        for aspecular in [15.0, 45.0, 110.0] {
            let (wi, wo) = Reading::new(45.0, aspecular).unwrap().directions();
            let lab = lab_from_rgb(PI * model.brdf_rgb(wi, wo));
            for (c, value) in ["L", "a", "b"].iter().zip(lab.to_array()) {
                all.push(format!("{name} {kind:?} 45:{aspecular} {c}"), value, 1e-6, TABLES);
            }
        }
        if kind == ModelKind::Full {
            let reflected = model.energy(PI / 4.0).unwrap().reflected.0[18];
            all.push(
                format!("{name} reflected at 45 degrees, 560 nm"),
                reflected,
                1e-8,
                "tables are good to 1e-9",
            );
        }
    }
}

/// Mean and deviation of the luminance of a slice, its clusters, and the least cost from those of one paint to the other's.
fn slices(all: &mut Numbers, btfs: &[FlakeBtf; 2]) {
    let clustered = btfs.each_ref().map(|btf| {
        let texels = &btf.slices[1].fluctuation;
        let light: Vec<f64> = texels.iter().map(|t| luminance(DVec3::from(t.map(f64::from)))).collect();
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        let variance = light.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / light.len() as f64;
        let name = btf.provenance["composition"]["title"].as_str().unwrap().to_owned();
        all.push(format!("{name} slice 1 mean"), mean, 1e-6 * variance.sqrt(), TEXELS);
        all.relative(format!("{name} slice 1 deviation"), variance.sqrt(), 1e-6, TEXELS);
        let statistics = cluster_slice(texels, 12, BoxRule::MomentMatched).unwrap();
        all.push(format!("{name} slice 1 clusters"), statistics.clusters.len() as f64, 0.0, "a count");
        let brightest = statistics.clusters.iter().map(|c| c.center().x).fold(f64::MIN, f64::max);
        all.push(format!("{name} slice 1 brightest cluster, L"), brightest, 1e-3, "corners are f32 of Lab");
        statistics
    });
    let places = |s: &SliceStatistics| -> (Vec<DVec3>, Vec<f64>) {
        s.clusters.iter().map(|c| (c.center(), c.probability)).unzip()
    };
    let [(a, p), (b, q)] = clustered.each_ref().map(places);
    let problem = Problem::from_centers(&a, &p, &b, &q, Cost::Euclidean).unwrap();
    let cost = solve(&problem, Solver::NetworkSimplex).unwrap().certificate.cost;
    all.relative("transport cost of slice 1", cost, 1e-4, "the optimum is proved; corners are f32 of Lab");
}

/// Fits of both, their blend, and a picture.
fn fitted(all: &mut Numbers, btfs: &[FlakeBtf; 2]) {
    let paints: [Paint; 2] = btfs.each_ref().map(|btf| {
        let options = FitOptions { lobes: 2, starts: 4, coat: Some(btf.coat), ..FitOptions::default() };
        let statistics = FlakeOptions { clusters: 12, ..FlakeOptions::default() };
        let (paint, report) = fit_btf(btf, &options, &statistics, &|| ()).unwrap();
        let name = btf.provenance["composition"]["title"].as_str().unwrap();
        all.relative(format!("{name} fit, error"), report.error, 1e-3, OPTIMUM);
        all.relative(format!("{name} fit, error with colors"), report.colored_error, 1e-2, OPTIMUM);
        for (k, lobe) in paint.lobes.iter().enumerate() {
            all.relative(format!("{name} lobe {k} coefficient"), lobe.coefficient, 0.05, OPTIMUM);
            all.relative(format!("{name} lobe {k} roughness"), lobe.roughness, 0.05, OPTIMUM);
        }
        paint
    });
    let named = [("a".to_owned(), &paints[0]), ("b".to_owned(), &paints[1])];
    let (mix, report) = couple(&named, &CoupleOptions::default(), &|| ()).unwrap();
    all.relative("mean distance of the coupled paints", report.mean_distance, 0.02, FITTED);
    for weights in [[0.5, 0.5], [-0.5, 1.5]] {
        let blend = mix.blend(&weights).unwrap();
        let slice = &blend.flakes.as_ref().unwrap().levels[0].slices[1];
        let brightest = slice.clusters.iter().map(|c| c.center().x).fold(f64::MIN, f64::max);
        all.push(format!("blend {weights:?} slice 1 brightest cluster, L"), brightest, 1.0, FITTED);
        let texel = DVec3::from(blend.colors.texels()[0].map(f64::from));
        for (c, value) in ["red", "green", "blue"].iter().zip(texel.to_array()) {
            all.push(format!("blend {weights:?} color table {c}"), value, 0.01, FITTED);
        }
        let scene = Scene { size: [24, 32], ..Scene::default() };
        let options = Options { samples: 4, directions: 16, ..Options::default() };
        let picture = render(&scene, &[RenderPaint::new(&blend).unwrap()], &options, &|| ()).unwrap();
        for c in 0..3 {
            let mean =
                picture.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / picture.pixels.len() as f64;
            all.relative(format!("picture of {weights:?} mean, channel {c}"), mean, 0.01, FITTED);
        }
    }
}

fn inks(all: &mut Numbers) {
    for name in ["red", "green", "blue"] {
        let ink = Ink::read(&fixture(&format!("inks/{name}.ink.json"))).unwrap();
        for angle in [20.0, 65.0] {
            let (wi, wo) = Reading::new(angle, 0.0).unwrap().directions();
            let factor = PI * ink.spectrum(&LobeGeometry::of(wi, wo)).0[18];
            all.relative(format!("{name} ink at {angle} degrees, 560 nm"), factor, 1e-9, FORMULA);
        }
    }
}

fn numbers() -> Vec<Number> {
    let mut all = Numbers::default();
    simulated(&mut all);
    let btfs = ["silver_metallic", "blue_metallic"].map(|name| {
        let grid = AngleGrid::triangle(3).unwrap();
        let options =
            SynthesisOptions { size: [32; 2], texel_mm: Some(0.015), ..SynthesisOptions::new(grid) };
        synthesize(&model(name, ModelKind::Fast), &options, &|| ()).unwrap()
    });
    slices(&mut all, &btfs);
    fitted(&mut all, &btfs);
    inks(&mut all);
    all.0
}

#[test]
fn the_numbers_of_the_chain_have_not_changed() {
    let path = fixture("golden/chain.json");
    let now = numbers();
    if std::env::var_os("CARPAINT_BLESS").is_some() {
        let text = serde_json::to_string_pretty(&now).unwrap();
        std::fs::write(&path, text + "\n").unwrap();
    }
    let golden: Vec<Number> = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert_eq!(now.len(), golden.len(), "other numbers: CARPAINT_BLESS=1 writes them anew");
    let off = |(now, golden): (&Number, &Number)| {
        assert_eq!((&now.name, &now.why), (&golden.name, &golden.why));
        let error = (now.value - golden.value).abs();
        // Not-a-numbers are wrong, too.
        let right = error <= golden.tolerance;
        (!right).then(|| format!("{}: {} was {} +- {}", now.name, now.value, golden.value, golden.tolerance))
    };
    let wrong: Vec<String> = now.iter().zip(&golden).filter_map(off).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
