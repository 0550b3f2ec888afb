//! The full model: what nodes, azimuth modes, doublings and wavelengths cost, and the error they leave.
//!
//! Error: the largest difference over max(value, 1e-3 of the peak) over instrument geometries, a 10 degree grid and all
//! wavelengths, to a solution with more of everything. Times are of all threads, optics tabulated before; ratios to the
//! first row, what [`Settings::choose`] takes for 1 %, the second with all wavelengths.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/directions.rs"]
mod directions;

use carpaint::simulate::models::accuracy::Settings;
use carpaint::simulate::models::bands::Bands;
use carpaint::simulate::models::transfer::film_kernel::Resolution;
use carpaint::simulate::optics::film_optics::PaintOptics;
use carpaint::simulate::{Accuracy, Composition, FullModel};
use std::time::Instant;

fn spectra(model: &FullModel) -> Vec<Vec<f64>> {
    directions::of_practice().iter().map(|(wi, wo)| model.brdf(*wi, *wo).0.to_vec()).collect()
}

/// Shortest of some runs, milliseconds.
fn time(optics: &PaintOptics, settings: &Settings) -> (f64, FullModel) {
    let mut best = f64::INFINITY;
    let mut model = None;
    for _ in 0..5 {
        let start = Instant::now();
        model = Some(FullModel::with_settings(optics, settings).expect("solved"));
        best = best.min(1e3 * start.elapsed().as_secs_f64());
    }
    (best, model.expect("a run"))
}

const THREE_LAYERS: &str = r#"
[substrate]
albedo = [[380, 0.2], [550, 0.4], [780, 0.5]]
[[film]]
thickness_um = 20
index = 1.5
absorption_per_mm = [[380, 20], [500, 8], [600, 3], [780, 2]]
[[film.pigments]]
rayleigh = { scattering_per_mm = 15, extinction_per_mm = 20 }
[[film.pigments]]
henyey_greenstein = { scattering_per_mm = [[380, 30], [780, 15]], extinction_per_mm = [[380, 40], [600, 26], [780, 20]], asymmetry = 0.6 }
[[film]]
thickness_um = 16
index = 1.5
[[film.flakes]]
area_density = 0.6
diameter_um = 16
sigma_deg = 7
mirror = { reflectance = [[380, 0.76], [550, 0.8], [780, 0.77]] }
[[film.flakes]]
area_density = 0.4
diameter_um = 18
sigma_deg = 8
stack = [{ material = "TiO2", thickness_nm = 60 }, { material = "mica", thickness_nm = 300 }, { material = "TiO2", thickness_nm = 60 }]
"#;

fn main() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions/");
    let read =
        |name: &str| Composition::read(format!("{folder}{name}.toml").as_ref()).expect("a composition");
    let paints = [
        ("silver metallic", read("silver_metallic")),
        ("blue metallic", read("blue_metallic")),
        ("three layers", Composition::parse(THREE_LAYERS).expect("a composition")),
    ];
    for (name, composition) in &paints {
        let optics = PaintOptics::new(composition).expect("optics");
        let chosen = Settings::choose(&optics, &Accuracy::default()).expect("settings");
        let reference = Settings {
            nodes: 24,
            thinness: 0.01,
            negligible: 1e-7,
            bands: Bands::All,
            resolution: Resolution { modes: 64, cutoff: 1e-8, azimuths: 8, ..chosen.resolution },
            ..chosen.clone()
        };
        let exact = spectra(&FullModel::with_settings(&optics, &reference).expect("solved"));
        println!(
            "{name}\n{:>6} {:>6} {:>8} {:>9} {:>6} {:>10} {:>6} {:>9}",
            "nodes", "modes", "thinness", "doublings", "bands", "ms", "ratio", "error"
        );
        let mut unit = None;
        let mut row = |settings: &Settings| {
            let (ms, model) = time(&optics, settings);
            let unit = *unit.get_or_insert(ms);
            println!(
                "{:>6} {:>6} {:>8.3} {:>9} {:>6} {ms:>10.1} {:>6.2} {:>9.1e}",
                settings.nodes,
                settings.resolution.modes,
                settings.thinness,
                model.doublings(),
                model.bands(),
                ms / unit,
                directions::error(&spectra(&model), &exact)
            );
        };
        row(&chosen);
        row(&Settings { bands: Bands::All, ..chosen.clone() });
        // Nodes, modes, first layers: each alone, then all.
        let curve = [
            (6, 16, 0.08),
            (8, 16, 0.08),
            (12, 16, 0.08),
            (10, 8, 0.08),
            (10, 12, 0.08),
            (10, 24, 0.08),
            (10, 16, 0.4),
            (10, 16, 0.2),
            (10, 16, 0.04),
            (18, 32, 0.02),
        ];
        for (nodes, modes, thinness) in curve {
            let mut settings = chosen.clone();
            settings.nodes = nodes;
            settings.resolution.modes = modes;
            settings.thinness = thinness;
            row(&settings);
        }
    }
}
