//! Fig. 12: a model in the flip-flop paint in surroundings with the sun. A mesh and a photographed sky where
//! CARPAINT_REFERENCE has them, a car-like body under a plain sky otherwise.

use super::{FLIP_FLOP, SUN, reference, sunny};
use crate::mosaic::{car, exposed, quick, tile, tile_with, write};
use crate::smooth::{chroma, hue};
use crate::{Figure, Finding, paints};
use carpaint::color::lab_from_rgb;
use carpaint::error::Result;
use carpaint::paint::Paint;
use carpaint::render::Options;
use carpaint::scene::{DirectionalLight, Environment, Object, Scene, Shape, Up};
use glam::DVec3;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-12",
    claim: "the flip-flop paint shows green and blue on one body in one light",
    draw,
};

/// Hues of green and of blue, degrees.
const GREEN: std::ops::Range<f64> = 120.0..200.0;
const BLUE: std::ops::Range<f64> = 220.0..300.0;
/// Below this chroma a hue is not seen.
const SEEN: f64 = 5.0;

fn draw(name: &Path) -> Result<Finding> {
    let paint = paints::simulated(FLIP_FLOP)?;
    let scene = scene();
    let picture = tile_with(&scene, &paint, &Options { samples: 4, ..quick() })?;
    let stops = picture.exposure(0.02);
    write(name, &exposed(picture, stops))?;

    // The body's own light, in white surroundings: neither gloss nor the blue of the sky.
    let mut matt = Paint { flakes: None, ..(*paint).clone() };
    matt.coat.mirror = 0.0;
    let white = Scene {
        background: Some([0.0; 3]),
        environment: Environment::Constant { radiance: [0.1; 3] },
        lights: vec![
            DirectionalLight { irradiance: [3.0; 3], direction: SUN, angular_radius_deg: 0.5 }.into(),
        ],
        ..scene
    };
    let body = tile(&white, &matt)?;
    let labs = body.pixels.iter().map(|p| lab_from_rgb(DVec3::from(p.map(f64::from))));
    let hues: Vec<f64> =
        labs.filter(|lab| chroma(*lab) > SEEN).map(|lab| hue(lab).rem_euclid(360.0)).collect();
    let share = |range: std::ops::Range<f64>| {
        100.0 * hues.iter().filter(|h| range.contains(h)).count() as f64 / hues.len() as f64
    };
    let (green, blue) = (share(GREEN), share(BLUE));
    Ok(Finding {
        holds: green > 5.0 && blue > 5.0,
        says: format!("{green:.0} % of the body that has a hue is green, {blue:.0} % blue"),
    })
}

fn scene() -> Scene {
    let (sky, sun) = sunny();
    let mut scene = Scene { size: [640, 352], environment: sky, lights: vec![sun], ..car() };
    if let Some(path) = reference("hdr/esplanade.exr") {
        scene.environment = Environment::Image { path, turn_deg: 0.0, scale: 1.0 };
    }
    if let Some(path) = reference("mesh/ToyCar_plain_geometry.glb") {
        let shape = Shape::Mesh { path, length_mm: Some(60.0), up: Up::Y };
        scene.objects = vec![Object { shape, ..scene.objects[0].clone() }];
    }
    scene
}
