//! Spectra of a flat sample in the plane of incidence, as a goniometer with a spectrometer measures them (Pranovich et al. 2024,
//! "Preparation and measurement").
//!
//! Repeats of a geometry are averaged, and their spread is kept. What the spectrometer says is divided by what it says of a
//! white reference, which scatters alike everywhere: BRDF = reading / reading of white * reflectance of white / pi. The paper
//! says "BRDF values" and not where the pi goes; here the white's factor is its reflectance, .99, and values are BRDF, 1/sr.

use super::instrument::Reading;
use super::multi_angle::read_ascending;
use super::sample_set::{Bands, BrdfSample, SampleSet};
use crate::check::range;
use crate::error::{Error, Result};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

/// Reflectance of the paper's white reference, Spectralon.
pub const WHITE_REFLECTANCE: f64 = 0.99;
/// Steps a degree in which geometries are told apart; goniometers are set to a hundredth at best.
const STEPS: f64 = 1e6;

/// In-plane spectra, one a geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Goniospectra {
    wavelengths: Vec<f64>,
    spectra: Vec<Goniospectrum>,
}

/// What was measured at one geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Goniospectrum {
    /// Where.
    pub reading: Reading,
    /// Mean BRDF, 1/sr, a value a wavelength, 0 or more.
    pub mean: Vec<f64>,
    /// How many readings that is the mean of, 1 or more.
    pub repeats: usize,
    /// What all of them together count, above 0: 1 each, unless their table says otherwise.
    pub weight: f64,
    /// Standard deviation of one reading over the mean, the root mean square over wavelengths; that of the mean is smaller by
    /// the root of `repeats`. None of a single reading, and where nothing was reflected.
    pub deviation: Option<f64>,
}

impl Goniospectrum {
    fn place(&self) -> String {
        let Reading { incidence_deg, .. } = self.reading;
        format!("theta_i {incidence_deg}, theta_o {}", self.reading.theta_o_deg())
    }
}

impl Goniospectra {
    /// Reads a table of [`super::multi_angle`] whose values are reflectance factors, and averages repeats.
    ///
    /// # Errors
    /// Those of [`super::multi_angle::read_multi_angle`] and of [`Goniospectra::new`]; colors in place of spectra, wavelengths out
    /// of order.
    pub fn read(path: &Path) -> Result<Self> {
        Self::new(&read_ascending(path)?.samples).map_err(|e| e.in_file(path))
    }

    /// Reads a table of readings in any unit and that of a white reference (see [`Goniospectra::over_white`]).
    ///
    /// # Errors
    /// Those of [`Goniospectra::read`] and [`Goniospectra::over_white`].
    pub fn read_over_white(path: &Path, white: &Path, reflectance: f64) -> Result<Self> {
        let (spectra, white_spectra) = (Self::read(path)?, Self::read(white)?);
        spectra.over_white(&white_spectra, reflectance).map_err(|e| e.in_file(white))
    }

    /// Averages the repeats of every geometry, in the order in which geometries first come.
    ///
    /// # Errors
    /// No samples, bands that are no wavelengths; with the row's number (from 1, samples only): light or eye out of the plane of
    /// incidence, an extended light; with geometry, first row and wavelength: a mean below 0.
    pub fn new(samples: &SampleSet) -> Result<Self> {
        let Bands::Wavelengths(wavelengths) = samples.bands() else {
            return Err(Error::invalid("", "bands", "Rec.709", "spectra: wavelengths in nm"));
        };
        if !samples.samples().iter().any(|sample| sample.weight > 0.0) {
            return Err(Error::invalid("", "samples", "none", "one or more that count"));
        }
        let mut groups: Vec<(Reading, Vec<usize>)> = Vec::new();
        let mut known = HashMap::new();
        // What weighs nothing was not read.
        for (k, sample) in samples.samples().iter().enumerate().filter(|(_, sample)| sample.weight > 0.0) {
            let reading = Reading::of(sample.wi, sample.wo).filter(|_| sample.lights.is_empty());
            let reading = reading.ok_or_else(|| {
                let found = format!("light {}, eye {}", sample.wi, sample.wo);
                Error::invalid(
                    format!("row {}", k + 1),
                    "directions",
                    found,
                    "both in one plane of incidence",
                )
            })?;
            let group = *known.entry(steps(&reading)).or_insert(groups.len());
            if group == groups.len() {
                groups.push((reading, Vec::new()));
            }
            groups[group].1.push(k);
        }
        let spectra = groups
            .into_iter()
            .map(|(reading, rows)| average(samples, wavelengths, reading, &rows))
            .collect::<Result<_>>()?;
        Ok(Self { wavelengths: wavelengths.clone(), spectra })
    }

