//! What a paint is made of: substrate, one film with flakes, surface. Read from TOML.
//!
//! ```toml
//! title = "silver"
//!
//! [substrate]
//! albedo = 0.1                      # a SPECTRUM
//!
//! [film]
//! thickness_um = 16
//! index = 1.5
//! absorption_per_mm = 0             # a SPECTRUM
//!
//! [[film.flakes]]
//! area_density = 1.0
//! diameter_um = 18
//! diameter_spread = 0.3
//! sigma_deg = 6
//! mirror = { reflectance = 0.8 }    # or: stack = [{ material = "TiO2", thickness_nm = 60 }, ...]
//! ```
//!
//! A SPECTRUM is a number or knots `[[nm, value], ...]`, linear between them, that cover 380-780 nm.

use super::materials::material;
use super::spectrum_text;
use crate::color::Spectrum;
use crate::error::{Error, Result};
use crate::file::read_text;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::path::Path;

/// A paint as a recipe.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Composition {
    /// A name for people.
    #[serde(default)]
    pub title: String,
    /// What the film lies on.
    pub substrate: Substrate,
    /// The film.
    pub film: Film,
    /// Its upper boundary.
    #[serde(default)]
    pub surface: Surface,
}

/// A Lambertian ground coat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Substrate {
    /// Albedo r_s, 0 to 1.
    #[serde(with = "spectrum_text")]
    pub albedo: Spectrum,
}

/// A transparent film with flakes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Film {
    /// Thickness h, micrometres, 0 to 1000; typically 12-20.
    pub thickness_um: f64,
    /// Index of refraction of the binder (eta), 1 to 4; typically 1.5.
    pub index: f64,
    /// Absorption coefficient kappa of the binder, 1/mm, 0 to 1e6; a strong transparent pigment reaches 100.
    #[serde(with = "spectrum_text", default = "nothing")]
    pub absorption_per_mm: Spectrum,
    /// Kinds of flakes, none to 16.
    #[serde(default)]
    pub flakes: Vec<FlakeKind>,
}

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
    /// Width sigma of the Gaussian of tilts, degrees, 0.1 to 89.9; typically 4-12.
    pub sigma_deg: f64,
    /// Full width at half maximum of a flake's angular lobe, degrees of theta_h outside near the normal, as measured from
    /// outside (Rump et al. 2008: 6 to 7 degrees); inside the binder the lobe is narrower by the index, the same for flakes
    /// of any tilt. 0 (a perfect mirror) or 0.1 to 90. Default 6.5.
    #[serde(default = "usual_lifetime")]
    pub flake_lifetime_deg: f64,
    /// A flake given by its reflectance; either this or `stack`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirror: Option<Mirror>,
    /// A flake given by its layers, 1 to 32 of together up to 20 micrometres, in order, each coherent; either this or `mirror`.
    #[serde(skip_serializing_if = "Option::is_none")]
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
    #[serde(with = "spectrum_text", default = "nothing")]
    pub transmittance: Spectrum,
}

/// One layer of a flake.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StackLayer {
    /// Name of a built-in material; either this or `index`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Real index of refraction, 1 to 5 for a layer given by numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub index: Option<f64>,
    /// Imaginary index of a layer given by numbers, 0 to 20. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extinction: Option<f64>,
    /// Thickness, nanometres, 0 to 5000.
    pub thickness_nm: f64,
}

/// The boundary to air.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Roughness, degrees; 0 (smooth, the index is the binder's) is what this version handles.
    #[serde(default)]
    pub roughness_deg: f64,
}

fn nothing() -> Spectrum {
    Spectrum::constant(0.0)
}

fn usual_spread() -> f64 {
    0.3
}

fn usual_lifetime() -> f64 {
    6.5
}

impl Composition {
    /// Largest file read, bytes; the ready ones have some two thousand.
    const MAX_BYTES: u64 = 1 << 20;
    /// Most kinds of flakes.
    pub const MAX_KINDS: usize = 16;
    /// Largest flake area over paint area; beyond, flakes of any real thickness do not fit between each other.
    pub const MAX_AREA_DENSITY: f64 = 10.0;
    /// Most layers of a flake.
    pub const MAX_LAYERS: usize = 32;
    /// Thickest stack, nanometres: ten times the thickest real flakes. Fringes over the angle get finer as it grows, and
    /// rounding in their phase stays below what the tables promise.
    pub const MAX_STACK_NM: f64 = 20_000.0;

