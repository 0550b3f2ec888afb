//! The mean BRDF of a composition as a file: spectra as CSV, a table for other programs, a paint.

use super::progress::Bar;
use crate::brdf::TabulatedBrdf;
use crate::color::{BANDS, Spectrum, wavelength_nm};
use crate::error::{Error, Result};
use crate::file::write_atomically;
use crate::fit::{FitOptions, fit_smooth};
use crate::math::half_difference::spherical;
use crate::simulate::Model;
use rayon::prelude::*;
use serde_json::json;
use std::io::Write;
use std::path::Path;

/// Cells of polar angle and azimuth: those of the measured tables in circulation.
const RESOLUTION: [usize; 2] = [45, 90];
/// Polar angles of the CSV: 0, 5, ... 85 degrees.
const POLAR_DEG: (usize, usize) = (5, 18);
/// Azimuths of the CSV: 0, 10, ... 180 degrees.
const AZIMUTH_DEG: (usize, usize) = (10, 19);

/// What a file holds, by the end of its name.
#[derive(Clone, Copy)]
pub enum BrdfFormat {
    Csv,
    Mbsdf,
    Paint,
}

impl BrdfFormat {
    /// The format of a name.
    pub fn of(path: &Path) -> Result<Self> {
        let name = path.to_string_lossy().to_ascii_lowercase();
        let known = [(".csv", Self::Csv), (".mbsdf", Self::Mbsdf), (".paint.exr", Self::Paint)];
        let found = known.into_iter().find(|(end, _)| name.ends_with(end));
        found.map(|(_, format)| format).ok_or_else(|| {
            Error::invalid("--brdf", "name", path.display(), "one that ends in .csv, .mbsdf or .paint.exr")
        })
    }

    /// Writes the mean BRDF of a model, gloss left out.
    pub fn write(self, model: &Model, seed: u32, path: &Path) -> Result<()> {
        match self {
            Self::Csv => write_csv(model, path),
            Self::Mbsdf => table(model)?.write_mbsdf(path),
            Self::Paint => write_paint(model, seed, path),
        }
    }
}

fn table(model: &Model) -> Result<TabulatedBrdf> {
    let [theta, phi] = RESOLUTION;
    TabulatedBrdf::from_fn(theta, phi, |wi, wo| model.brdf_rgb(wi, wo))
}

fn write_csv(model: &Model, path: &Path) -> Result<()> {
    let (polar_step, polar_count) = POLAR_DEG;
    let (step, count) = AZIMUTH_DEG;
    let rows: Vec<([usize; 3], Spectrum)> = (0..polar_count * polar_count * count)
        .into_par_iter()
        .map(|k| {
            let (i, o, a) = (k / count / polar_count, k / count % polar_count, k % count);
            let angles = [i * polar_step, o * polar_step, a * step];
            let [theta_i, theta_o, phi] = angles.map(|deg| (deg as f64).to_radians());
            (angles, model.brdf(spherical(theta_i, 0.0), spherical(theta_o, phi)))
        })
        .collect();
    let write = |w: &mut dyn Write| -> std::io::Result<()> {
        writeln!(w, "# carpaint: mean BRDF of a composition, model {}", name(model))?;
        writeln!(w, "# unit=1/sr; cosine_included=false; gloss_included=false; columns from 380 on: nm")?;
        writeln!(w, "# angles in degrees; phi: azimuth from light to eye, 180 is the mirror side")?;
        write!(w, "theta_i,theta_o,phi")?;
        (0..BANDS).try_for_each(|k| write!(w, ",{}", wavelength_nm(k)))?;
        for ([theta_i, theta_o, phi], spectrum) in &rows {
            write!(w, "\n{theta_i},{theta_o},{phi}")?;
            spectrum.0.iter().try_for_each(|value| write!(w, ",{value:.6e}"))?;
        }
        writeln!(w)
    };
    write_atomically(path, |w| write(w).map_err(|e| Error::io(path, e)))
}

/// A paint without flakes, fitted to the model as to a measured table.
fn write_paint(model: &Model, seed: u32, path: &Path) -> Result<()> {
    let options = FitOptions { coat: Some(model.coat()), filled: false, seed, ..FitOptions::default() };
    let bar = Bar::new("fitting lobes", options.ticks());
    let (smooth, report) = fit_smooth(&table(model)?, &options, &bar.tick())?;
    let provenance =
        json!({ "tool": "carpaint simulate", "model": model.kind(), "composition": model.composition() });
    smooth.into_paint(None, provenance, &report).write(path)
}

/// The model's name as on the command line.
pub fn name(model: &Model) -> String {
    json!(model.kind()).as_str().unwrap_or_default().to_owned()
}
