//! How random numbers follow the half vector.

use crate::error::{Error, Result};
use crate::math::knots::KnotMap;
use serde::Serialize;

/// The lattice of random numbers over projected half vectors p ([`projected_half`](crate::brdf::projected_half()); near the
/// normal an angle inside the lacquer, radians): square in the compressed plane of `q = p / sqrt(1 + c |p|^2)`.
///
/// All flakes go out within the same angle; but the farther out, the fewer shine, and colors drawn by a Gaussian field forget
/// the faster the rarer they are: hence the compression c, which each paint has of its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Knots {
    /// Spacing of the knots, of q, 1e-4 to 10: how far the half vector turns until a flake has gone out.
    pub spacing: f64,
    /// c, 0 to 64. At `|p| = 1 / sqrt(c)` q grows at 0.35 of the pace of p.
    pub compression: f64,
}

impl Knots {
    /// Largest compression.
    pub const MAX_COMPRESSION: f64 = 64.0;
    /// The compression of silver and pearl paints, for those that do not tell: at 17 degrees inside the lacquer q grows at two
    /// thirds of the pace of p.
    pub const USUAL_COMPRESSION: f64 = 4.0;

    /// Knots of this spacing and the usual compression.
    pub fn usual(spacing: f64) -> Self {
        Self { spacing, compression: Self::USUAL_COMPRESSION }
    }

    /// From projected half vectors to places in units of the spacing.
    pub fn map(&self) -> KnotMap {
        KnotMap::new(self.spacing, self.compression)
    }

    /// # Errors
    /// A number outside its legal range.
    pub fn validate(&self) -> Result<()> {
        if !(1e-4..=10.0).contains(&self.spacing) {
            return Err(Error::invalid("flakes", "knot_spacing", self.spacing, "1e-4 to 10"));
        }
        if !(0.0..=Self::MAX_COMPRESSION).contains(&self.compression) {
            return Err(Error::invalid("flakes", "knot_compression", self.compression, "0 to 64"));
        }
        Ok(())
    }
}
