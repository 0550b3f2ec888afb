//! Files that hold no paint: read behind the window, taken in the order in which they were named.

use super::document::stem;
use super::job::Progress;
use super::kind::Kind;
use super::staged::Staged;
use crate::error::{Error, Result};
use crate::scene::{Bodies, Environment, Scene, Shape, Up};
use crate::simulate::Composition;
use std::path::{Path, PathBuf};

/// Longest side of a mesh, millimetres: files do not agree on units, and the eye sees some 60.
const MESH_MM: f64 = 60.0;

/// What such a file holds, read without a fault.
#[derive(Debug)]
pub enum Beside {
    /// A composition, and its name.
    Composition(Box<Composition>, String),
    /// A picture of surroundings.
    Surroundings(PathBuf),
    /// A mesh.
    Mesh(PathBuf),
    /// A scene.
    Scene(Box<Staged>),
}

impl Beside {
    /// Reads a file of a kind.
    ///
    /// # Errors
    /// Those of reading it, and the files that it names; a paint.
    pub fn read(file: &Path, kind: Kind, progress: &Progress) -> Result<Self> {
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        let _tick = progress.begin(&format!("reading {name}"), 1);
        match kind {
            Kind::Paint => {
                let legal = "a composition, a scene, surroundings or a mesh";
                Err(Error::invalid(file.display().to_string(), "kind of file", "paint", legal))
            }
            Kind::Image => {
                let legal = "none beside paints: carpaint view IMAGE shows it as a print";
                Err(Error::invalid(file.display().to_string(), "kind of file", "image", legal))
            }
            Kind::Composition => Ok(Self::Composition(Box::new(Composition::read(file)?), stem(file))),
            Kind::Scene => Ok(Self::Scene(Box::new(Staged::read(file)?))),
            Kind::Surroundings => {
                let path = file.to_owned();
                Environment::Image { path: path.clone(), turn_deg: 0.0, scale: 1.0 }.surroundings()?;
                Ok(Self::Surroundings(path))
            }
            Kind::Mesh => {
                let path = file.to_owned();
                Bodies::new(&Scene { shape: mesh(&path), ..Scene::default() })?;
                Ok(Self::Mesh(path))
            }
        }
    }
}

/// A mesh as the window shows it.
pub fn mesh(path: &Path) -> Shape {
    Shape::Mesh { path: path.to_owned(), length_mm: Some(MESH_MM), up: Up::Y }
}
