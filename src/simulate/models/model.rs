//! The mean BRDF of a paint, from whichever model: what synthesis, fits and checks are measured against.
//!
//! All models share the light that flakes scatter once ([`PaintOptics::glitter`], eq. 36 of Ershov 2001), so that explicit
//! flakes fit any of them; they differ in the rest: substrate, pigments, and all that is scattered more than once.
//!
//! * `fast`: eq. 28 alone; always low, by 1 % for a few flakes to nearly all far off the
//!   peak of dense ones over black (`benches/models.rs` prints where).
//! * `fast-corrected`: what the fast model drops (the true 2Q, light that flakes scatter onto the substrate and back to the
//!   surface, higher orders) from adding and doubling with as few nodes, modes and wavelengths as 5 % take. A series of
//!   corrected formulas was tried first: an exact 2Q and the diffuse transmission leave 16 % of wide, dense layers out.
//! * `full`: the same to any error.
//! * `auto`: `fast` where it agrees with `full` to the error asked for at the multi-angle instruments and a few directions
//!   out of their plane, else `full`.

use super::accuracy::Accuracy;
use super::fast_model::FastModel;
use super::full_model::{Energy, FullModel};
use super::gloss::Gloss;
use crate::brdf::ClearCoat;
use crate::color::{BANDS, Spectrum};
use crate::error::{Error, Result};
use crate::math::half_difference::spherical;
use crate::simulate::composition::Composition;
use crate::simulate::instrument::MULTI_ANGLE;
use crate::simulate::optics::film_optics::PaintOptics;
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// Which model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModelKind {
    /// The published fast model, as corrected: one film without pigments.
    Fast,
    /// The fast model with the terms it drops put back, to 5 %; any composition.
    FastCorrected,
    /// The full solution of the radiative transfer.
    Full,
    /// The cheapest of them that meets the error target.
    #[default]
    Auto,
}

/// How a composition is to be modelled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelOptions {
    /// Which model.
    pub kind: ModelKind,
    /// Error target of the full solution, of the BRDF relative to its value or to a thousandth of its peak; 1e-8 to 0.1.
    pub error: f64,
}

impl Default for ModelOptions {
    /// The cheapest model, to one percent.
    fn default() -> Self {
        Self { kind: ModelKind::default(), error: 1e-2 }
    }
}

/// A composition with its mean BRDF.
#[derive(Debug, Clone)]
pub struct Model {
    composition: Composition,
    optics: PaintOptics,
    gloss: Gloss,
    /// What was asked for.
    error: f64,
    rest: Rest,
}

/// Everything but gloss and singly scattering flakes.
#[derive(Debug, Clone)]
enum Rest {
    Fast(Box<FastModel>),
    Corrected(Box<FullModel>),
    Full(Box<FullModel>),
    /// Flakes alone: what they show is the same under any model.
    #[cfg(test)]
    Nothing,
}

impl Model {
    /// Prepares the model of a composition.
    ///
    /// # Errors
    /// As [`PaintOptics::new`]; an error target outside its range; a composition that the model asked for does not know.
    pub fn new(composition: &Composition, options: ModelOptions) -> Result<Self> {
        if !(1e-8..=0.1).contains(&options.error) {
            return Err(Error::invalid("model", "tolerance", options.error, "1e-8 to 0.1"));
        }
        let optics = PaintOptics::new(composition)?;
        let rest = Rest::new(&optics, options)?;
        Self::assemble(composition, optics, options.error, rest)
    }

    /// A model of the flakes alone, of any films.
    #[cfg(test)]
    pub(in crate::simulate) fn flakes_alone(composition: &Composition) -> Result<Self> {
        Self::assemble(composition, PaintOptics::new(composition)?, 0.0, Rest::Nothing)
    }

    fn assemble(composition: &Composition, optics: PaintOptics, error: f64, rest: Rest) -> Result<Self> {
        let gloss = Gloss::new(optics.top().index, optics.roughness)?;
        Ok(Self { composition: composition.clone(), optics, gloss, error, rest })
    }

    /// What is modelled.
    pub fn composition(&self) -> &Composition {
        &self.composition
    }

    /// The films' optics.
    pub fn optics(&self) -> &PaintOptics {
        &self.optics
    }

    /// Which model it is; never `Auto`.
    pub fn kind(&self) -> ModelKind {
        match &self.rest {
            Rest::Fast(_) => ModelKind::Fast,
            Rest::Corrected(_) => ModelKind::FastCorrected,
            Rest::Full(_) => ModelKind::Full,
            #[cfg(test)]
            Rest::Nothing => ModelKind::Auto,
        }
    }

