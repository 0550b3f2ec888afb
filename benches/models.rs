//! The two fast models against the full one, by density and spread of the flakes, by angle, and for every preset; what
//! `auto` picks, and what each costs.
//!
//! Error: the largest difference over max(value, 1e-3 of the peak) over instrument geometries, a 10 degree grid and all
//! wavelengths, to the full model at 1e-3. Times are of composition to BRDF at six instrument geometries, of all threads,
//! the best of five, and their ratios to `fast` prepared at once.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/common/directions.rs"]
mod directions;

use carpaint::simulate::instrument::{MULTI_ANGLE, Reading};
use carpaint::simulate::models::fast_model::FastModel;
use carpaint::simulate::optics::film_optics::Preparation;
use carpaint::simulate::{Composition, Model, ModelKind, ModelOptions};
use std::hint::black_box;
use std::time::Instant;

/// Gray mirror flakes, their diffuse substrate, and the surface above.
fn flakes(substrate: f64, [reflectance, transmittance]: [f64; 2], density: f64, sigma: f64) -> Composition {
    let text = format!(
        "[substrate]\nalbedo = {substrate}\n[[film]]\nthickness_um = 15\nindex = 1.5\n[[film.flakes]]\n\
         area_density = {density}\ndiameter_um = 15\nsigma_deg = {sigma}\nflake_lifetime_deg = 0\n\
         mirror = {{ reflectance = {reflectance}, transmittance = {transmittance} }}\n"
    );
    Composition::parse(&text).expect("a legal composition")
}

fn model(composition: &Composition, kind: ModelKind, error: f64) -> Model {
    Model::new(composition, ModelOptions { kind, error }).expect("a model")
}

/// The full model as the others are held against it.
fn reference(composition: &Composition) -> Model {
    model(composition, ModelKind::Full, 1e-3)
}

fn spectra(model: &Model) -> Vec<Vec<f64>> {
    directions::of_practice().iter().map(|(wi, wo)| model.brdf(*wi, *wo).0.to_vec()).collect()
}

/// As the program calls them.
fn name(kind: ModelKind) -> String {
    serde_json::to_value(kind).expect("a name").as_str().expect("a text").to_owned()
}

fn by_density_and_spread() {
    println!(
        "{:>7} {:>9} {:>7} {:>5} {:>9} {:>14}  auto at 1e-2",
        "r_p t_p", "substrate", "density", "sigma", "fast", "fast-corrected"
    );
    for mirror in [[0.6, 0.0], [0.6, 0.4]] {
        for substrate in [0.5, 0.0] {
            for density in [0.01, 0.1, 0.3, 1.0, 3.0] {
                for sigma in [3.0, 6.0, 12.0, 25.0] {
                    let composition = flakes(substrate, mirror, density, sigma);
                    let exact = spectra(&reference(&composition));
                    let [fast, corrected] = [ModelKind::Fast, ModelKind::FastCorrected]
                        .map(|kind| directions::error(&spectra(&model(&composition, kind, 1e-2)), &exact));
                    println!(
                        "{:>3} {:>3} {substrate:>9} {density:>7} {sigma:>5} {fast:>9.1e} {corrected:>14.1e}  {}",
                        mirror[0],
                        mirror[1],
                        name(model(&composition, ModelKind::Auto, 1e-2).kind())
                    );
                }
            }
        }
    }
}

fn by_angle() {
    let composition = flakes(0.5, [0.6, 0.4], 1.0, 6.0);
    let full = reference(&composition);
    let others = [ModelKind::Fast, ModelKind::FastCorrected].map(|kind| model(&composition, kind, 1e-2));
    println!("\nover full: density 1, sigma 6, r_p 0.6, t_p 0.4, substrate 0.5");
    println!("{:>9} {:>23} {:>23}", "", "mirror direction", "45 degrees off");
    println!(
        "{:>9} {:>8} {:>14} {:>8} {:>14}",
        "incidence", "fast", "fast-corrected", "fast", "fast-corrected"
    );
    for incidence in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0] {
        let ratios = [0.0, 45.0].map(|aspecular| {
            let (wi, wo) = Reading::new(incidence, aspecular).expect("above the horizon").directions();
            others.each_ref().map(|other| other.brdf(wi, wo).0[0] / full.brdf(wi, wo).0[0])
        });
        let [[a, b], [c, d]] = ratios;
        println!("{incidence:>9} {a:>8.3} {b:>14.3} {c:>8.3} {d:>14.3}");
    }
}

/// Shortest of five runs, milliseconds.
fn time<T>(run: impl Fn() -> T) -> f64 {
    let once = || {
        let start = Instant::now();
        black_box(run());
        1e3 * start.elapsed().as_secs_f64()
    };
    (0..5).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn by_preset() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions");
    let entries = std::fs::read_dir(folder).expect("the presets");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("a file").path()).collect();
    files.sort();
    let geometries = MULTI_ANGLE[..6].iter().map(Reading::directions).collect::<Vec<_>>();
    println!(
        "\n{:<22} {:>9} {:>14} | {:>13} {:>21} {:>21}  auto at 1e-2",
        "error and time", "fast", "fast-corrected", "fast", "fast-corrected", "full at 1e-2"
    );
    for file in files {
        let composition = Composition::read(&file).expect("a composition");
        let exact = spectra(&reference(&composition));
        let error = |model: &Model| format!("{:.1e}", directions::error(&spectra(model), &exact));
        let fast =
            Model::new(&composition, ModelOptions { kind: ModelKind::Fast, error: 1e-2 }).ok().map(|fast| {
                let ms = time(|| {
                    let fast = FastModel::prepared(&composition, Preparation::Direct).expect("one film");
                    geometries.iter().map(|(wi, wo)| fast.brdf(*wi, *wo).0[0]).sum::<f64>()
                });
                (error(&fast), ms)
            });
        let [corrected, full] = [ModelKind::FastCorrected, ModelKind::Full].map(|kind| {
            let ms = time(|| {
                let model = model(&composition, kind, 1e-2);
                geometries.iter().map(|(wi, wo)| model.brdf(*wi, *wo).0[0]).sum::<f64>()
            });
            let ratio = fast.as_ref().map_or("-".to_owned(), |(_, unit)| format!("{:.1}", ms / unit));
            format!("{ms:.2} ms {ratio:>8}")
        });
        let (fast_error, fast_ms) =
            fast.map_or(("-".to_owned(), "-".to_owned()), |(error, ms)| (error, format!("{ms:.2} ms")));
        println!(
            "{:<22} {fast_error:>9} {:>14} | {fast_ms:>13} {corrected:>21} {full:>21}  {}",
            file.file_stem().expect("a name").to_string_lossy(),
            error(&model(&composition, ModelKind::FastCorrected, 1e-2)),
            name(model(&composition, ModelKind::Auto, 1e-2).kind())
        );
    }
}

fn main() {
    by_density_and_spread();
    by_angle();
    by_preset();
}
