//! The pictures of a capture, asked for one at a time.

use super::Rig;
use crate::error::Result;

/// What a camera said: linear in nothing yet, 0 (dark) to 1 (saturated), red, green, blue.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Row-major, top row first.
    pub pixels: Vec<[f32; 3]>,
}

/// Which picture; numbers are those of the rig's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shot {
    /// The plate of diodes in the dark, without zoom.
    LedsWide {
        /// The camera.
        camera: usize,
    },
    /// The same at the zoom of the measurement.
    LedsZoom {
        /// The camera.
        camera: usize,
    },
    /// An evenly lit gray field at one step of the response series.
    Response {
        /// The camera.
        camera: usize,
        /// The step.
        step: usize,
    },
    /// The sample under one flash.
    Pair {
        /// The camera.
        camera: usize,
        /// The camera whose flash it is.
        light: usize,
        /// The exposure.
        exposure: usize,
    },
}

/// A capture, from which pictures come one at a time and from any thread, so that they need not all be in memory.
pub trait Images: Sync {
    /// The dome.
    fn rig(&self) -> &Rig;

    /// A picture of the rig's size.
    ///
    /// # Errors
    /// It was not taken, cannot be read, has another size, or holds a pixel outside 0 to 1, named.
    fn picture(&self, shot: Shot) -> Result<Picture>;
}

impl std::fmt::Display for Shot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::LedsWide { camera } => write!(f, "diodes seen by camera {camera} without zoom"),
            Self::LedsZoom { camera } => write!(f, "diodes seen by camera {camera} with zoom"),
            Self::Response { camera, step } => write!(f, "gray field of camera {camera}, step {step}"),
            Self::Pair { camera, light, exposure } => {
                write!(f, "camera {camera}, light {light}, exposure {exposure}")
            }
        }
    }
}
