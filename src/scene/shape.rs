//! What a painted object is, as a scene file says it.

use super::check;
use super::convex::Convex;
use crate::error::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A painted object in a frame of its own, around the origin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// An upright cylinder with hemispherical ends.
    Capsule {
        /// Radius, millimetres, above 0.
        radius_mm: f64,
        /// Height over all, millimetres, at least twice the radius.
        height_mm: f64,
    },
    /// A ball.
    Sphere {
        /// Radius, millimetres, above 0.
        radius_mm: f64,
    },
    /// A flat rectangle, painted on the side of its normal.
    Panel {
        /// Width and height, millimetres, above 0.
        size_mm: [f64; 2],
        /// Normal of the painted side; any length.
        normal: [f64; 3],
    },
    /// A sheet bent about an upright axis behind it, its middle to the front (-y), the outer side painted with its picture.
    Sheet {
        /// Width along the sheet and height, millimetres, above 0.
        size_mm: [f64; 2],
        /// Radius of the bend, millimetres, at least the width over 2 pi.
        radius_mm: f64,
    },
    /// Triangles from a file, painted on both sides, the middle of their box at the origin.
    Mesh {
        /// glTF (`.glb`, `.gltf`) or Wavefront OBJ; in a scene file relative to that.
        path: PathBuf,
        /// Longest side of the box, millimetres; left out, the file's own meters (glTF) or millimetres (OBJ).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        length_mm: Option<f64>,
        /// The axis that is up in the file; the other two follow as in glTF, whose front is +z.
        #[serde(default)]
        up: Up,
    },
    /// A car-like body to judge paints by: long gentle curves, tight radii, and a hollow along the side.
    SpeedShape {
        /// Length from nose to tail, millimetres.
        length_mm: f64,
    },
}

/// The upright axis of a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Up {
    /// As in glTF: +z is to the front, which becomes -y.
    #[default]
    Y,
    /// As in scenes.
    Z,
}

impl Default for Shape {
    fn default() -> Self {
        Self::Capsule { radius_mm: 12.0, height_mm: 50.0 }
    }
}

impl Shape {
    /// The shape named `capsule`, `sphere`, `panel`, `sheet` or `speed-shape`, of the size used in demonstrations.
    ///
    /// # Errors
    /// Another name.
    pub fn named(name: &str) -> Result<Self> {
        match name {
            "capsule" => Ok(Self::default()),
            "sphere" => Ok(Self::Sphere { radius_mm: 22.0 }),
            "panel" => Ok(Self::Panel { size_mm: [24.0, 50.0], normal: [0.0, -1.0, 0.05] }),
            "sheet" => Ok(Self::Sheet { size_mm: [60.0, 45.0], radius_mm: 22.0 }),
            "speed-shape" => Ok(Self::SpeedShape { length_mm: 60.0 }),
            _ => Err(Error::invalid("shape", "name", name, "capsule, sphere, panel, sheet or speed-shape")),
        }
    }

    pub(super) fn validate(&self) -> Result<()> {
        let length = |what: &str, value: f64| check::range("", what, value, 1e-3..=1e6);
        match *self {
            Self::Capsule { radius_mm, height_mm } => {
                length("radius_mm", radius_mm)?;
                length("height_mm", height_mm)?;
                check::range("", "height_mm", height_mm, 2.0 * radius_mm..=1e6)
            }
            Self::Sphere { radius_mm } => length("radius_mm", radius_mm),
            Self::Panel { size_mm, normal } => {
                length("width (size_mm)", size_mm[0])?;
                length("height (size_mm)", size_mm[1])?;
                check::direction("", "normal", normal)
            }
            Self::Sheet { size_mm, radius_mm } => {
                length("width (size_mm)", size_mm[0])?;
                length("height (size_mm)", size_mm[1])?;
                check::range("", "radius_mm", radius_mm, size_mm[0] / std::f64::consts::TAU..=1e6)
            }
            Self::Mesh { length_mm, .. } => length_mm.map_or(Ok(()), |mm| length("length_mm", mm)),
            Self::SpeedShape { length_mm } => length("length_mm", length_mm),
        }
    }

    /// Paths of files become relative to the working folder instead of `folder`.
    pub(super) fn resolve(&mut self, folder: &Path) {
        if let Self::Mesh { path, .. } = self {
            *path = folder.join(&path);
        }
    }

    /// The file of a mesh.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        if let Self::Mesh { path, .. } = self { Some(path) } else { None }
    }

    /// The body that a formula gives; none for triangles.
    pub(super) fn convex(&self) -> Option<Convex> {
        match *self {
            Self::Capsule { radius_mm, height_mm } => {
                Some(Convex::Capsule { radius: radius_mm, half: height_mm / 2.0 - radius_mm })
            }
            Self::Sphere { radius_mm } => Some(Convex::Sphere { radius: radius_mm }),
            Self::Panel { size_mm, normal } => {
                Some(Convex::Panel { axes: panel_axes(DVec3::from(normal).normalize()), size: size_mm })
            }
            Self::Sheet { .. } | Self::Mesh { .. } | Self::SpeedShape { .. } => None,
        }
    }
}

/// Right, up and normal of a panel, unit vectors.
fn panel_axes(normal: DVec3) -> [DVec3; 3] {
    // A panel that lies flat has no upright direction of its own: take y.
    let upright = if normal.z.abs() < 0.999 { DVec3::Z } else { DVec3::Y };
    let right = upright.cross(normal).normalize();
    [right, normal.cross(right), normal]
}
