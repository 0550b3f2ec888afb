//! Spectra on the 10 nm grid 380-780 nm, and their color under an illuminant.

use super::observer::{BANDS, TABLE, wavelength_nm};
use super::rgb::{WHITE_XYZ, rgb_from_xyz};
use crate::error::{Error, Result};
use glam::{DMat3, DVec3};

/// A quantity per wavelength band (reflectance, transmittance, absorption): 41 values, 380, 390, ... 780 nm.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum(pub [f64; BANDS]);

/// Standard illuminants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Illuminant {
    /// Average daylight, 6504 K.
    D65,
    /// Incandescent light, 2856 K.
    A,
}

impl Spectrum {
    /// The same value at every wavelength.
    pub const fn constant(value: f64) -> Self {
        Self([value; BANDS])
    }

    /// Piecewise linear through `(wavelength nm, value)` knots.
    ///
    /// # Errors
    /// Fewer than two knots, wavelengths that do not ascend or do not cover 380-780 nm, values that are not finite.
    pub fn from_knots(knots: &[(f64, f64)]) -> Result<Self> {
        let range = |found: String| {
            Error::invalid("spectrum", "wavelengths", found, "two or more, ascending, covering 380 to 780 nm")
        };
        let (Some(first), Some(last)) = (knots.first(), knots.last()) else {
            return Err(range("no knots".into()));
        };
        if knots.len() < 2 || first.0 > wavelength_nm(0) || last.0 < wavelength_nm(BANDS - 1) {
            return Err(range(format!("{} knots from {} to {} nm", knots.len(), first.0, last.0)));
        }
        for pair in knots.windows(2) {
            if pair[0].0.partial_cmp(&pair[1].0) != Some(std::cmp::Ordering::Less) {
                return Err(range(format!("{} nm before {} nm", pair[0].0, pair[1].0)));
            }
        }
        if let Some(bad) = knots.iter().find(|k| !k.1.is_finite()) {
            return Err(Error::invalid(
                "spectrum",
                format!("value at {} nm", bad.0),
                bad.1,
                "a finite number",
            ));
        }
        Ok(Self(std::array::from_fn(|k| {
            let nm = wavelength_nm(k);
            let right = knots.partition_point(|knot| knot.0 < nm).max(1);
            let (a, b) = (knots[right - 1], knots[right]);
            // A knot at a band is that band to the bit: of 1e6 and 57 the sum below would lose digits of the 57.
            if nm == b.0 { b.1 } else { a.1 + (b.1 - a.1) * ((nm - a.0) / (b.0 - a.0)) }
        })))
    }

    /// The value at a wavelength, nanometres: linear between bands, level beyond them.
    pub fn at(&self, nm: f64) -> f64 {
        let place = ((nm - wavelength_nm(0)) / 10.0).clamp(0.0, (BANDS - 1) as f64);
        let left = (place as usize).min(BANDS - 2);
        self.0[left] + (self.0[left + 1] - self.0[left]) * (place - left as f64)
    }

    /// XYZ of a reflectance under a light of any power, straight sums over the bands, perfect reflector Y = 1.
    pub fn xyz(&self, light: &Self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut normalization = 0.0;
        for ((value, row), light) in self.0.iter().zip(&TABLE).zip(light.0) {
            sum += DVec3::new(row[0], row[1], row[2]) * (light * value);
            normalization += row[1] * light;
        }
        sum / normalization
    }

    /// Linear Rec.709 of a reflectance under D65; the constant 1 is (1, 1, 1).
    ///
    /// The white of the straight sums, (.950174, 1, 1.088128), is brought to [`WHITE_XYZ`] by the Bradford transform:
    /// a change of at most 1e-3.
    pub fn linear_rgb(&self) -> DVec3 {
        let weights = rgb_weights();
        self.0.iter().zip(weights).fold(DVec3::ZERO, |sum, (value, w)| sum + *w * *value)
    }
}

/// What one unit of reflectance in each band adds to linear Rec.709 (see [`Spectrum::linear_rgb`]).
pub(crate) fn rgb_weights() -> &'static [DVec3; BANDS] {
    static WEIGHTS: std::sync::LazyLock<[DVec3; BANDS]> = std::sync::LazyLock::new(|| {
        let d65 = Illuminant::D65.spectrum();
        let adapt = bradford(Illuminant::D65.white(), WHITE_XYZ);
        std::array::from_fn(|k| {
            let mut one = [0.0; BANDS];
            one[k] = 1.0;
            rgb_from_xyz(adapt * Spectrum(one).xyz(&d65))
        })
    });
    &WEIGHTS
}

impl Illuminant {
    /// Relative power, 100 at 560 nm.
    pub fn spectrum(self) -> Spectrum {
        let column = match self {
            Self::D65 => 3,
            Self::A => 4,
        };
        Spectrum(TABLE.map(|row| row[column]))
    }

    /// XYZ of the perfect reflector under this illuminant (straight sums).
    pub fn white(self) -> DVec3 {
        Spectrum::constant(1.0).xyz(&self.spectrum())
    }
}

/// Bradford chromatic adaptation from one white to another (ICC.1, annex E).
pub fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    let cone = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    cone.inverse() * DMat3::from_diagonal((cone * to) / (cone * from)) * cone
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_perfect_diffuser_is_white() {
        assert!((Spectrum::constant(1.0).linear_rgb() - DVec3::ONE).abs().max_element() < 1e-14);
    }

    #[test]
    fn knots_interpolate_linearly() {
        let s = Spectrum::from_knots(&[(300.0, 0.0), (500.0, 1.0), (900.0, 1.0)]).unwrap();
        assert!((s.0[0] - 0.4).abs() < 1e-15);
        assert!((s.0[BANDS - 1] - 1.0).abs() < 1e-15);
        assert!(Spectrum::from_knots(&[(400.0, 0.0), (780.0, 1.0)]).is_err());
        assert!(Spectrum::from_knots(&[(300.0, 0.0), (780.0, f64::NAN)]).is_err());
    }

    #[test]
    fn knots_at_the_bands_are_the_values_to_the_bit() {
        let values: [f64; BANDS] =
            std::array::from_fn(
                |k| if k % 2 == 0 { 1e6 / 3.0 } else { 57.255_422_407_724_026 / (k + 1) as f64 },
            );
        let knots: Vec<_> = values.iter().enumerate().map(|(k, v)| (wavelength_nm(k), *v)).collect();
        assert_eq!(Spectrum::from_knots(&knots).unwrap().0, values);
    }
}
