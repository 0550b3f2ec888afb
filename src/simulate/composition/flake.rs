//! Kinds of flakes in a film.

use super::Composition;
use super::checks::{number, spectrum};
use super::spectrum_text;
use crate::color::Spectrum;
use crate::error::{Error, Result};
use crate::simulate::optics::materials::optical_constants;
use crate::simulate::optics::orientation::Orientation;
use serde::{Deserialize, Serialize};

/// Flakes of one kind: round platelets of negligible thickness, independent of each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlakeKind {
    /// One-sided flake area over area of paint, `D<S>h` of the papers (not per thickness), 0 to 10 over all kinds; typically
    /// 0.3-2. The number of flakes per area is this over the mean area of a flake, [`FlakeKind::mean_area_um2`].
    pub area_density: f64,
    /// Mean diameter, micrometres, 0.01 to 1000; typically 10-30.
    pub diameter_um: f64,
    /// Standard deviation of the diameter over its mean, 0 to 1; diameters are log-normal. Default 0.3.
    #[serde(default = "usual_spread")]
    pub diameter_spread: f64,
    /// Width sigma of the Gaussian of tilts, degrees, 0.1 to 89.9; typically 4-12. Either this or `tilts`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma_deg: Option<f64>,
    /// Measured tilts: 2 to 1024 knots [degrees, density per steradian], ascending within 0 to 90, linear between and 0
    /// outside, in any unit. Either this or `sigma_deg`.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "spectrum_text::optional_pairs"
    )]
    pub tilts: Option<Vec<[f64; 2]>>,
    /// Full width at half maximum of a flake's angular lobe, degrees of theta_h outside near the normal, as measured from
    /// outside (Rump et al. 2008: 6 to 7 degrees); inside the binder the lobe is narrower by the index, the same for flakes
    /// of any tilt. 0 (a perfect mirror) or 0.1 to 90. Default 6.5.
    #[serde(default = "usual_lifetime")]
    pub flake_lifetime_deg: f64,
    /// A flake given by its reflectance; either this or `stack`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror: Option<Mirror>,
    /// A flake given by its layers, 1 to 32 of together up to 20 micrometres, in order, each coherent; either this or `mirror`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stack: Option<Vec<StackLayer>>,
}

/// A flake that reflects alike at every angle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// Reflectance r_p of either face, 0 to 1.
    #[serde(with = "spectrum_text")]
    pub reflectance: Spectrum,
    /// Transmittance t_p, 0 to 1; with the reflectance at most 1. Default 0.
    #[serde(with = "spectrum_text", default = "spectrum_text::zero")]
    pub transmittance: Spectrum,
}

/// One layer of a flake.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StackLayer {
    /// Name of a built-in material; either this or `index`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Real index of refraction, 0.01 to 10; below 1 with an `extinction` only: no dielectric is below 1, metals are.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "spectrum_text::optional")]
    pub index: Option<Spectrum>,
    /// Imaginary index of a layer given by numbers, 0 to 20. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "spectrum_text::optional")]
    pub extinction: Option<Spectrum>,
    /// Mean thickness, nanometres, 0 to 5000.
    pub thickness_nm: f64,
    /// Standard deviation of the thickness over its mean, from flake to flake and independent of the other layers', 0 to
    /// 0.5 ([`crate::simulate::optics::thickness_spread`] says of which law); on three layers at most. Default 0.
    #[serde(default)]
    pub thickness_spread: f64,
}

fn usual_spread() -> f64 {
    0.3
}

fn usual_lifetime() -> f64 {
    6.5
}

impl FlakeKind {
    /// Mean area of a flake, square micrometres: pi/4 times the mean squared diameter.
    pub fn mean_area_um2(&self) -> f64 {
        std::f64::consts::FRAC_PI_4 * self.diameter_um.powi(2) * (1.0 + self.diameter_spread.powi(2))
    }

    /// P, the density of flake normals.
    ///
    /// # Errors
    /// Neither or both of `sigma_deg` and `tilts`, or values outside their range.
    pub fn orientation(&self) -> Result<Orientation> {
        match (self.sigma_deg, &self.tilts) {
            (Some(sigma), None) => {
                number("sigma_deg", sigma, 0.1..=89.9)?;
                Ok(Orientation::new(sigma.to_radians()))
            }
            (None, Some(knots)) => Orientation::tabulated(knots),
            (None, None) => {
                Err(Error::invalid("", "tilts of a flake", "neither sigma_deg nor tilts", "one of the two"))
            }
            (Some(_), Some(_)) => {
                Err(Error::invalid("", "tilts of a flake", "both sigma_deg and tilts", "one of the two"))
            }
        }
    }

    pub(super) fn validate(&self) -> Result<()> {
        number("area_density", self.area_density, 0.0..=Composition::MAX_AREA_DENSITY)?;
        number("diameter_um", self.diameter_um, 0.01..=1000.0)?;
        number("diameter_spread", self.diameter_spread, 0.0..=1.0)?;
        self.orientation()?;
        if self.flake_lifetime_deg != 0.0 {
            number("flake_lifetime_deg (or 0, a mirror)", self.flake_lifetime_deg, 0.1..=90.0)?;
        }
        match (&self.mirror, &self.stack) {
            (Some(mirror), None) => mirror.validate().map_err(|e| e.within("mirror")),
            (None, Some(layers)) => validate_stack(layers),
            (Some(_), Some(_)) => Err(Error::invalid("", "flake", "both mirror and stack", "one of the two")),
            (None, None) => Err(Error::invalid("", "flake", "neither mirror nor stack", "one of the two")),
        }
    }
}

impl Mirror {
    fn validate(&self) -> Result<()> {
        spectrum("reflectance", &self.reflectance, 0.0..=1.0)?;
        spectrum("transmittance", &self.transmittance, 0.0..=1.0)?;
        let most =
            self.reflectance.0.iter().zip(&self.transmittance.0).map(|(r, t)| r + t).fold(0.0, f64::max);
        // 0.6 + 0.4 may round up.
        if most > 1.0 + 1e-12 {
            return Err(Error::invalid("", "reflectance + transmittance", most, "at most 1"));
        }
        Ok(())
    }
}

fn validate_stack(layers: &[StackLayer]) -> Result<()> {
    if !(1..=Composition::MAX_LAYERS).contains(&layers.len()) {
        return Err(Error::invalid("stack", "layers", layers.len(), "1 to 32"));
    }
    for (k, layer) in layers.iter().enumerate() {
        layer.validate().map_err(|e| e.within(format!("stack[{k}]")))?;
    }
    let total = layers.iter().map(|layer| layer.thickness_nm).sum();
    number("stack: thickness_nm of all layers", total, 0.0..=Composition::MAX_STACK_NM)?;
    let spread = layers.iter().filter(|layer| layer.thickness_spread > 0.0).count();
    if spread > Composition::MAX_SPREAD_LAYERS {
        return Err(Error::invalid("stack", "layers with a thickness_spread", spread, "0 to 3"));
    }
    Ok(())
}

impl StackLayer {
    /// Real and imaginary index over wavelength.
    ///
    /// # Errors
    /// As [`optical_constants`].
    pub fn indices(&self) -> Result<(Spectrum, Spectrum)> {
        optical_constants(self.material.as_deref(), self.index.as_ref(), self.extinction.as_ref())
    }

    fn validate(&self) -> Result<()> {
        number("thickness_nm", self.thickness_nm, 0.0..=5000.0)?;
        number("thickness_spread", self.thickness_spread, 0.0..=0.5)?;
        self.indices().map(|_| ())
    }
}
