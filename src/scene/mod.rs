//! What is in the picture besides the paint: camera, object, lights, surroundings.
//!
//! A scene is a TOML file in which every key may be left out ([`Scene::default`] fills it in); lengths are millimetres,
//! angles degrees, directions point from the object to what they name, z is up. The shape stands at the origin, and several
//! paints are several tiles: the same scene once a paint, side by side. A scene that lists objects is one picture instead, in
//! which each of them wears one of the paints.

mod bodies;
mod camera;
mod chart;
mod check;
mod convex;
mod environment;
mod hierarchy;
mod lamp_groups;
mod lamp_points;
mod light;
mod mesh;
mod object;
mod panorama;
mod print;
mod shape;
mod sheet;
mod sky;
mod softbox;
mod speed_shape;
mod triangle;

pub use bodies::{Bodies, Hit};
#[cfg(feature = "gpu")]
pub(crate) use bodies::{Body, Form};
pub use camera::{Camera, View};
pub use environment::{Environment, Surroundings};
pub(crate) use lamp_groups::LampGroup;
#[cfg(feature = "gpu")]
pub(crate) use lamp_points::LampPoint;
pub(crate) use lamp_points::LampPoints;
pub use light::{DirectionalLight, Incidence, Light, PointLight, SpotLight};
pub use object::Object;
pub use print::PrintPlace;
pub use shape::{Shape, Up};
pub use softbox::Softbox;
#[cfg(feature = "gpu")]
pub(crate) use {convex::Convex, mesh::Mesh, panorama::Panorama};

use crate::error::{Error, Result};
use crate::file::read_text;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

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
    /// The painted object, unless there are `objects`.
    pub shape: Shape,
    /// Surroundings that light the object from everywhere.
    pub environment: Environment,
    /// Lamps; these make flakes sparkle.
    #[serde(rename = "light")]
    pub lights: Vec<Light>,
    /// Painted objects instead of `shape`, all in one picture.
    #[serde(rename = "object", skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<Object>,
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
            objects: Vec::new(),
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
    /// Most objects.
    pub const MAX_OBJECTS: usize = 16;
    /// Largest scene file, bytes.
    const MAX_BYTES: u64 = 1 << 20;

    /// The default scene in tiles so narrow that capsules of several paints stand shoulder to shoulder.
    pub fn strip() -> Self {
        Self { size: [216, 480], ..Self::default() }
    }

    /// Reads a scene file. Files that it names are looked for beside it, and read when the scene is made ready for rays.
    ///
    /// # Errors
    /// Those of the file system; more than a megabyte; not UTF-8; not TOML; unknown keys (the legal ones are listed); illegal values.
    pub fn read(path: &Path) -> Result<Self> {
        let mut scene = Self::parse(&read_text(path, Self::MAX_BYTES)?).map_err(|e| e.in_file(path))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        scene.environment.resolve(folder);
        scene.shape.resolve(folder);
        scene.objects.iter_mut().for_each(|object| object.shape.resolve(folder));
        Ok(scene)
    }

    /// Files that the scene names: pictures of the surroundings, meshes.
    pub fn files(&self) -> Vec<PathBuf> {
        let shapes = std::iter::once(&self.shape).chain(self.objects.iter().map(|object| &object.shape));
        self.environment.file().into_iter().chain(shapes.filter_map(Shape::file)).cloned().collect()
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
        if self.objects.len() > Self::MAX_OBJECTS {
            return Err(Error::invalid("scene", "objects", self.objects.len(), "up to 16"));
        }
        for (k, object) in self.objects.iter().enumerate() {
            object.validate().map_err(|e| e.within(format!("scene: object {k}")))?;
        }
        Ok(())
    }

    /// # Errors
    /// An object that wears none of `count` paints.
    pub fn check_paints(&self, count: usize) -> Result<()> {
        match self.objects.iter().enumerate().find(|(_, object)| object.paint >= count) {
            None => Ok(()),
            Some((k, object)) => {
                let legal = format!("0 to {}, as many as there are paints", count.saturating_sub(1));
                Err(Error::invalid(format!("scene: object {k}"), "paint", object.paint, legal))
            }
        }
    }

    /// The paints of each tile of a picture, left to right: one each, or all in one tile whose objects choose.
    pub fn tiles<'a, T>(&self, paints: &'a [T]) -> Vec<&'a [T]> {
        if self.objects.is_empty() { paints.chunks(1).collect() } else { vec![paints] }
    }
}
