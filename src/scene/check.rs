//! Range checks shared by the parts of a scene.

pub(super) use crate::check::range;
use crate::error::{Error, Result};

/// Radiance or irradiance: three numbers from 0 to 1e6.
pub(super) fn radiance(place: &str, what: &str, rgb: [f64; 3]) -> Result<()> {
    if rgb.iter().all(|c| (0.0..=1e6).contains(c)) {
        return Ok(());
    }
    Err(Error::invalid(place, what, format!("{rgb:?}"), "numbers from 0 to 1e6"))
}

/// A direction that can be normalized.
pub(super) fn direction(place: &str, what: &str, v: [f64; 3]) -> Result<()> {
    let length = glam::DVec3::from(v).length();
    if (1e-6..=1e6).contains(&length) {
        return Ok(());
    }
    Err(Error::invalid(place, what, format!("{v:?}"), "a vector of length 1e-6 to 1e6"))
}

/// A place within ten kilometres.
pub(super) fn position(place: &str, what: &str, v: [f64; 3]) -> Result<()> {
    if v.iter().all(|c| c.abs() <= 1e7) {
        return Ok(());
    }
    Err(Error::invalid(place, what, format!("{v:?}"), "millimetres, -1e7 to 1e7"))
}
