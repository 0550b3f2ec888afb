//! What a composition's films do to light at one encounter: extinction, flakes, pigments, and single scattering by flakes.
//!
//! Ershov, Kolchin & Myszkowski 2001, as corrected. Angles with a bar are inside the film, primes mark the incident ray.
//!
//! * extinction of a slanted ray per depth, eqs 10, 21:
//!   `tau h = (kappa h + sum D sigma_ext h + sum D<S>h <(1 - t_p) |cos alpha|>) / cos(bar theta)`, the average over flake
//!   normals at that ray;
//! * glitter, eq. 36: `D<S>h [1-r][1-r'] / (4 eta^2 cos' cos) (1 - exp(-x))/x r_p(alpha) P(beta)`,
//!   `x = [tau(bar theta) + tau(bar theta')] h`; for a film under others their boundaries and attenuation come on top.
//!
//! With a finite flake lobe, P is its convolution with the lobe ([`super::orientation`]), for what rays meet as for what they
//! send back: with P itself in the extinction, grazing light would return in a lobe from flat flakes that it hardly meets.

use super::flake_areas::FlakeAreas;
use super::flake_optics::FlakeOptics;
use super::geometry::Geometry;
use super::interception::Interception;
use super::orientation::{FlakeLobe, HalfVectorDensity, Orientation};
use super::pigment::PigmentOptics;
use crate::brdf::fresnel::transmitted;
use crate::color::{BANDS, Spectrum};
use crate::error::Result;
use crate::parallel::TryMap;
use crate::simulate::composition::{Composition, Film, FlakeKind};
use glam::DVec3;
use rayon::prelude::*;

/// What optics are prepared for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preparation {
    /// Many directions: tables of all that takes more than a microsecond, in some 10 ms a kind of flakes; 1e-9 of the peak,
    /// extinction by stacks 1e-4.
    #[default]
    Tables,
    /// A handful of directions, at once: what tables would hold is evaluated where asked. Averages over stacks take them from
    /// 32 angles and 48 flakes, which leaves some 1e-3 of the extinction where fringes are sharp.
    Direct,
}

/// One film, without its boundaries.
#[derive(Debug, Clone)]
pub struct FilmOptics {
    /// Index eta of the binder.
    pub index: f64,
    /// The kinds of flakes.
    pub kinds: Vec<KindOptics>,
    /// The kinds of pigments.
    pub pigments: Vec<PigmentOptics>,
    /// What it is prepared for.
    pub preparation: Preparation,
    /// `kappa h` of the binder.
    pub absorption: Spectrum,
    /// `kappa h + sum D sigma_ext h`.
    steady: [f64; BANDS],
}

/// One kind of flakes in a film.
#[derive(Debug, Clone)]
pub struct KindOptics {
    /// `D<S>h`.
    pub area_density: f64,
    /// Areas of the flakes.
    pub areas: FlakeAreas,
    /// P, the flakes' own.
    pub orientation: Orientation,
    /// Lobe of a flake over half vectors inside the binder; `None` for a perfect mirror.
    pub lobe: Option<FlakeLobe>,
    /// P as half vectors and rays find it.
    pub density: HalfVectorDensity,
    /// r_p, t_p.
    pub optics: FlakeOptics,
    interception: Interception,
    preparation: Preparation,
}

impl KindOptics {
    fn new(kind: &FlakeKind, index: f64, preparation: Preparation) -> Result<Self> {
        let orientation = kind.orientation()?;
        // Near the normal refraction shows a tilt inside `index` times as wide outside, where lifetimes are measured.
        let lobe = (kind.flake_lifetime_deg > 0.0)
            .then(|| FlakeLobe::new(kind.flake_lifetime_deg.to_radians() / index));
        let density = HalfVectorDensity::new(orientation.clone(), lobe)?;
        let optics = match preparation {
            Preparation::Tables => FlakeOptics::new(kind, index)?,
            Preparation::Direct => FlakeOptics::coarse(kind, index)?,
        };
        Ok(Self {
            area_density: kind.area_density,
            areas: FlakeAreas::of(kind),
            lobe,
            interception: Interception::new(&density, &optics, preparation)?,
            density,
            orientation,
            optics,
            preparation,
        })
    }

    /// r_p at an angle of incidence alpha on a flake, mean of all flakes.
    pub fn reflectance(&self, cos_alpha: f64) -> [f64; BANDS] {
        match self.preparation {
            Preparation::Tables => self.optics.reflectance(cos_alpha),
            Preparation::Direct => self.optics.exact_reflectance(cos_alpha),
        }
    }
}

impl FilmOptics {
    /// Optics of a film for many directions.
    ///
    /// # Errors
    /// What [`Composition::validate`] refuses; a table that misses its tolerance
    /// ([`Piecewise::fit`](super::piecewise::Piecewise::fit)).
    pub fn new(film: &Film) -> Result<Self> {
        Self::prepared(film, Preparation::Tables)
    }

    /// Optics of a film.
    ///
    /// # Errors
    /// As [`FilmOptics::new`].
    pub fn prepared(film: &Film, preparation: Preparation) -> Result<Self> {
        let kinds = film.flakes.par_iter().try_map(|kind| KindOptics::new(kind, film.index, preparation))?;
        let pigments = film
            .pigments
            .iter()
            .map(|pigment| PigmentOptics::new(pigment, film))
            .collect::<Result<Vec<_>>>()?;
        let absorption = Spectrum(film.absorption_per_mm.0.map(|kappa| kappa * film.thickness_um * 1e-3));
        let mut steady = absorption.0;
        for pigment in &pigments {
            steady.iter_mut().zip(&pigment.extinction.0).for_each(|(t, e)| *t += e);
        }
        Ok(Self { index: film.index, kinds, pigments, preparation, absorption, steady })
    }

