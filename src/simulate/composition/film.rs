//! A film of a paint, and the boundary of the topmost to air.

use super::checks::{number, spectrum};
use super::spectrum_text;
use super::{Composition, FlakeKind, Pigment};
use crate::color::Spectrum;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// A film of binder with flakes and pigments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Film {
    /// Thickness h, micrometres, 0 to 1000; typically 12-20.
    pub thickness_um: f64,
    /// Index of refraction of the binder (eta), 1 to 4; typically 1.5.
    pub index: f64,
    /// Absorption coefficient kappa of the binder, 1/mm, 0 to 1e6; a strong transparent pigment reaches 100.
    #[serde(with = "spectrum_text", default = "spectrum_text::zero")]
    pub absorption_per_mm: Spectrum,
    /// Kinds of flakes, none to 16.
    #[serde(default)]
    pub flakes: Vec<FlakeKind>,
    /// Kinds of pigments, none to 16.
    #[serde(default)]
    pub pigments: Vec<Pigment>,
}

/// The boundary to air.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Width sigma of the Gaussian that smooths the gloss, degrees, 0 (a mirror) to 45.
    #[serde(default)]
    pub roughness_deg: f64,
}

impl Film {
    pub(super) fn validate(&self) -> Result<()> {
        number("thickness_um", self.thickness_um, 0.0..=1000.0)?;
        number("index", self.index, 1.0..=4.0)?;
        spectrum("absorption_per_mm", &self.absorption_per_mm, 0.0..=1e6)?;
        for (what, kinds) in [("flakes", self.flakes.len()), ("pigments", self.pigments.len())] {
            if kinds > Composition::MAX_KINDS {
                return Err(Error::invalid(what, "kinds", kinds, "0 to 16"));
            }
        }
        for (k, kind) in self.flakes.iter().enumerate() {
            kind.validate().map_err(|e| e.within(format!("flakes[{k}]")))?;
        }
        for (k, kind) in self.pigments.iter().enumerate() {
            kind.validate().map_err(|e| e.within(format!("pigments[{k}]")))?;
        }
        let area = self.flakes.iter().map(|kind| kind.area_density).sum();
        number("flakes: area_density of all kinds", area, 0.0..=Composition::MAX_AREA_DENSITY)?;
        let legal = 0.0..=Pigment::MAX_VOLUME_FRACTION;
        number("pigments: volume_fraction of all kinds", self.sphere_volume(), legal)
    }

    /// Share of the volume that pigment spheres fill.
    pub(super) fn sphere_volume(&self) -> f64 {
        self.pigments.iter().filter_map(|kind| kind.mie.as_ref()).map(|spheres| spheres.volume_fraction).sum()
    }
}
