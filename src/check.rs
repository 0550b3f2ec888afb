//! Whether numbers that a file or a caller gives lie in their legal range.

use crate::error::{Error, Result};
use std::fmt::Display;
use std::ops::RangeInclusive;

/// A number within `legal`; NaN is not.
///
/// # Errors
/// One that is not, named.
pub fn range<T: PartialOrd + Display>(
    place: &str,
    what: &str,
    value: T,
    legal: RangeInclusive<T>,
) -> Result<()> {
    if legal.contains(&value) {
        return Ok(());
    }
    Err(Error::invalid(place, what, value, format!("{} to {}", legal.start(), legal.end())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_legal_and_no_number_is_not() {
        assert!(range("a", "b", 1.0, 1.0..=2.0).is_ok() && range("a", "b", 7usize, 1..=7).is_ok());
        let message = range("lamp", "height", f64::NAN, 0.0..=0.5).unwrap_err().to_string();
        assert_eq!(message, "lamp: height: found NaN, expected 0 to 0.5");
        assert!(range("", "count", 8usize, 1..=7).is_err());
    }
}
