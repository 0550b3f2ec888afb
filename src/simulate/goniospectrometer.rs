//! What a goniometer with a spectrometer measures of a simulated print: spectra in the plane of incidence, with repeats and noise
//! (Pranovich et al. 2024, "Preparation and measurement").
//!
//! Light at 20 to 70 degrees in steps of 10 and at 65. The paper says of the exit angles only that at small incidence the detector
//! could not be on the lamp's side of the normal, and at larger could: here it moves by one degree between 80 degrees on either side
//! and stays [`LAMP_CLEARANCE_DEG`] clear of the lamp, so that at 20 degrees it ends at the normal. The mirror direction
//! is always among them. Noise is relative, of every reading and wavelength by itself, as where photons are many.

use super::Model;
use crate::brdf::{Bands, BrdfSample, SampleSet};
use crate::check::range;
use crate::color::{BANDS, Spectrum, wavelength_nm};
use crate::error::{Error, Result};
use crate::math::hash::{pcg4d, unit};
use crate::math::normal::probit;
use crate::parallel::TryMap;
use crate::simulate::Reading;
use rayon::prelude::*;

/// Least angle between detector and lamp, degrees.
pub const LAMP_CLEARANCE_DEG: f64 = 20.0;
/// Steepest exit angle of the scan, degrees, and its step.
const SCAN_DEG: (i32, f64) = (80, 1.0);
/// Most readings, a row of a table each.
const MAX_READINGS: usize = 1 << 16;

/// How it measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Goniospectrometer {
    /// Incidences, degrees, 10 (half the clearance: the mirror direction must be seen) to 85, in any order, each once.
    pub incidences_deg: Vec<f64>,
    /// Readings of each geometry, 1 to 1000.
    pub repeats: usize,
    /// Standard deviation of a reading at one wavelength over its value, 0 to 0.5.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u32,
}

impl Default for Goniospectrometer {
    /// The paper's incidences and ten repeats; one percent of noise.
    fn default() -> Self {
        let incidences_deg = vec![20.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0];
        Self { incidences_deg, repeats: 10, noise: 0.01, seed: 1 }
    }
}

impl Goniospectrometer {
    /// The geometries, incidence after incidence, exit angles ascending.
    ///
    /// # Errors
    /// No incidence, one outside its range, one twice; repeats or noise outside their range; more than 65536 readings.
    pub fn geometries(&self) -> Result<Vec<Reading>> {
        range("", "repeats", self.repeats, 1..=1000)?;
        range("", "noise", self.noise, 0.0..=0.5)?;
        let incidences = &self.incidences_deg;
        if incidences.is_empty() {
            return Err(Error::invalid("", "incidences", "none", "one or more"));
        }
        let mut all = Vec::new();
        for (k, incidence) in incidences.iter().enumerate() {
            range("", "incidence, degrees", *incidence, 0.5 * LAMP_CLEARANCE_DEG..=85.0)?;
            if incidences[..k].contains(incidence) {
                return Err(Error::invalid(
                    "",
                    "incidence, degrees",
                    format!("{incidence} twice"),
                    "each once",
                ));
            }
            for exit in exits(*incidence) {
                all.push(Reading::between(*incidence, exit)?);
            }
            // Before a long list of incidences has become a longer one of geometries.
            range("", "readings, repeats counted", all.len() * self.repeats, 1..=MAX_READINGS)?;
        }
        Ok(all)
    }

    /// Measures a model: BRDF, 1/sr, repeats of a geometry one after the other. Gloss of a rough surface is part of it; a
    /// mirror's, in its own direction alone, is left out.
    ///
    /// # Errors
    /// Those of [`Goniospectrometer::geometries`].
    pub fn measure(&self, model: &Model) -> Result<SampleSet> {
        let geometries = self.geometries()?;
        let spectra = geometries.par_iter().try_map(|reading| {
            let (wi, wo) = reading.directions();
            let gloss = model.gloss(wi, wo);
            Ok((wi, wo, Spectrum(model.brdf(wi, wo).0.map(|f| f + gloss))))
        })?;
        let mut set = SampleSet::new(Bands::Wavelengths((0..BANDS).map(wavelength_nm).collect()))?;
        for (geometry, (wi, wo, spectrum)) in (0..).zip(spectra) {
            for repeat in (0..).take(self.repeats) {
                let values: [f64; BANDS] = std::array::from_fn(|band| {
                    spectrum.0[band] * (1.0 + self.noise * self.normal(geometry, repeat, band))
                });
                set.push(BrdfSample::new(wi, wo, 1.0), &values)?;
            }
        }
        Ok(set)
    }

    /// A standard normal number of one reading at one wavelength.
    fn normal(&self, geometry: u32, repeat: u32, band: usize) -> f64 {
        probit(f64::from(unit(pcg4d([self.seed, geometry, repeat, band as u32])[0])))
    }
}

/// Exit angles at an incidence, degrees, ascending, the mirror direction among them.
fn exits(incidence: f64) -> Vec<f64> {
    let (last, step) = SCAN_DEG;
    let scan = (-last..=last).map(|k| step * f64::from(k));
    let mut exits: Vec<f64> = scan.filter(|exit| exit + incidence >= LAMP_CLEARANCE_DEG).collect();
    if !exits.contains(&incidence) {
        exits.push(incidence);
        exits.sort_by(f64::total_cmp);
    }
    exits
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometries(incidences: &[f64]) -> Vec<Reading> {
        let incidences_deg = incidences.to_vec();
        Goniospectrometer { incidences_deg, ..Goniospectrometer::default() }.geometries().unwrap()
    }

    #[test]
    fn the_detector_keeps_clear_of_the_lamp_and_sees_the_mirror_direction() {
        let exits =
            |incidence: f64| geometries(&[incidence]).iter().map(Reading::theta_o_deg).collect::<Vec<f64>>();
        let (steep, flat) = (exits(20.0), exits(70.0));
        assert_eq!((steep.len(), steep[0], steep[80]), (81, 0.0, 80.0));
        assert_eq!((flat.len(), flat[0], flat[130]), (131, -50.0, 80.0));
        let between = exits(32.25);
        assert!(between.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(between.iter().filter(|exit| **exit == 32.25).count(), 1);
        // Beyond the scan only the mirror direction.
        assert_eq!(exits(84.0).last(), Some(&84.0));
        assert!(geometries(&Goniospectrometer::default().incidences_deg).len() > 700);
    }

    #[test]
    fn bad_settings_are_named() {
        let good = Goniospectrometer::default();
        let at = |incidences_deg: Vec<f64>| Goniospectrometer { incidences_deg, ..good.clone() };
        for (bad, words) in [
            (at(vec![]), "incidences: found none"),
            (at(vec![9.0]), "incidence, degrees: found 9, expected 10 to 85"),
            (at(vec![f64::NAN]), "found NaN"),
            (at(vec![20.0, 20.0]), "found 20 twice"),
            (Goniospectrometer { repeats: 0, ..good.clone() }, "repeats: found 0, expected 1 to 1000"),
            (Goniospectrometer { repeats: 100, ..good.clone() }, "readings, repeats counted"),
            (Goniospectrometer { noise: -0.1, ..good.clone() }, "noise: found -0.1, expected 0 to 0.5"),
        ] {
            let message = bad.geometries().unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
