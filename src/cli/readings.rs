//! What a multi-angle instrument reads from a composition, and where its light goes.

use super::output;
use crate::brdf::fresnel::dielectric;
use crate::color::{BANDS, Spectrum, lab_from_rgb, wavelength_nm};
use crate::simulate::models::full_model::Energy;
use crate::simulate::{Model, Reading, flop_index};
use serde::Serialize;
use std::f64::consts::PI;

/// Aspecular angles of the flop index.
const FLOP_DEG: [f64; 3] = [15.0, 45.0, 110.0];
/// Their incidence.
const FLOP_INCIDENCE_DEG: f64 = 45.0;

/// All readings of a list.
#[derive(Serialize)]
pub struct Readings {
    /// The unit of what is reported.
    unit: &'static str,
    wavelengths_nm: Vec<f64>,
    readings: Vec<Measured>,
    /// For light at 45 degrees, if the angles it takes are read.
    flop_index: Option<f64>,
}

#[derive(Serialize)]
struct Measured {
    incidence_deg: f64,
    aspecular_deg: f64,
    /// L*a*b* under D65 of the body, gloss left out.
    lab: [f64; 3],
    /// pi f at every wavelength.
    spectrum: Vec<f64>,
    /// pi f of the gloss; 0 for a mirror.
    gloss: f64,
    /// What the surface reflects into the mirror direction if it is smooth.
    surface_reflectance: f64,
}

impl Readings {
    pub fn new(model: &Model, list: &[Reading]) -> Self {
        let readings: Vec<Measured> = list.iter().map(|reading| Measured::new(model, reading)).collect();
        let lightness = |aspecular: f64| {
            let wanted =
                |m: &&Measured| m.incidence_deg == FLOP_INCIDENCE_DEG && m.aspecular_deg == aspecular;
            readings.iter().find(wanted).map(|m| m.lab[0])
        };
        let flop = match FLOP_DEG.map(lightness) {
            [Some(near), Some(face), Some(far)] => flop_index([near, face, far]),
            _ => None,
        };
        Self {
            unit: "reflectance factor pi f, the perfect diffuser 1; L*a*b* under D65, 2 degree observer; gloss apart",
            wavelengths_nm: (0..BANDS).map(wavelength_nm).collect(),
            readings,
            flop_index: flop,
        }
    }

    /// A table for people.
    pub fn print(&self) {
        output::say!("incidence  aspecular       L*       a*       b*    gloss");
        for m in &self.readings {
            let [l, a, b] = m.lab;
            let gloss = if m.gloss > 0.0 { format!("{:8.4}", m.gloss) } else { "       -".to_owned() };
            let (incidence, aspecular) = (m.incidence_deg, m.aspecular_deg);
            output::say!("{incidence:9.1}  {aspecular:9.1} {l:8.2} {a:8.2} {b:8.2} {gloss}");
        }
        if let Some(flop) = self.flop_index {
            output::say!("flop index {flop:.2} (2.69 (L*15 - L*110)^1.11 / L*45^0.86, light at 45 degrees)");
        }
    }
}

impl Measured {
    fn new(model: &Model, reading: &Reading) -> Self {
        let (wi, wo) = reading.directions();
        let factor = Spectrum(model.brdf(wi, wo).0.map(|f| PI * f));
        Self {
            incidence_deg: reading.incidence_deg,
            aspecular_deg: reading.aspecular_deg,
            lab: lab_from_rgb(factor.linear_rgb()).to_array(),
            spectrum: factor.0.to_vec(),
            gloss: PI * model.gloss(wi, wo),
            surface_reflectance: dielectric(wi.z, model.optics().top().index),
        }
    }
}

/// Where light goes, wavelength by wavelength.
#[derive(Serialize)]
pub struct EnergyTable {
    incidence_deg: f64,
    /// Reflected by the surface itself, at every wavelength.
    gloss: f64,
    wavelengths_nm: Vec<f64>,
    reflected: Vec<f64>,
    to_substrate: Vec<f64>,
    absorbed: Vec<f64>,
}

impl EnergyTable {
    pub fn new(energy: &Energy, incidence_deg: f64) -> Self {
        Self {
            incidence_deg,
            gloss: energy.gloss,
            wavelengths_nm: (0..BANDS).map(wavelength_nm).collect(),
            reflected: energy.reflected.0.to_vec(),
            to_substrate: energy.substrate.0.to_vec(),
            absorbed: energy.films.0.to_vec(),
        }
    }

    /// A table for people.
    pub fn print(&self) {
        output::say!("light at {} degrees, shares: gloss {:.5} and", self.incidence_deg, self.gloss);
        output::say!("   nm  reflected  to substrate  absorbed");
        for (k, nm) in self.wavelengths_nm.iter().enumerate() {
            // What is left after the others may round below 0.
            let (reflected, substrate, absorbed) =
                (self.reflected[k], self.to_substrate[k], self.absorbed[k].max(0.0));
            output::say!("{nm:5.0}  {reflected:9.5}  {substrate:12.5}  {absorbed:8.5}");
        }
    }
}
