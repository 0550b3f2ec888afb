//! Pigment particles: how much they scatter and absorb, and where to (Ershov 2001, section 5.2).
//!
//! Spheres of radius r that fill the share f of the film's volume have `D sigma h = f 3/(4 r) Q h`, with the efficiencies Q
//! of [`super::mie`] in the binder (its real index: binders absorb little over a wavelength).

use super::mie::{MieSphere, PhaseTable};
use crate::color::{BANDS, Spectrum, wavelength_nm};
use crate::error::{Error, Result};
use crate::parallel::TryMap;
use crate::simulate::composition::{Film, MieSpheres, Pigment};
use nalgebra::Complex;
use rayon::prelude::*;
use std::f64::consts::PI;

/// One kind of pigments in a film.
#[derive(Debug, Clone, PartialEq)]
pub struct PigmentOptics {
    /// `D sigma_sc h`.
    pub scattering: Spectrum,
    /// `D sigma_ext h`.
    pub extinction: Spectrum,
    /// Where scattered light goes.
    pub phase: Phase,
}

/// A phase function.
// A film has a few: their size does not matter.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum Phase {
    /// `3/(16 pi) (1 + cos^2)`.
    Rayleigh,
    /// Henyey & Greenstein 1941, with the mean cosine g of each band.
    HenyeyGreenstein(Spectrum),
    /// The same of what pigments of a paint scatter: at bands with g above 0.92 two wider laws, and a share of the light, no longer
    /// part of scattering and extinction, goes straight on.
    Similar(Spectrum),
    /// Mie's, a table for each band.
    Mie(Vec<PhaseTable>),
}

/// Mean cosines of the two phase functions that stand for a sharper one. Azimuth modes hold the first at any error target.
const SHARPEST: f64 = 0.92;
const WIDER: f64 = 0.8;

/// A Henyey-Greenstein law of mean cosine g above [`SHARPEST`] as light that goes straight on and, with these weights, laws of
/// mean cosines [`SHARPEST`] and [`WIDER`]: what is left of their sum to 1 is not scattered (similarity, van de Hulst 1980).
///
/// Mean and mean square of the law's parameter are kept, and so how light spreads (moments 1 and 2); what goes back or sideways is within
/// 1.2 %, at 45 degrees within 3.2 %. Only the narrow peak around the onward direction is lost, in paints a glare.
fn similar(g: f64) -> [f64; 2] {
    let [u, near, far] = [g, SHARPEST, WIDER].map(|g| 1.0 - g);
    [u * (far - u) / (near * (far - near)), u * (u - near) / (far * (far - near))]
}

/// Share of what is scattered by a law of mean cosine g that counts as going straight on.
fn unscattered(g: f64) -> f64 {
    if g > SHARPEST { 1.0 - similar(g).iter().sum::<f64>() } else { 0.0 }
}

/// Henyey and Greenstein's law, 1/sr.
fn henyey_greenstein(g: f64, cos: f64) -> f64 {
    // 1 + g^2 - 2 g cos without the cancellation at forward angles.
    let distance = (1.0 - g).powi(2) + 2.0 * g * (1.0 - cos);
    (1.0 - g * g) / (4.0 * PI * distance * distance.sqrt())
}

impl PigmentOptics {
    /// Optics of one kind of pigments in a film.
    ///
    /// # Errors
    /// None of the three laws, or several; what [`crate::simulate::Composition::validate`] refuses.
    pub fn new(pigment: &Pigment, film: &Film) -> Result<Self> {
        let depth = film.thickness_um * 1e-3;
        let times = |per_mm: &Spectrum| Spectrum(per_mm.0.map(|s| s * depth));
        match (&pigment.mie, &pigment.rayleigh, &pigment.henyey_greenstein) {
            (None, Some(law), None) => Ok(Self {
                scattering: times(&law.scattering_per_mm),
                extinction: times(&law.extinction_per_mm),
                phase: Phase::Rayleigh,
            }),
            (None, None, Some(law)) => {
                let (mut scattering, mut extinction) =
                    (times(&law.scattering_per_mm), times(&law.extinction_per_mm));
                for (k, g) in law.asymmetry.0.iter().enumerate() {
                    let on = unscattered(*g) * scattering.0[k];
                    scattering.0[k] -= on;
                    extinction.0[k] -= on;
                }
                Ok(Self { scattering, extinction, phase: Phase::Similar(law.asymmetry.clone()) })
            }
            (Some(spheres), None, None) => Self::spheres(spheres, film),
            _ => Err(Error::invalid("", "laws of a pigment", "none or several", "one")),
        }
    }

    fn spheres(spheres: &MieSpheres, film: &Film) -> Result<Self> {
        let (n, k) = spheres.indices()?;
        let bands = (0..BANDS).into_par_iter().try_map(|band| {
            let x = 2.0 * PI * spheres.radius_um * film.index / (wavelength_nm(band) * 1e-3);
            let sphere = MieSphere::new(x, Complex::new(n.0[band], k.0[band]) / film.index)?;
            Ok((sphere.scattering(), sphere.extinction(), PhaseTable::new(&sphere)))
        })?;
        let shadow = spheres.volume_fraction * 0.75 / spheres.radius_um * film.thickness_um;
        Ok(Self {
            scattering: Spectrum(std::array::from_fn(|band| shadow * bands[band].0)),
            extinction: Spectrum(std::array::from_fn(|band| shadow * bands[band].1)),
            phase: Phase::Mie(bands.into_iter().map(|band| band.2).collect()),
        })
    }
}

impl Phase {
    /// Mean cosine g of the scattering angle, at a band; of [`Phase::Similar`] that of its sharpest part.
    pub fn asymmetry(&self, band: usize) -> f64 {
        match self {
            Self::Rayleigh => 0.0,
            Self::HenyeyGreenstein(g) => g.0[band],
            Self::Similar(g) => g.0[band].min(SHARPEST),
            Self::Mie(bands) => bands[band].asymmetry,
        }
    }

    /// Highest degree of a sphere's field at any band; 0 for other laws.
    pub fn degree(&self) -> usize {
        match self {
            Self::Mie(bands) => bands.iter().map(|table| table.degree).max().unwrap_or(0),
            _ => 0,
        }
    }

    /// Whether two bands have the same phase function.
    pub fn alike(&self, a: usize, b: usize) -> bool {
        match self {
            Self::Rayleigh => true,
            Self::HenyeyGreenstein(g) | Self::Similar(g) => g.0[a] == g.0[b],
            Self::Mie(bands) => bands[a] == bands[b],
        }
    }

    /// Density of scattered light, 1/sr (its integral over the sphere is 1), at a scattering angle of cosine `cos` (1 is
    /// forward), at a band.
    pub fn eval(&self, cos: f64, band: usize) -> f64 {
        debug_assert!(band < BANDS);
        match self {
            Self::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cos * cos),
            Self::HenyeyGreenstein(g) => henyey_greenstein(g.0[band], cos),
            Self::Similar(g) if g.0[band] > SHARPEST => {
                let [near, far] = similar(g.0[band]);
                let sum = near * henyey_greenstein(SHARPEST, cos) + far * henyey_greenstein(WIDER, cos);
                sum / (near + far)
            }
            Self::Similar(g) => henyey_greenstein(g.0[band], cos),
            Self::Mie(bands) => bands[band].eval(cos),
        }
    }
}
