//! How finely the full model is solved: nodes, azimuth modes, first layers and wavelengths for an error target.

use super::bands::Bands;
use super::transfer::film_kernel::Resolution;
use crate::color::BANDS;
use crate::error::{Error, Result};
use crate::simulate::optics::film_optics::PaintOptics;
use std::f64::consts::FRAC_PI_2;

/// The error wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Largest difference of the BRDF without gloss to its limit, over the greater of its value and 1e-3 of its peak, over
    /// directions of practice; 1e-8 to 0.1, typically 1e-2.
    pub error: f64,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self { error: 1e-2 }
    }
}

/// Everything that costs time.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Nodes in each panel: outside directions, and those beyond the critical angle of each film.
    pub nodes: usize,
    /// Kernels.
    pub resolution: Resolution,
    /// Largest scattering thickness of a first layer.
    pub thinness: f64,
    /// Modes this small, over the first, end the series.
    pub negligible: f64,
    /// Wavelengths.
    pub bands: Bands,
    /// The error to expect: the one asked for, or, where flakes are too narrow for the nodes and modes, how much too wide the
    /// lobes of light scattered more than once come out, as a share of their area; 7 % where the diffraction of large spheres
    /// is too narrow for the modes (measured with spheres of 10 um).
    pub expected_error: f64,
}

impl Settings {
    /// Settings for an accuracy. With d = -log10(error):
    ///
    /// * nodes: the light that flakes of width w mirror is a bell of width 2 w in the polar angle; a panel of the angle
    ///   theta takes `(0.95 + 0.3 (d - 2)) theta / w + 1` nodes, and at least `4 + 2 d`, or `8 + 6 d` without a boundary that refracts,
    ///   where light at grazing angles, for which kernels are least smooth, comes out;
    /// * modes: at the inside angle theta of a ray 80 degrees off the normal outside, the narrowest bell in azimuth that is not
    ///   left to the formula of single scattering has the width `sqrt(8) w / tan(theta)`; a Gaussian's series falls below
    ///   error/100 at `sqrt(2 ln(100 / error))` over it. A phase function of mean cosine g needs half of what `g^m` takes to
    ///   fall there, scattered twice. A series ends earlier where its modes get negligible;
    /// * first layers: the error grows like the second power of their thickness at the least ([`super::transfer::film`]);
    /// * wavelengths: equal ones once, and only as many others as [`Bands::Adaptive`] needs.
    ///
    /// All measured by `benches/full_model.rs`. Nodes and modes are capped; flakes too narrow for that are widened to what
    /// the nodes hold, in light scattered more than once only, see [`Settings::expected_error`].
    ///
    /// # Errors
    /// An error target outside 1e-8 to 0.1.
    pub fn choose(optics: &PaintOptics, accuracy: &Accuracy) -> Result<Self> {
        let error = accuracy.error;
        if !(1e-8..=0.1).contains(&error) {
            return Err(Error::invalid("accuracy", "error", error, "1e-8 to 0.1"));
        }
        let digits = -error.log10();
        let indices = optics.films.iter().map(|film| film.index);
        let panel = indices.clone().map(widest_panel).fold(0.0, f64::max);
        let narrowest = narrowest(optics);
        let bare = indices.clone().map(bare).fold(0.0, f64::max);
        let least = 4.0 + 2.0 * digits + bare * (4.0 + 4.0 * digits);
        let per_panel = (0.95 + 0.3 * (digits - 2.0)) * panel;
        let most_nodes = 24.0 + 8.0 * (digits - 2.0).clamp(0.0, 5.0);
        let nodes = (1.0 + per_panel / narrowest).max(least).min(most_nodes).ceil();
        let least_width = per_panel / (most_nodes - 1.0);
        let width = narrowest.max(least_width);

        let slope = indices.map(|index| (STEEP / index).asin().tan()).fold(0.0, f64::max);
        let flakes = (2.0 * (100.0 / error).ln()).sqrt() * slope / (8f64.sqrt() * width);
        let pigments = 0.5 * (0.01 * error).ln() / asymmetry(optics).clamp(0.05, 0.99).ln();
        let most_modes = 64.0 + 32.0 * (digits - 2.0).clamp(0.0, 4.0);
        let modes = (2.0 + flakes.max(pigments)).min(most_modes).ceil();
        Ok(Self {
            nodes: nodes as usize,
            resolution: Resolution {
                modes: modes as usize,
                cutoff: 1e-3 * error,
                azimuths: 4 + digits.ceil() as usize,
                least_width,
            },
            thinness: 0.8 * error.sqrt(),
            negligible: 0.01 * error,
            bands: Bands::Adaptive { tolerance: 0.5 * error },
            expected_error: error
                .max(if narrowest < least_width {
                    1.0 - (narrowest / least_width.hypot(narrowest)).powi(2)
                } else {
                    0.0
                })
                .max(if degree(optics) as f64 > 2.0 * modes { LARGE_SPHERES } else { 0.0 }),
        })
    }
}

/// Error to expect of spheres whose diffraction is narrower than the modes.
const LARGE_SPHERES: f64 = 0.07;

/// Sine of the polar angle outside up to which modes are resolved: 80 degrees.
const STEEP: f64 = 0.985;

/// Angle of the wider of the two panels inside a film, radians.
fn widest_panel(index: f64) -> f64 {
    let critical = (1.0 / index).asin();
    critical.max(FRAC_PI_2 - critical)
}

/// How bare of refraction a film is: 0 from an index of the square root of 2 on, 1 at 1.
fn bare(index: f64) -> f64 {
    if index * index < 2.0 { 2.0 * widest_panel(index) / FRAC_PI_2 - 1.0 } else { 0.0 }
}

/// Narrowest P of any flakes, radians; wide where there are none.
fn narrowest(optics: &PaintOptics) -> f64 {
    let kinds = optics.films.iter().flat_map(|film| &film.kinds).filter(|kind| kind.area_density > 0.0);
    kinds.map(|kind| kind.density.width()).fold(1.0, f64::min)
}

/// Highest degree of any phase function of spheres, in the cosine of the angle.
fn degree(optics: &PaintOptics) -> usize {
    let pigments = optics.films.iter().flat_map(|film| &film.pigments);
    pigments.map(|pigment| pigment.phase.degree()).max().unwrap_or(0)
}

/// Sharpest mean cosine of any pigment.
fn asymmetry(optics: &PaintOptics) -> f64 {
    let pigments = optics.films.iter().flat_map(|film| &film.pigments);
    pigments
        .flat_map(|pigment| (0..BANDS).map(|band| pigment.phase.asymmetry(band).abs()))
        .fold(0.0, f64::max)
}
