//! How inks are seen: the light, the formula, the wavelengths; and the inks that come with the program.

use super::{InkModel, PrintInks};
use crate::brdf::Ink;
use crate::color::{Spectrum, Wavelengths};
use crate::error::{Error, Result};

/// How inks are seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Light of the lamps.
    pub light: Spectrum,
    /// Whether the eye takes the light's white for white.
    pub adapted: bool,
    /// How inks reflect.
    pub model: InkModel,
    /// At which wavelengths.
    pub bands: Bands,
}

/// Wavelengths at which light is added up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bands {
    /// So many, evenly from 380 to 780 nm.
    Wavelengths(usize),
    /// None: three numbers fitted to the goniochromatic model ([`PrintInks::tristimulus`]).
    Xyz,
}

impl Look {
    /// Up to three inks as they are seen.
    ///
    /// # Errors
    /// As [`PrintInks::at`]; three numbers of another model than the goniochromatic one.
    pub fn inks(&self, inks: &[Ink]) -> Result<PrintInks> {
        let count = match (self.bands, self.model) {
            (Bands::Xyz, InkModel::Goniochromatic) => {
                return PrintInks::tristimulus(inks, &self.light, self.adapted);
            }
            (Bands::Xyz, model) => {
                let legal = "Goniochromatic with three numbers";
                return Err(Error::invalid("print", "model", format!("{model:?}"), legal));
            }
            (Bands::Wavelengths(count), _) => count,
        };
        let wavelengths = Wavelengths::even(count)?;
        PrintInks::at(&wavelengths, inks, self.model, &self.light, self.adapted)
    }
}

/// The red, green and blue ink that come with the program (fixtures/README.md).
///
/// # Errors
/// None that is known: they are files of the program.
pub fn own_inks() -> Result<Vec<Ink>> {
    OWN_INKS.iter().map(|text| Ink::parse(text)).collect()
}

const OWN_INKS: [&str; 3] = [
    include_str!("../../../fixtures/inks/red.ink.json"),
    include_str!("../../../fixtures/inks/green.ink.json"),
    include_str!("../../../fixtures/inks/blue.ink.json"),
];
