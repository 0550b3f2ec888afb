//! The fast two-layer model: a film with flakes over a Lambertian substrate, under a smooth surface.
//!
//! Ershov, Kolchin & Myszkowski 2001, eqs 20-36, as corrected (re-derived; the published text has misprints). Angles with a
//! bar are inside the binder, primes mark the incident ray; several kinds of flakes add, in extinction and in glitter:
//!
//! * extinction of a slanted ray per depth, eqs 10, 21: `tau h = (kappa h + sum D<S>h <(1 - t_p) |cos alpha|>) / cos(bar theta)`,
//!   the average over flake normals at that ray;
//! * glitter, eq. 36 = (20) through the surface:
//!   `D<S>h [1-r][1-r'] / (4 eta^2 cos' cos) (1 - exp(-x))/x r_p(alpha) P(beta)`, `x = [tau(bar theta) + tau(bar theta')] h`;
//! * shade, eq. 28 over cos(theta): `[1-r][1-r'] exp(-x) eta^-2 / (1 - 2 r_s Q) r_s / pi`; 2Q is what layer
//!   and surface return of a Lambertian substrate's light ([`super::substrate_return`]).
//!
//! With a finite flake lobe, P in the glitter is its convolution with the lobe ([`super::orientation`]); extinction keeps P
//! itself, the flakes' geometry. What the model drops: multiple scattering between flakes, light scattered by flakes
//! towards the substrate, flake-surface interreflection. It is always low, 3-4 % at the peak of a thin narrow layer, up to
//! 40 % for dense, strongly tilted flakes under a clear surface.

use super::composition::{Composition, FlakeKind};
use super::flake_optics::FlakeOptics;
use super::geometry::Geometry;
use super::orientation::{FlakeLobe, HalfVectorDensity, Orientation};
use super::piecewise::Piecewise;
use super::substrate_return::substrate_return;
use crate::color::{BANDS, Spectrum};
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// The fast model of one composition.
#[derive(Debug, Clone)]
pub struct FastModel {
    index: f64,
    albedo: Spectrum,
    /// `tau h cos(bar theta)` over bar theta.
    extinction: Piecewise<BANDS>,
    kinds: Vec<KindModel>,
    two_q: Spectrum,
}

/// One kind of flakes in the model.
#[derive(Debug, Clone)]
pub struct KindModel {
    /// `D<S>h`.
    pub area_density: f64,
    /// P, the flakes' own.
    pub orientation: Orientation,
    /// Lobe of a flake over half vectors inside the binder; `None` for a perfect mirror.
    pub lobe: Option<FlakeLobe>,
    /// P as the half vector finds it.
    pub density: HalfVectorDensity,
    /// r_p, t_p.
    pub optics: FlakeOptics,
}

impl KindModel {
    fn new(kind: &FlakeKind, index: f64) -> Result<Self> {
        let orientation = Orientation::new(kind.sigma_deg.to_radians());
        // Near the normal refraction shows a tilt inside `index` times as wide outside, where lifetimes are measured.
        let lobe = (kind.flake_lifetime_deg > 0.0)
            .then(|| FlakeLobe::new(kind.flake_lifetime_deg.to_radians() / index));
        Ok(Self {
            area_density: kind.area_density,
            orientation,
            lobe,
            density: HalfVectorDensity::new(orientation, lobe)?,
            optics: FlakeOptics::new(kind, index)?,
        })
    }

    /// Adds `D<S>h <(1 - t_p) |cos alpha|>` at bar theta to a spectrum.
    fn add_interception(&self, theta: f64, sum: &mut [f64; BANDS]) {
        let mut area = 0.0;
        let rays = |add: &mut dyn FnMut(f64, f64)| self.orientation.projected_average(theta, add);
        rays(&mut |_, weight| area += weight);
        let passed = match &self.optics {
            FlakeOptics::Mirror(mirror) => mirror.transmittance.0.map(|t| area * t),
            FlakeOptics::Stack { transmittance, .. } => transmittance.weighted_sum(rays),
        };
        for (s, passed) in sum.iter_mut().zip(passed) {
            *s += self.area_density * (area - passed);
        }
    }
}

