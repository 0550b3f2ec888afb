//! Spectra sampled anywhere, and what they add up to.

use super::observer::{BANDS, TABLE, wavelength_nm};
use super::spectrum::Spectrum;
use crate::error::{Error, Result};
use glam::DVec3;

/// Where spectra are sampled: 1 to 4096 wavelengths, nanometres, ascending, at least one within 380 to 780.
#[derive(Debug, Clone, PartialEq)]
pub struct Wavelengths(Vec<f64>);

impl Wavelengths {
    /// Most wavelengths.
    pub const MAX: usize = 4096;
    /// Legal wavelengths, nanometres.
    const LEGAL_NM: std::ops::RangeInclusive<f64> = 100.0..=10_000.0;
    /// Spacing from which on samples within a band's triangle are averaged, nanometres.
    const FINE_NM: f64 = 5.0;

    /// Any wavelengths.
    ///
    /// # Errors
    /// None or over 4096, none in the visible range, one out of order, or outside 100 to 10,000 nm, as those in micrometres
    /// are.
    pub fn new(nm: Vec<f64>) -> Result<Self> {
        let invalid = |found: String, legal: &str| Err(Error::invalid("", "wavelengths", found, legal));
        if !(1..=Self::MAX).contains(&nm.len()) {
            return invalid(nm.len().to_string(), "1 to 4096 of them");
        }
        if let Some(bad) = nm.iter().find(|nm| !Self::LEGAL_NM.contains(nm)) {
            let hint = if (0.1..10.0).contains(bad) { " (in micrometres?)" } else { "" };
            return invalid(format!("{bad}{hint}"), "nanometres, 100 to 10000");
        }
        if let Some(pair) = nm.windows(2).find(|pair| pair[0] >= pair[1]) {
            return invalid(format!("{} before {}", pair[0], pair[1]), "ascending");
        }
        let (first, last) = (wavelength_nm(0), wavelength_nm(BANDS - 1));
        if !nm.iter().any(|nm| (first..=last).contains(nm)) {
            return invalid(format!("{} to {}", nm[0], nm[nm.len() - 1]), "some within 380 to 780 nm");
        }
        Ok(Self(nm))
    }

    /// `count` wavelengths, evenly from 380 to 780 nm.
    ///
    /// # Errors
    /// As [`Wavelengths::new`].
    pub fn even(count: usize) -> Result<Self> {
        let steps = count.clamp(2, Self::MAX) - 1;
        let (first, last) = (wavelength_nm(0), wavelength_nm(BANDS - 1));
        Self::new(
            (0..count.min(Self::MAX + 1)).map(|k| first + (last - first) * k as f64 / steps as f64).collect(),
        )
    }

    /// Nanometres.
    pub fn nm(&self) -> &[f64] {
        &self.0
    }

    /// Number of wavelengths.
    #[allow(clippy::len_without_is_empty, reason = "there is always one")]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// What each sample is of a band's mean, where samples lie within 5 nm of each other: the mean of all within 10 nm, the near ones
    /// weighing more (a triangle).
    fn around(&self, band: usize) -> Option<Vec<(usize, f64)>> {
        let (nm, at) = (&self.0, wavelength_nm(band));
        let near = nm.partition_point(|l| *l <= at - 10.0)..nm.partition_point(|l| *l < at + 10.0);
        let is_fine = near.len() > 2
            && nm[near.clone()].windows(2).all(|pair| pair[1] - pair[0] <= Self::FINE_NM)
            && nm[near.start] <= at - 10.0 + Self::FINE_NM
            && nm[near.end - 1] >= at + 10.0 - Self::FINE_NM;
        is_fine.then(|| {
            let width = |k: usize| nm[(k + 1).min(nm.len() - 1)] - nm[k.saturating_sub(1)];
            let weights: Vec<f64> =
                near.clone().map(|k| (1.0 - (nm[k] - at).abs() / 10.0) * width(k)).collect();
            let sum: f64 = weights.iter().sum();
            let mean = |f: &dyn Fn(f64) -> f64| {
                near.clone().zip(&weights).map(|(k, w)| w * f(nm[k])).sum::<f64>() / sum
            };
            // Uneven samples may lie to one side of the band: tilted weights have their mean in its middle.
            let middle = mean(&|l| l);
            let tilt = (at - middle) / mean(&|l| (l - middle) * (l - middle));
            let tilted =
                near.clone().zip(&weights).map(|(k, w)| (k, w / sum * (1.0 + tilt * (nm[k] - middle))));
            tilted.collect()
        })
    }

