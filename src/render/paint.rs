//! A paint prepared for rendering: f32, samplers built.

use super::flakes::RenderFlakes;
use super::proposal::Proposal;
use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::error::Result;
use crate::paint::Paint;

/// A [`Paint`] as the renderer and its shader twin read it.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderPaint {
    /// The clear coat.
    pub coat: RenderCoat,
    /// Diffuse intensity a.
    pub diffuse: f32,
    /// Cook-Torrance lobes.
    pub lobes: Vec<Lobe<f32>>,
    /// The color table chi.
    pub colors: ColorTable,
    /// The flakes, if any.
    pub flakes: Option<RenderFlakes>,
    pub(crate) proposal: Proposal,
}

/// A [`ClearCoat`] in f32.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderCoat {
    /// Index of refraction, 1 to 4.
    pub ior: f32,
    /// Whether the base is seen along refracted directions.
    pub refracts: bool,
    /// Share of the ideal mirror reflection, 0 to 1.
    pub mirror: f32,
    /// Gloss lobe.
    pub gloss: Option<Lobe<f32>>,
}

impl RenderPaint {
    /// Prepares a paint.
    ///
    /// # Errors
    /// As [`Paint::validate`].
    pub fn new(paint: &Paint) -> Result<Self> {
        paint.validate()?;
        let coat = RenderCoat::new(&paint.coat);
        let lobes: Vec<_> = paint.lobes.iter().map(lobe).collect();
        Ok(Self {
            coat,
            diffuse: paint.diffuse as f32,
            proposal: Proposal::new(&coat, paint.diffuse as f32, &lobes),
            lobes,
            colors: paint.colors.clone(),
            flakes: paint.flakes.as_ref().map(RenderFlakes::new).transpose()?,
        })
    }

    /// The same paint with its flakes left out: the mean that the smooth part carries.
    #[must_use]
    pub fn without_flakes(self) -> Self {
        Self { flakes: None, ..self }
    }
}

impl RenderCoat {
    /// A coat in f32.
    pub fn new(coat: &ClearCoat) -> Self {
        Self {
            ior: coat.ior as f32,
            refracts: coat.refracts,
            mirror: coat.mirror as f32,
            gloss: coat.gloss.as_ref().map(lobe),
        }
    }
}

fn lobe(lobe: &Lobe) -> Lobe<f32> {
    Lobe {
        coefficient: lobe.coefficient as f32,
        // A roughness that f32 rounds to 0 would be no lobe at all.
        roughness: (lobe.roughness as f32).max(1e-6),
        f0: lobe.f0 as f32,
    }
}
