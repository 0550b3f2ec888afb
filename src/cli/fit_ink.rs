//! `carpaint fit` of goniochromatic inks: spectra to an ink, and an ink to a paint.

use super::output;
use super::progress::Bar;
use crate::brdf::{Goniospectra, Ink, LobeGeometry, TabulatedBrdf, WHITE_REFLECTANCE};
use crate::color::{Illuminant, Spectrum, delta_e_2000, lab_from_xyz};
use crate::error::Result;
use crate::fit::{FitOptions, FitReport, InkOptions, InkReport, InkWeights, fit_ink, fit_smooth};
use crate::math::half_difference::spherical;
use crate::paint::Paint;
use glam::DVec3;
use serde::Serialize;
use serde_json::json;
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// How spectra become an ink.
#[derive(clap::Args)]
pub struct InkArguments {
    /// Readings of a white reference (.csv, same columns): those of the sample are divided by them.
    #[arg(long, value_name = "WHITE.csv")]
    white: Option<PathBuf>,
    /// Reflectance of the white reference.
    #[arg(long, default_value_t = WHITE_REFLECTANCE, requires = "white", allow_negative_numbers = true)]
    white_reflectance: f64,
    /// Leave out these angles of incidence, degrees, as in 70,65 (the paper leaves out 70).
    #[arg(long, value_name = "DEGREES,...", value_delimiter = ',', allow_negative_numbers = true)]
    leave_out: Vec<f64>,
    /// What errors of mirrored readings count.
    #[arg(long, value_enum, default_value_t)]
    weights: Weights,
    /// Legal range of the coefficient c, within -50 to 50.
    #[arg(long, value_name = "LOW,HIGH", value_parser = growth, default_value = "-10,40", allow_hyphen_values = true)]
    growth: Growth,
    /// Take alpha from the readings as they are, as the paper does: their growth with the angle passes for the lobe's shape.
    #[arg(long)]
    published_alpha: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum Weights {
    /// As a share of the reading: steep angles count as much as grazing ones.
    #[default]
    Relative,
    /// The same for all: grazing angles decide.
    Uniform,
}

#[derive(Debug, Clone)]
struct Growth(RangeInclusive<f64>);

fn growth(text: &str) -> std::result::Result<Growth, String> {
    let ends = text.split_once(',').map(|(low, high)| (low.trim().parse(), high.trim().parse()));
    match ends {
        Some((Ok(low), Ok(high))) if low <= high => Ok(Growth(low..=high)),
        _ => Err("two ascending numbers, as in -10,40".to_owned()),
    }
}

impl InkArguments {
    fn options(&self) -> InkOptions {
        InkOptions {
            weights: match self.weights {
                Weights::Uniform => InkWeights::Uniform,
                Weights::Relative => InkWeights::Relative,
            },
            growth: self.growth.0.clone(),
            published_alpha: self.published_alpha,
        }
    }

