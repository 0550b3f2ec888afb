//! How a spectrum is written in a composition: a number, or knots `[[nm, value], ...]` that cover 380-780 nm.

use crate::color::{BANDS, Spectrum, wavelength_nm};
use serde::Deserialize;
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
        while let Some(List([nm, value])) = sequence.next_element::<List<2>>()? {
            knots.push((nm, value));
        }
        Spectrum::from_knots(&knots).map_err(A::Error::custom)
    }
}

/// A list of `N` numbers, no more and no fewer: serde's arrays leave unread what a TOML list holds beyond them.
#[derive(Deserialize)]
#[serde(try_from = "Vec<f64>")]
pub struct List<const N: usize>(pub [f64; N]);

impl<const N: usize> TryFrom<Vec<f64>> for List<N> {
    type Error = String;

    fn try_from(values: Vec<f64>) -> Result<Self, String> {
        let found = values.len();
        values.try_into().map(Self).map_err(|_| format!("length: found {found}, expected {N} numbers"))
    }
}

/// For `#[serde(deserialize_with)]`: a list of the length.
pub fn optional_list<'de, D: Deserializer<'de>, const N: usize>(
    deserializer: D,
) -> Result<Option<[f64; N]>, D::Error> {
    List::deserialize(deserializer).map(|List(values)| Some(values))
}

/// For `#[serde(deserialize_with)]`: a list of pairs.
pub fn optional_pairs<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<[f64; 2]>>, D::Error> {
    let pairs = Vec::<List<2>>::deserialize(deserializer)?;
    Ok(Some(pairs.into_iter().map(|List(pair)| pair).collect()))
}

/// Nothing at any wavelength: the default of absorption and transmittance.
pub fn zero() -> Spectrum {
    Spectrum::constant(0.0)
}

/// The same for a spectrum that may be left out, with `default`.
pub mod optional {
    use super::{NumberOrKnots, Spectrum};
    use serde::de::Deserializer;
    use serde::ser::Serializer;

    /// For `#[serde(with)]`, beside `skip_serializing_if = "Option::is_none"`.
    pub fn serialize<S: Serializer>(spectrum: &Option<Spectrum>, serializer: S) -> Result<S::Ok, S::Error> {
        match spectrum {
            Some(spectrum) => super::serialize(spectrum, serializer),
            None => serializer.serialize_none(),
        }
    }

    /// For `#[serde(with)]`.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Spectrum>, D::Error> {
        deserializer.deserialize_any(NumberOrKnots).map(Some)
    }
}
