//! Optical constants of the materials flakes are made of, 380-780 nm at 10 nm.
//!
//! Figures from refractiveindex.info (public domain, CC0), interpolated linearly to the bands; each row names its source.
//! Mica (muscovite) is in no such table; its index is 1.58 to 1.60 over the visible and almost without dispersion, so it is
//! the constant 1.58.

mod table;

pub use table::MATERIALS;

use crate::color::{Spectrum, wavelength_nm};
use crate::error::{Error, Result};

/// Complex index of refraction n + i k of a material, k >= 0 absorbing.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in a composition.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Whose measurement.
    pub source: &'static str,
    /// Real part.
    pub n: Spectrum,
    /// Imaginary part.
    pub k: Spectrum,
}

/// The material of this name, letter case aside.
///
/// # Errors
/// There is none: the error lists all names, the nearest first.
pub fn material(name: &str) -> Result<&'static Material> {
    MATERIALS.iter().find(|m| m.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
        let mut names: Vec<_> = MATERIALS.iter().map(|m| m.name).collect();
        names.sort_by_key(|known| edits(&name.to_ascii_lowercase(), &known.to_ascii_lowercase()));
        Error::invalid("", "material", if name.is_empty() { "\"\"" } else { name }, names.join(", "))
    })
}

/// Real and imaginary index over wavelength, by a material's name or by numbers: real 1 to 10, or 0.01 to 10 where the
/// imaginary part (0 to 20; 0 if left out) is positive: metals are below 1, dielectrics are not.
///
/// # Errors
/// An unknown material; neither or both of material and index; a value outside its range.
pub fn optical_constants(
    name: Option<&str>,
    index: Option<&Spectrum>,
    extinction: Option<&Spectrum>,
) -> Result<(Spectrum, Spectrum)> {
    let legal = "material, or index and extinction";
    match (name, index, extinction) {
        (Some(name), None, None) => material(name).map(|m| (m.n.clone(), m.k.clone())),
        (None, Some(n), k) => {
            let k = k.cloned().unwrap_or_else(|| Spectrum::constant(0.0));
            for (band, (n, k)) in n.0.iter().zip(&k.0).enumerate() {
                let least = if *k > 0.0 { 0.01 } else { 1.0 };
                for (what, value, least, most) in [("index", *n, least, 10.0), ("extinction", *k, 0.0, 20.0)]
                {
                    if !(least..=most).contains(&value) {
                        let what = format!("{what} at {} nm", wavelength_nm(band));
                        return Err(Error::invalid("", what, value, format!("{least} to {most}")));
                    }
                }
            }
            Ok((n.clone(), k))
        }
        (None, None, _) => Err(Error::invalid("", "optical constants", "neither material nor index", legal)),
        _ => Err(Error::invalid("", "optical constants", "material and numbers", legal)),
    }
}

/// Least number of letters to insert, delete or replace (Levenshtein 1966).
fn edits(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, other) in b.chars().enumerate() {
            let replaced = diagonal + usize::from(letter != other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[row.len() - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_and_unknown_ones_listed() {
        assert_eq!(material("tio2").unwrap().name, "TiO2");
        let message = material("TiO3").unwrap_err().to_string();
        assert!(message.contains("found TiO3, expected TiO2, "), "{message}");
        assert!(material("micka").unwrap_err().to_string().contains("expected mica, "));
        assert_eq!(edits("kitten", "sitting"), 3);
    }

    #[test]
    fn sodium_line_indices_are_the_handbook_values() {
        // Fused silica 1.4585, sapphire (o) 1.768, MgF2 (o) 1.378 at 589 nm; a band is 590 nm.
        for (name, index) in [("SiO2", 1.4585), ("Al2O3", 1.768), ("MgF2", 1.378)] {
            assert!((material(name).unwrap().n.0[21] - index).abs() < 5e-4, "{name}");
        }
    }

    #[test]
    fn every_row_is_physical() {
        for m in &MATERIALS {
            assert!(m.n.0.iter().all(|n| *n > 0.0 && *n < 10.0), "{}", m.name);
            assert!(m.k.0.iter().all(|k| *k >= 0.0 && *k < 10.0), "{}", m.name);
        }
    }
}
