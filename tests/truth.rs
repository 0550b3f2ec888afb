//! Flakes from statistics against what they stand for, in the picture: raw slices and Ershov's sparkles.
#![allow(clippy::expect_used, clippy::panic, clippy::print_stderr, clippy::print_stdout, clippy::unwrap_used)]

use carpaint::color::luminance;
use carpaint::render::{FlakeTruth, Options, Picture, RenderPaint, RenderSlices, render, render_truth};
use carpaint::report::{Chain, ChainOptions, run_chain};
use carpaint::scene::{Camera, DirectionalLight, Environment, Scene, Shape};
use carpaint::simulate::Composition;
use carpaint::simulate::sparkle::{Masking, SparkleModel};
use glam::DVec3;
use std::sync::LazyLock;

/// Texels of a slice and pixels of a picture: it shows slices as wholes.
const SIDE: usize = 128;

static SILVER: LazyLock<Chain> = LazyLock::new(|| {
    let text = include_str!("../fixtures/compositions/silver_metallic.toml");
    let options = ChainOptions { bins: 12, size: SIDE, texel_mm: None, seed: 3 };
    run_chain("silver", &Composition::parse(text).unwrap(), &options, |_, _| || ()).unwrap()
});

/// A panel under one lamp, seen from above; so many millimetres a pixel. Half angles are 7.5 degrees, those of a slice: between
/// slices the raw ones would blend flakes that have nothing to do with each other.
fn panel(pixel_mm: f64) -> Scene {
    let (side, distance) = (SIDE, 4000.0);
    let fov = 2.0 * (0.5 * pixel_mm * side as f64 / distance).atan().to_degrees();
    Scene {
        size: [side, side],
        camera: Camera { position_mm: [0.0, -distance, 0.0], vertical_fov_deg: fov, ..Camera::default() },
        shape: Shape::Panel { size_mm: [1e4, 1e4], normal: [0.0, -1.0, 0.0] },
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![
            DirectionalLight {
                direction: [15f64.to_radians().tan(), -1.0, 0.0],
                irradiance: [1.0; 3],
                angular_radius_deg: 0.27,
            }
            .into(),
        ],
        ..Scene::default()
    }
}

fn moments(picture: &Picture) -> (f64, f64) {
    let values: Vec<f64> = picture.pixels.iter().map(|p| luminance(DVec3::from(p.map(f64::from)))).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0))
}

#[test]
fn statistics_have_the_mean_and_the_contrast_of_the_slices_at_every_distance() {
    let Chain { btf, paint, .. } = &*SILVER;
    let (slices, paint) = (RenderSlices::new(btf), RenderPaint::new(paint).unwrap());
    let options = Options { samples: 4, ..Options::default() };
    // Each no larger than a texel: sums over texels, exact.
    let fine = Options { samples: 64, ..options };
    for texels in [1.5, 3.0, 8.0] {
        let scene = panel(texels * btf.texel_mm);
        let truth = FlakeTruth::Slices(&slices);
        let expected =
            moments(&render_truth(&scene, std::slice::from_ref(&paint), &[truth], &fine, &|| ()).unwrap());
        let found = moments(&render(&scene, std::slice::from_ref(&paint), &options, &|| ()).unwrap());
        let contrast = (found.1 / expected.1).sqrt();
        println!(
            "{texels} texels a pixel: mean {:.4}, contrast {contrast:.3} of the slices'",
            found.0 / expected.0
        );
        // Four standard errors of two means; pixels nearer to each other than a flake's four texels say the same.
        let alone = (SIDE * SIDE) as f64 * (texels / 4.0f64).min(1.0).powi(2);
        let error = 4.0 * ((found.1 + expected.1) / alone).sqrt();
        assert!((found.0 - expected.0).abs() < error, "{texels}: {found:?} {expected:?}");
        // The error of a deviation of heavy tails, and what interpolation of angles and levels costs.
        let allowed = 0.88..1.12;
        assert!(allowed.contains(&contrast), "{texels}: {contrast}");
    }
}

#[test]
fn sparkles_fluctuate_about_the_same_mean_and_less_from_afar() {
    let Chain { model, paint, .. } = &*SILVER;
    let paint = RenderPaint::new(paint).unwrap();
    let options = Options { samples: 1, ..Options::default() };
    for masking in [Masking::Dimmed, Masking::Hidden] {
        let mut sparkles = SparkleModel::new(model.optics());
        sparkles.masking = masking;
        let mut last = f64::INFINITY;
        for pixel_mm in [0.05, 0.2, 0.8] {
            let scene = panel(pixel_mm);
            let truth = FlakeTruth::Sparkles(&sparkles);
            let picture =
                render_truth(&scene, std::slice::from_ref(&paint), &[truth], &options, &|| ()).unwrap();
            let smooth = Options { flakes: false, ..options };
            let expected = moments(
                &render_truth(&scene, std::slice::from_ref(&paint), &[truth], &smooth, &|| ()).unwrap(),
            );
            let (mean, variance) = moments(&picture);
            println!(
                "{masking:?}, {pixel_mm} mm a pixel: mean {:.4}, contrast {:.3}",
                mean / expected.0,
                variance.sqrt() / mean
            );
            let error = (variance / (SIDE * SIDE) as f64).sqrt() / expected.0;
            assert!((mean / expected.0 - 1.0).abs() < 4.0 * error + 1e-3, "{pixel_mm}: {mean} {expected:?}");
            // Sixteen times the area: a sixteenth of the variance, which 16,384 heavy-tailed pixels tell to a fifth.
            assert!(variance < last / 8.0, "{pixel_mm}: {variance} after {last}");
            last = variance;
        }
    }
}