    /// Whether an option was given that only inks know.
    pub fn is_given(&self) -> bool {
        self.options() != InkOptions::default() || self.white.is_some() || !self.leave_out.is_empty()
    }
}

/// What a file of an ink ends in.
pub const SUFFIX: &str = ".ink.json";

/// Whether a path names an ink.
pub fn is_ink(path: &Path) -> bool {
    path.to_string_lossy().to_ascii_lowercase().ends_with(SUFFIX)
}

/// What a fit of a measurement found.
#[derive(Serialize)]
pub struct Report {
    #[serde(flatten)]
    fit: InkReport,
    /// How far readings scatter about the mean of their repeats, as a share of it.
    repeats: Option<f64>,
}

/// The ink of a file of spectra.
pub fn ink_of_spectra(path: &Path, arguments: &InkArguments) -> Result<(Ink, Report)> {
    let read = Goniospectra::read(path)?.without(&arguments.leave_out).map_err(|e| e.in_file(path))?;
    let spectra = match &arguments.white {
        Some(white) => {
            let divided = read.over_white(&Goniospectra::read(white)?, arguments.white_reflectance);
            divided.map_err(|e| e.in_file(white))?
        }
        None => read,
    };
    let samples = spectra.samples();
    let name = output::stem(path);
    let fitted = samples.and_then(|samples| fit_ink(&name, &samples, &arguments.options()));
    let (ink, report) = fitted.map_err(|e| e.in_file(path))?;
    let provenance = json!({ "tool": "carpaint fit", "spectra": name, "alpha_interval": report.alpha_interval,
        "alpha_spread": report.alpha_spread, "noise": report.noise, "error": report.error,
        "rho_interval": intervals(&report, |band| band.rho_interval), "c_interval": intervals(&report, |band| band.c_interval),
        "correlation": report.bands.iter().map(|band| band.correlation).collect::<Vec<_>>() });
    Ok((ink.with_provenance(provenance), Report { fit: report, repeats: spectra.deviation() }))
}

fn intervals(
    report: &InkReport,
    of: impl Fn(&crate::fit::BandFit) -> Option<[f64; 2]>,
) -> Vec<Option<[f64; 2]>> {
    report.bands.iter().map(of).collect()
}

/// The report for people.
pub fn print_ink(Report { fit: report, repeats }: &Report) {
    let interval = |range: Option<[f64; 2]>| match range {
        Some([low, high]) => format!("{low:.5} to {high:.5}"),
        None => "not known, or on its bound".to_owned(),
    };
    output::say!("incidence    alpha  readings");
    for fit in &report.incidences {
        output::say!("{:9.2} {:8.5}  {:8}", fit.incidence_deg, fit.alpha, fit.readings);
    }
    output::say!(
        "alpha {:.5}, spread over incidences {:.2} %, 95 % {}",
        report.alpha,
        100.0 * report.alpha_spread,
        interval(Some(report.alpha_interval))
    );
    output::say!("    nm      rho  95 %                          c  95 %                        correlation");
    for band in &report.bands {
        let (rho, c) = (interval(band.rho_interval), interval(band.c_interval));
        let correlation = band.correlation.map_or("-".to_owned(), |r| format!("{r:.2}"));
        output::say!("{:6.1} {:8.5}  {rho:<26} {:8.4}  {c:<26}  {correlation}", band.nm, band.rho, band.c);
    }
    let noise = report.noise.map_or("not known".to_owned(), |noise| format!("{:.3} %", 100.0 * noise));
    output::say!(
        "error {:.2} % of all readings, {:.2} % of mirrored ones (root mean squares); scatter of mirrored ones {noise}",
        100.0 * report.error,
        100.0 * report.mirrored_error
    );
    if let Some(repeats) = repeats {
        output::say!(
            "repeats scatter by {:.2} % of their mean; what is more, the model does not follow",
            100.0 * repeats
        );
    }
    if report.albedo > 1.0 {
        output::say!(
            "note: gives back up to {:.2} times the light it gets: nothing in the model forbids it",
            report.albedo
        );
    }
}

/// Cells of polar angle and azimuth between which a paint is fitted: those of `simulate --brdf`.
const RESOLUTION: [usize; 2] = [45, 90];

/// A paint that looks like an ink under D65: a color table and lobes.
pub fn paint_of_ink(ink: &Ink, options: &FitOptions) -> Result<(Paint, FitReport, SpectralError)> {
    let rgb = |wi: DVec3, wo: DVec3| ink.spectrum(&LobeGeometry::of(wi, wo)).linear_rgb();
    let [theta, phi] = RESOLUTION;
    let table = TabulatedBrdf::from_fn(theta, phi, rgb)?;
    let bar = Bar::new("fitting lobes", options.ticks());
    let (smooth, report) = fit_smooth(&table, options, &bar.tick())?;
    drop(bar);
    let error = SpectralError::new(ink);
    let source = json!({ "ink": ink.name(), "illuminant_a_delta_e_2000": [error.mean, error.largest] });
    Ok((smooth.into_paint(None, source, &report), report, error))
}

/// What is lost where three numbers stand for a spectrum: Delta-E 2000 between the color under illuminant A and the one that is
/// expected from that under D65, each in Lab by the white of its own light; under D65 nothing is lost.
pub struct SpectralError {
    pub mean: f64,
    pub largest: f64,
}

impl SpectralError {
    /// Over mirror directions, every 5 degrees up to 80: the roughness cancels.
    fn new(ink: &Ink) -> Self {
        let (d65, a) = (Illuminant::D65, Illuminant::A);
        let errors: Vec<f64> = (0..=16)
            .map(|k| {
                let theta = f64::from(5 * k).to_radians();
                let g = LobeGeometry::of(spherical(theta, 0.0), spherical(theta, PI));
                // As bright as a white paper at the brightest wavelength: Lab is made for that.
                let spectrum = ink.spectrum(&g);
                let brightest = spectrum.0.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
                let spectrum = Spectrum(spectrum.0.map(|f| f / brightest));
                let expected = lab_from_xyz(spectrum.xyz(&d65.spectrum()), d65.white());
                delta_e_2000(expected, lab_from_xyz(spectrum.xyz(&a.spectrum()), a.white()))
            })
            .collect();
        Self {
            mean: errors.iter().sum::<f64>() / errors.len() as f64,
            largest: errors.iter().copied().fold(0.0, f64::max),
        }
    }
}