    /// The samples on both sides of a wavelength and their shares; the first or last one beyond the ends.
    fn beside(&self, at: f64) -> [(usize, f64); 2] {
        let nm = &self.0;
        let right = nm.partition_point(|l| *l < at);
        if right == 0 || right == nm.len() {
            let end = right.min(nm.len() - 1);
            return [(end, 1.0), (end, 0.0)];
        }
        let share = (at - nm[right - 1]) / (nm[right] - nm[right - 1]);
        [(right - 1, 1.0 - share), (right, share)]
    }

    /// The value between samples, of which there is one a wavelength; level beyond the ends.
    pub fn interpolate(&self, samples: &[f64], nm: f64) -> f64 {
        self.beside(nm).into_iter().map(|(k, share)| share * samples[k]).sum()
    }

    /// The spectrum with these samples, of which there is one a wavelength: linear between them, level beyond the first and the last.
    pub fn spectrum(&self, samples: &[f64]) -> Spectrum {
        Spectrum(std::array::from_fn(|band| self.interpolate(samples, wavelength_nm(band))))
    }

    /// The same with means over bands where samples are within 5 nm of each other: what lies between bands, as lines of a lamp do,
    /// counts, and is not as sharp any more.
    pub fn spectrum_of_means(&self, samples: &[f64]) -> Spectrum {
        Spectrum(std::array::from_fn(|band| {
            let shares = self.around(band).unwrap_or_else(|| self.beside(wavelength_nm(band)).to_vec());
            shares.into_iter().map(|(k, share)| share * samples[k]).sum()
        }))
    }

    /// What a reflectance of 1 at each wavelength adds to something that is linear in bands.
    pub(crate) fn weights(&self, of_band: impl Fn(usize) -> DVec3) -> Vec<DVec3> {
        let mut weights = vec![DVec3::ZERO; self.len()];
        for band in 0..BANDS {
            let value = of_band(band);
            self.beside(wavelength_nm(band)).into_iter().for_each(|(k, share)| weights[k] += share * value);
        }
        weights
    }

    /// The value between samples, of which there is one a wavelength: cubic through four that are even, linear elsewhere; level beyond
    /// the ends. It may go beyond its neighbors a little.
    pub fn interpolate_smoothly(&self, samples: &[f64], nm: f64) -> f64 {
        self.about(nm).into_iter().map(|(k, share)| share * samples[k]).sum()
    }

    /// XYZ of a reflectance of 1 at each wavelength under a light; all of them are a perfect reflector's, of Y = 1. Between even
    /// samples spectra are cubic: 21 of them tell nearly what 41 do.
    pub fn xyz_weights(&self, light: &Spectrum) -> Vec<DVec3> {
        let white: f64 = TABLE.iter().zip(&light.0).map(|(row, light)| row[1] * light).sum();
        let mut weights = vec![DVec3::ZERO; self.len()];
        for (band, ([x, y, z, ..], power)) in TABLE.iter().zip(light.0).enumerate() {
            let value = DVec3::new(*x, *y, *z) * (power / white);
            let shares = self.about(wavelength_nm(band));
            shares.into_iter().for_each(|(k, share)| weights[k] += share * value);
        }
        weights
    }

