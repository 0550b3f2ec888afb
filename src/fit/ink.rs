//! Fitting goniochromatic inks to spectra (Pranovich et al. 2024, "Fitting procedure").
//!
//! Where light is mirrored the distribution is constant, and every wavelength follows eq. 7, `rho exp(c (1 - cos)) / (4 pi alpha^2)`:
//! its growth c needs no roughness. Alpha is fitted to the average over wavelengths, one incidence at a time, by a scaled
//! distribution (eq. 3), and its mean over the incidences is taken. The paper does so first, from readings that grow with the
//! angles within a scan, which makes alpha too large or too small; here growth is found first and divided out, so that exact data
//! give back exact parameters. The published order is an option.

use super::separable::Separable;
use crate::brdf::goniochromatic::{Goniochromatic, cos_mean_angle, ggx};
use crate::brdf::{Bands, Ink, LobeGeometry, SampleSet};
use crate::check::range;
use crate::color::Wavelengths;
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// What the squared error of a mirrored reading counts; the paper does not say. Roughness is found from errors that count alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InkWeights {
    /// The inverse square of the reading, a thousandth of the largest at least: steep angles, whose readings are small, count as
    /// much as grazing ones, and noise is a share of the reading.
    #[default]
    Relative,
    /// The same for all: grazing angles decide.
    Uniform,
}

/// How to fit an ink.
#[derive(Debug, Clone, PartialEq)]
pub struct InkOptions {
    /// What mirrored readings count.
    pub weights: InkWeights,
    /// Coefficients c that may be, within -50 to 50.
    pub growth: RangeInclusive<f64>,
    /// Whether growth within a scan counts as the lobe's (the paper).
    pub published_alpha: bool,
}

impl Default for InkOptions {
    fn default() -> Self {
        Self { weights: InkWeights::default(), growth: -10.0..=40.0, published_alpha: false }
    }
}

/// What a fit found besides the ink.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InkReport {
    /// Roughness: mean over the incidences.
    pub alpha: f64,
    /// Standard deviation over the incidences, as a share of the mean; the paper has below 0.03.
    pub alpha_spread: f64,
    /// The 95 % interval of the mean by its scatter over the incidences.
    pub alpha_interval: [f64; 2],
    /// What each incidence says alone.
    pub incidences: Vec<IncidenceFit>,
    /// Each wavelength.
    pub bands: Vec<BandFit>,
    /// Scatter of mirrored readings about the fit, as a share of them, noise or misfit: the median over wavelengths; `None` with two
    /// incidences, which every curve goes through.
    pub noise: Option<f64>,
    /// Root mean square of the error over all readings and wavelengths, as a share of that of the readings.
    pub error: f64,
    /// The same of mirrored readings alone.
    pub mirrored_error: f64,
    /// Largest share of light that the ink gives back, over wavelengths and angles up to 80 degrees: above 1 it shines by itself.
    pub albedo: f64,
}

/// Roughness at one angle of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IncidenceFit {
    /// Angle of incidence, degrees.
    pub incidence_deg: f64,
    /// Roughness.
    pub alpha: f64,
    /// Readings.
    pub readings: usize,
}

/// One wavelength, with 95 % intervals by its own scatter about the fit; none where a value lies on a bound or the noise is not known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BandFit {
    /// Wavelength, nanometres.
    pub nm: f64,
    /// Reflectance rho.
    pub rho: f64,
    /// Where it may lie.
    pub rho_interval: Option<[f64; 2]>,
    /// Coefficient c.
    pub c: f64,
    /// Where it may lie.
    pub c_interval: Option<[f64; 2]>,
    /// Correlation of c and the logarithm of rho.
    pub correlation: Option<f64>,
}

/// Squared tangent of the half vector up to which a reading counts as mirrored: a hundredth of a degree.
const MIRRORED: f64 = 3e-8;
/// Angles of incidence nearer than this are one, radians.
const SAME_ANGLE: f64 = 1e-6;
/// Range of the logarithm of alpha.
const LOG_ALPHA: RangeInclusive<f64> = -9.2..=0.0;
/// Standard deviations on both sides of 95 % of a normal distribution.
const NORMAL_95: f64 = 1.959_964;

