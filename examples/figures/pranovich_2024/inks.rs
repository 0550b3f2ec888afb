//! The three inks, brushed flat: simulated, measured with a goniospectrometer as in the paper, and fitted, once a run.

use carpaint::brdf::{DeviationNeighbors, Goniospectra, Ink};
use carpaint::color::{Illuminant, Wavelengths};
use carpaint::error::Result;
use carpaint::fit::{InkOptions, InkReport, fit_ink};
use carpaint::render::{Bands, InkModel, Look, PrintInks};
use carpaint::simulate::{Composition, Goniospectrometer, Model, ModelOptions};
use glam::{DVec3, Vec3};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// An ink and where it comes from.
pub struct MeasuredInk {
    pub color: &'static str,
    /// The simulation: the truth.
    pub model: Model,
    /// What the instrument reads.
    pub measured: Goniospectra,
    pub ink: Ink,
    pub report: InkReport,
}

/// Red, green and blue.
pub fn measured() -> Result<Arc<[MeasuredInk; 3]>> {
    static DONE: Mutex<Option<Arc<[MeasuredInk; 3]>>> = Mutex::new(None);
    let mut done = DONE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(inks) = &*done {
        return Ok(inks.clone());
    }
    let inks = Arc::new([measure("red")?, measure("green")?, measure("blue")?]);
    *done = Some(inks.clone());
    Ok(inks)
}

fn measure(color: &'static str) -> Result<MeasuredInk> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fixtures/inks/{color}_flat.toml"));
    let model = Model::new(&Composition::read(&path)?, ModelOptions::default())?;
    let measured =
        Goniospectra::new(&Goniospectrometer { seed: 1, ..Goniospectrometer::default() }.measure(&model)?)?;
    // As in the paper, 70 degrees are not fitted.
    let (ink, report) = fit_ink(color, &measured.without(&[70.0])?.samples()?, &InkOptions::default())?;
    Ok(MeasuredInk { color, model, measured, ink, report })
}

/// Readings as a BRDF of all directions, without a model.
pub struct Readings {
    wavelengths: Wavelengths,
    neighbors: DeviationNeighbors,
}

impl Readings {
    /// As in the paper.
    pub fn new(measured: &Goniospectra) -> Result<Self> {
        let wavelengths = Wavelengths::new(measured.wavelengths().to_vec())?;
        Ok(Self { wavelengths, neighbors: DeviationNeighbors::new(measured)? })
    }

    /// Without noise and from more incidences: near to the simulation itself.
    pub fn every_five_degrees(of: &MeasuredInk) -> Result<Self> {
        let incidences_deg = (2..=17).map(|k| 5.0 * f64::from(k)).collect();
        let dense = Goniospectrometer { incidences_deg, repeats: 1, noise: 0.0, seed: 1 };
        Self::new(&Goniospectra::new(&dense.measure(&of.model)?)?)
    }

    /// BRDF, linear Rec.709 under D65, 1/sr.
    pub fn color(&self, wi: DVec3, wo: DVec3) -> Vec3 {
        self.wavelengths.spectrum(&self.neighbors.eval(wi, wo)).linear_rgb().as_vec3()
    }
}

/// Inks under a light, at all wavelengths, for an eye that is adapted to D65.
pub fn seen(inks: &[Ink], model: InkModel, light: Illuminant) -> Result<PrintInks> {
    let bands = Bands::Wavelengths(carpaint::color::BANDS);
    Look { light: light.spectrum(), adapted: false, model, bands }.inks(inks)
}

/// The three fitted inks.
pub fn fitted() -> Result<Vec<Ink>> {
    Ok(measured()?.iter().map(|of| of.ink.clone()).collect())
}