    /// `tau h cos(bar theta)` at bar theta in [0, pi/2], radians: optical thickness of the film along the normal if every
    /// depth took as much light as it takes from a ray at this angle.
    pub fn extinction(&self, theta: f64) -> [f64; BANDS] {
        let mut sum = self.steady;
        for kind in &self.kinds {
            let taken = kind.interception.at(theta, &kind.optics);
            sum.iter_mut().zip(taken).for_each(|(s, t)| *s += kind.area_density * t);
        }
        sum
    }

    /// `x = [tau(bar theta) + tau(bar theta')] h`: optical thickness of the film along both rays.
    pub fn optical_thickness(&self, g: &Geometry) -> [f64; BANDS] {
        let [down, up] = g.theta_inside.map(|theta| self.extinction(theta));
        std::array::from_fn(|k| down[k] / g.cos_inside[0] + up[k] / g.cos_inside[1])
    }

    /// Eq. 36 at eta = 1, for the film alone: `D<S>h / (4 cos cos') (1 - exp(-x))/x sum r_p P`, 1/sr, for both directions
    /// inside it; `thickness` is x.
    pub fn single_scattering(&self, g: &Geometry, thickness: &[f64; BANDS]) -> [f64; BANDS] {
        let cosines = 4.0 * g.cos_inside[0] * g.cos_inside[1];
        let mut sum = [0.0; BANDS];
        for kind in &self.kinds {
            let factor = kind.area_density * kind.density.eval(g.beta) / cosines;
            for (s, r) in sum.iter_mut().zip(kind.reflectance(g.cos_alpha)) {
                *s += factor * r;
            }
        }
        std::array::from_fn(|k| sum[k] * mean_attenuation(thickness[k]))
    }
}

/// All films of a paint over their substrate.
#[derive(Debug, Clone)]
pub struct PaintOptics {
    /// The films, bottom to top, at least one.
    pub films: Vec<FilmOptics>,
    /// Albedo r_s of the Lambertian substrate.
    pub albedo: Spectrum,
    /// Width of the gloss, radians; 0 for a mirror.
    pub roughness: f64,
}

impl PaintOptics {
    /// Optics of a composition for many directions.
    ///
    /// # Errors
    /// As [`Composition::validate`] and [`FilmOptics::new`].
    pub fn new(composition: &Composition) -> Result<Self> {
        Self::prepared(composition, Preparation::Tables)
    }

    /// Optics of a composition.
    ///
    /// # Errors
    /// As [`PaintOptics::new`].
    pub fn prepared(composition: &Composition, preparation: Preparation) -> Result<Self> {
        composition.validate()?;
        let films = composition.films.par_iter();
        Ok(Self {
            films: films.map(|film| FilmOptics::prepared(film, preparation)).collect::<Result<_>>()?,
            albedo: composition.substrate.albedo.clone(),
            roughness: composition.surface.roughness_deg.to_radians(),
        })
    }

    /// The topmost film.
    pub fn top(&self) -> &FilmOptics {
        &self.films[self.films.len() - 1]
    }

    /// Mean BRDF of the flakes of all films that scattered once, 1/sr, for unit directions outside; 0 unless both are above
    /// the horizon.
    pub fn glitter(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        let mut sum = [0.0; BANDS];
        self.visit(wi, wo, |film, seen| {
            let scattered = film.single_scattering(&seen.geometry, &seen.thickness);
            let factor = seen.transmission / film.index.powi(2);
            for k in 0..BANDS {
                sum[k] += factor * (-seen.above[k]).exp() * scattered[k];
            }
        });
        Spectrum(sum)
    }

    /// Calls `f` for every film, topmost first, with what a pair of outer directions finds there; not at all unless both
    /// are above the horizon.
    pub fn visit(&self, wi: DVec3, wo: DVec3, mut f: impl FnMut(&FilmOptics, &FilmView)) {
        self.visit_with(wi, wo, |k, g| self.films[k].optical_thickness(g), |k, seen| f(&self.films[k], seen));
    }

    /// [`PaintOptics::visit`] with the optical thickness of film k along both rays from elsewhere; films are passed by their
    /// number, 0 at the bottom.
    pub fn visit_with(
        &self,
        wi: DVec3,
        wo: DVec3,
        thickness: impl Fn(usize, &Geometry) -> [f64; BANDS],
        mut f: impl FnMut(usize, &FilmView),
    ) {
        let mut transmission = 1.0;
        let mut above = [0.0; BANDS];
        let (mut index, mut cosines) = (1.0, [wi.z, wo.z]);
        for (k, film) in self.films.iter().enumerate().rev() {
            let Some(geometry) = Geometry::new(wi, wo, film.index) else { return };
            for cosine in cosines {
                transmission *= transmitted(cosine, film.index / index);
            }
            (index, cosines) = (film.index, geometry.cos_inside);
            let thickness = thickness(k, &geometry);
            f(k, &FilmView { geometry, transmission, thickness, above });
            above.iter_mut().zip(thickness).for_each(|(a, x)| *a += x);
        }
    }
}

/// What a pair of outer directions finds in a film.
#[derive(Debug, Clone)]
pub struct FilmView {
    /// The directions inside the film; its own `transmission` is that of a surface straight to air.
    pub geometry: Geometry,
    /// What passes all boundaries above the film, both ways.
    pub transmission: f64,
    /// Optical thickness of the film, both ways.
    pub thickness: [f64; BANDS],
    /// Optical thickness of all films above, both ways.
    pub above: [f64; BANDS],
}

/// `(1 - exp(-x))/x`: mean of exp(-x z) over z in [0, 1]. `x >= 0`.
pub fn mean_attenuation(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}