impl FastModel {
    /// Prepares the model: densities, extinction and Q are tabulated here, in some 0.1 s.
    ///
    /// # Errors
    /// As [`Composition::validate`]; a table that misses its tolerance ([`Piecewise::fit`]).
    pub fn new(composition: &Composition) -> Result<Self> {
        composition.validate()?;
        let film = &composition.film;
        let kinds =
            film.flakes.iter().map(|kind| KindModel::new(kind, film.index)).collect::<Result<Vec<_>>>()?;
        let absorbed = film.absorption_per_mm.0.map(|kappa| kappa * film.thickness_um * 1e-3);
        // The average over flakes takes 16 nodes a width of P: fringes finer than those leave their grain in the extinction.
        let stacks = kinds.iter().any(|kind| matches!(kind.optics, FlakeOptics::Stack { .. }));
        let tolerance = if stacks { 1e-4 } else { 1e-10 };
        let extinction =
            Piecewise::fit("extinction of the film", &[0.0, 0.25 * PI, FRAC_PI_2], tolerance, |theta| {
                let mut sum = absorbed;
                kinds.iter().for_each(|kind| kind.add_interception(theta, &mut sum));
                sum
            })?;
        let two_q = substrate_return(film.index, &extinction, &kinds);
        Ok(Self { index: film.index, albedo: composition.substrate.albedo.clone(), extinction, kinds, two_q })
    }

    /// Index of the binder.
    pub fn index(&self) -> f64 {
        self.index
    }

    /// The kinds of flakes.
    pub fn kinds(&self) -> &[KindModel] {
        &self.kinds
    }

    /// 2Q: the share of a Lambertian substrate's light that flakes and surface send back to it.
    pub fn two_q(&self) -> &Spectrum {
        &self.two_q
    }

    /// `x = [tau(bar theta) + tau(bar theta')] h`: optical thickness of the film along both rays.
    pub fn optical_thickness(&self, g: &Geometry) -> Spectrum {
        let [down, up] = [0, 1].map(|k| self.extinction.eval(g.theta_inside[k]));
        Spectrum(std::array::from_fn(|k| down[k] / g.cos_inside[0] + up[k] / g.cos_inside[1]))
    }

    /// Eq. 36: mean BRDF of the flakes, 1/sr.
    pub fn glitter(&self, g: &Geometry) -> Spectrum {
        self.glitter_through(g, &self.optical_thickness(g))
    }

    fn glitter_through(&self, g: &Geometry, thickness: &Spectrum) -> Spectrum {
        let surface = self.surface_factor(g);
        let mut sum = [0.0; BANDS];
        for kind in &self.kinds {
            let factor = kind.area_density * kind.density.eval(g.beta) * surface;
            for (s, r) in sum.iter_mut().zip(kind.optics.reflectance(g.cos_alpha)) {
                *s += factor * r;
            }
        }
        Spectrum(std::array::from_fn(|k| sum[k] * mean_attenuation(thickness.0[k])))
    }

    /// `[1-r][1-r'] / (4 eta^2 cos(bar theta) cos(bar theta'))`.
    pub fn surface_factor(&self, g: &Geometry) -> f64 {
        g.transmission / (4.0 * self.index * self.index * g.cos_inside[0] * g.cos_inside[1])
    }

    /// Eq. 28 over cos(theta): BRDF of the substrate seen through the film, 1/sr.
    pub fn shade(&self, g: &Geometry) -> Spectrum {
        self.shade_through(g, &self.optical_thickness(g))
    }

    fn shade_through(&self, g: &Geometry, thickness: &Spectrum) -> Spectrum {
        let factor = g.transmission / (self.index * self.index * PI);
        Spectrum(std::array::from_fn(|k| {
            let albedo = self.albedo.0[k];
            factor * (-thickness.0[k]).exp() * albedo / (1.0 - albedo * self.two_q.0[k])
        }))
    }

    /// Glitter and shade, 1/sr, for unit directions outside, without gloss; 0 unless both are above the horizon.
    pub fn brdf(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        let Some(g) = Geometry::new(wi, wo, self.index) else { return Spectrum::constant(0.0) };
        let thickness = self.optical_thickness(&g);
        let (glitter, shade) = (self.glitter_through(&g, &thickness), self.shade_through(&g, &thickness));
        Spectrum(std::array::from_fn(|k| glitter.0[k] + shade.0[k]))
    }

    /// [`FastModel::brdf`] as linear Rec.709.
    pub fn brdf_rgb(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        self.brdf(wi, wo).linear_rgb()
    }
}

/// `(1 - exp(-x))/x`: mean of exp(-x z) over z in [0, 1]. `x >= 0`.
pub fn mean_attenuation(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}
