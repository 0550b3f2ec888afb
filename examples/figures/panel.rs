//! A panel under the sun alone, and how much it sparkles.

use carpaint::color::luminance;
use carpaint::render::{Options, Picture};
use carpaint::scene::{Camera, DirectionalLight, Environment, Scene, Shape};
use glam::DVec3;

/// What the eye tells apart: one minute of arc, radians.
pub const EYE: f64 = 2.909e-4;
/// Angle of incidence of the sun, degrees; the panel is seen along its normal.
pub const INCIDENCE_DEG: f64 = 15.0;
/// Angular radius of the sun, degrees.
pub const SUN_DEG: f64 = 0.27;

/// A panel of which a pixel shows so many millimetres.
pub fn panel(pixel_mm: f64, side: usize) -> Scene {
    // So far away that all of it is seen along the normal.
    let extent = pixel_mm * side as f64;
    let distance = 1000.0 * extent;
    let fov = 2.0 * (0.5 * extent / distance).atan().to_degrees();
    let light = DirectionalLight {
        direction: [INCIDENCE_DEG.to_radians().tan(), -1.0, 0.0],
        irradiance: [1.0; 3],
        angular_radius_deg: SUN_DEG,
    };
    Scene {
        size: [side, side],
        camera: Camera { position_mm: [0.0, -distance, 0.0], vertical_fov_deg: fov, ..Camera::default() },
        shape: Shape::Panel { size_mm: [1e5, 1e5], normal: [0.0, -1.0, 0.0] },
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![light.into()],
        ..Scene::default()
    }
}

/// How it is rendered: nothing lights it from around.
pub fn options() -> Options {
    Options { directions: 1, ..Options::default() }
}

/// Luminance of every pixel.
pub fn luminances(picture: &Picture) -> Vec<f64> {
    picture.pixels.iter().map(|p| luminance(DVec3::from(p.map(f64::from)))).collect()
}

/// Mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation over mean.
pub fn contrast(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / values.len() as f64).sqrt() / mean
}