/// Readings under one angle of incidence.
struct Scan {
    theta_i: f64,
    /// Numbers of the samples.
    readings: Vec<usize>,
    /// Those where light is mirrored.
    mirrored: Vec<usize>,
}

impl Scan {
    fn place(&self) -> String {
        format!("incidence {:.4} degrees", self.degrees())
    }

    /// The angle without the rounding that directions bring: angles nearer than [`SAME_ANGLE`] are one.
    fn degrees(&self) -> f64 {
        (1e6 * self.theta_i.to_degrees()).round() / 1e6
    }
}

/// An ink of spectral readings, in or out of the plane of incidence; each incidence has at least one where light is mirrored.
///
/// # Errors
/// Readings that are no spectra; wavelengths that [`Wavelengths::new`] refuses; a negative reading; fewer than two angles of incidence;
/// one without a mirrored reading, with fewer than three readings or without a lobe; options outside their ranges.
pub fn fit_ink(name: &str, samples: &SampleSet, options: &InkOptions) -> Result<(Ink, InkReport)> {
    let Bands::Wavelengths(nm) = samples.bands() else {
        return Err(Error::invalid("", "readings", "colors", "spectra: columns of wavelengths"));
    };
    let wavelengths = Wavelengths::new(nm.clone())?;
    for end in [*options.growth.start(), *options.growth.end()] {
        range(
            "growth",
            "end of the range of c",
            end,
            -Goniochromatic::MAX_GROWTH..=Goniochromatic::MAX_GROWTH,
        )?;
    }
    if options.growth.is_empty() {
        let (low, high) = options.growth.clone().into_inner();
        return Err(Error::invalid("growth", "range of c", format!("{low} to {high}"), "ascending"));
    }
    let readings = Readings::new(samples, options)?;
    let mirrored: Vec<usize> = readings.scans.iter().flat_map(|scan| scan.mirrored.iter().copied()).collect();
    let peaks: Vec<Peak> = (0..nm.len()).into_par_iter().map(|band| readings.peak(&mirrored, band)).collect();
    let growth: Vec<f64> = peaks.iter().map(|peak| peak.growth).collect();
    let incidences = readings.alphas(&growth)?;
    let alpha = mean(incidences.iter().map(|fit| fit.alpha));
    let reflectance = peaks.iter().map(|peak| peak.height * 4.0 * PI * alpha * alpha).collect();
    let ink = Ink::new(name, alpha, wavelengths, reflectance, growth)?;
    let report = readings.report(&ink, incidences, &peaks, &mirrored);
    Ok((ink, report))
}

/// Eq. 7 at one wavelength.
struct Peak {
    /// `rho / (4 pi alpha^2)`.
    height: f64,
    growth: f64,
    on_bound: bool,
    /// Variances of the logarithm of the height and of the growth, and their covariance, where readings are off by all of
    /// themselves.
    covariance: [f64; 3],
    /// Sum over readings of squared errors, as shares of the fit, and what it would be were they off by all of themselves.
    scatter: f64,
    expected_scatter: f64,
}

/// The samples, by incidence.
struct Readings<'a> {
    samples: &'a SampleSet,
    options: &'a InkOptions,
    geometry: Vec<LobeGeometry>,
    scans: Vec<Scan>,
}

