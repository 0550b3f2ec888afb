//! What a paint is made of: substrate, films with flakes and pigments, surface. Read from TOML.
//!
//! ```toml
//! title = "silver"
//!
//! [substrate]
//! albedo = 0.1                      # a SPECTRUM; or: albedo_rgb = [0.5, 0.1, 0.1], linear Rec.709
//!
//! [[film]]                          # one for each film, bottom to top
//! thickness_um = 16
//! index = 1.5
//! absorption_per_mm = 0             # a SPECTRUM
//!
//! [[film.flakes]]
//! area_density = 1.0
//! diameter_um = 18
//! diameter_spread = 0.3
//! sigma_deg = 6                     # or: tilts = [[0, 1], [5, 0.8], [20, 0]], degrees and density per steradian
//! mirror = { reflectance = 0.8 }    # or: stack = [{ material = "TiO2", thickness_nm = 60, thickness_spread = 0.1 },
//!                                   #              { index = 1.58, thickness_nm = 500 }, ...], SPECTRUMs here too
//!
//! [[film.pigments]]
//! henyey_greenstein = { scattering_per_mm = 20, extinction_per_mm = 30, asymmetry = 0.6 }
//! # or: rayleigh = { scattering_per_mm = 20, extinction_per_mm = 30 }
//! # or: mie = { radius_um = 0.12, volume_fraction = 0.05, material = "TiO2-rutile" }
//!
//! [surface]
//! roughness_deg = 0
//! ```
//!
//! A SPECTRUM is a number or knots `[[nm, value], ...]`, linear between them, that cover 380-780 nm.

mod checks;
mod film;
mod flake;
mod pigment;
pub(in crate::simulate) mod spectrum_text;
mod substrate;
mod warnings;

pub use film::{Film, Surface};
pub use flake::{FlakeKind, Mirror, StackLayer};
pub use pigment::{HenyeyGreenstein, MieSpheres, Pigment, Rayleigh};
pub use substrate::Substrate;

use crate::error::{Error, Result};
use crate::file::read_text;
use checks::number;
use serde::{Deserialize, Serialize};
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
    /// The films, bottom to top, 1 to 8.
    #[serde(rename = "film")]
    pub films: Vec<Film>,
    /// The upper boundary of the topmost.
    #[serde(default)]
    pub surface: Surface,
}

impl Composition {
    /// Largest file read, bytes; the ready ones have some two thousand.
    const MAX_BYTES: u64 = 1 << 20;
    /// Most films.
    pub const MAX_FILMS: usize = 8;
    /// Most kinds of flakes, and of pigments, in a film.
    pub const MAX_KINDS: usize = 16;
    /// Largest flake area over paint area; beyond, flakes of any real thickness do not fit between each other.
    pub const MAX_AREA_DENSITY: f64 = 10.0;
    /// Most layers of a flake.
    pub const MAX_LAYERS: usize = 32;
    /// Most layers of a flake whose thickness varies.
    pub const MAX_SPREAD_LAYERS: usize = 3;
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
        let fail = |e: toml::de::Error, path: String| {
            let line =
                e.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            let place = [format!("line {line}"), path].join(": ");
            let message = e.message().trim();
            // Both serde and this crate say "found, expected legal".
            let (found, legal) = message
                .rsplit_once(", expected ")
                .unwrap_or((message, "the keys and types of a composition"));
            Error::invalid(place.trim_end_matches(": "), "key or value", found, legal)
        };
        let document = toml::Deserializer::parse(text).map_err(|e| fail(e, String::new()))?;
        let composition: Self = serde_path_to_error::deserialize(document).map_err(|e| {
            let path = place(e.path());
            match fail(e.into_inner(), path.clone()) {
                Error::Invalid(fault) if path == "film" && fault.found.contains("map") => Error::invalid(
                    fault.place,
                    "film",
                    "one table [film]",
                    "a list: write [[film]] for each film",
                ),
                error => error,
            }
        })?;
        composition.validate()?;
        Ok(composition)
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        self.substrate.validate().map_err(|e| e.within("substrate"))?;
        if !(1..=Self::MAX_FILMS).contains(&self.films.len()) {
            return Err(Error::invalid("", "films", self.films.len(), "1 to 8"));
        }
        for (k, film) in self.films.iter().enumerate() {
            film.validate().map_err(|e| e.within(format!("film[{k}]")))?;
        }
        number("surface.roughness_deg", self.surface.roughness_deg, 0.0..=45.0)
    }

    /// Flake area over paint area, all kinds of all films.
    pub fn area_density(&self) -> f64 {
        self.flakes().map(|kind| kind.area_density).sum()
    }

    /// All kinds of flakes, film after film, bottom to top.
    pub fn flakes(&self) -> impl Iterator<Item = &FlakeKind> {
        self.films.iter().flat_map(|film| &film.flakes)
    }
}

/// A path of keys as errors write it: `film[1]: flakes[0]: sigma_deg`.
fn place(path: &serde_path_to_error::Path) -> String {
    let keys = path.to_string();
    if keys == "." { String::new() } else { keys.replace('.', ": ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAINT: &str = r#"
title = "test"
[substrate]
albedo = [[380, 0.1], [500, 0.2], [780, 0.4]]
[[film]]
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
        assert_eq!(paint.films[0].flakes[0].flake_lifetime_deg, 6.5);
        assert!((paint.substrate.albedo.0[12] - 0.2).abs() < 1e-15);
        let json = serde_json::to_value(&paint).unwrap();
        assert_eq!(serde_json::from_value::<Composition>(json).unwrap(), paint);
    }

    #[test]
    fn bad_paints_are_refused_with_place_value_and_range() {
        let cases = [
            ("thickness_um = 15", "thickness_um = -1", ["film[0]: thickness_um", "-1", "0 to 1000"]),
            ("index = 1.5\n", "index = 0.9\n", ["film[0]: index", "0.9", "1 to 4"]),
            ("sigma_deg = 5\nmirror", "sigma_deg = 90\nmirror", ["film[0]: flakes[0]", "sigma_deg", "90"]),
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
            ("index = 1.5\n", "index = nan\n", ["film[0]: index", "NaN", "1 to 4"]),
            (
                "{ index = 1.58,",
                "{ index = 1.58, material = \"mica\",",
                ["stack[1]", "material and numbers", "index"],
            ),
            (
                "title = \"test\"",
                "surface = { roughness_deg = 46 }",
                ["surface.roughness_deg", "46", "0 to 45"],
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
