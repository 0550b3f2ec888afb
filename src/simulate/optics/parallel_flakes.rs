//! The fast model for nearly parallel gray mirror flakes in a clear binder: forms with a constant optical thickness.
//!
//! Ershov 2001, eqs 29-33, corrected, for any number of kinds. With flakes all but parallel a ray meets as many per depth at
//! any slant: `tau h = sum D<S>h (1 - t_p)`. Binder absorption must be 0. The general forms are in [`crate::simulate::models::fast_model`];
//! these are what the paper prints last, for comparison.

use super::film_optics::mean_attenuation;
use super::geometry::Geometry;
use super::orientation::Orientation;
use crate::simulate::models::substrate_return::mean_inner_reflectance;
use std::f64::consts::PI;

/// A two-layer paint of such flakes, one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelFlakes {
    /// The kinds of flakes.
    pub kinds: Vec<ParallelKind>,
    /// Index eta of the binder.
    pub index: f64,
    /// Albedo r_s of the substrate, 0 to 1.
    pub albedo: f64,
}

/// One kind of such flakes.
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelKind {
    /// P(beta).
    pub orientation: Orientation,
    /// `D<S>h`.
    pub area_density: f64,
    /// r_p, 0 to 1.
    pub reflectance: f64,
    /// t_p, 0 to 1 - r_p.
    pub transmittance: f64,
}

impl ParallelFlakes {
    /// tau h, eq. 29.
    pub fn optical_thickness(&self) -> f64 {
        self.kinds.iter().map(|kind| kind.area_density * (1.0 - kind.transmittance)).sum()
    }

    /// `sum D<S>h r_p`: optical thickness if nothing but reflection took light, `r_p + t_p = 1`.
    pub fn reflecting_thickness(&self) -> f64 {
        self.kinds.iter().map(|kind| kind.area_density * kind.reflectance).sum()
    }

    /// Third term of eq. 33, corrected: `sum D<S>h r_p P (1 - exp(-2 tau h)) / (2 tau h) / (4 eta^2 cos cos')`, with the
    /// Fresnel losses.
    pub fn glitter(&self, g: &Geometry) -> f64 {
        self.per_solid_angle(g) * mean_attenuation(2.0 * self.optical_thickness())
    }

    /// The same as printed, `1 - exp(-2 D<S>h r_p)`, which holds for `r_p + t_p = 1` only.
    pub fn glitter_as_printed(&self, g: &Geometry) -> f64 {
        self.per_solid_angle(g) * mean_attenuation(2.0 * self.reflecting_thickness())
    }

    /// `[1-r][1-r'] sum D<S>h r_p P / (4 eta^2 cos cos')`.
    fn per_solid_angle(&self, g: &Geometry) -> f64 {
        let cosines = 4.0 * self.index * self.index * g.cos_inside[0] * g.cos_inside[1];
        let reflected =
            |kind: &ParallelKind| kind.area_density * kind.reflectance * kind.orientation.density(g.beta);
        g.transmission / cosines * self.kinds.iter().map(reflected).sum::<f64>()
    }

    /// r_s,eff of eq. 30: albedo of the substrate as seen through the film.
    pub fn effective_albedo(&self) -> f64 {
        let tau = self.optical_thickness();
        let flakes = self.reflecting_thickness() * mean_attenuation(2.0 * tau);
        let surface = (-2.0 * tau).exp() * mean_inner_reflectance(self.index);
        self.albedo * (-2.0 * tau).exp() / (self.index.powi(2) * (1.0 - self.albedo * (flakes + surface)))
    }

    /// r_s,eff as eq. 32 prints it, which holds for `r_p + t_p = 1` only.
    pub fn effective_albedo_as_printed(&self) -> f64 {
        let passed = (-2.0 * self.reflecting_thickness()).exp();
        let back = 0.5 * (1.0 + passed * (2.0 * mean_inner_reflectance(self.index) - 1.0));
        self.albedo * passed / (self.index.powi(2) * (1.0 - self.albedo * back))
    }

    /// Second term of eq. 33, corrected by 1/pi: BRDF of the substrate, 1/sr.
    pub fn shade(&self, g: &Geometry) -> f64 {
        g.transmission * self.effective_albedo() / PI
    }
}
