//! A goniochromatic ink: two spectra and a roughness (Pranovich et al. 2024), in memory and as a JSON file.
//!
//! ```json
//! { "kind": "carpaint ink", "version": 1, "name": "red",
//!   "alpha": 0.19, "wavelengths_nm": [380, 390, 780], "rho": [0.11, 0.12, 0.51], "c": [2.1, 1.9, -0.3] }
//! ```

use super::LobeGeometry;
use super::goniochromatic::{Goniochromatic, cos_mean_angle, ggx};
use crate::color::{Spectrum, Wavelengths};
use crate::error::{Error, Result};
use crate::file::{check_kind, read_text};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// What the key `kind` of an ink's file says.
pub const KIND: &str = "carpaint ink";
/// Newest version of the file that is understood.
const VERSION: u64 = 1;
/// Largest file, bytes.
const MAX_BYTES: u64 = 1 << 22;

/// A goniochromatic material over wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Ink {
    name: String,
    roughness: f64,
    wavelengths: Wavelengths,
    reflectance: Vec<f64>,
    growth: Vec<f64>,
    provenance: Value,
}

/// An ink's file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    kind: String,
    version: u64,
    name: String,
    alpha: f64,
    wavelengths_nm: Vec<f64>,
    rho: Vec<f64>,
    c: Vec<f64>,
    /// Where the numbers come from.
    #[serde(default)]
    provenance: Value,
}

impl Ink {
    /// An ink of roughness alpha, 1e-4 to 1, reflectance rho, 0 to 1e6, and growth c, -50 to 50, at each wavelength.
    ///
    /// # Errors
    /// A value outside its range, its wavelength named; another number of values than wavelengths.
    pub fn new(
        name: impl Into<String>,
        roughness: f64,
        wavelengths: Wavelengths,
        reflectance: Vec<f64>,
        growth: Vec<f64>,
    ) -> Result<Self> {
        let count = wavelengths.len();
        for (what, values) in [("rho", &reflectance), ("c", &growth)] {
            if values.len() != count {
                let legal = format!("{count}, one a wavelength");
                return Err(Error::invalid("", format!("number of {what}"), values.len(), legal));
            }
        }
        let ink =
            Self { name: name.into(), roughness, wavelengths, reflectance, growth, provenance: Value::Null };
        for (band, nm) in ink.wavelengths.nm().iter().enumerate() {
            ink.at(band).validate().map_err(|e| e.within(format!("{nm} nm")))?;
        }
        Ok(ink)
    }

