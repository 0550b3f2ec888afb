//! What a way of shading is compiled for: software renderers run through all that is not ruled out beforehand.

use super::options::FrameOptions;
use crate::gpu::paint::GpuPaint;
use crate::gpu::rows::Rows;
use crate::render::{Disc, Random};
use crate::scene::{Bodies, Environment, Form, Light, Scene};
use glam::Vec3;

/// What a way of shading is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    pub surroundings: Surroundings,
    /// Whether objects may stand in each other's light.
    pub shades: bool,
    /// Whether flakes sparkle under the surroundings.
    around: bool,
    /// Whether there is one object only.
    alone: bool,
    /// Whether a lamp may be seen in several directions.
    wide: bool,
    /// Whether random numbers repeat after some cells.
    textured: bool,
    /// Whether boxes may have bands between them.
    ramps: bool,
    /// Whether the coat mirrors the lamps themselves.
    mirrors: bool,
    /// Whether flakes are drawn from rows, and whether they turn.
    pub rows: Option<bool>,
}

impl Variant {
    /// The usual one, compiled beforehand.
    pub const FIRST: Self = Self {
        surroundings: Surroundings::Maps,
        shades: false,
        around: true,
        alone: true,
        wide: false,
        textured: false,
        ramps: false,
        mirrors: false,
        rows: None,
    };

    pub fn of(scene: &Scene, bodies: &Bodies, options: &FrameOptions, paint: &GpuPaint) -> Self {
        let surroundings = Surroundings::of(scene, options);
        Self {
            surroundings,
            shades: casts_shadows(scene, bodies),
            around: options.around && options.flakes && surroundings != Surroundings::None,
            alone: scene.objects.len() < 2,
            wide: scene.lights.iter().any(is_wide),
            textured: options.random != Random::Hash,
            ramps: paint.has_ramps(),
            mirrors: paint.mirrors(),
            rows: paint.turns().filter(|_| options.rows && options.flakes && Rows::fit(paint)),
        }
    }

    /// Values of the shader's constants.
    pub fn constants(self) -> [(&'static str, f64); 10] {
        let Self { surroundings, shades, around, alone, wide, textured, ramps, mirrors, rows } = self;
        let flag = |is: bool| f64::from(u8::from(is));
        [
            ("SURROUNDINGS", f64::from(surroundings as u8)),
            ("SHADES", flag(shades)),
            ("AROUND", flag(around)),
            ("ALONE", flag(alone)),
            ("WIDE_DISCS", flag(wide)),
            ("TEXTURED", flag(textured)),
            ("RAMPS", flag(ramps)),
            ("MIRRORS", flag(mirrors)),
            ("ROWS", flag(rows.is_some())),
            ("TURNING", flag(rows == Some(true))),
        ]
    }
}

/// Whether objects may stand in their own or each other's light.
pub fn casts_shadows(scene: &Scene, bodies: &Bodies) -> bool {
    scene.objects.len() > 1 || bodies.iter().any(|body| matches!(body.form, Form::Mesh(_)))
}

/// Whether more than one direction may stand for a lamp.
fn is_wide(light: &Light) -> bool {
    match light {
        Light::Directional(sun) => {
            // Further than a rounding of the shader's.
            let sine = 1.001 * sun.angular_radius_deg.to_radians().sin();
            Disc { direction: Vec3::Z, sine: sine as f32 }.tap_count() > 1
        }
        // From near.
        Light::Point(_) | Light::Spot(_) => true,
    }
}

/// How a frame knows the surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surroundings {
    /// They are dark.
    None,
    Maps,
    Sampled,
}

impl Surroundings {
    fn of(scene: &Scene, options: &FrameOptions) -> Self {
        match (&scene.environment, options.directions) {
            (Environment::Constant { radiance: [0.0, 0.0, 0.0] }, _) => Self::None,
            (_, None) => Self::Maps,
            (_, Some(_)) => Self::Sampled,
        }
    }
}
