//! The color table by wavelength.
//!
//! Rump et al. 2008, eq. 3: intensity is the mean over N bands, and chi has a channel for each. Under the eye's weights it turns
//! into the table of linear Rec.709 that a paint carries; fit and weights are both linear, so that nothing is lost on the way
//! but what the bands do not cover.

use crate::brdf::{Bands, ColorTable};
use crate::color::{BANDS, Spectrum, Wavelengths, luminance, rgb_weights, wavelength_nm};
use crate::error::Result;
use glam::DVec3;

/// chi(theta_h, theta_i) with a channel a wavelength; texels as in [`ColorTable`].
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralColors {
    /// Wavelengths, nanometres, ascending.
    pub wavelengths_nm: Vec<f64>,
    /// Columns (theta_h) and rows (theta_i).
    pub size: [usize; 2],
    /// A table a wavelength, row-major.
    pub channels: Vec<Vec<f64>>,
    /// Whether each texel rests on a measurement.
    pub measured: Vec<bool>,
}

impl SpectralColors {
    /// The table in linear Rec.709 under D65. Beyond the first and the last band a spectrum goes on level.
    ///
    /// # Errors
    /// A table that [`ColorTable::new`] refuses.
    pub fn rgb(&self) -> Result<ColorTable> {
        let weights = rgb_of_bands(&Bands::Wavelengths(self.wavelengths_nm.clone()))?;
        let texel = |k: usize| self.channels.iter().zip(&weights).map(|(c, rgb)| *rgb * c[k]).sum::<DVec3>();
        let texels = (0..self.measured.len()).map(|k| shown(texel(k))).collect();
        ColorTable::new(self.size, texels, self.measured.clone())
    }

    /// Share of white's luminance at wavelengths that the bands do not reach, where [`SpectralColors::rgb`] guesses: 0 to 1.
    pub fn beyond(&self) -> f64 {
        let (Some(first), Some(last)) = (self.wavelengths_nm.first(), self.wavelengths_nm.last()) else {
            return 1.0;
        };
        let weight = |k: usize| {
            let mut one = [0.0; BANDS];
            one[k] = 1.0;
            luminance(Spectrum(one).linear_rgb())
        };
        (0..BANDS).filter(|k| !(*first..=*last).contains(&wavelength_nm(*k))).map(weight).sum()
    }
}

/// A texel as a paint carries it. A negative luminance is measurement noise, and set to black.
pub(super) fn shown(color: DVec3) -> [f32; 3] {
    if luminance(color) > 0.0 { color.as_vec3().to_array() } else { [0.0; 3] }
}

/// What one unit in each band adds to linear Rec.709.
///
/// # Errors
/// Those of [`Wavelengths::new`].
pub(super) fn rgb_of_bands(bands: &Bands) -> Result<Vec<DVec3>> {
    let Bands::Wavelengths(nm) = bands else {
        return Ok(vec![DVec3::X, DVec3::Y, DVec3::Z]);
    };
    let weights = rgb_weights();
    Ok(Wavelengths::new(nm.clone())?.weights(|band| weights[band]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_bands_are_gray() {
        for nm in [vec![550.0], vec![400.0, 700.0], (0..31).map(|k| 400.0 + 10.0 * f64::from(k)).collect()] {
            let white: DVec3 = rgb_of_bands(&Bands::Wavelengths(nm)).unwrap().into_iter().sum();
            assert!((white - DVec3::ONE).abs().max_element() < 1e-13, "{white}");
        }
    }

    #[test]
    fn what_bands_do_not_reach_is_told() {
        let of = |nm: [f64; 2]| SpectralColors {
            wavelengths_nm: nm.to_vec(),
            size: [2, 2],
            channels: vec![vec![0.5; 4]; 2],
            measured: vec![true; 4],
        };
        assert_eq!(of([380.0, 780.0]).beyond(), 0.0);
        // The eye sees little beyond: 380 and 390, and 710 to 780 nm, are 0.2 % of white's luminance.
        let beyond = of([400.0, 700.0]).beyond();
        assert!(beyond > 1e-4 && beyond < 5e-3, "{beyond}");
        assert!(of([560.0, 570.0]).beyond() > 0.7);
        let gray = of([400.0, 700.0]).rgb().unwrap();
        assert!(gray.texels().iter().flatten().all(|c| (c - 0.5).abs() < 1e-6));
    }
}
