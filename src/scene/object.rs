//! A painted object that stands somewhere in the scene.

use super::check;
use super::shape::Shape;
use crate::error::Result;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A shape, where it stands, and which paint it wears.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Object {
    /// What it is, in a frame of its own.
    pub shape: Shape,
    /// Where the middle of that frame is, millimetres.
    pub position_mm: [f64; 3],
    /// Rotation about x, then about y, both before `turn_deg`, degrees, -360 to 360.
    pub tilt_deg: [f64; 2],
    /// Rotation about z, counterclockwise from above, degrees, -360 to 360.
    pub turn_deg: f64,
    /// Which of the paints that are rendered it wears, from 0.
    pub paint: usize,
}

impl Object {
    pub(super) fn validate(&self) -> Result<()> {
        self.shape.validate().map_err(|e| e.within("shape"))?;
        check::position("", "position_mm", self.position_mm)?;
        for (what, angle) in
            [("tilt_deg", self.tilt_deg[0]), ("tilt_deg", self.tilt_deg[1]), ("turn_deg", self.turn_deg)]
        {
            check::range("", what, angle, -360.0..=360.0)?;
        }
        Ok(())
    }

    pub(super) fn placement(&self) -> Placement {
        let [x, y] = self.tilt_deg.map(f64::to_radians);
        let axes = DMat3::from_rotation_z(self.turn_deg.to_radians())
            * DMat3::from_rotation_y(y)
            * DMat3::from_rotation_x(x);
        Placement { axes, position: self.position_mm.into() }
    }
}

/// From an object's own frame to the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    /// Columns: the axes of the frame.
    pub axes: DMat3,
    /// Its middle, millimetres.
    pub position: DVec3,
}

impl Placement {
    /// A point of the world in the object's frame.
    pub fn local(&self, point: DVec3) -> DVec3 {
        self.local_direction(point - self.position)
    }

    /// A direction of the world in the object's frame.
    pub fn local_direction(&self, direction: DVec3) -> DVec3 {
        self.axes.transpose() * direction
    }
}