    /// BRDF from these readings and those of a white reference in the same unit: of the same geometry, or, where white was
    /// measured at one geometry an incidence, of the same incidence. The white's own spread is common to all that is divided by it
    /// and left out of the deviations. `reflectance` above 0 to 1.
    ///
    /// # Errors
    /// Other wavelengths; no reading of white for a geometry (named); one of 0 or less (with geometry and wavelength); a
    /// reflectance outside its range.
    pub fn over_white(&self, white: &Self, reflectance: f64) -> Result<Self> {
        range("white reference", "reflectance", reflectance, f64::MIN_POSITIVE..=1.0)?;
        if self.wavelengths != white.wavelengths {
            let list = |nm: &[f64]| format!("{} from {:?} to {:?} nm", nm.len(), nm.first(), nm.last());
            let (found, legal) = (list(&white.wavelengths), list(&self.wavelengths));
            return Err(Error::invalid(
                "white reference",
                "wavelengths",
                found,
                format!("the sample's, {legal}"),
            ));
        }
        for row in &white.spectra {
            if let Some(k) = row.mean.iter().position(|w| *w <= 0.0) {
                let what = format!("reading of white at {} nm", white.wavelengths[k]);
                return Err(Error::invalid(row.place(), what, PI * row.mean[k], "above 0"));
            }
        }
        let by_geometry: HashMap<_, _> = white.spectra.iter().map(|w| (steps(&w.reading), w)).collect();
        let spectra = self.spectra.iter().map(|row| {
            let reference = by_geometry.get(&steps(&row.reading)).copied();
            let reference = reference.map_or_else(|| white.only_of_incidence(row), Ok)?;
            let mean = row.mean.iter().zip(&reference.mean).map(|(s, w)| s / w * reflectance / PI).collect();
            Ok(Goniospectrum { mean, ..row.clone() })
        });
        Ok(Self { wavelengths: self.wavelengths.clone(), spectra: spectra.collect::<Result<_>>()? })
    }

    /// The one spectrum of white at the incidence of `row`.
    fn only_of_incidence(&self, row: &Goniospectrum) -> Result<&Goniospectrum> {
        let incidence = steps(&row.reading).0;
        let mut all = self.spectra.iter().filter(|white| steps(&white.reading).0 == incidence);
        match (all.next(), all.next()) {
            (Some(only), None) => Ok(only),
            (first, _) => {
                let found =
                    if first.is_some() { "others of this incidence" } else { "none of this incidence" };
                let legal = "one of the same geometry, or a single one of the same incidence";
                Err(Error::invalid(row.place(), "reading of white", found, legal))
            }
        }
    }

    /// The same without some incidences, degrees: the paper leaves out 70.
    ///
    /// # Errors
    /// An incidence that was not measured; none that is left.
    pub fn without(&self, incidences: &[f64]) -> Result<Self> {
        let measured = self.incidences();
        let is = |a: f64, b: f64| step(a) == step(b);
        if let Some(other) = incidences.iter().find(|a| !measured.iter().any(|b| is(**a, *b))) {
            return Err(Error::invalid("", "incidence to leave out", other, format!("one of {measured:?}")));
        }
        let is_kept = |row: &&Goniospectrum| !incidences.iter().any(|a| is(*a, row.reading.incidence_deg));
        let spectra: Vec<Goniospectrum> = self.spectra.iter().filter(is_kept).cloned().collect();
        if spectra.is_empty() {
            return Err(Error::invalid("", "incidences to leave out", "all", "one or more that stay"));
        }
        Ok(Self { wavelengths: self.wavelengths.clone(), spectra })
    }

    /// The incidences, degrees, ascending, each once.
    pub fn incidences(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.spectra.iter().map(|row| row.reading.incidence_deg).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by_key(|a| step(*a));
        all
    }

    /// Wavelengths, nm, ascending.
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// The spectra, one or more, in the order of the measurement.
    pub fn spectra(&self) -> &[Goniospectrum] {
        &self.spectra
    }

    /// How far readings scatter about the mean of their repeats, as a share of it: root mean square over geometries; none without
    /// repeats.
    pub fn deviation(&self) -> Option<f64> {
        let known: Vec<f64> = self.spectra.iter().filter_map(|row| row.deviation).collect();
        let squares: f64 = known.iter().map(|deviation| deviation * deviation).sum();
        (!known.is_empty()).then(|| (squares / known.len() as f64).sqrt())
    }

