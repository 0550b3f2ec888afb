//! A rough surface on its way to a paint: the coat's lobe against the gloss it stands for, and the fit that leaves it alone.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::brdf::fresnel::{dielectric, schlick};
use carpaint::brdf::{ClearCoat, LobeGeometry};
use carpaint::btf::AngleGrid;
use carpaint::fit::{FitOptions, albedo, fit_btf};
use carpaint::math::half_difference::spherical;
use carpaint::simulate::models::gloss::Gloss;
use carpaint::simulate::{Composition, Model, ModelKind, ModelOptions, SynthesisOptions, synthesize};
use std::f64::consts::PI;

#[test]
fn the_lobe_of_a_rough_coat_is_the_gloss_up_to_schlick() {
    let index = 1.5;
    for degrees in [0.01f64, 0.5, 1.0, 3.0] {
        let sigma = degrees.to_radians();
        let gloss = Gloss::new(index, sigma).unwrap();
        let lobe = ClearCoat::rough(index, false, sigma).gloss.unwrap();
        for angle in [0.0, 15.0, 30.0, 45.0, 60.0f64] {
            let theta = angle.to_radians();
            // All that a narrow lobe sends back is Schlick's reflectance; facets tilted by some sigma / 2 shadow each other:
            // terms of sigma^2 times tan^2(theta), 2.1 sigma^2 at 60 degrees.
            let share = albedo(&lobe, theta) / schlick(lobe.f0, theta.cos());
            assert!((share - 1.0).abs() < 1e-6 + 3.0 * sigma * sigma, "{degrees} {angle}: {share}");
            // What the gloss sends back is Fresnel's reflectance, a law of its own. Schlick's is below it by 0.0015 of 0.0415
            // at 30 degrees and 0.0192 of 0.0892 at 60.
            let reflectance = dielectric(theta.cos(), index);
            let lost = 1.0 - albedo(&lobe, theta) / reflectance;
            let bar = if angle > 30.0 { 0.22 } else { 0.04 };
            assert!((-1e-6..bar).contains(&lost), "{degrees} {angle}: {lost}");
            // Facets see a tilt across the plane of incidence shortened, so the lobe is narrower there by the cosine, and
            // higher; the rest again to sigma^2.
            let (wi, wo) = (spherical(theta, 0.0), spherical(theta, PI));
            let taller = lobe.eval(&LobeGeometry::of(wi, wo)) / gloss.brdf(wi, wo);
            let peak = taller * theta.cos() * reflectance / schlick(lobe.f0, theta.cos());
            assert!((peak - 1.0).abs() < 1e-6 + 2.0 * sigma * sigma, "{degrees} {angle}: {peak}");
        }
        // Light along the normal falls by exp(-1/2) a width sigma beside it.
        let at = |theta: f64| lobe.eval(&LobeGeometry::of(spherical(0.0, 0.0), spherical(theta, 0.0)));
        assert!((at(sigma) / at(0.0) - (-0.5f64).exp()).abs() < sigma * sigma, "{degrees}");
    }
}

#[test]
fn a_fit_leaves_the_gloss_of_a_rough_surface_alone() {
    let paint = |surface: &str| {
        let text = format!(
            "substrate = {{ albedo = 0.2 }}\n{surface}\n[[film]]\nthickness_um = 16\nindex = 1.5\n\
             [[film.flakes]]\narea_density = 0.8\ndiameter_um = 15\nsigma_deg = 6\nmirror = {{ reflectance = 0.8 }}\n"
        );
        let fast = ModelOptions { kind: ModelKind::Fast, ..ModelOptions::default() };
        let model = Model::new(&Composition::parse(&text).unwrap(), fast).unwrap();
        let options =
            SynthesisOptions { size: [32; 2], ..SynthesisOptions::new(AngleGrid::triangle(3).unwrap()) };
        let btf = synthesize(&model, &options, &|| ()).unwrap();
        assert_eq!(btf.coat, model.coat());
        let options = FitOptions { coat: Some(btf.coat), starts: 1, lobes: 2, ..FitOptions::default() };
        fit_btf(&btf, &options, &Default::default(), &|| ()).unwrap()
    };
    let (smooth, smooth_report) = paint("");
    let (rough, rough_report) = paint("surface = { roughness_deg = 1 }");
    assert_eq!(smooth.coat, ClearCoat::ideal(1.5, false));
    assert_eq!(rough.coat, ClearCoat::rough(1.5, false, 1f64.to_radians()));
    // The table holds no gloss either way, so all else is the same to the last bit.
    assert_eq!((smooth.diffuse, &smooth.lobes, &smooth.colors), (rough.diffuse, &rough.lobes, &rough.colors));
    assert_eq!(smooth.flakes, rough.flakes);
    assert_eq!(smooth_report.aspecular, rough_report.aspecular);
    assert_eq!((rough_report.error, rough_report.gloss_error), (smooth_report.error, None));
    assert_eq!(rough_report.coat, rough.coat);
}
