//! Fig. 7: the halftone on a shape, under D65 (left) and A (right), by ours (top) and by the standard model.

use super::inks::{fitted, seen};
use super::prints::print;
use crate::{Figure, Finding, pictures};
use carpaint::brdf::LobeGeometry;
use carpaint::brdf::goniochromatic::ggx;
use carpaint::color::{Illuminant, delta_e_2000, lab_from_rgb};
use carpaint::error::Result;
use carpaint::proof::Coverage;
use carpaint::render::{InkModel, Options, Paper, Picture, Print, ToneMap, render_lit, render_print};
use carpaint::scene::{Scene, Shape};
use glam::{DVec3, Vec3};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "pranovich-2024-7",
    claim: "both models differ to the eye under D65 and under A, and more so where angles are grazing",
    draw,
};

/// A color beside another is seen to differ from here on, Delta-E (Mahy et al. 1994).
const SEEN: f64 = 2.3;
/// Mean angle of light and eye up to which light falls steeply, and from which on it grazes, degrees.
const STEEP: f64 = 30.0;
const GRAZING: f64 = 50.0;
/// Roughness of the lobe by which angles under several lamps are averaged: that of the inks, about.
const ROUGHNESS: f64 = 0.19;

fn draw(name: &Path) -> Result<Finding> {
    let (_, dots) = print(3)?;
    let coverage = Coverage::new(dots);
    let mut scene = Scene::proof(Shape::printed("sphere", 1.0)?);
    (scene.size, scene.background, scene.camera.vertical_fov_deg) = ([400, 400], Some([0.0; 3]), 12.5);
    let inks = fitted()?;
    let picture = |model, light| {
        let inks = seen(&inks, model, light)?;
        let print = Print { inks: &inks, coverage: &coverage, paper: Paper::BLACK };
        render_print(&scene, &print, &Options::default(), &|| ())
    };
    let lights = [Illuminant::D65, Illuminant::A];
    let [ours, standard] =
        [InkModel::Goniochromatic, InkModel::Schlick].map(|model| lights.map(|light| picture(model, light)));
    let tiles = ours.into_iter().chain(standard).collect::<Result<Vec<Picture>>>()?;
    let stops = tiles[0].exposure(Picture::WHITE_SHARE);
    pictures::mosaic(&tiles, 2).write(&name.with_added_extension("png"), stops, &ToneMap::InGamut)?;
    let angles = angles(&scene)?;
    let apart = [0, 1].map(|light| {
        let pair = [&tiles[light], &tiles[light + 2]];
        [(0.0, STEEP), (GRAZING, 90.0)].map(|range| difference(pair, &angles, range, stops))
    });
    Ok(Finding {
        holds: apart.iter().all(|[steep, grazing]| *grazing > SEEN && grazing > steep),
        says: format!(
            "D65, A: both models are Delta-E 2000 {apart:.1?} apart where the mean angle of light and eye is below {STEEP} \
             degrees, and where it is above {GRAZING}"
        ),
    })
}

/// Mean angle of light and eye at every pixel, degrees, lamps weighed by what the lobe mirrors; none where it mirrors nothing.
fn angles(scene: &Scene) -> Result<Vec<f64>> {
    let weighed = |wi: DVec3, wo: DVec3| {
        let weight = ggx(LobeGeometry::of(wi, wo).tan2_h, ROUGHNESS);
        let angle = 0.5 * (wi.z.clamp(-1.0, 1.0).acos() + wo.z.clamp(-1.0, 1.0).acos());
        Vec3::new(weight as f32, (weight * angle.to_degrees()) as f32, 0.0)
    };
    let picture = render_lit(scene, &Options::default(), &weighed, &|| ())?;
    // Black over black is no number, and in no range.
    let angle = |p: &[f32; 3]| f64::from(p[1] / p[0]);
    Ok(picture.pixels.iter().map(angle).collect())
}

/// Mean Delta-E 2000 of two pictures where angles are in a range.
fn difference([a, b]: [&Picture; 2], angles: &[f64], (low, high): (f64, f64), stops: f64) -> f64 {
    let lab = |p: &[f32; 3]| lab_from_rgb(DVec3::from(p.map(f64::from)) * stops.exp2());
    let pixels = a.pixels.iter().zip(&b.pixels).zip(angles);
    let (mut sum, mut count) = (0.0, 0.0);
    for ((a, b), _) in pixels.filter(|(_, angle)| (low..high).contains(*angle)) {
        sum += delta_e_2000(lab(a), lab(b));
        count += 1.0;
    }
    sum / count
}
