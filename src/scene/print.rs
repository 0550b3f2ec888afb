//! Prints on objects: where a patch lies in its picture, and what a soft proof shows where nobody says otherwise, a printed shape in
//! a dark room.

use super::{Camera, Environment, Light, PointLight, Scene, Shape};
use crate::error::{Error, Result};
use glam::DVec2;

/// Where a patch of an object lies in the picture that it is printed with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrintPlace {
    /// (0, 0) is the picture's top left, (1, 1) its bottom right corner.
    pub uv: DVec2,
    /// Width and height of the upright rectangle with the patch's variance along both axes, as shares of the picture's: an upright patch
    /// itself, and a square one that is turned has its own sides.
    pub sides: DVec2,
}

impl PrintPlace {
    /// A parallelogram.
    pub fn new(uv: DVec2, [a, b]: [DVec2; 2]) -> Self {
        Self { uv, sides: DVec2::new(a.x.hypot(b.x), a.y.hypot(b.y)) }
    }
}

/// Longer side of a sheet or panel, millimetres.
const SIDE_MM: f64 = 60.0;

impl Shape {
    /// Names of the shapes that [`Shape::printed`] knows.
    pub const PRINTED: [&str; 4] = ["sheet", "panel", "sphere", "capsule"];

    /// The shape of this name, printed with an image of these proportions, width over height; sheets and panels have the same.
    ///
    /// # Errors
    /// Another name than those of [`Shape::PRINTED`].
    pub fn printed(name: &str, proportions: f64) -> Result<Self> {
        let size_mm = [1.0, 1.0 / proportions].map(|side| side * SIDE_MM * proportions.min(1.0));
        match name {
            "panel" => Ok(Self::Panel { size_mm, normal: [0.0, -1.0, 0.0] }),
            "sheet" => Ok(Self::Sheet { size_mm, radius_mm: 0.5 * size_mm[0] }),
            "sphere" | "capsule" => Self::named(name),
            _ => Err(Error::invalid("shape", "name", name, "sheet, panel, sphere or capsule")),
        }
    }
}

impl Scene {
    /// A dark room with two lamps: one that a sheet mirrors near its middle, and one behind it, that its side mirrors at grazing angles.
    pub fn proof(shape: Shape) -> Self {
        let lamp = |position_mm: [f64; 3], power: f64| {
            Light::Point(PointLight { position_mm, irradiance: [power; 3], radius_mm: 4.0 })
        };
        Self {
            size: [640, 480],
            shape,
            camera: Camera { position_mm: [0.0, -220.0, 30.0], vertical_fov_deg: 16.0, ..Camera::default() },
            background: Some([0.02; 3]),
            environment: Environment::Constant { radiance: [0.0; 3] },
            lights: vec![lamp([-60.0, -220.0, 60.0], 3.0), lamp([230.0, 60.0, 40.0], 3.0)],
            ..Self::default()
        }
    }
}