    /// The samples about a wavelength and what each is of the value there: Lagrange's cubic through four where samples are even and
    /// four or more, linear elsewhere, level beyond the ends.
    fn about(&self, at: f64) -> Vec<(usize, f64)> {
        let nm = &self.0;
        let step = (nm[nm.len() - 1] - nm[0]) / (nm.len() - 1) as f64;
        let is_even = nm.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() < 1e-6 * step);
        let at_step = (at - nm[0]) / step;
        if nm.len() < 4 || !is_even || !(0.0..=(nm.len() - 1) as f64).contains(&at_step) {
            return self.beside(at).to_vec();
        }
        let first = (at_step as usize).saturating_sub(1).min(nm.len() - 4);
        let share = |k: usize| {
            let others = (first..first + 4).filter(|other| *other != k);
            (k, others.map(|other| (at_step - other as f64) / (k as f64 - other as f64)).product())
        };
        (first..first + 4).map(share).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Illuminant;

    #[test]
    fn wavelengths_that_make_no_grid_are_refused() {
        for (nm, words) in [
            (vec![], "found 0, expected 1 to 4096"),
            (vec![500.0, 400.0], "500 before 400, expected ascending"),
            (vec![500.0, 500.0], "ascending"),
            (vec![0.38, 0.78], "0.38 (in micrometres?), expected nanometres"),
            (vec![400.0, f64::NAN], "NaN"),
            (vec![800.0, 900.0], "800 to 900, expected some within"),
            (vec![400.0; 5000], "5000"),
        ] {
            let message = Wavelengths::new(nm).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
        assert_eq!(Wavelengths::even(41).unwrap().nm()[40], 780.0);
        assert!(Wavelengths::even(0).is_err() && Wavelengths::even(usize::MAX).is_err());
    }

    #[test]
    fn straight_lines_stay_what_they_are() {
        let line = |nm: f64| 0.1 + 0.002 * (nm - 380.0);
        for count in [2, 8, 16, 21, 41, 81, 100, 401] {
            let grid = Wavelengths::even(count).unwrap();
            let samples: Vec<f64> = grid.nm().iter().map(|nm| line(*nm)).collect();
            let both = [grid.spectrum(&samples), grid.spectrum_of_means(&samples)];
            for (band, value) in both.iter().flat_map(|s| s.0.iter().enumerate()) {
                assert!((value - line(wavelength_nm(band))).abs() < 1e-13, "{count} {band}: {value}");
            }
        }
    }

    #[test]
    fn weights_sum_to_what_spectra_do() {
        for light in [Illuminant::D65, Illuminant::A] {
            for grid in
                [Wavelengths::even(41).unwrap(), Wavelengths::new(vec![410.0, 433.0, 590.0, 711.0]).unwrap()]
            {
                let samples: Vec<f64> = (0..grid.len()).map(|k| 0.3 + 0.2 * (k as f64).sin()).collect();
                let weights = grid.xyz_weights(&light.spectrum());
                let xyz: DVec3 = weights.iter().zip(&samples).map(|(w, s)| *w * *s).sum();
                assert!(xyz.distance(grid.spectrum(&samples).xyz(&light.spectrum())) < 1e-14);
            }
        }
    }

    #[test]
    fn coarse_even_samples_tell_smooth_spectra() {
        let smooth = |nm: f64| 0.4 + 0.3 * (nm / 60.0).sin();
        let light = Illuminant::D65.spectrum();
        let xyz = |count: usize| -> DVec3 {
            let grid = Wavelengths::even(count).unwrap();
            grid.xyz_weights(&light).iter().zip(grid.nm()).map(|(w, nm)| *w * smooth(*nm)).sum()
        };
        let truth = xyz(41);
        // A cubic is off by 3/128 of the fourth derivative times the step's fourth power, at most: 7e-3 (20 / 60)^4.
        assert!(xyz(21).distance(truth) < 1e-4, "{}", xyz(21) - truth);
        let white: DVec3 = Wavelengths::even(8).unwrap().xyz_weights(&light).into_iter().sum();
        assert!(white.distance(Illuminant::D65.white()) < 1e-13);
    }

    /// What lies between bands counts, where it is known.
    #[test]
    fn a_line_between_bands_is_seen() {
        let grid = Wavelengths::even(401).unwrap();
        let line: Vec<f64> = grid.nm().iter().map(|nm| if *nm == 546.0 { 10.0 } else { 0.0 }).collect();
        let sum: f64 = grid.spectrum_of_means(&line).0.iter().sum();
        // Ten in one of ten samples a band.
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}
