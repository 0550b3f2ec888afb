//! The fast models against the full one.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

#[path = "common/directions.rs"]
mod directions;

use carpaint::simulate::instrument::Reading;
use carpaint::simulate::{Composition, Model, ModelKind, ModelOptions};
use rayon::prelude::*;

fn model(composition: &Composition, kind: ModelKind, error: f64) -> Model {
    Model::new(composition, ModelOptions { kind, error }).expect("a model")
}

fn spectra(model: &Model) -> Vec<Vec<f64>> {
    directions::of_practice().iter().map(|(wi, wo)| model.brdf(*wi, *wo).0.to_vec()).collect()
}

/// A clear film over a gray substrate, with gray mirror flakes if any.
fn paint(albedo: f64, flakes: &str) -> Composition {
    let text = format!("[substrate]\nalbedo = {albedo}\n[[film]]\nthickness_um = 15\nindex = 1.5\n{flakes}");
    Composition::parse(&text).expect("a composition")
}

fn flakes(density: f64, sigma: f64, reflectance: f64, transmittance: f64) -> String {
    format!(
        "[[film.flakes]]\narea_density = {density}\ndiameter_um = 15\nsigma_deg = {sigma}\nflake_lifetime_deg = 0\n\
         mirror = {{ reflectance = {reflectance}, transmittance = {transmittance} }}\n"
    )
}

#[test]
fn the_corrected_fast_model_is_within_five_percent_for_every_preset() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/compositions");
    let entries = std::fs::read_dir(folder).expect("the presets");
    let files: Vec<_> = entries.map(|entry| entry.expect("a file").path()).collect();
    assert!(files.len() >= 12, "{files:?}");
    files.par_iter().for_each(|file| {
        let composition = Composition::read(file).expect("a composition");
        let [corrected, full] =
            [ModelKind::FastCorrected, ModelKind::Full].map(|kind| spectra(&model(&composition, kind, 1e-3)));
        let error = directions::error(&corrected, &full);
        // The issue's.
        assert!(error < 0.05, "{}: {error:e}", file.display());
    });
}

#[test]
fn the_fast_model_is_below_the_full_one() {
    // Density, sigma, r_p, t_p, substrate, and how far below at most for light from 0 and 45 degrees in the mirror direction:
    // rounded up to a percent, what another solution of the first four gave, and ours of the last.
    let cases = [
        (0.5, 5.0, 0.6, 0.4, 0.5, 0.04),
        (2.0, 15.0, 0.6, 0.4, 0.5, 0.38),
        (2.0, 5.0, 0.6, 0.0, 0.3, 0.05),
        (0.5, 15.0, 0.6, 0.0, 0.8, 0.19),
        (0.1, 6.0, 0.6, 0.4, 0.0, 0.04),
    ];
    for (density, sigma, reflectance, transmittance, substrate, below) in cases {
        let composition = paint(substrate, &flakes(density, sigma, reflectance, transmittance));
        let [fast, full] = [ModelKind::Fast, ModelKind::Full].map(|kind| model(&composition, kind, 1e-3));
        for incidence in [0.0, 45.0] {
            let (wi, wo) = Reading::new(incidence, 0.0).expect("above the horizon").directions();
            let ratio = fast.brdf(wi, wo).0[0] / full.brdf(wi, wo).0[0];
            assert!(ratio > 1.0 - below, "density {density}, sigma {sigma}, {incidence} degrees: {ratio}");
        }
        let [fast, full] = [&fast, &full].map(spectra);
        let peak = full.iter().map(|row| row[0]).fold(0.0, f64::max);
        for (a, b) in fast.iter().zip(&full) {
            // The error asked for of the full model.
            assert!(
                a[0] - b[0] < 1e-3 * b[0].max(1e-3 * peak),
                "density {density}, sigma {sigma}: {a:?} {b:?}"
            );
        }
    }
}

#[test]
fn auto_takes_the_fast_model_where_flakes_are_few() {
    let taken = |composition: &Composition| model(composition, ModelKind::Auto, 1e-2).kind();
    assert_eq!(taken(&paint(0.5, "")), ModelKind::Fast, "no flakes");
    for sigma in [6.0, 25.0] {
        let at = |density: f64| taken(&paint(0.5, &flakes(density, sigma, 0.6, 0.0)));
        assert_eq!(at(1e-4), ModelKind::Fast, "few, sigma {sigma}");
        assert_eq!(at(1.0), ModelKind::Full, "dense, sigma {sigma}");
    }
}
