//! How a spectrum is written in a composition: a number, or knots `[[nm, value], ...]` that cover 380-780 nm.

use crate::color::{BANDS, Spectrum, wavelength_nm};
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{SerializeSeq, Serializer};

/// For `#[serde(with)]`: a constant as a number, anything else as its 41 knots.
pub fn serialize<S: Serializer>(spectrum: &Spectrum, serializer: S) -> Result<S::Ok, S::Error> {
    let first = spectrum.0[0];
    if spectrum.0.iter().all(|v| *v == first) {
        return serializer.serialize_f64(first);
    }
    let mut knots = serializer.serialize_seq(Some(BANDS))?;
    for (k, value) in spectrum.0.iter().enumerate() {
        knots.serialize_element(&[wavelength_nm(k), *value])?;
    }
    knots.end()
}

/// For `#[serde(with)]`.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Spectrum, D::Error> {
    deserializer.deserialize_any(NumberOrKnots)
}

struct NumberOrKnots;

impl<'de> Visitor<'de> for NumberOrKnots {
    type Value = Spectrum;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a number or knots [[nm, value], ...] covering 380 to 780 nm")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Spectrum, E> {
        Ok(Spectrum::constant(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Spectrum, E> {
        Ok(Spectrum::constant(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Spectrum, E> {
        Ok(Spectrum::constant(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Spectrum, A::Error> {
        let mut knots = Vec::new();
        while let Some([nm, value]) = sequence.next_element::<[f64; 2]>()? {
            knots.push((nm, value));
        }
        Spectrum::from_knots(&knots).map_err(A::Error::custom)
    }
}
