//! The three inks, brushed flat: simulated, measured with a goniospectrometer as in the paper, and fitted, once a run.

use carpaint::brdf::{Goniospectra, Ink};
use carpaint::color::Illuminant;
use carpaint::error::Result;
use carpaint::fit::{InkOptions, InkReport, fit_ink};
use carpaint::render::{Bands, InkModel, Look, PrintInks};
use carpaint::simulate::{Composition, Goniospectrometer, Model, ModelOptions};
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

/// Inks under a light, at all wavelengths, for an eye that is adapted to D65.
pub fn seen(inks: &[Ink], model: InkModel, light: Illuminant) -> Result<PrintInks> {
    let bands = Bands::Wavelengths(carpaint::color::BANDS);
    Look { light: light.spectrum(), adapted: false, model, bands }.inks(inks)
}

/// The three fitted inks.
pub fn fitted() -> Result<Vec<Ink>> {
    Ok(measured()?.iter().map(|of| of.ink.clone()).collect())
}