impl<'a> Readings<'a> {
    fn new(samples: &'a SampleSet, options: &'a InkOptions) -> Result<Self> {
        let geometry: Vec<LobeGeometry> =
            samples.samples().iter().map(|s| LobeGeometry::of(s.wi, s.wo)).collect();
        let mut scans: Vec<Scan> = Vec::new();
        for (k, sample) in samples.samples().iter().enumerate() {
            let theta_i = sample.wi.truncate().length().atan2(sample.wi.z);
            let is_same = |angle: &f64| (angle - theta_i).abs() < SAME_ANGLE;
            if sample.weight == 0.0 {
                continue;
            }
            if let Some((band, value)) = samples.values(k).iter().enumerate().find(|(_, v)| **v < 0.0) {
                let place = format!("reading {}: value {}", k + 1, band + 1);
                return Err(Error::invalid(place, "reflectance factor", PI * value, "0 or more"));
            }
            let at = scans.iter().position(|scan| is_same(&scan.theta_i));
            let at = at.unwrap_or_else(|| {
                scans.push(Scan { theta_i, readings: Vec::new(), mirrored: Vec::new() });
                scans.len() - 1
            });
            scans[at].readings.push(k);
            if geometry[k].tan2_h < MIRRORED {
                scans[at].mirrored.push(k);
            }
        }
        scans.sort_by(|a, b| a.theta_i.total_cmp(&b.theta_i));
        if scans.len() < 2 {
            return Err(Error::invalid("", "angles of incidence", scans.len(), "2 or more"));
        }
        for scan in &scans {
            let place = scan.place();
            if scan.mirrored.is_empty() {
                let legal = "one or more where light is mirrored (aspecular angle 0)";
                return Err(Error::invalid(place, "readings", "none", legal));
            }
            if scan.readings.len() < 3 {
                return Err(Error::invalid(place, "readings", scan.readings.len(), "3 or more"));
            }
        }
        Ok(Self { samples, options, geometry, scans })
    }

    /// Eq. 7 at a wavelength.
    fn peak(&self, mirrored: &[usize], band: usize) -> Peak {
        let values: Vec<f64> = mirrored.iter().map(|k| self.samples.values(*k)[band]).collect();
        let least = 1e-3 * values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let weigh = |(k, y): (&usize, &f64)| match self.options.weights {
            InkWeights::Uniform => self.samples.samples()[*k].weight,
            InkWeights::Relative => self.samples.samples()[*k].weight / y.max(least).powi(2),
        };
        let weights: Vec<f64> = mirrored.iter().zip(&values).map(weigh).collect();
        let versine = |k: usize| 1.0 - self.geometry[mirrored[k]].cos_i;
        let model = |growth: f64, k: usize| ((growth * versine(k)).exp(), versine(k));
        let bounds = self.options.growth.clone();
        let problem = Separable { values: &values, weights: &weights, model, bounds };
        let found = problem.solve();
        let fitted = |k: usize| found.scale * model(found.shape, k).0;
        let scatter = if !found.on_bound {
            values.iter().enumerate().map(|(k, y)| (y / fitted(k) - 1.0).powi(2)).sum()
        } else {
            0.0
        };
        let covariance = problem.covariance(found, 1.0);
        let expected_scatter = if found.on_bound { 0.0 } else { problem.expected_scatter(found) };
        // A dark wavelength has no growth.
        let growth = if found.scale > 0.0 {
            found.shape
        } else {
            0f64.clamp(*self.options.growth.start(), *self.options.growth.end())
        };
        Peak { height: found.scale, growth, on_bound: found.on_bound, covariance, scatter, expected_scatter }
    }

    /// Roughness of every scan.
    ///
    /// # Errors
    /// A scan without a lobe that is found.
    fn alphas(&self, growth: &[f64]) -> Result<Vec<IncidenceFit>> {
        let one = |scan: &Scan| {
            let values: Vec<f64> = scan.readings.iter().map(|k| self.average(*k, growth)).collect();
            let weights: Vec<f64> = scan.readings.iter().map(|k| self.samples.samples()[*k].weight).collect();
            let tan2 = |k: usize| self.geometry[scan.readings[k]].tan2_h;
            let model = |log_alpha: f64, k: usize| {
                let alpha = log_alpha.exp();
                let a2 = alpha * alpha;
                (ggx(tan2(k), alpha), 2.0 * (tan2(k) - a2) / (a2 + tan2(k)))
            };
            let found = Separable { values: &values, weights: &weights, model, bounds: LOG_ALPHA }.solve();
            let (readings, alpha) = (scan.readings.len(), found.shape.exp());
            if found.scale == 0.0 || found.shape == *LOG_ALPHA.start() {
                let found =
                    if found.scale == 0.0 { "no light".to_owned() } else { format!("{alpha:.4} or less") };
                return Err(Error::invalid(scan.place(), "roughness", found, "a lobe of 1e-4 or wider"));
            }
            Ok(IncidenceFit { incidence_deg: scan.degrees(), alpha, readings })
        };
        self.scans.iter().map(one).collect()
    }

