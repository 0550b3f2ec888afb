//! Whether numbers and spectra of a recipe lie in their legal range.

use crate::check::range;
use crate::color::{Spectrum, wavelength_nm};
use crate::error::Result;
use std::ops::RangeInclusive;

/// Refuses a number outside `legal`, not-a-number included.
pub fn number(what: &str, value: f64, legal: RangeInclusive<f64>) -> Result<()> {
    range("", what, value, legal)
}

/// Refuses a spectrum with a value outside `legal`; the error names the first such wavelength.
pub fn spectrum(what: &str, values: &Spectrum, legal: RangeInclusive<f64>) -> Result<()> {
    match values.0.iter().position(|v| !legal.contains(v)) {
        None => Ok(()),
        Some(k) => number(&format!("{what} at {} nm", wavelength_nm(k)), values.0[k], legal),
    }
}