    /// Reads a TOML file.
    ///
    /// # Errors
    /// Those of the file system; more than a megabyte; not UTF-8, not TOML; an unknown or missing key (the legal ones listed); a value outside its
    /// range.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path, Self::MAX_BYTES)?).map_err(|e| e.in_file(path))
    }

    /// Reads TOML.
    ///
    /// # Errors
    /// As [`Composition::read`], without the file.
    pub fn parse(text: &str) -> Result<Self> {
        let composition: Self = toml::from_str(text).map_err(|e| {
            let line =
                e.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            let legal = "the keys and types of a composition";
            Error::invalid(format!("line {line}"), "key or value", e.message().trim(), legal)
        })?;
        composition.validate()?;
        Ok(composition)
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        spectrum("substrate.albedo", &self.substrate.albedo, 0.0..=1.0)?;
        let film = &self.film;
        number("film.thickness_um", film.thickness_um, 0.0..=1000.0)?;
        number("film.index", film.index, 1.0..=4.0)?;
        spectrum("film.absorption_per_mm", &film.absorption_per_mm, 0.0..=1e6)?;
        if film.flakes.len() > Self::MAX_KINDS {
            return Err(Error::invalid("film.flakes", "kinds", film.flakes.len(), "0 to 16"));
        }
        for (k, kind) in film.flakes.iter().enumerate() {
            kind.validate().map_err(|e| e.within(format!("film.flakes[{k}]")))?;
        }
        number("film.flakes: area_density of all kinds", self.area_density(), 0.0..=Self::MAX_AREA_DENSITY)?;
        if self.surface.roughness_deg != 0.0 {
            let found = self.surface.roughness_deg;
            return Err(Error::unsupported("surface", "roughness_deg", found, "0 (smooth)"));
        }
        Ok(())
    }

    /// Flake area over paint area, all kinds.
    pub fn area_density(&self) -> f64 {
        self.film.flakes.iter().map(|kind| kind.area_density).sum()
    }
}

impl FlakeKind {
    /// Mean area of a flake, square micrometres: pi/4 times the mean squared diameter.
    pub fn mean_area_um2(&self) -> f64 {
        std::f64::consts::FRAC_PI_4 * self.diameter_um.powi(2) * (1.0 + self.diameter_spread.powi(2))
    }