    /// Mean BRDF of the flakes that scatter once, 1/sr, for unit directions outside; 0 unless both are above the horizon.
    pub fn glitter(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        self.optics.glitter(wi, wo)
    }

    /// The rest of the BRDF, 1/sr: without gloss.
    pub fn rest(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        match &self.rest {
            Rest::Fast(fast) => fast.shade_between(wi, wo),
            Rest::Corrected(full) | Rest::Full(full) => full.rest(wi, wo),
            #[cfg(test)]
            Rest::Nothing => Spectrum::constant(0.0),
        }
    }

    /// The coat of a paint that looks like this one: a mirror, or a gloss lobe as wide as that of the rough surface.
    pub fn coat(&self) -> ClearCoat {
        let index = self.optics.top().index;
        if self.gloss.is_mirror() {
            ClearCoat::ideal(index, false)
        } else {
            ClearCoat::rough(index, false, self.optics.roughness)
        }
    }

    /// Gloss of a rough surface, 1/sr; a mirror's is in its own direction alone, and left out.
    pub fn gloss(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.gloss.brdf(wi, wo)
    }

    /// The error to expect of a solved model, where it is larger than what was asked for ([`Settings::expected_error`](
    /// super::accuracy::Settings::expected_error)).
    pub fn missed_error(&self) -> Option<f64> {
        let (full, asked) = match &self.rest {
            Rest::Corrected(full) => (full, CORRECTED_ERROR),
            Rest::Full(full) => (full, self.error),
            _ => return None,
        };
        let expected = full.settings().expected_error;
        (expected > asked).then_some(expected)
    }

    /// Where the light goes that comes in at `theta`, radians, 0 to below pi/2.
    ///
    /// # Errors
    /// The fast model does not keep account of it.
    pub fn energy(&self, theta: f64) -> Result<Energy> {
        match &self.rest {
            Rest::Corrected(full) | Rest::Full(full) => Ok(full.energy(theta)),
            _ => Err(Error::unsupported("energy", "model", "fast", "fast-corrected or full")),
        }
    }

    /// Mean BRDF without gloss, 1/sr: glitter and rest.
    pub fn brdf(&self, wi: DVec3, wo: DVec3) -> Spectrum {
        let (glitter, rest) = (self.glitter(wi, wo), self.rest(wi, wo));
        Spectrum(std::array::from_fn::<_, BANDS, _>(|k| glitter.0[k] + rest.0[k]))
    }

    /// [`Model::brdf`] as linear Rec.709.
    pub fn brdf_rgb(&self, wi: DVec3, wo: DVec3) -> DVec3 {
        match &self.rest {
            Rest::Corrected(full) | Rest::Full(full) => {
                self.glitter(wi, wo).linear_rgb() + full.rest_rgb(wi, wo)
            }
            _ => self.brdf(wi, wo).linear_rgb(),
        }
    }
}

/// Error of the corrected fast model.
const CORRECTED_ERROR: f64 = 0.05;

impl Rest {
    fn new(optics: &PaintOptics, options: ModelOptions) -> Result<Self> {
        let fast = || FastModel::from_optics(optics).map(|fast| Self::Fast(Box::new(fast)));
        let solved = |error: f64| FullModel::new(optics, &Accuracy { error }).map(Box::new);
        match options.kind {
            ModelKind::Fast => fast(),
            ModelKind::FastCorrected => solved(CORRECTED_ERROR).map(Self::Corrected),
            ModelKind::Full => solved(options.error).map(Self::Full),
            // Half of the error for the solution, half for the distance to it.
            ModelKind::Auto => {
                let full = solved(0.5 * options.error)?;
                match FastModel::from_optics(optics) {
                    Ok(fast) if agree(&fast, &full, 0.5 * options.error) => Ok(Self::Fast(Box::new(fast))),
                    _ => Ok(Self::Full(full)),
                }
            }
        }
    }
}

/// Whether the fast model is within `error` of the full one at every wavelength, at the multi-angle instruments and at pairs
/// of flat and steep directions in and out of the plane.
fn agree(fast: &FastModel, full: &FullModel, error: f64) -> bool {
    let polar = [0.2, 0.8, 1.2];
    let pairs = polar.iter().flat_map(|a| polar.map(|b| (*a, b)));
    let others =
        pairs.flat_map(|(a, b)| [0.0, FRAC_PI_2, PI].map(|phi| (spherical(a, 0.0), spherical(b, phi))));
    MULTI_ANGLE.iter().map(|reading| reading.directions()).chain(others).all(|(wi, wo)| {
        let (a, b) = (fast.brdf(wi, wo), full.brdf(wi, wo));
        a.0.iter().zip(&b.0).all(|(a, b)| (a - b).abs() <= error * b)
    })
}
