//! What is in the picture besides the paint: camera, object, lights, surroundings.
//!
//! A scene is a TOML file in which every key may be left out ([`Scene::default`] fills it in); lengths are millimetres,
//! angles degrees, directions point from the object to what they name, z is up. The object stands at the origin. Several
//! paints are several tiles: the same scene once a paint, side by side.

mod camera;
mod check;
mod environment;
mod light;
mod shape;
mod softbox;

pub use camera::{Camera, View};
pub use environment::{Environment, Surroundings};
pub use light::{DirectionalLight, Incidence, Light, PointLight, SpotLight};
pub use shape::{Hit, Shape};
pub use softbox::Softbox;

use crate::error::{Error, Result};
use crate::file::read_text;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Everything a renderer needs to know besides the paint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Columns and rows of one tile, pixels, 1 to 16384 each, at most 2^26 together.
    pub size: [usize; 2],
    /// Exposure, stops: an 8-bit picture shows radiance times 2^exposure.
    pub exposure_stops: f64,
    /// Radiance behind the object, linear Rec.709; left out, the surroundings themselves are seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<[f64; 3]>,
    /// Where the picture is taken from.
    pub camera: Camera,
    /// The painted object.
    pub shape: Shape,
    /// Surroundings that light the object from everywhere.
    pub environment: Environment,
    /// Lamps; these make flakes sparkle.
    #[serde(rename = "light")]
    pub lights: Vec<Light>,
}

impl Default for Scene {
    /// A capsule 50 mm high in a small studio under one sun-like lamp, a pixel about 0.12 mm wide on it.
    fn default() -> Self {
        Self {
            size: [360, 480],
            exposure_stops: 0.0,
            background: None,
            camera: Camera::default(),
            shape: Shape::default(),
            environment: Environment::default(),
            lights: vec![Light::default()],
        }
    }
}

impl Scene {
    /// Largest side of a tile, pixels.
    pub const MAX_SIDE: usize = 16_384;
    /// Most pixels of a picture, all tiles together.
    pub const MAX_PIXELS: usize = 1 << 26;
    /// Most lamps.
    pub const MAX_LIGHTS: usize = 64;
    /// Largest scene file, bytes.
    const MAX_BYTES: u64 = 1 << 20;

    /// The default scene in tiles so narrow that capsules of several paints stand shoulder to shoulder.
    pub fn strip() -> Self {
        Self { size: [216, 480], ..Self::default() }
    }

    /// Reads a scene file.
    ///
    /// # Errors
    /// Those of the file system; more than a megabyte; not UTF-8; not TOML; unknown keys (the legal ones are listed); illegal values.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path, Self::MAX_BYTES)?).map_err(|e| e.in_file(path))
    }

    /// A scene from the text of its file.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn parse(text: &str) -> Result<Self> {
        let scene: Self = toml::from_str(text)
            .map_err(|e| Error::invalid("scene", "TOML", e.to_string().trim_end(), "the keys of a scene"))?;
        scene.validate()?;
        Ok(scene)
    }

    /// # Errors
    /// A value outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        let [width, height] = self.size;
        let sides = 1..=Self::MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) || width * height > Self::MAX_PIXELS {
            let legal = "sides of 1 to 16384, up to 67108864 pixels";
            return Err(Error::invalid("scene", "size", format!("{width} x {height}"), legal));
        }
        check::range("scene", "exposure_stops", self.exposure_stops, -64.0..=64.0)?;
        if let Some(background) = self.background {
            check::radiance("scene", "background", background)?;
        }
        if self.lights.len() > Self::MAX_LIGHTS {
            return Err(Error::invalid("scene", "lights", self.lights.len(), "up to 64"));
        }
        self.camera.validate().map_err(|e| e.within("scene: camera"))?;
        self.shape.validate().map_err(|e| e.within("scene: shape"))?;
        self.environment.validate().map_err(|e| e.within("scene: environment"))?;
        for (k, light) in self.lights.iter().enumerate() {
            light.validate().map_err(|e| e.within(format!("scene: light {k}")))?;
        }
        Ok(())
    }
}
