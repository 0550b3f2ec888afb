//! The fast two-layer model: one film with flakes over a Lambertian substrate, under a smooth surface.
//!
//! Ershov, Kolchin & Myszkowski 2001, eqs 20-36, as corrected (re-derived; the published text has misprints). Glitter is eq. 36
//! ([`crate::simulate::optics::film_optics`]); shade is eq. 28 over cos(theta):
//! `[1-r][1-r'] exp(-x) eta^-2 / (1 - 2 r_s Q) r_s / pi`; 2Q is what layer and surface return of a Lambertian substrate's
//! light ([`super::substrate_return`]).
//!
//! What the model drops: multiple scattering between flakes, light scattered by flakes towards the substrate, flake-surface
//! interreflection. It is always low, 3-4 % at the peak of a thin narrow layer, up to 40 % for dense, strongly tilted flakes
//! under a clear surface.

use super::gloss::Gloss;
use super::substrate_return::substrate_return;
use crate::color::Spectrum;
use crate::error::{Error, Result};
use crate::simulate::composition::Composition;
use crate::simulate::optics::film_optics::{FilmOptics, KindOptics, PaintOptics, Preparation};
use crate::simulate::optics::geometry::Geometry;
use glam::DVec3;
use std::f64::consts::PI;

/// The fast model of one composition.
#[derive(Debug, Clone)]
pub struct FastModel {
    optics: PaintOptics,
    two_q: Spectrum,
}

impl FastModel {
    /// Prepares the model for many directions.
    ///
    /// # Errors
    /// As [`PaintOptics::new`]; more than one film, or pigments in it, which the model does not know.
    pub fn new(composition: &Composition) -> Result<Self> {
        Self::prepared(composition, Preparation::Tables)
    }

    /// Prepares the model; [`Preparation::Direct`] takes well below a millisecond for perfect mirrors, about one with a lobe.
    ///
    /// # Errors
    /// As [`FastModel::new`].
    pub fn prepared(composition: &Composition, preparation: Preparation) -> Result<Self> {
        Self::of(PaintOptics::prepared(composition, preparation)?)
    }

    /// The model of films already prepared.
    ///
    /// # Errors
    /// More than one film, or pigments in it, which the model does not know.
    pub fn from_optics(optics: &PaintOptics) -> Result<Self> {
        Self::of(optics.clone())
    }

    fn of(optics: PaintOptics) -> Result<Self> {
        let legal = "one film without pigments";
        if optics.films.len() != 1 {
            return Err(Error::unsupported("fast model", "films", optics.films.len(), legal));
        }
        let film = optics.top();
        if !film.pigments.is_empty() {
            return Err(Error::unsupported("fast model", "pigments in the film", film.pigments.len(), legal));
        }
        let two_q = substrate_return(film);
        Ok(Self { optics, two_q })
    }

    /// What the model was made of.
    pub fn optics(&self) -> &PaintOptics {
        &self.optics
    }

    /// The film.
    pub fn film(&self) -> &FilmOptics {
        self.optics.top()
    }

    /// Eq. 18's first term, the gloss of the surface; the others are [`FastModel::glitter`] and [`FastModel::shade`].
    ///
    /// # Errors
    /// As [`Gloss::new`]: not for what a composition may say.
    pub fn gloss(&self) -> Result<Gloss> {
        Gloss::new(self.index(), self.optics.roughness)
    }

    /// Index of the binder.
    pub fn index(&self) -> f64 {
        self.film().index
    }

    /// The kinds of flakes.
    pub fn kinds(&self) -> &[KindOptics] {
        &self.film().kinds
    }

    /// 2Q: the share of a Lambertian substrate's light that flakes and surface send back to it.
    pub fn two_q(&self) -> &Spectrum {
        &self.two_q
    }

    /// `x = [tau(bar theta) + tau(bar theta')] h`: optical thickness of the film along both rays.
    pub fn optical_thickness(&self, g: &Geometry) -> Spectrum {
        Spectrum(self.film().optical_thickness(g))
    }

    /// Eq. 36: mean BRDF of the flakes, 1/sr.
    pub fn glitter(&self, g: &Geometry) -> Spectrum {
        self.glitter_through(g, &self.optical_thickness(g))
    }

    fn glitter_through(&self, g: &Geometry, thickness: &Spectrum) -> Spectrum {
        let surface = g.transmission / self.film().index.powi(2);
        Spectrum(self.film().single_scattering(g, &thickness.0).map(|f| surface * f))
    }

    /// `[1-r][1-r'] / (4 eta^2 cos(bar theta) cos(bar theta'))`.
    pub fn surface_factor(&self, g: &Geometry) -> f64 {
        g.transmission / (4.0 * self.film().index.powi(2) * g.cos_inside[0] * g.cos_inside[1])
    }

    /// Eq. 28 over cos(theta): BRDF of the substrate seen through the film, 1/sr.
    pub fn shade(&self, g: &Geometry) -> Spectrum {
        self.shade_through(g, &self.optical_thickness(g))
    }

    /// [`FastModel::shade`] for unit directions outside; 0 unless both are above the horizon.
    pub fn shade_between(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        Geometry::new(wi, wo, self.index()).map_or(Spectrum::constant(0.0), |g| self.shade(&g))
    }

    fn shade_through(&self, g: &Geometry, thickness: &Spectrum) -> Spectrum {
        let factor = g.transmission / (self.film().index.powi(2) * PI);
        Spectrum(std::array::from_fn(|k| {
            let albedo = self.optics.albedo.0[k];
            factor * (-thickness.0[k]).exp() * albedo / (1.0 - albedo * self.two_q.0[k])
        }))
    }

    /// Glitter and shade, 1/sr, for unit directions outside, without gloss; 0 unless both are above the horizon.
    pub fn brdf(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        let Some(g) = Geometry::new(wi, wo, self.index()) else { return Spectrum::constant(0.0) };
        let thickness = self.optical_thickness(&g);
        let (glitter, shade) = (self.glitter_through(&g, &thickness), self.shade_through(&g, &thickness));
        Spectrum(std::array::from_fn(|k| glitter.0[k] + shade.0[k]))
    }

    /// [`FastModel::brdf`] as linear Rec.709.
    pub fn brdf_rgb(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        self.brdf(wi, wo).linear_rgb()
    }
}
