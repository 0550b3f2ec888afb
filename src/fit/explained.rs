//! The samples and what was fitted to their intensity: from here color table and report are made.

use super::FitOptions;
use super::SmoothFit;
use super::color_errors::{ColorErrors, Scaled};
use super::colors::{self, ColorSample};
use super::lobes::LobeFit;
use super::report::{FitReport, Start, aspecular, difference, spread};
use super::samples::{Sample, SampleCounts, Samples};
use super::spectral::{SpectralColors, shown};
use crate::brdf::cook_torrance::brightness;
use crate::brdf::{Bands, ColorTable};
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;

/// What the fit says at every sample.
pub(super) struct Explained<'a> {
    samples: &'a Samples<'a>,
    fitted: &'a LobeFit,
    /// Diffuse and lobes, seen through the coat.
    brightness: Vec<f64>,
    /// The gloss lobe.
    gloss: Vec<f64>,
}

impl<'a> Explained<'a> {
    pub fn new(samples: &'a Samples<'a>, fitted: &'a LobeFit) -> Self {
        let base = |s: &Sample| -> f64 {
            let lights = samples.inside(s).into_iter();
            lights.map(|(g, weight)| weight * brightness(fitted.diffuse, &fitted.lobes, &g)).sum()
        };
        let peak = |s: &Sample| {
            fitted.gloss.map_or(0.0, |lobe| samples.outside(s).map(|(g, share)| share * lobe.eval(&g)).sum())
        };
        Self {
            samples,
            fitted,
            brightness: samples.list.par_iter().map(base).collect(),
            gloss: samples.list.par_iter().map(peak).collect(),
        }
    }

    /// The samples in or outside the gloss peak.
    fn which(&self, gloss: bool) -> impl Iterator<Item = usize> {
        (0..self.samples.list.len()).filter(move |k| self.in_gloss(*k) == gloss)
    }

    fn in_gloss(&self, k: usize) -> bool {
        let s = &self.samples.list[k];
        s.apart || s.outer_theta_h() < self.fitted.gloss_end
    }

    /// The color table of the samples outside the gloss, of spectral ones by wavelength, too.
    pub fn colors(&self, size: [usize; 2]) -> Result<(ColorTable, Option<SpectralColors>)> {
        let samples: Vec<ColorSample> = self
            .which(false)
            .map(|k| ColorSample {
                sample: &self.samples.list[k],
                brightness: self.brightness[k],
                gloss: self.gloss[k],
                values: self.samples.values(k),
            })
            .collect();
        let fitted = colors::fit(&samples, self.samples.bands.len(), size, self.fitted.epsilon)?;
        match &self.samples.bands {
            Bands::Rgb => {
                let texel = |k: usize| shown(DVec3::from([0, 1, 2].map(|c| fitted.bands[c][k])));
                let texels = (0..fitted.measured.len()).map(texel).collect();
                Ok((ColorTable::new(size, texels, fitted.measured)?, None))
            }
            Bands::Wavelengths(nm) => {
                let (wavelengths_nm, channels) = (nm.clone(), fitted.bands);
                let spectral = SpectralColors { wavelengths_nm, size, channels, measured: fitted.measured };
                Ok((spectral.rgb()?, Some(spectral)))
            }
        }
    }

    /// The fit at sample `k`, color table in.
    fn colored(&self, k: usize, colors: &ColorTable) -> DVec3 {
        let angles = self.samples.list[k].angles;
        let chi = colors.sample(angles.theta_h as f32, angles.theta_i as f32).map(f64::from);
        DVec3::from(chi) * self.brightness[k] + DVec3::splat(self.gloss[k])
    }

    /// Eq. 7 over the samples in or outside the gloss peak, for a model of the intensity.
    fn error(&self, gloss: bool, model: impl Fn(usize) -> f64) -> f64 {
        let epsilon = self.fitted.epsilon;
        let (mut sum, mut count) = (0.0, 0usize);
        for k in self.which(gloss) {
            let measured = self.samples.list[k].intensity.max(0.0);
            sum += ((measured + epsilon) / (model(k).max(0.0) + epsilon)).ln().abs();
            count += 1;
        }
        sum / count.max(1) as f64
    }

    /// Fitted over measured light of the gloss peak, what lies below it taken off both.
    fn gloss_energy(&self, colors: &ColorTable) -> f64 {
        let (mut fitted, mut measured) = (0.0, 0.0);
        for k in self.which(true) {
            let s = &self.samples.list[k];
            let weight = s.solid_angle * s.outer.cos_i * s.outer.cos_o;
            let below = self.colored(k, colors).element_sum() / 3.0 - self.gloss[k];
            fitted += weight * self.gloss[k];
            measured += weight * (s.color.element_sum() / 3.0 - below);
        }
        fitted / measured
    }

    fn color_errors(&self, colors: &ColorTable) -> ColorErrors {
        let scaled = |k: usize| {
            let s = &self.samples.list[k];
            let chi = colors.sample(s.angles.theta_h as f32, s.angles.theta_i as f32).map(f64::from);
            Scaled::new(s, s.color - DVec3::splat(self.gloss[k]), DVec3::from(chi), self.fitted.epsilon)
        };
        let all: Vec<Scaled> = self.which(false).filter_map(scaled).collect();
        ColorErrors::of(&all, colors)
    }

    /// Everything that can be said. `measured` is the measurement in two directions, if it was taken there.
    pub fn report(
        &self,
        fit: &SmoothFit,
        measured: &dyn Fn(DVec3, DVec3) -> Option<DVec3>,
        options: &FitOptions,
        mut samples: SampleCounts,
    ) -> FitReport {
        samples.gloss = self.which(true).count();
        let plain = |k: usize| self.brightness[k] + self.gloss[k];
        let colored = |k: usize| self.colored(k, &fit.colors).element_sum() / 3.0;
        let list = &self.samples.list;
        let differences: Vec<f64> = (0..list.len())
            .into_par_iter()
            .map(|k| difference(list[k].color, self.colored(k, &fit.colors)))
            .collect();
        let outside = self.which(false).map(|k| differences[k]).collect();
        let texels = fit.colors.measured();
        let has_gloss = self.fitted.gloss.is_some();
        FitReport {
            options: options.clone(),
            coat: fit.coat,
            diffuse: fit.diffuse,
            lobes: fit.lobes.clone(),
            samples,
            epsilon: self.fitted.epsilon,
            error: self.error(false, plain),
            colored_error: self.error(false, colored),
            gloss_error: has_gloss.then(|| self.error(true, colored)),
            gloss_energy: has_gloss.then(|| self.gloss_energy(&fit.colors)),
            gloss_end_deg: self.fitted.gloss_end.to_degrees(),
            starts: self.fitted.starts.iter().map(|s| Start { error: s.error, steps: s.steps }).collect(),
            choices: self.fitted.choices.clone(),
            uncertainty: self.fitted.uncertainty.clone(),
            aspecular: aspecular(measured, fit),
            delta_e_2000: spread(outside),
            without_refraction: None,
            texels_measured: texels.iter().filter(|m| **m).count() as f64 / texels.len() as f64,
            color: self.color_errors(&fit.colors),
            beyond_bands: fit.spectral.as_ref().map(SpectralColors::beyond),
            delta_e_2000_with_gloss: spread(differences),
        }
    }
}
