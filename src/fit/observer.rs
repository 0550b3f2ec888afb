//! An ink as the eye's three numbers.

use super::separable::Separable;
use crate::brdf::Ink;
use crate::brdf::goniochromatic::Goniochromatic;
use crate::color::Spectrum;

/// Angles of the fit: the mean of the polar angles, every degree up to 80.
const ANGLES: u32 = 81;

/// X, Y and Z of an ink under a light, each fitted by the goniochromatic model: a sum of exponentials `sum w rho exp(c x)`, `x = 1 -
/// cos` of the mean angle, is nearly one exponential where c changes little over the wavelengths that count.
pub fn ink_of_observer(ink: &Ink, light: &Spectrum) -> [Goniochromatic; 3] {
    let weights = ink.wavelengths().xyz_weights(light);
    let cosines: Vec<f64> = (0..ANGLES).map(|k| f64::from(k).to_radians().cos()).collect();
    std::array::from_fn(|channel| {
        let value = |cos: &f64| -> f64 {
            weights.iter().enumerate().map(|(band, w)| w[channel] * ink.at(band).directional(*cos)).sum()
        };
        let values: Vec<f64> = cosines.iter().map(value).collect();
        // The eye judges by ratios.
        let squares: Vec<f64> = values.iter().map(|v| if *v > 0.0 { 1.0 / (v * v) } else { 0.0 }).collect();
        let model = |growth: f64, k: usize| ((growth * (1.0 - cosines[k])).exp(), 1.0 - cosines[k]);
        let bounds = -Goniochromatic::MAX_GROWTH..=Goniochromatic::MAX_GROWTH;
        let found = Separable { values: &values, weights: &squares, model, bounds }.solve();
        Goniochromatic { roughness: ink.roughness(), reflectance: found.scale, growth: found.shape }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Illuminant, Wavelengths};

    #[test]
    fn an_ink_that_grows_alike_everywhere_loses_nothing() {
        let grid = Wavelengths::even(41).unwrap();
        let rho = (0..41).map(|k| 0.1 + 0.02 * f64::from(k)).collect();
        let ink = Ink::new("", 0.2, grid, rho, vec![1.7; 41]).unwrap();
        let light = Illuminant::D65.spectrum();
        let expected = ink.wavelengths().spectrum(ink.reflectance()).xyz(&light);
        for (k, fitted) in ink_of_observer(&ink, &light).iter().enumerate() {
            assert!(
                (fitted.growth - 1.7).abs() < 1e-9 && (fitted.reflectance / expected[k] - 1.0).abs() < 1e-9
            );
        }
    }
}