    /// Reads an ink's file.
    ///
    /// # Errors
    /// Those of the file system; no JSON, of another kind or a newer version; unknown or missing keys; a value that [`Ink::new`] or
    /// [`Wavelengths::new`] refuses.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path, MAX_BYTES)?).map_err(|e| e.in_file(path))
    }

    /// An ink from the text of its file.
    ///
    /// # Errors
    /// As [`Ink::read`].
    pub fn parse(text: &str) -> Result<Self> {
        let legal = "an ink: kind, version, name, alpha, wavelengths_nm, rho, c";
        let json: Value = serde_json::from_str(text).map_err(|e| Error::invalid("", "JSON", e, legal))?;
        check_kind(&json, KIND, VERSION)?;
        let keys: Keys = serde_path_to_error::deserialize(json)
            .map_err(|e| Error::invalid(e.path().to_string(), "JSON", e.inner(), legal))?;
        let wavelengths = Wavelengths::new(keys.wavelengths_nm)?;
        let ink = Self::new(keys.name, keys.alpha, wavelengths, keys.rho, keys.c)?;
        Ok(Self { provenance: keys.provenance, ..ink })
    }

    /// Writes the ink's file, whole or not at all.
    ///
    /// # Errors
    /// Those of the file system.
    #[cfg(feature = "files")]
    pub fn write(&self, path: &Path) -> Result<()> {
        let keys = Keys {
            kind: KIND.into(),
            version: VERSION,
            name: self.name.clone(),
            alpha: self.roughness,
            wavelengths_nm: self.wavelengths.nm().to_vec(),
            rho: self.reflectance.clone(),
            c: self.growth.clone(),
            provenance: self.provenance.clone(),
        };
        let text = serde_json::to_string_pretty(&keys)
            .map_err(|e| Error::invalid("ink", "not representable as JSON", e, "finite numbers"))?;
        crate::file::write_text(path, &(text + "\n"))
    }

    /// The same, and where it comes from.
    #[must_use]
    pub fn with_provenance(self, provenance: Value) -> Self {
        Self { provenance, ..self }
    }

    /// The same ink printed otherwise: another roughness, above 0 to 1.
    ///
    /// # Errors
    /// As [`Ink::new`].
    pub fn with_roughness(self, roughness: f64) -> Result<Self> {
        let provenance = self.provenance;
        let ink = Self::new(self.name, roughness, self.wavelengths, self.reflectance, self.growth)?;
        Ok(Self { provenance, ..ink })
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where it comes from; null if nobody said.
    pub fn provenance(&self) -> &Value {
        &self.provenance
    }

    /// Roughness alpha.
    pub fn roughness(&self) -> f64 {
        self.roughness
    }

    /// Where the spectra are sampled.
    pub fn wavelengths(&self) -> &Wavelengths {
        &self.wavelengths
    }

    /// Reflectance rho, one a wavelength.
    pub fn reflectance(&self) -> &[f64] {
        &self.reflectance
    }

    /// Growth c, one a wavelength.
    pub fn growth(&self) -> &[f64] {
        &self.growth
    }

    /// The model at one of its wavelengths.
    pub fn at(&self, band: usize) -> Goniochromatic {
        let (reflectance, growth) = (self.reflectance[band], self.growth[band]);
        Goniochromatic { roughness: self.roughness, reflectance, growth }
    }

    /// BRDF, 1/sr, one a wavelength (eq. 5).
    pub fn brdf(&self, g: &LobeGeometry) -> Vec<f64> {
        if g.cos_i < 0.0 || g.cos_o < 0.0 {
            return vec![0.0; self.wavelengths.len()];
        }
        let distribution = 0.25 * ggx(g.tan2_h, self.roughness);
        let cos_mean = cos_mean_angle(g.cos_i, g.cos_o);
        (0..self.wavelengths.len()).map(|band| distribution * self.at(band).directional(cos_mean)).collect()
    }

    /// [`Ink::brdf`] in bands of 10 nm.
    pub fn spectrum(&self, g: &LobeGeometry) -> Spectrum {
        self.wavelengths.spectrum(&self.brdf(g))
    }

    /// The same ink at other wavelengths, rho and c as smooth as [`Wavelengths::interpolate_smoothly`] has them, within their ranges.
    ///
    /// # Errors
    /// As [`Ink::new`].
    pub fn resampled(&self, wavelengths: &Wavelengths) -> Result<Self> {
        let resample = |values: &[f64], least: f64, most: f64| {
            let value = |nm: &f64| self.wavelengths.interpolate_smoothly(values, *nm).clamp(least, most);
            wavelengths.nm().iter().map(value).collect()
        };
        let most = Goniochromatic::MAX_GROWTH;
        let reflectance = resample(&self.reflectance, 0.0, Goniochromatic::MAX_REFLECTANCE);
        let growth = resample(&self.growth, -most, most);
        Self::new(self.name.clone(), self.roughness, wavelengths.clone(), reflectance, growth)
    }

    /// Share of the light from polar angle `theta`, radians, 0 to pi/2, that goes out again, one a wavelength. Above 1 the model
    /// gives back more than it gets: nothing in eq. 5 forbids it.
    pub fn albedo(&self, theta: f64) -> Vec<f64> {
        // Half vectors by the distribution's own quantiles: a lobe of any width gets its share of them.
        const RINGS: usize = 128;
        const SECTORS: usize = 64;
        let wo = glam::DVec3::new(theta.min(FRAC_PI_2).sin(), 0.0, theta.min(FRAC_PI_2).cos());
        let mut sum = vec![0.0; self.wavelengths.len()];
        for ring in 0..RINGS {
            for sector in 0..SECTORS {
                let u = [ring, sector].map(|k| k as f64 + 0.5);
                let u = [u[0] / RINGS as f64, u[1] / SECTORS as f64];
                let Some(wi) = super::goniochromatic::sample(wo, self.roughness, u) else { continue };
                let g = LobeGeometry::of(wi, wo);
                let weight =
                    wi.z / super::goniochromatic::density(&g, self.roughness) / (RINGS * SECTORS) as f64;
                sum.iter_mut().zip(self.brdf(&g)).for_each(|(s, f)| *s += f * weight);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;

    fn red() -> Ink {
        let grid = Wavelengths::new(vec![400.0, 500.0, 700.0]).unwrap();
        Ink::new("red", 0.19, grid, vec![0.1, 0.2, 0.8], vec![3.0, 1.0, -0.5]).unwrap()
    }

    #[test]
    fn files_come_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("red.ink.json");
        let ink = red().with_provenance(serde_json::json!({ "from": "spectra" }));
        ink.write(&path).unwrap();
        assert_eq!(Ink::read(&path).unwrap(), ink);
    }

    #[test]
    fn bad_files_are_refused_by_key() {
        let good = r#"{"kind":"carpaint ink","version":1,"name":"a","alpha":0.2,"wavelengths_nm":[400,700],"rho":[0.1,0.2],"c":[1,2]}"#;
        assert!(Ink::parse(good).is_ok());
        for (from, to, words) in [
            ("carpaint ink", "paint", "kind of file: found paint"),
            ("\"version\":1", "\"version\":2", "version: found 2"),
            ("0.2,\"w", "1.5,\"w", "alpha: found 1.5, expected"),
            ("400,700", "700,400", "wavelengths: found 700 before 400, expected ascending"),
            ("400,700", "0.4,0.7", "in micrometres?"),
            ("0.1,0.2", "0.1,-0.2", "700 nm: goniochromatic model: rho: found -0.2"),
            ("0.1,0.2", "0.1", "number of rho: found 1, expected 2"),
            ("[1,2]", "[1,200]", "c: found 200, expected -50 to 50"),
            ("\"name\"", "\"nom\"", "unknown field `nom`"),
            ("0.1,0.2", "0.1,\"x\"", "rho[1]: JSON"),
            ("}", "", "JSON"),
        ] {
            let text = good.replace(from, to);
            let message = Ink::parse(&text).unwrap_err().to_string();
            assert!(message.contains(words), "{text}: {message}");
        }
        (0..good.len()).for_each(|length| assert!(Ink::parse(&good[..length]).is_err()));
    }

    #[test]
    fn resampled_at_its_own_wavelengths_it_stays() {
        let ink = red();
        assert_eq!(ink.resampled(ink.wavelengths()).unwrap(), ink);
        let finer = ink.resampled(&Wavelengths::new(vec![300.0, 450.0, 800.0]).unwrap()).unwrap();
        assert_eq!(finer.growth(), [3.0, 2.0, -0.5]);
        assert!((finer.reflectance()[1] - 0.15).abs() < 1e-15);
    }

    /// Spectra of interference are smooth: those at 20 nm know what lies between.
    #[test]
    fn smooth_spectra_are_resampled_smoothly() {
        let wave = |nm: f64| 0.5 + 0.4 * (nm / 60.0).sin();
        let ink = |count: usize| {
            let grid = Wavelengths::even(count).unwrap();
            let [rho, c] = [1.0, 3.0].map(|scale| grid.nm().iter().map(|nm| scale * wave(*nm)).collect());
            Ink::new("", 0.2, grid, rho, c).unwrap()
        };
        let (fine, from_coarse) = (ink(33), ink(21).resampled(&Wavelengths::even(33).unwrap()).unwrap());
        for (k, rho) in fine.reflectance().iter().enumerate() {
            // A cubic is off by 3/128 of the fourth derivative times the step's fourth power, at most, twice that in end
            // intervals: .4 (20 / 60)^4; linear ones by 1/8 of the second, 6e-3.
            assert!((from_coarse.reflectance()[k] - rho).abs() < 3e-4, "{k}");
            assert!((from_coarse.growth()[k] - fine.growth()[k]).abs() < 9e-4, "{k}");
        }
        let steep =
            Ink::new("", 0.2, Wavelengths::even(5).unwrap(), vec![0.0, 0.0, 1.0, 1.0, 0.0], vec![50.0; 5]);
        let finer = steep.unwrap().resampled(&Wavelengths::even(41).unwrap()).unwrap();
        assert!(finer.reflectance().iter().all(|rho| *rho >= 0.0));
    }

    /// Reference 10 states them for rho = 1, c = 0 to about 1e-5, by a quadrature over half vectors.
    #[test]
    fn albedos_are_those_of_the_reference() {
        for (alpha, theta, expected) in
            [(0.19, 0.0, 0.830_451_6), (0.19, 60.0, 0.267_026_8), (0.5, 30.0, 0.443_291_2), (1.0, 80.0, 0.25)]
        {
            let grid = Wavelengths::new(vec![500.0]).unwrap();
            let ink = Ink::new("", alpha, grid, vec![1.0], vec![0.0]).unwrap();
            let found = ink.albedo(f64::to_radians(theta))[0];
            // The edge of the horizon goes through cells: a few of 8,192.
            assert!((found / expected - 1.0).abs() < 5e-3, "{alpha} {theta}: {found}");
        }
    }

    #[test]
    fn spectra_of_one_are_those_of_the_model() {
        let ink = red();
        let g = LobeGeometry::of(spherical(0.3, 0.0), spherical(0.9, 2.0));
        let f = ink.brdf(&g);
        (0..3).for_each(|band| assert_eq!(f[band], ink.at(band).eval(&g)));
        assert_eq!(ink.brdf(&LobeGeometry::of(spherical(0.3, 0.0), spherical(2.0, 2.0))), [0.0; 3]);
        assert!((ink.spectrum(&g).0[2] - f[0]).abs() < 1e-15);
    }
}