    /// One sample a geometry, as fits take them.
    ///
    /// # Errors
    /// None that a measurement has.
    pub fn samples(&self) -> Result<SampleSet> {
        let mut set = SampleSet::new(Bands::Wavelengths(self.wavelengths.clone()))?;
        for row in &self.spectra {
            let (wi, wo) = row.reading.directions();
            set.push(BrdfSample::new(wi, wo, row.weight), &row.mean)?;
        }
        Ok(set)
    }
}

/// An angle as a whole number of steps.
fn step(degrees: f64) -> i64 {
    (degrees * STEPS).round() as i64
}

/// Incidence and aspecular angle as whole numbers of steps.
fn steps(reading: &Reading) -> (i64, i64) {
    (step(reading.incidence_deg), step(reading.aspecular_deg))
}

/// Mean and spread of the readings in `rows`, all of one geometry.
fn average(samples: &SampleSet, nm: &[f64], reading: Reading, rows: &[usize]) -> Result<Goniospectrum> {
    let repeats = rows.len();
    let counts = |row: &usize| samples.samples()[*row].weight;
    let weight: f64 = rows.iter().map(counts).sum();
    let mean_at =
        |k: usize| rows.iter().map(|row| counts(row) * samples.values(*row)[k]).sum::<f64>() / weight;
    let mean: Vec<f64> = (0..nm.len()).map(mean_at).collect();
    let deviation = relative_deviation(samples, rows, &mean);
    let spectrum = Goniospectrum { reading, mean, repeats, weight, deviation };
    if let Some(k) = spectrum.mean.iter().position(|f| *f < 0.0) {
        let place = format!("{} (row {})", spectrum.place(), rows[0] + 1);
        let what = format!("mean reflectance factor at {} nm", nm[k]);
        return Err(Error::invalid(place, what, PI * spectrum.mean[k], "0 or more"));
    }
    Ok(spectrum)
}

