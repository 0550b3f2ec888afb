//! Sweeps of camera, lamp and weights over a ball, and how far its pixels are from what they should be.
#![allow(dead_code)]

use carpaint::Paint;
use carpaint::color::luminance;
use carpaint::paint::Flakes;
use carpaint::render::{Options, RenderPaint, render};
use carpaint::report::{ChainOptions, run_chain};
use carpaint::scene::{Camera, DirectionalLight, Environment, Scene, Shape};
use carpaint::simulate::Composition;
use glam::DVec3;
use std::path::Path;

/// Radius of the ball, pixels: a degree of the camera moves its front by 6 of them.
const RADIUS: f64 = 343.0;
/// From its middle to the camera, in radii.
const DISTANCE: f64 = 10.0;
/// Angle between camera and lamp, degrees: the lamp's mirror image stays out of the picture, flakes near it are seen.
const LAMP_DEG: f64 = 20.0;

/// The luminances of the pixels of a picture.
pub type Pixels = Vec<f64>;

/// A simulated paint of a composition of the fixtures.
pub fn simulated(name: &str, bins: usize, size: usize) -> Paint {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/compositions/{name}.toml"));
    let composition = Composition::read(&path).unwrap();
    let options = ChainOptions { bins, size, texel_mm: None, seed: 1 };
    run_chain(name, &composition, &options, |_, _| || ()).unwrap().paint
}

/// Side of a texel, millimetres.
pub fn texel_mm(paint: &Paint) -> f64 {
    paint.flakes.as_ref().unwrap().texel_mm
}

/// The same paint without its filter of footprints: texels so wide that each of them is a part of one, for which the finest level
/// is drawn from once. Where flakes are says the pitch, which stays.
pub fn unfiltered(paint: &Paint) -> Paint {
    let flakes = paint.flakes.clone().unwrap();
    Paint { flakes: Some(Flakes { texel_mm: 1e4, ..flakes }), ..paint.clone() }
}

/// The front of a ball under a lamp.
#[derive(Debug, Clone, Copy)]
pub struct Ball {
    /// Pixels along an edge of the picture.
    pub side: usize,
    /// Width of a pixel on the ball, millimetres.
    pub pixel_mm: f64,
    /// How far the camera is turned about the ball, degrees.
    pub camera_deg: f64,
    /// How far the lamp is.
    pub lamp_deg: f64,
}

impl Ball {
    /// Before a sweep.
    pub fn new(side: usize, pixel_mm: f64) -> Self {
        Self { side, pixel_mm, camera_deg: 0.0, lamp_deg: 0.0 }
    }

    fn scene(&self) -> Scene {
        let radius_mm = RADIUS * self.pixel_mm;
        let (across, ahead) = self.camera_deg.to_radians().sin_cos();
        let (up, towards) = (LAMP_DEG + self.lamp_deg).to_radians().sin_cos();
        let half = 0.5 * self.side as f64 / (RADIUS * (DISTANCE - 1.0));
        Scene {
            size: [self.side; 2],
            camera: Camera {
                position_mm: [across, -ahead, 0.0].map(|c| c * DISTANCE * radius_mm),
                vertical_fov_deg: 2.0 * half.atan().to_degrees(),
                ..Camera::default()
            },
            shape: Shape::Sphere { radius_mm },
            environment: Environment::Constant { radiance: [0.0; 3] },
            lights: vec![
                DirectionalLight { direction: [0.0, -towards, up], ..DirectionalLight::default() }.into(),
            ],
            ..Scene::default()
        }
    }

    /// A picture with so many samples a pixel; `flakes`: whether they sparkle.
    pub fn picture(&self, paint: &RenderPaint, samples: usize, flakes: bool) -> Pixels {
        let options = Options { samples, directions: 1, flakes, ..Options::default() };
        let picture = render(&self.scene(), std::slice::from_ref(paint), &options, &|| ()).unwrap();
        picture.pixels.iter().map(|p| luminance(DVec3::from(p.map(f64::from)))).collect()
    }
}

/// Samples a pixel that leave each no more than a quarter of a cell of flakes, which is some 1.5 texels wide; `texels` a side of a
/// pixel.
pub fn enough_samples(texels: f64) -> usize {
    (2.0 * texels * texels).ceil().max(32.0) as usize
}

/// Frames of a sweep against a reference: all relative to the reference's mean.
#[derive(Debug, Clone, Copy)]
pub struct Flicker {
    /// Root mean square of what pixels are off.
    pub error: f64,
    /// Of how much pixels change from frame to frame.
    pub step: f64,
    /// The same of the reference.
    pub own_step: f64,
    /// Of how far the changes are apart.
    pub step_error: f64,
}

impl Flicker {
    /// Of frames, in order, against those of a reference.
    pub fn of(frames: &[Pixels], reference: &[Pixels]) -> Self {
        let mean = mean(reference.iter().flatten());
        let (moves, own) = (steps(frames), steps(reference));
        Self {
            error: rms(differences(frames, reference)) / mean,
            step: rms(moves.iter().flatten().copied()) / mean,
            own_step: rms(own.iter().flatten().copied()) / mean,
            step_error: rms(differences(&moves, &own)) / mean,
        }
    }
}

/// Root mean square of what flakes add to smooth pictures, relative to the mean of these.
pub fn contrast(frames: &[Pixels], smooth: &[Pixels]) -> f64 {
    rms(differences(frames, smooth)) / mean(smooth.iter().flatten())
}

/// From each frame to the next.
pub fn steps(frames: &[Pixels]) -> Vec<Pixels> {
    frames.windows(2).map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| b - a).collect()).collect()
}

fn differences<'a>(a: &'a [Pixels], b: &'a [Pixels]) -> impl Iterator<Item = f64> + 'a {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a - b)
}

/// Root mean square.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), v| (sum + v * v, n + 1));
    (sum / f64::from(n)).sqrt()
}

/// Mean.
pub fn mean<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), v| (sum + v, n + 1));
    sum / f64::from(n)
}
