//! Fig. 5: balls in each ink under two lamps: the measurement, our model and the standard one at three roughnesses.

use super::inks::{MeasuredInk, Readings, measured, seen};
use crate::{Figure, Finding, pictures};
use carpaint::brdf::Ink;
use carpaint::brdf::instrument::Reading;
use carpaint::color::{Illuminant, delta_e_2000, lab_from_rgb, luminance};
use carpaint::error::Result;
use carpaint::render::{InkModel, Options, Picture, PrintInks, Reflecting, ToneMap, render_lit};
use carpaint::scene::{Camera, DirectionalLight, Environment, Scene, Shape};
use glam::Vec3;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "pranovich-2024-5",
    claim: "towards grazing angles ours changes color as the measurement does, which the standard model does not, and its balls \
            are nearer to the measured ones",
    draw,
};

/// Roughnesses besides the fitted one.
const ROUGHER: [f64; 2] = [0.3, 0.45];
const MODELS: [InkModel; 2] = [InkModel::Goniochromatic, InkModel::Schlick];
/// Share of a picture that is white.
const WHITE_SHARE: f64 = 0.01;

fn draw(name: &Path) -> Result<Finding> {
    let mut tiles = Vec::new();
    let (mut shifts, mut errors) = (Vec::new(), Vec::new());
    for of in measured()?.iter() {
        let row = row(of)?;
        let stops = row[0].exposure(WHITE_SHARE);
        errors.push([1, 1 + row.len() / 2].map(|k| rmse(&row[0], &row[k], stops)));
        shifts.push(shifts_of(of)?);
        // Exposed one by one, as inks are not equally bright.
        let scale = stops.exp2() as f32;
        tiles.extend(row.into_iter().map(|tile| Picture {
            pixels: tile.pixels.iter().map(|p| p.map(|c| c * scale)).collect(),
            ..tile
        }));
    }
    let columns = tiles.len() / 3;
    pictures::mosaic(&tiles, columns).write(&name.with_added_extension("png"), 0.0, &ToneMap::InGamut)?;
    let is_nearer =
        |[measured, ours, standard]: &[f64; 3]| (ours - measured).abs() < (standard - measured).abs();
    Ok(Finding {
        holds: errors.iter().all(|[ours, standard]| ours < standard) && shifts.iter().all(is_nearer),
        says: format!(
            "red, green, blue: from 20 to 65 degrees the mirrored color moves by Delta-E 2000 (measured, ours, Schlick) \
             {shifts:.1?}, luminance made equal; RMSE of the balls in sRGB codes from 0 to 1 (ours, Schlick) {errors:.3?}"
        ),
    })
}

/// A ball seen from afar, two lamps on either side.
fn ball() -> Scene {
    let lamp = |direction: [f64; 3]| {
        DirectionalLight { direction, irradiance: [1.0; 3], ..DirectionalLight::default() }.into()
    };
    Scene {
        size: [160, 160],
        shape: Shape::Sphere { radius_mm: 20.0 },
        camera: Camera { position_mm: [0.0, -400.0, 0.0], vertical_fov_deg: 6.0, ..Camera::default() },
        background: Some([0.0; 3]),
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![lamp([-0.6, -0.6, 0.5]), lamp([0.9, -0.1, 0.2])],
        ..Scene::default()
    }
}

/// The measurement, ours and the standard model at all roughnesses.
fn row(of: &MeasuredInk) -> Result<Vec<Picture>> {
    let scene = ball();
    let lit = |f: &Reflecting| render_lit(&scene, &Options { samples: 2, ..Options::default() }, f, &|| ());
    let readings = Readings::new(&of.measured)?;
    let mut row = vec![lit(&|wi, wo| readings.color(wi, wo))?];
    for model in MODELS {
        for roughness in [of.ink.roughness()].into_iter().chain(ROUGHER) {
            let inks = under_daylight(of.ink.clone().with_roughness(roughness)?, model)?;
            row.push(lit(&|wi, wo| inks.reflectance(Vec3::X, wi.as_vec3(), wo.as_vec3()))?);
        }
    }
    Ok(row)
}

fn under_daylight(ink: Ink, model: InkModel) -> Result<PrintInks> {
    seen(&[ink], model, Illuminant::D65)
}

/// Root mean square error of sRGB codes, 0 to 1, over the ball.
fn rmse(reference: &Picture, found: &Picture, stops: f64) -> f64 {
    let [a, b] = [reference, found].map(|picture| picture.encode(stops, &ToneMap::InGamut));
    let on_ball = reference.pixels.iter().map(|p| *p != [0.0; 3]);
    let (mut sum, mut count) = (0.0, 0.0);
    for ((a, b), _) in a.iter().zip(&b).zip(on_ball).filter(|(_, on_ball)| *on_ball) {
        sum += (0..3).map(|c| ((f64::from(a[c]) - f64::from(b[c])) / 255.0).powi(2)).sum::<f64>() / 3.0;
        count += 1.0;
    }
    (sum / count).sqrt()
}

/// How far the mirrored color moves from 20 to 65 degrees as measured, by ours and by the standard model.
fn shifts_of(of: &MeasuredInk) -> Result<[f64; 3]> {
    let readings = Readings::new(&of.measured)?;
    let [ours, standard] =
        [under_daylight(of.ink.clone(), MODELS[0])?, under_daylight(of.ink.clone(), MODELS[1])?];
    let shift = |color: &Reflecting| {
        let [steep, grazing] = [20.0, 65.0].map(|angle| {
            let reading = Reading { incidence_deg: angle, aspecular_deg: 0.0 };
            let (wi, wo) = reading.directions();
            let rgb = color(wi, wo).as_dvec3();
            lab_from_rgb(rgb * (0.5 / luminance(rgb)))
        });
        delta_e_2000(steep, grazing)
    };
    let modelled = |inks: &PrintInks| shift(&|wi, wo| inks.reflectance(Vec3::X, wi.as_vec3(), wo.as_vec3()));
    Ok([shift(&|wi, wo| readings.color(wi, wo)), modelled(&ours), modelled(&standard)])
}
