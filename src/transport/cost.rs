//! What moving a unit of mass between two centers costs.

use crate::error::{Error, Result};
use glam::DVec3;
use std::fmt;
use std::str::FromStr;

/// Ground cost over the distance d between two cluster centers in Lab.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Cost {
    /// `euclidean`: d, in Delta-E (Golla & Klein 2018, eq. 8).
    #[default]
    Euclidean,
    /// `squared`: d^2. Long moves are dearer, so that many share a way rather than few go far.
    Squared,
    /// `capped:T`: min(d, T), T above 0. Beyond T all moves cost the same: what is far apart is replaced, not moved.
    Capped(f64),
}

impl Cost {
    /// The names as a message lists them.
    pub const NAMES: &str = "euclidean, squared, capped:T (T above 0, Delta-E)";

    /// Cost of a unit of mass.
    pub fn between(self, a: DVec3, b: DVec3) -> f64 {
        match self {
            Self::Euclidean => a.distance(b),
            Self::Squared => a.distance_squared(b),
            Self::Capped(cap) => a.distance(b).min(cap),
        }
    }

    /// Costs of a unit of mass from one center to many, whose coordinates these are, to the bit those of
    /// [`Cost::between`]; side by side, as roots are slow.
    pub(super) fn extend_row(self, row: &mut Vec<f64>, from: DVec3, to: &[Vec<f64>; 3]) {
        let [x, y, z] = to;
        let squares = x.iter().zip(y).zip(z).map(|((x, y), z)| {
            let (x, y, z) = (from.x - x, from.y - y, from.z - z);
            x * x + y * y + z * z
        });
        match self {
            Self::Euclidean => row.extend(squares.map(f64::sqrt)),
            Self::Squared => row.extend(squares),
            Self::Capped(cap) => row.extend(squares.map(|square| square.sqrt().min(cap))),
        }
    }

    /// The same cost if it is legal.
    ///
    /// # Errors
    /// A cap that is not above 0 or not finite.
    pub fn validated(self) -> Result<Self> {
        match self {
            Self::Capped(cap) if !(cap > 0.0 && cap.is_finite()) => {
                Err(Error::invalid("cost", "cap", cap, "a finite number above 0"))
            }
            _ => Ok(self),
        }
    }
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Euclidean => f.pad("euclidean"),
            Self::Squared => f.pad("squared"),
            Self::Capped(cap) => f.pad(&format!("capped:{cap}")),
        }
    }
}

impl FromStr for Cost {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "euclidean" => Ok(Self::Euclidean),
            "squared" => Ok(Self::Squared),
            _ => text
                .strip_prefix("capped:")
                .and_then(|cap| cap.parse().ok())
                .and_then(|cap| Self::Capped(cap).validated().ok())
                .ok_or_else(|| Error::invalid("cost", "name", text, Self::NAMES)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_of_a_distance_of_5() {
        let (a, b) = (DVec3::new(50.0, 1.0, -2.0), DVec3::new(50.0, 4.0, 2.0));
        let costs = [Cost::Euclidean, Cost::Squared, Cost::Capped(7.0), Cost::Capped(3.0)];
        assert_eq!(costs.map(|cost| cost.between(a, b)), [5.0, 25.0, 5.0, 3.0]);
        let coordinates = [vec![b.x, 0.1], vec![b.y, 0.2], vec![b.z, 0.3]];
        for cost in costs {
            let mut row = Vec::new();
            cost.extend_row(&mut row, a, &coordinates);
            assert_eq!(row, [cost.between(a, b), cost.between(a, DVec3::new(0.1, 0.2, 0.3))]);
        }
    }

    #[test]
    fn names_are_read_back() {
        for cost in [Cost::Euclidean, Cost::Squared, Cost::Capped(30.0), Cost::Capped(0.1)] {
            assert_eq!(cost.to_string().parse::<Cost>().expect("its own name"), cost);
        }
        for text in
            ["", "manhattan", "capped", "capped:", "capped:0", "capped:-1", "capped:NaN", "capped:inf"]
        {
            let message = text.parse::<Cost>().expect_err("illegal").to_string();
            assert_eq!(message, format!("cost: name: found {text}, expected {}", Cost::NAMES));
        }
    }
}
