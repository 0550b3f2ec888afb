//! Scattered measurements of a homogeneous BRDF: what images and instruments give, and fits take.

use super::TabulatedBrdf;
use crate::error::{Error, Result};
use glam::DVec3;

/// Samples of a BRDF at scattered pairs of directions, each with one value a band.
///
/// Values are BRDF, 1/sr, no cosine. Bands are linear Rec.709, or wavelengths: Rump et al. 2008, eq. 3, knows any number.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleSet {
    bands: Bands,
    samples: Vec<BrdfSample>,
    /// Sample after sample, band after band.
    values: Vec<f64>,
}

/// What the values of a sample are.
#[derive(Debug, Clone, PartialEq)]
pub enum Bands {
    /// Linear Rec.709: red, green, blue.
    Rgb,
    /// Spectral values at these wavelengths, nanometres, ascending.
    Wavelengths(Vec<f64>),
}

/// Where a sample was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct BrdfSample {
    /// Unit direction to the light, of an extended one to its middle; z = normal, above the horizon.
    pub wi: DVec3,
    /// Unit direction to the eye, above the horizon.
    pub wo: DVec3,
    /// What the sample counts in a mean over directions, 0 or more: its share of the two spheres, up to a common factor.
    pub weight: f64,
    /// The points of an extended light, as seen from the sample; empty for a light that is one point at `wi`. The sample's value
    /// is the mean of the BRDF over them (the inner sum of Rump et al. 2008, eq. 7), by their shares.
    pub lights: Vec<LightPoint>,
}

/// A point of an extended light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPoint {
    /// Unit direction to it.
    pub direction: DVec3,
    /// Its share of the irradiance; the shares of a sample sum to 1.
    pub share: f64,
}

impl Bands {
    /// Number of bands.
    #[allow(clippy::len_without_is_empty, reason = "there is always a band")]
    pub fn len(&self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Wavelengths(nm) => nm.len(),
        }
    }
}

impl BrdfSample {
    /// A sample under light from one direction.
    pub fn new(wi: DVec3, wo: DVec3, weight: f64) -> Self {
        Self { wi, wo, weight, lights: Vec::new() }
    }

    /// Mean of `f(wi, wo)` over the light's points.
    pub fn mean(&self, f: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        if self.lights.is_empty() {
            return f(self.wi, self.wo);
        }
        self.lights.iter().map(|light| light.share * f(light.direction, self.wo)).sum()
    }
}

impl SampleSet {
    /// An empty set.
    ///
    /// # Errors
    /// No wavelength, or wavelengths that are not finite, positive and ascending.
    pub fn new(bands: Bands) -> Result<Self> {
        if let Bands::Wavelengths(nm) = &bands {
            let ascending = nm.windows(2).all(|pair| pair[0] < pair[1]);
            if nm.is_empty() || !ascending || nm.iter().any(|nm| !nm.is_finite() || *nm <= 0.0) {
                let legal = "one or more, positive, ascending";
                return Err(Error::invalid("samples", "wavelengths", format!("{nm:?}"), legal));
            }
        }
        Ok(Self { bands, samples: Vec::new(), values: Vec::new() })
    }

    /// Adds a sample with one value a band.
    ///
    /// # Errors
    /// A direction that is not above the horizon, a number that is not finite, another number of values than bands.
    pub fn push(&mut self, sample: BrdfSample, values: &[f64]) -> Result<()> {
        let place = || format!("sample {}", self.samples.len());
        if values.len() != self.bands.len() {
            return Err(Error::invalid(place(), "values", values.len(), self.bands.len().to_string()));
        }
        for (name, direction) in [("wi", sample.wi), ("wo", sample.wo)] {
            if !(direction.z > 0.0 && (direction.length() - 1.0).abs() < 1e-6) {
                return Err(Error::invalid(place(), name, direction, "a unit direction above the horizon"));
            }
        }
        if let Some(value) = values.iter().find(|v| !v.is_finite()) {
            return Err(Error::invalid(place(), "value", value, "a finite number"));
        }
        if !(sample.weight >= 0.0 && sample.weight.is_finite()) {
            return Err(Error::invalid(place(), "weight", sample.weight, "0 or more"));
        }
        self.values.extend_from_slice(values);
        self.samples.push(sample);
        Ok(())
    }

    /// What the values are.
    pub fn bands(&self) -> &Bands {
        &self.bands
    }

    /// The samples, in the order they came.
    pub fn samples(&self) -> &[BrdfSample] {
        &self.samples
    }

    /// The values of sample `k`, one a band.
    pub fn values(&self, k: usize) -> &[f64] {
        let n = self.bands.len();
        &self.values[k * n..(k + 1) * n]
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }
}

/// Every cell of a table, filled ones included, weighed by its solid angles.
impl From<&TabulatedBrdf> for SampleSet {
    fn from(table: &TabulatedBrdf) -> Self {
        let [n, m] = table.resolution();
        let mut set = Self { bands: Bands::Rgb, samples: Vec::new(), values: Vec::new() };
        for cell in 0..n * n * m {
            let (a, b, k) = (cell / m / n, cell / m % n, cell % m);
            let (wi, wo) = table.directions(a, b, k);
            let weight = wi.truncate().length() * wo.truncate().length();
            set.samples.push(BrdfSample::new(wi, wo, weight));
            set.values.extend_from_slice(&table.cell(a, b, k).to_array());
        }
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;

    #[test]
    fn what_is_no_measurement_is_refused() {
        let mut set = SampleSet::new(Bands::Rgb).unwrap();
        let up = spherical(0.3, 1.0);
        let refused = |set: &mut SampleSet, wi, weight, values: &[f64]| {
            set.push(BrdfSample::new(wi, up, weight), values).unwrap_err().to_string()
        };
        assert!(refused(&mut set, -up, 1.0, &[1.0; 3]).contains("above the horizon"));
        assert!(refused(&mut set, up * 0.5, 1.0, &[1.0; 3]).contains("wi"));
        assert!(refused(&mut set, up, -1.0, &[1.0; 3]).contains("weight"));
        assert!(refused(&mut set, up, 1.0, &[1.0; 2]).contains("values: found 2, expected 3"));
        set.push(BrdfSample::new(up, up, 1.0), &[1.0, 2.0, 3.0]).unwrap();
        assert!(refused(&mut set, up, 1.0, &[1.0, f64::NAN, 1.0]).starts_with("sample 1: value"));
        assert_eq!((set.len(), set.values(0)), (1, &[1.0, 2.0, 3.0][..]));
        for nm in [vec![], vec![500.0, 500.0], vec![-1.0], vec![f64::NAN]] {
            assert!(SampleSet::new(Bands::Wavelengths(nm)).is_err());
        }
    }

    #[test]
    fn an_extended_light_is_averaged_by_its_shares() {
        let points = [(0.2, 0.25), (0.4, 0.75)];
        let lights = points.map(|(theta, share)| LightPoint { direction: spherical(theta, 0.0), share });
        let sample = BrdfSample { lights: lights.to_vec(), ..BrdfSample::new(DVec3::Z, DVec3::Z, 1.0) };
        let mean = sample.mean(|wi, _| wi.z.acos());
        assert!((mean - 0.35).abs() < 1e-15, "{mean}");
    }
}
