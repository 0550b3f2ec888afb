//! What the films lie on.

use super::checks::spectrum;
use super::spectrum_text;
use crate::color::{Spectrum, reflectance_of_rgb};
use crate::error::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A Lambertian ground coat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SubstrateKeys", deny_unknown_fields)]
pub struct Substrate {
    /// Albedo r_s, 0 to 1. A file may give linear Rec.709 under D65 instead, `albedo_rgb = [r, g, b]`: it stands for the
    /// flattest reflectance of that color, [`reflectance_of_rgb`].
    #[serde(with = "spectrum_text")]
    pub albedo: Spectrum,
}

/// The keys of `[substrate]`: one of the two.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SubstrateKeys {
    #[serde(with = "spectrum_text::optional", default)]
    albedo: Option<Spectrum>,
    #[serde(default, deserialize_with = "spectrum_text::optional_list")]
    albedo_rgb: Option<[f64; 3]>,
}

impl TryFrom<SubstrateKeys> for Substrate {
    type Error = Error;

    fn try_from(keys: SubstrateKeys) -> Result<Self> {
        let found = match (keys.albedo, keys.albedo_rgb) {
            (Some(albedo), None) => return Ok(Self { albedo }),
            (None, Some(rgb)) => return Ok(Self { albedo: reflectance_of_rgb(DVec3::from(rgb))? }),
            (None, None) => "neither albedo nor albedo_rgb",
            (Some(_), Some(_)) => "both albedo and albedo_rgb",
        };
        Err(Error::invalid("", "substrate", found, "one of the two"))
    }
}

impl Substrate {
    pub(super) fn validate(&self) -> Result<()> {
        spectrum("albedo", &self.albedo, 0.0..=1.0)
    }
}