    fn validate(&self) -> Result<()> {
        number("area_density", self.area_density, 0.0..=Composition::MAX_AREA_DENSITY)?;
        number("diameter_um", self.diameter_um, 0.01..=1000.0)?;
        number("diameter_spread", self.diameter_spread, 0.0..=1.0)?;
        number("sigma_deg", self.sigma_deg, 0.1..=89.9)?;
        if self.flake_lifetime_deg != 0.0 {
            number("flake_lifetime_deg (or 0, a mirror)", self.flake_lifetime_deg, 0.1..=90.0)?;
        }
        match (&self.mirror, &self.stack) {
            (Some(mirror), None) => mirror.validate().map_err(|e| e.within("mirror")),
            (None, Some(layers)) => {
                if !(1..=Composition::MAX_LAYERS).contains(&layers.len()) {
                    return Err(Error::invalid("stack", "layers", layers.len(), "1 to 32"));
                }
                for (k, layer) in layers.iter().enumerate() {
                    layer.validate().map_err(|e| e.within(format!("stack[{k}]")))?;
                }
                let total = layers.iter().map(|layer| layer.thickness_nm).sum();
                number("stack: thickness_nm of all layers", total, 0.0..=Composition::MAX_STACK_NM)
            }
            (Some(_), Some(_)) => Err(Error::invalid("", "flake", "mirror and stack", "one of the two")),
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

impl StackLayer {
    /// Real and imaginary index over wavelength.
    ///
    /// # Errors
    /// An unknown material; neither or both of material and index.
    pub fn indices(&self) -> Result<(Spectrum, Spectrum)> {
        match (&self.material, self.index) {
            (Some(name), None) if self.extinction.is_none() => {
                material(name).map(|m| (m.n.clone(), m.k.clone()))
            }
            (None, Some(n)) => {
                Ok((Spectrum::constant(n), Spectrum::constant(self.extinction.unwrap_or(0.0))))
            }
            (None, None) => Err(Error::invalid("", "layer", "neither material nor index", "one of the two")),
            _ => Err(Error::invalid(
                "",
                "layer",
                "material and numbers",
                "a material, or index and extinction",
            )),
        }
    }

    fn validate(&self) -> Result<()> {
        number("thickness_nm", self.thickness_nm, 0.0..=5000.0)?;
        number("index", self.index.unwrap_or(1.0), 1.0..=5.0)?;
        number("extinction", self.extinction.unwrap_or(0.0), 0.0..=20.0)?;
        self.indices().map(|_| ())
    }
}

fn number(what: &str, value: f64, legal: RangeInclusive<f64>) -> Result<()> {
    if legal.contains(&value) {
        return Ok(());
    }
    Err(Error::invalid("", what, value, format!("{} to {}", legal.start(), legal.end())))
}

fn spectrum(what: &str, values: &Spectrum, legal: RangeInclusive<f64>) -> Result<()> {
    match values.0.iter().position(|v| !legal.contains(v)) {
        None => Ok(()),
        Some(k) => {
            let what = format!("{what} at {} nm", crate::color::wavelength_nm(k));
            number(&what, values.0[k], legal)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAINT: &str = r#"
title = "test"
[substrate]
albedo = [[380, 0.1], [500, 0.2], [780, 0.4]]
[film]
thickness_um = 15
index = 1.5
[[film.flakes]]
area_density = 0.5
diameter_um = 20
sigma_deg = 5
mirror = { reflectance = 0.6, transmittance = 0.4 }
[[film.flakes]]
area_density = 0.2
diameter_um = 10
sigma_deg = 5
stack = [{ material = "TiO2", thickness_nm = 60 }, { index = 1.58, thickness_nm = 300 }]
"#;

    #[test]
    fn a_paint_is_read_and_survives_json() {
        let paint = Composition::parse(PAINT).unwrap();
        assert_eq!(paint.film.flakes[0].flake_lifetime_deg, 6.5);
        assert!((paint.substrate.albedo.0[12] - 0.2).abs() < 1e-15);
        let json = serde_json::to_value(&paint).unwrap();
        assert_eq!(serde_json::from_value::<Composition>(json).unwrap(), paint);
    }

    #[test]
    fn bad_paints_are_refused_with_place_value_and_range() {
        let cases = [
            ("thickness_um = 15", "thickness_um = -1", ["film.thickness_um", "-1", "0 to 1000"]),
            ("index = 1.5\n", "index = 0.9\n", ["film.index", "0.9", "1 to 4"]),
            ("sigma_deg = 5\nmirror", "sigma_deg = 90\nmirror", ["film.flakes[0]", "sigma_deg", "90"]),
            ("area_density = 0.5", "area_density = 9.9", ["area_density of all kinds", "10.1", "0 to 10"]),
            (
                "transmittance = 0.4",
                "transmittance = 0.5",
                ["reflectance + transmittance", "1.1", "at most 1"],
            ),
            ("\"TiO2\"", "\"TiO3\"", ["stack[0]", "TiO3", "TiO2-rutile"]),
            ("albedo = [[380", "albedo = [[390", ["line 4", "wavelengths", "380 to 780"]),
            ("diameter_um = 20", "diameter = 20", ["line 10", "diameter", "diameter_um"]),
            ("index = 1.5\n", "index = 1.5\nabsorption_per_mm = -1\n", ["absorption_per_mm", "380 nm", "-1"]),
            ("index = 1.5\n", "index = nan\n", ["film.index", "NaN", "1 to 4"]),
            (
                "{ index = 1.58,",
                "{ index = 1.58, material = \"mica\",",
                ["stack[1]", "material and numbers", "index"],
            ),
            (
                "title = \"test\"",
                "surface = { roughness_deg = 1 }",
                ["surface", "roughness_deg", "0 (smooth)"],
            ),
        ];
        for (from, to, words) in cases {
            assert!(PAINT.contains(from), "{from}");
            let message = Composition::parse(&PAINT.replacen(from, to, 1)).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{to}: {message}");
            }
        }
    }
}
