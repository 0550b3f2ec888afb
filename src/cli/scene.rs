//! Scene and sampling as the command line gives them.

use crate::error::{Error, Result};
use crate::render::Options;
use crate::scene::{Scene, Shape};
use std::path::PathBuf;

/// The scene of a picture, and how densely it is sampled: both decide what a picture needs of a paint.
#[derive(clap::Args)]
pub struct SceneArguments {
    /// Scene file (TOML).
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Painted object instead of the scene's: capsule, sphere, panel, sheet or speed-shape.
    #[arg(long)]
    shape: Option<String>,
    /// Size of one tile, pixels, e.g. 640x480.
    #[arg(long)]
    size: Option<String>,
    /// Rays a pixel.
    #[arg(long, default_value_t = Options::default().samples)]
    samples: usize,
}

impl SceneArguments {
    /// The scene that file and options describe, `None` if no file is named.
    pub fn named(&self) -> Result<Option<Scene>> {
        self.scene.as_ref().map(|path| self.changed(Scene::read(path)?)).transpose()
    }

    /// The scene that file and options describe; without a file a capsule in a studio, narrower where there are more `tiles`.
    pub fn scene(&self, tiles: usize) -> Result<Scene> {
        match self.named()? {
            Some(scene) => Ok(scene),
            None if tiles > 1 => self.changed(Scene::strip()),
            None => self.changed(Scene::default()),
        }
    }

    /// How the picture is sampled.
    pub fn options(&self) -> Options {
        Options { samples: self.samples, ..Options::default() }
    }

    fn changed(&self, mut scene: Scene) -> Result<Scene> {
        if let Some(name) = &self.shape {
            if !scene.objects.is_empty() {
                return Err(Error::invalid("--shape", "shape", name, "none: the scene lists its objects"));
            }
            scene.shape = Shape::named(name).map_err(|e| e.within("--shape"))?;
        }
        if let Some(size) = &self.size {
            scene.size = parse_size(size)?;
        }
        scene.validate()?;
        Ok(scene)
    }
}

/// `WIDTHxHEIGHT`.
pub fn parse_size(text: &str) -> Result<[usize; 2]> {
    let sides = text.split_once('x').map(|(w, h)| (w.parse(), h.parse()));
    match sides {
        Some((Ok(width), Ok(height))) => Ok([width, height]),
        _ => Err(Error::invalid("--size", "picture size", text, "WIDTHxHEIGHT, e.g. 640x480")),
    }
}
