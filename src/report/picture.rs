//! Pictures against the analytic model, pixel by pixel.

use super::Check;
use super::stage::mean;
use crate::color::{delta_e_2000, lab_from_rgb};
use crate::error::Result;
use crate::paint::Paint;
use crate::render::{Options, Picture, RenderPaint, render};
use crate::scene::{Bodies, Camera, DirectionalLight, Environment, Incidence, Scene, Shape};
use crate::simulate::Model;
use glam::DVec3;
use std::f64::consts::PI;

/// A ball under one lamp and nothing else, so far away that a pixel averages many flakes.
fn distant_ball() -> Scene {
    Scene {
        size: [96, 96],
        background: Some([0.0; 3]),
        camera: Camera {
            position_mm: [0.0, -4000.0, 0.0],
            target_mm: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            vertical_fov_deg: 10.0,
        },
        shape: Shape::Sphere { radius_mm: 330.0 },
        environment: Environment::Constant { radiance: [0.0; 3] },
        lights: vec![
            DirectionalLight { direction: [-0.5, -0.8, 0.35], irradiance: [PI; 3], angular_radius_deg: 0.25 }
                .into(),
        ],
        ..Scene::default()
    }
}

/// A ball rendered with the paint (gloss left out) against the model evaluated at the middle of every pixel.
///
/// # Errors
/// Those of the renderer.
pub fn checks(paint: &Paint, model: &Model) -> Result<Vec<Check>> {
    let scene = distant_ball();
    let mut matt = paint.clone();
    matt.coat.mirror = 0.0;
    matt.coat.gloss = None;
    let options = Options { samples: 4, ..Options::default() };
    let picture = render(&scene, &[RenderPaint::new(&matt)?], &options, &|| ())?;
    let differences = differences(&scene, &Bodies::new(&scene)?, &picture, model);
    let what = format!("distant ball, mean Delta-E 2000 of {} pixels", differences.len());
    // The presets show 0.1 to 0.3 (fit, pixel size, f32); a difference nobody sees is below 1.
    Ok(vec![Check::new(what, mean(differences), 1.0)])
}

/// Delta-E 2000 in every pixel whose middle the lamp reaches at less than 80 degrees (beyond, a pixel spans the terminator).
fn differences(scene: &Scene, bodies: &Bodies, picture: &Picture, model: &Model) -> Vec<f64> {
    let view = scene.camera.view(scene.size);
    let Incidence { direction: light, irradiance, .. } = scene.lights[0].at(DVec3::ZERO);
    let limit = 80f64.to_radians().cos();
    let mut out = Vec::new();
    for (k, pixel) in picture.pixels.iter().enumerate() {
        let direction = view.direction((k % scene.size[0]) as f64 + 0.5, (k / scene.size[0]) as f64 + 0.5);
        let Some(hit) = bodies.intersect(view.origin, direction) else { continue };
        let to_local = view.frame(hit.normal).transpose();
        let (wi, wo) = (to_local * light, to_local * -direction);
        if wi.z > limit && wo.z > limit {
            let truth = model.brdf_rgb(wi, wo) * irradiance * wi.z;
            out.push(delta_e_2000(lab_from_rgb(truth), lab_from_rgb(DVec3::from(pixel.map(f64::from)))));
        }
    }
    out
}
