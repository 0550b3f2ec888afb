//! In-plane spectra of a simulated print, and how they are measured.

use super::brdf_output::name;
use crate::brdf::multi_angle_text;
use crate::error::Result;
use crate::file::write_text;
use crate::simulate::{Goniospectrometer, Model};
use std::path::Path;

/// The goniometer with a spectrometer.
#[derive(clap::Args)]
pub struct GoniometerArguments {
    /// Angles of incidence, degrees, 10 to 85 [default: 20,30,40,50,60,65,70].
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "DEGREES,...",
        requires = "spectra",
        allow_negative_numbers = true
    )]
    incidence: Option<Vec<f64>>,
    /// Readings of every geometry, a row each [default: 10].
    #[arg(long, requires = "spectra")]
    repeats: Option<usize>,
    /// Standard deviation of a reading at one wavelength over its value [default: 0.01].
    #[arg(long, requires = "spectra", allow_negative_numbers = true)]
    noise: Option<f64>,
}

impl GoniometerArguments {
    /// What the library is asked for, found to be legal.
    pub fn options(&self, seed: u32) -> Result<Goniospectrometer> {
        let usual = Goniospectrometer::default();
        let asked = Goniospectrometer {
            incidences_deg: self.incidence.clone().unwrap_or(usual.incidences_deg),
            repeats: self.repeats.unwrap_or(usual.repeats),
            noise: self.noise.unwrap_or(usual.noise),
            seed,
        };
        asked.geometries().map_err(|e| e.within("--spectra"))?;
        Ok(asked)
    }
}

/// Measures a model into a table of text.
pub fn write(model: &Model, goniometer: &Goniospectrometer, path: &Path) -> Result<()> {
    let Goniospectrometer { repeats, noise, seed, .. } = goniometer;
    let comments = format!(
        "carpaint: in-plane spectra of a composition, model {}\n\
         angles in degrees, theta_o positive on the mirror side; reflectance factors pi f, columns in nm\n\
         {repeats} readings of each geometry, noise {noise}, seed {seed}; gloss of a mirror left out",
        name(model)
    );
    write_text(path, &multi_angle_text(&goniometer.measure(model)?, &comments)?)
}
