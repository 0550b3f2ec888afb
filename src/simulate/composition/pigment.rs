//! Pigments of a film, in one of three laws.

use super::checks::{number, spectrum};
use super::spectrum_text;
use crate::color::{Spectrum, wavelength_nm};
use crate::error::{Error, Result};
use crate::simulate::optics::materials::optical_constants;
use serde::{Deserialize, Serialize};

/// Particles of one kind, spread evenly through a film, far smaller than it is thick. One of the three laws.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pigment {
    /// Spheres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mie: Option<MieSpheres>,
    /// Particles far smaller than the wavelength.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rayleigh: Option<Rayleigh>,
    /// The empirical law of Henyey and Greenstein.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub henyey_greenstein: Option<HenyeyGreenstein>,
}

/// Homogeneous spheres of one radius, scattering after Mie.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MieSpheres {
    /// Share of the film's volume, 0 to 0.3 over all kinds; beyond 0.1 particles begin to scatter together, which
    /// [`super::Composition::warnings`] says.
    pub volume_fraction: f64,
    /// Radius, micrometres, 0.001 to 10.
    pub radius_um: f64,
    /// Name of a built-in material; either this or `index`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Real index of refraction, 0.01 to 10; below 1 with an `extinction` only: no dielectric is below 1, metals are.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "spectrum_text::optional")]
    pub index: Option<Spectrum>,
    /// Imaginary index, 0 to 20. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "spectrum_text::optional")]
    pub extinction: Option<Spectrum>,
}

/// Rayleigh scattering with given coefficients.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rayleigh {
    /// Scattering coefficient, number density times sigma_sc, 1/mm, 0 to 1e6.
    #[serde(with = "spectrum_text")]
    pub scattering_per_mm: Spectrum,
    /// Extinction coefficient, number density times sigma_ext, 1/mm, up to 1e6; at least the scattering.
    #[serde(with = "spectrum_text")]
    pub extinction_per_mm: Spectrum,
}

/// Henyey-Greenstein scattering with given coefficients.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HenyeyGreenstein {
    /// Scattering coefficient, number density times sigma_sc, 1/mm, 0 to 1e6.
    #[serde(with = "spectrum_text")]
    pub scattering_per_mm: Spectrum,
    /// Extinction coefficient, number density times sigma_ext, 1/mm, up to 1e6; at least the scattering.
    #[serde(with = "spectrum_text")]
    pub extinction_per_mm: Spectrum,
    /// Mean cosine g of the scattering angle, -0.8 (narrower peaks towards the light are not resolved) to 0.99.
    #[serde(with = "spectrum_text")]
    pub asymmetry: Spectrum,
}

impl Pigment {
    /// Largest share of a film's volume.
    pub const MAX_VOLUME_FRACTION: f64 = 0.3;

    pub(super) fn validate(&self) -> Result<()> {
        match (&self.mie, &self.rayleigh, &self.henyey_greenstein) {
            (Some(spheres), None, None) => spheres.validate().map_err(|e| e.within("mie")),
            (None, Some(law), None) => {
                coefficients(&law.scattering_per_mm, &law.extinction_per_mm).map_err(|e| e.within("rayleigh"))
            }
            (None, None, Some(law)) => coefficients(&law.scattering_per_mm, &law.extinction_per_mm)
                .and_then(|()| spectrum("asymmetry", &law.asymmetry, -0.8..=0.99))
                .map_err(|e| e.within("henyey_greenstein")),
            (mie, rayleigh, hg) => {
                let laws =
                    usize::from(mie.is_some()) + usize::from(rayleigh.is_some()) + usize::from(hg.is_some());
                let legal = "one of mie, rayleigh, henyey_greenstein";
                Err(Error::invalid("", "laws of a pigment", laws, legal))
            }
        }
    }
}

impl MieSpheres {
    /// Real and imaginary index over wavelength.
    ///
    /// # Errors
    /// As [`optical_constants`].
    pub fn indices(&self) -> Result<(Spectrum, Spectrum)> {
        optical_constants(self.material.as_deref(), self.index.as_ref(), self.extinction.as_ref())
    }

    fn validate(&self) -> Result<()> {
        number("volume_fraction", self.volume_fraction, 0.0..=Pigment::MAX_VOLUME_FRACTION)?;
        number("radius_um", self.radius_um, 0.001..=10.0)?;
        self.indices().map(|_| ())
    }
}

fn coefficients(scattering: &Spectrum, extinction: &Spectrum) -> Result<()> {
    spectrum("scattering_per_mm", scattering, 0.0..=1e6)?;
    spectrum("extinction_per_mm", extinction, 0.0..=1e6)?;
    match scattering.0.iter().zip(&extinction.0).position(|(s, e)| s > e) {
        None => Ok(()),
        Some(k) => {
            let what = format!("extinction_per_mm at {} nm", wavelength_nm(k));
            let legal = format!("at least the scattering there, {}", scattering.0[k]);
            Err(Error::invalid("", what, extinction.0[k], legal))
        }
    }
}
