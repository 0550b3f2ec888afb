//! Rump, Müller, Sarlette, Koch & Klein 2008, Photo-realistic Rendering of Metallic Car Paint from Image-Based Measurements.

mod figure_1;
mod figure_10;
mod figure_11;
mod figure_12;
mod figure_2;
mod figure_8;
mod figure_9;

use crate::{Figure, paints};
use carpaint::btf::FlakeBtf;
use carpaint::error::Result;
use carpaint::math::half_difference::directions;
use carpaint::render::Picture;
use carpaint::scene::{DirectionalLight, Environment, Light};
use carpaint::simulate::{Model, ModelOptions};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;

pub const FIGURES: &[Figure] = &[
    figure_1::FIGURE,
    figure_2::FIGURE,
    figure_8::FIGURE,
    figure_9::FIGURE,
    figure_10::FIGURE,
    figure_11::FIGURE,
    figure_12::FIGURE,
];

/// The paper's green-blue flip-flop; ours.
const FLIP_FLOP: &str = "green_blue_flip_flop";

/// It with a surface that is not quite smooth, as real ones are: its gloss is a lobe that a table can hold.
fn glossy() -> Result<Model> {
    let mut composition = paints::composition(FLIP_FLOP)?;
    composition.surface.roughness_deg = 1.5;
    Model::new(&composition, ModelOptions::default())
}

/// Its BRDF, gloss included.
fn brdf(model: &Model, wi: DVec3, wo: DVec3) -> DVec3 {
    model.brdf_rgb(wi, wo) + DVec3::splat(model.gloss(wi, wo))
}

/// Real data, where CARPAINT_REFERENCE names their folder and has them.
fn reference(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(std::env::var_os("CARPAINT_REFERENCE")?).join("data").join(name);
    path.exists().then_some(path)
}

/// A clear day: the sky without its sun, and the sun.
fn sunny() -> (Environment, Light) {
    let sky = Environment::Studio {
        ground: [0.16, 0.14, 0.11],
        horizon: [0.62, 0.68, 0.75],
        zenith: [0.16, 0.28, 0.55],
        softbox: Vec::new(),
    };
    (sky, DirectionalLight { direction: SUN, irradiance: [9.0, 8.6, 7.9], angular_radius_deg: 0.27 }.into())
}

/// Towards the sun.
const SUN: [f64; 3] = [-0.5, -0.7, 0.6];

/// The slice in whose middle the flakes of a BTF are looked at: theta_h 7.5, theta_i 30 degrees.
fn slice(btf: &FlakeBtf) -> usize {
    let bin = |degrees: f64| (degrees.to_radians() / btf.grid.width()).round() as usize;
    btf.grid.slice(bin(7.5), bin(30.0)).unwrap_or(0)
}

/// What the coat lets through of a slice.
fn passed(btf: &FlakeBtf, k: usize) -> f64 {
    let (theta_h, theta_i) = btf.grid.angles(k);
    let (wi, wo) = directions(theta_h, theta_i, FRAC_PI_2);
    btf.coat.transmittance(wi.z, wo.z)
}

/// Texels as a picture, each `times` pixels wide.
fn enlarged(texels: &[[f32; 3]], size: [usize; 2], times: usize) -> Picture {
    let wide = size.map(|n| n * times);
    let texel = |k: usize| texels[k / wide[0] / times * size[0] + k % wide[0] / times];
    Picture { size: wide, pixels: (0..wide[0] * wide[1]).map(texel).collect() }
}