    /// Mean over the wavelengths of a reading, unless told otherwise without its growth.
    fn average(&self, k: usize, growth: &[f64]) -> f64 {
        let values = self.samples.values(k);
        let versine = 1.0 - cos_mean_angle(self.geometry[k].cos_i, self.geometry[k].cos_o);
        let grown = |c: &f64| if self.options.published_alpha { 1.0 } else { (c * versine).exp() };
        mean(values.iter().zip(growth).map(|(f, c)| f / grown(c)))
    }

    fn report(
        &self,
        ink: &Ink,
        incidences: Vec<IncidenceFit>,
        peaks: &[Peak],
        mirrored: &[usize],
    ) -> InkReport {
        let alpha = ink.roughness();
        let count = incidences.len();
        let squares: f64 = incidences.iter().map(|fit| (fit.alpha - alpha).powi(2)).sum();
        let deviation = (squares / (count - 1) as f64).sqrt();
        let error = deviation / (count as f64).sqrt();
        let freedom = mirrored.len().saturating_sub(2);
        let noise_of = |peak: &Peak| (peak.scatter / peak.expected_scatter).sqrt();
        let is_known = |peak: &Peak| freedom > 0 && !peak.on_bound;
        let bands = peaks.iter().enumerate().map(|(band, peak)| {
            let (rho, c) = (ink.reflectance()[band], peak.growth);
            let reach = student_95(freedom.max(1)) * noise_of(peak);
            let [log_height, growth] = [0, 1].map(|k| reach * peak.covariance[k].sqrt());
            // rho is the height times alpha squared.
            let log_rho = log_height.hypot(2.0 * student_95(count - 1) * error / alpha);
            let rho_interval = is_known(peak).then(|| [rho * (-log_rho).exp(), rho * log_rho.exp()]);
            let c_interval = is_known(peak).then_some([c - growth, c + growth]);
            let correlation = is_known(peak).then(|| reach * reach * peak.covariance[2] / (log_rho * growth));
            let correlation = correlation.filter(|r| r.is_finite());
            BandFit { nm: ink.wavelengths().nm()[band], rho, rho_interval, c, c_interval, correlation }
        });
        let mut noises: Vec<f64> = peaks.iter().filter(|peak| is_known(peak)).map(noise_of).collect();
        noises.sort_by(f64::total_cmp);
        let noise = noises.get(noises.len() / 2).copied();
        let all = self.scans.iter().flat_map(|scan| scan.readings.iter());
        let angles = (0..=8).map(|k| f64::from(10 * k).to_radians());
        let albedo = angles.flat_map(|theta| ink.albedo(theta)).fold(0.0, f64::max);
        InkReport {
            alpha,
            alpha_spread: deviation / alpha,
            alpha_interval: [-1.0, 1.0].map(|side| alpha + side * student_95(count - 1) * error),
            bands: bands.collect(),
            noise,
            error: self.error(ink, all),
            mirrored_error: self.error(ink, mirrored.iter()),
            albedo,
            incidences,
        }
    }