/// Root mean square over wavelengths of the standard deviation over the mean, where that is not 0.
fn relative_deviation(samples: &SampleSet, rows: &[usize], mean: &[f64]) -> Option<f64> {
    let lit: Vec<usize> = (0..mean.len()).filter(|k| mean[*k] > 0.0).collect();
    if rows.len() < 2 || lit.is_empty() {
        return None;
    }
    let square = |row: usize, k: usize| (samples.values(row)[k] / mean[k] - 1.0).powi(2);
    let sum: f64 = lit.iter().map(|k| rows.iter().map(|row| square(*row, *k)).sum::<f64>()).sum();
    Some((sum / (lit.len() * (rows.len() - 1)) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::multi_angle::parse;

    #[test]
    fn rows_count_what_they_weigh() {
        let read =
            spectra("theta_i,theta_o,weight,400,700\n20,20,3,1,1\n20,20,1,2,1\n20,20,0,9,9\n30,30,1,1,1\n")
                .unwrap();
        assert_eq!(read.spectra()[0].mean[0], 1.25 / PI);
        assert_eq!((read.spectra()[0].repeats, read.samples().unwrap().samples()[0].weight), (2, 4.0));
        assert!(spectra("theta_i,theta_o,weight,400,700\n20,20,0,1,1\n").is_err());
    }

    fn spectra(text: &str) -> Result<Goniospectra> {
        Goniospectra::new(&parse(text).unwrap().samples)
    }

    const SAMPLE: &str = "theta_i,theta_o,400,500\n20,20,1,4\n30,-10,0.5,0.25\n20,20,3,4\n30,30,0,2\n";

    #[test]
    fn repeats_are_averaged_wherever_they_stand() {
        let read = spectra(SAMPLE).unwrap();
        let rows = read.spectra();
        let geometries: Vec<f64> = rows.iter().map(|row| row.reading.theta_o_deg()).collect();
        assert_eq!(geometries, [20.0, -10.0, 30.0]);
        assert_eq!((rows[0].repeats, rows[1].repeats), (2, 1));
        assert!((PI * rows[0].mean[0] - 2.0).abs() < 1e-15 && (PI * rows[0].mean[1] - 4.0).abs() < 1e-15);
        // 1 and 3 about 2: variance 2, half the mean squared; 4 and 4: none.
        let deviation = rows[0].deviation.unwrap();
        assert!((deviation - 0.25f64.sqrt()).abs() < 1e-15, "{deviation}");
        assert_eq!(rows[1].deviation, None);
        assert_eq!((read.incidences(), read.wavelengths()), (vec![20.0, 30.0], &[400.0, 500.0][..]));
        assert_eq!(read.samples().unwrap().values(2), &rows[2].mean[..]);
        let left = read.without(&[20.0]).unwrap();
        assert_eq!((left.incidences(), left.spectra()), (vec![30.0], &rows[1..]));
        assert_eq!(Goniospectra::new(&left.samples().unwrap()).unwrap().spectra(), left.spectra());
    }

    #[test]
    fn white_is_that_of_the_geometry_or_of_the_incidence() {
        let white = "theta_i,theta_o,400,500\n20,20,2,8\n20,0,9,9\n30,0,10,5\n";
        let read = spectra(SAMPLE).unwrap().over_white(&spectra(white).unwrap(), 0.99).unwrap();
        let factors = |k: usize| read.spectra()[k].mean.iter().map(|f| PI * f).collect::<Vec<f64>>();
        for (k, expected) in [(0, [0.99, 0.495]), (1, [0.0495, 0.0495]), (2, [0.0, 0.396])] {
            for (found, expected) in factors(k).iter().zip(expected) {
                // A few roundings.
                assert!((found - expected).abs() < 1e-15, "{k}: {found} {expected}");
            }
        }
        assert_eq!(read.spectra()[0].deviation, spectra(SAMPLE).unwrap().spectra()[0].deviation);
    }

    #[test]
    fn what_is_no_measurement_is_refused() {
        let sample = spectra(SAMPLE).unwrap();
        let message = |result: Result<Goniospectra>| result.unwrap_err().to_string();
        let head = "theta_i,theta_o,400,500\n";
        let negative = spectra(&format!("{head}20,20,1,1\n20,30,1,-2\n20,30,1,1\n"));
        let words = "theta_i 20, theta_o 30 (row 2): mean reflectance factor at 500 nm: found -0.5, expected 0 or more";
        assert_eq!(message(negative), words);
        assert!(message(spectra("theta_i,theta_o,R,G,B\n20,20,1,1,1\n")).contains("bands: found Rec.709"));
        for (white, words) in [
            ("20,20,1,1\n30,30,1,1\n30,0,1,1\n", "theta_i 30, theta_o -10: reading of white: found others"),
            ("20,20,1,1\n", "theta_i 30, theta_o -10: reading of white: found none"),
            (
                "20,20,1,0\n30,30,1,1\n",
                "theta_i 20, theta_o 20: reading of white at 500 nm: found 0, expected above 0",
            ),
        ] {
            let white = spectra(&format!("{head}{white}")).unwrap();
            let found = message(sample.over_white(&white, 0.99));
            assert!(found.contains(words), "{found}");
        }
        let other = spectra("theta_i,theta_o,400,510\n20,20,1,1\n30,30,1,1\n").unwrap();
        assert!(message(sample.over_white(&other, 0.99)).contains("510"));
        for reflectance in [0.0, 1.1, f64::NAN] {
            assert!(message(sample.over_white(&sample, reflectance)).contains("reflectance"));
        }
        assert!(message(sample.without(&[25.0])).contains("found 25, expected one of [20.0, 30.0]"));
        assert!(message(sample.without(&[20.0, 30.0])).contains("all"));
    }

    #[test]
    fn files_must_hold_spectra_in_order() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let good = path("good.csv", SAMPLE);
        assert_eq!(Goniospectra::read(&good).unwrap(), spectra(SAMPLE).unwrap());
        let own = path("white.csv", &SAMPLE.replace("30,30,0,2", "30,30,1,2"));
        let read = Goniospectra::read_over_white(&good, &own, 0.5).unwrap();
        assert!((PI * read.spectra()[0].mean[1] - 0.5).abs() < 1e-15);
        for (text, words) in [
            (
                "theta_i,theta_o,500,400\n20,20,1,1\n",
                "line 1: column 4: wavelengths: found 400 nm after 500 nm",
            ),
            ("theta_i,theta_o,L,a,b\n20,20,1,1,1\n", "line 1: columns of values: found colors"),
            (
                "theta_i,theta_o,0.38,0.39\n20,20,1,1\n",
                "line 1: column 3: wavelength: found \"0.38\", micrometres, expected nanometres, as 380",
            ),
            ("theta_i,theta_o,400\n20,20,nan\n", "line 2: column 3: number"),
            ("theta_i,theta_o,400\n20,20,-1\n", "(row 1): mean reflectance factor at 400 nm"),
        ] {
            let bad = path("bad.csv", text);
            let found = Goniospectra::read(&bad).unwrap_err().to_string();
            assert!(found.contains(words) && found.contains("bad.csv"), "{text:?}: {found}");
        }
        let zero = path("zero.csv", SAMPLE);
        let message = Goniospectra::read_over_white(&good, &zero, 0.99).unwrap_err().to_string();
        assert!(
            message.contains("zero.csv: theta_i 30, theta_o 30: reading of white at 400 nm"),
            "{message}"
        );
    }
}