    /// Root mean square of the error of readings over that of the readings.
    fn error<'b>(&self, ink: &Ink, readings: impl Iterator<Item = &'b usize>) -> f64 {
        let (mut off, mut all) = (0.0, 0.0);
        for k in readings {
            for (f, y) in ink.brdf(&self.geometry[*k]).iter().zip(self.samples.values(*k)) {
                off += (f - y) * (f - y);
                all += y * y;
            }
        }
        if all > 0.0 { (off / all).sqrt() } else { 0.0 }
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Half-width of the central 95 % of Student's distribution: the expansion of Abramowitz & Stegun 26.7.5, and its exact values
/// for one to three degrees of freedom, where that is off by more than a percent.
fn student_95(freedom: usize) -> f64 {
    if let Some(exact) = [12.706_2, 4.302_7, 3.182_4].get(freedom.wrapping_sub(1)) {
        return *exact;
    }
    let (z, n) = (NORMAL_95, freedom as f64);
    let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
    z + (z3 + z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n.powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::BrdfSample;
    use crate::brdf::instrument::Reading;
    use crate::math::hash::{pcg4d, unit};

    const INCIDENCES: [f64; 7] = [20.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0];

    fn ink() -> Ink {
        let grid = Wavelengths::even(41).unwrap();
        let wave = |k: usize, a: f64| (0.17 * k as f64 + a).sin();
        let rho = (0..41).map(|k| 0.5 + 0.45 * wave(k, 0.3)).collect();
        let c = (0..41).map(|k| 2.5 + 3.5 * wave(k, 2.0)).collect();
        Ink::new("truth", 0.19, grid, rho, c).unwrap()
    }

    /// Scans of an ink, every reading and wavelength off by a normal share of itself.
    fn scans(ink: &Ink, noise: f64, seed: u32) -> SampleSet {
        let mut set = SampleSet::new(Bands::Wavelengths(ink.wavelengths().nm().to_vec())).unwrap();
        for incidence in INCIDENCES {
            for aspecular in -16..=40 {
                let Ok(reading) = Reading::new(incidence, 1.25 * f64::from(aspecular)) else { continue };
                let (wi, wo) = reading.directions();
                let f = ink.brdf(&LobeGeometry::of(wi, wo));
                let at = set.len() as u32;
                let normal = |band: u32| -> f64 {
                    let bits = (0..3).flat_map(|j| pcg4d([seed, at, band, j]));
                    bits.map(|b| f64::from(unit(b))).sum::<f64>() - 6.0
                };
                let values: Vec<f64> =
                    (0..).zip(f).map(|(band, f)| f * (1.0 + noise * normal(band))).collect();
                set.push(BrdfSample::new(wi, wo, 1.0), &values).unwrap();
            }
        }
        set
    }

    #[test]
    fn exact_readings_give_back_the_ink() {
        let truth = ink();
        for weights in [InkWeights::Uniform, InkWeights::Relative] {
            let options = InkOptions { weights, ..InkOptions::default() };
            let (found, report) = fit_ink("found", &scans(&truth, 0.0, 0), &options).unwrap();
            assert!((found.roughness() / truth.roughness() - 1.0).abs() < 1e-8, "{}", found.roughness());
            for band in 0..41 {
                let (a, b) = (found.at(band), truth.at(band));
                assert!((a.reflectance / b.reflectance - 1.0).abs() < 1e-8, "{a:?} {b:?}");
                assert!((a.growth - b.growth).abs() < 1e-8, "{a:?} {b:?}");
            }
            assert!(report.error < 1e-8 && report.noise.unwrap() < 1e-8 && report.alpha_spread < 1e-8);
        }
    }

    /// Growth within a scan passes for the lobe's shape where it is not divided out.
    #[test]
    fn the_published_order_is_off_where_reflectance_grows() {
        let options = InkOptions { published_alpha: true, ..InkOptions::default() };
        let (found, report) = fit_ink("", &scans(&ink(), 0.0, 0), &options).unwrap();
        assert!((found.roughness() / 0.19 - 1.0).abs() > 1e-3, "{}", found.roughness());
        assert!(report.alpha_spread > 1e-3);
        // Growth itself is right in any order.
        assert!((found.growth()[7] - ink().growth()[7]).abs() < 1e-8);
    }

    /// Of 95 % intervals 95 of a hundred hold the truth, over many noises.
    #[test]
    fn intervals_hold_the_truth() {
        let truth = ink();
        let (mut held, mut count, mut noise) = ([0.0; 3], 0.0, 0.0);
        for seed in 0..40 {
            let (_, report) = fit_ink("", &scans(&truth, 0.01, seed), &InkOptions::default()).unwrap();
            let holds = |interval: Option<[f64; 2]>, value: f64| {
                let [low, high] = interval.unwrap();
                f64::from(u8::from((low..=high).contains(&value)))
            };
            for (band, fit) in report.bands.iter().enumerate() {
                held[0] += holds(fit.rho_interval, truth.reflectance()[band]) / 41.0;
                held[1] += holds(fit.c_interval, truth.growth()[band]) / 41.0;
            }
            held[2] += holds(Some(report.alpha_interval), 0.19);
            count += 1.0;
            noise += report.noise.unwrap() / 0.01 / 40.0;
        }
        // 1640 intervals of wavelengths, of which 2 % more or less are four standard deviations; 40 of alpha, where two more than
        // six may miss once in a thousand. Those of rho also hold the error of alpha.
        assert!(held[0] / count > 0.93 && (held[1] / count - 0.95).abs() < 0.02, "{held:?}");
        assert!(held[2] / count > 0.8, "{held:?}");
        // The median of estimates from seven readings each, of which the bright ones count most, is below their mean.
        assert!((0.75..1.1).contains(&noise), "{noise}");
    }

    #[test]
    fn dark_bands_stay_dark_and_weightless_readings_do_not_count() {
        let truth = ink();
        let mut set = SampleSet::new(truth_bands()).unwrap();
        let source = scans(&truth, 0.0, 0);
        for (k, sample) in source.samples().iter().enumerate() {
            let spoilt = sample.wi.z < 0.35;
            let factor = if spoilt { 3.0 } else { 1.0 };
            let of_band = |(b, f): (usize, &f64)| if b == 5 { 0.0 } else { f * factor };
            let values: Vec<f64> = source.values(k).iter().enumerate().map(of_band).collect();
            let weight = if spoilt { 0.0 } else { 1.0 };
            set.push(BrdfSample { weight, ..sample.clone() }, &values).unwrap();
        }
        let (found, report) = fit_ink("", &set, &InkOptions::default()).unwrap();
        assert_eq!((report.incidences.len(), found.reflectance()[5], found.growth()[5]), (6, 0.0, 0.0));
        assert!(report.bands[5].rho_interval.is_none());
        assert!((found.growth()[7] - truth.growth()[7]).abs() < 1e-8);
    }

    fn truth_bands() -> Bands {
        Bands::Wavelengths(ink().wavelengths().nm().to_vec())
    }

    #[test]
    fn what_cannot_be_fitted_is_named() {
        let message =
            |set: &SampleSet, options: &InkOptions| fit_ink("", set, options).unwrap_err().to_string();
        let set = scans(&ink(), 0.0, 0);
        let none = SampleSet::new(truth_bands()).unwrap();
        assert!(
            message(&none, &InkOptions::default())
                .contains("angles of incidence: found 0, expected 2 or more")
        );
        let wide = InkOptions { growth: -200.0..=3.0, ..InkOptions::default() };
        assert!(message(&set, &wide).contains("-200"));
        assert!(message(&SampleSet::new(Bands::Rgb).unwrap(), &InkOptions::default()).contains("spectra"));
        let mut few = SampleSet::new(truth_bands()).unwrap();
        for (incidence, aspecular) in [(20.0, 0.0), (20.0, 5.0), (20.0, 9.0), (40.0, 1.0)] {
            let (wi, wo) = Reading::new(incidence, aspecular).unwrap().directions();
            few.push(BrdfSample::new(wi, wo, 1.0), &[0.5; 41]).unwrap();
        }
        assert!(
            message(&few, &InkOptions::default()).contains("incidence 40.0000 degrees: readings: found none")
        );
        let (wi, wo) = Reading::new(40.0, 0.0).unwrap().directions();
        few.push(BrdfSample::new(wi, wo, 1.0), &[0.5; 41]).unwrap();
        assert!(message(&few, &InkOptions::default()).contains("found 2, expected 3 or more"));
        few.push(BrdfSample::new(wi, wo, 1.0), &[-0.5; 41]).unwrap();
        assert!(
            message(&few, &InkOptions::default())
                .contains("reading 6: value 1: reflectance factor: found -1.57")
        );
    }

    #[test]
    fn students_distribution_is_that_of_the_tables() {
        for (freedom, expected) in
            [(1, 12.706), (3, 3.182), (4, 2.776), (6, 2.447), (10, 2.228), (30, 2.042), (1000, 1.962)]
        {
            assert!(
                (student_95(freedom) / expected - 1.0).abs() < 6e-3,
                "{freedom}: {}",
                student_95(freedom)
            );
        }
    }
}
