//! From weights to a paint (Golla & Klein 2018, section 4.2).

use super::realization::Realization;
use super::weights::Weights;
use super::{Channels, Constituent, LobePath, Mix, MixFlakes, MixSlice, Path};
use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::error::{Error, Result};
use crate::paint::{FlakeLevel, Flakes, Paint};
use rayon::prelude::*;
use serde_json::json;

/// What a blend is made of besides its weights.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BlendOptions {
    /// How arcs go; none: [`Mix::path`].
    pub path: Option<Path>,
    /// What of the flakes goes.
    pub channels: Channels,
    /// The paint that keeps what does not go, below the number of paints.
    pub source: usize,
    /// Which lobes belong together.
    pub lobes: LobePath,
}

impl Mix {
    /// The paint at these weights, one a paint, summing to 1; weights outside [0, 1] extrapolate.
    ///
    /// A paint blended with weight 1 is itself to the bit (but for the bands of one that is itself a blend), and so is a
    /// quantity that all paints share. The mean of every slice is the linear blend of the ends' means.
    ///
    /// # Errors
    /// Weights that do not fit the number of paints, are outside [-1000, 1000], or do not sum to 1 within 1e-5.
    pub fn blend(&self, weights: &[f64]) -> Result<Paint> {
        self.blend_with(weights, &BlendOptions::default())
    }

    /// [`Mix::blend`] along another path, or of some channels only.
    ///
    /// # Errors
    /// As [`Mix::blend`]; a source that is no paint of the mix.
    pub fn blend_with(&self, weights: &[f64], options: &BlendOptions) -> Result<Paint> {
        let c = &self.constituents;
        if options.source >= c.len() {
            return Err(Error::invalid("blend", "source", options.source, format!("0 to {}", c.len() - 1)));
        }
        let w = Weights::new(weights, c.len())?;
        let only = Weights::only(options.source, c.len());
        let smooth = if options.channels == Channels::Lightness { &only } else { &w };
        let lobes: Vec<&[Lobe]> = c.iter().map(|p| p.lobes.as_slice()).collect();
        let names: Vec<_> = c.iter().map(|p| p.name.as_str()).collect();
        let path = options.path.unwrap_or(self.path);
        let realization = Realization::new(&w, path, options.channels, options.source);
        Ok(Paint {
            coat: smooth.coat(c, options.lobes),
            diffuse: smooth.linear(c.iter().map(|p| p.diffuse)),
            lobes: smooth.lobes(&lobes, options.lobes),
            colors: smooth.color_table(c)?,
            flakes: self.flakes.as_ref().map(|f| f.realized(&realization)),
            provenance: json!({ "made": "blend", "paints": names, "weights": weights, "path": path,
                "channels": options.channels, "carpaint": env!("CARGO_PKG_VERSION") }),
        })
    }

    /// The coat of the blend at these weights.
    ///
    /// # Errors
    /// As [`Mix::blend`].
    pub fn blended_coat(&self, weights: &[f64], options: &BlendOptions) -> Result<ClearCoat> {
        let w = Weights::new(weights, self.constituents.len())?;
        let only = Weights::only(options.source, self.constituents.len());
        let smooth = if options.channels == Channels::Lightness { &only } else { &w };
        Ok(smooth.coat(&self.constituents, options.lobes))
    }

    /// Share of the flakes' probability, 0 to 1, whose box would turn inside out on some axis at these weights (extrapolated
    /// past the narrower paint) if all boxes travel, and is kept flat there; mean over the slices of the finest level.
    ///
    /// # Errors
    /// As [`Mix::blend`].
    pub fn inverted_mass(&self, weights: &[f64]) -> Result<f64> {
        let w = Weights::new(weights, self.constituents.len())?;
        let Some(level) = self.flakes.as_ref().and_then(|f| f.levels.first()) else { return Ok(0.0) };
        let width = |s: &MixSlice, arc: usize, c: usize| {
            w.linear(s.boxes.iter().map(|b| f64::from(b[arc][1][c]) - f64::from(b[arc][0][c])))
        };
        // Widths below f32's resolution of a corner are none.
        let inverts = |s: &MixSlice, arc: usize| (0..3).any(|c| width(s, arc, c) < -1e-4);
        let mass = |s: &MixSlice| {
            let arcs = s.probabilities.iter().enumerate();
            arcs.filter(|(arc, _)| inverts(s, *arc)).map(|(_, p)| p).sum::<f64>()
        };
        let there = level.slices.iter().filter(|s| !s.is_left_out());
        Ok(there.clone().map(mass).sum::<f64>() / there.count().max(1) as f64)
    }
}

impl Weights {
    fn coat(&self, constituents: &[Constituent], path: LobePath) -> ClearCoat {
        let coats = constituents.iter().map(|c| c.coat);
        let gloss: Vec<Option<&Lobe>> = constituents.iter().map(|c| c.coat.gloss.as_ref()).collect();
        // That of a paint without weight is none: an end comes back as it is.
        let has_gloss = gloss.iter().zip(&self.0).any(|(lobe, weight)| lobe.is_some() && *weight != 0.0);
        ClearCoat {
            ior: self.linear(coats.clone().map(|c| c.ior)).clamp(1.0, 4.0),
            refracts: constituents[0].coat.refracts,
            mirror: self.linear(coats.map(|c| c.mirror)).clamp(0.0, 1.0),
            gloss: has_gloss.then(|| self.lobe(&gloss, path)),
        }
    }

    /// The color table, linear in Lab (section 4.2), texel by texel.
    fn color_table(&self, constituents: &[Constituent]) -> Result<ColorTable> {
        let tables: Vec<&ColorTable> = constituents.iter().map(|c| &c.colors).collect();
        let size = tables[0].size();
        let texels = (0..size[0] * size[1])
            .map(|k| self.color(&tables.iter().map(|t| t.texels()[k]).collect::<Vec<_>>()));
        let used = |k: usize| tables.iter().zip(&self.0).all(|(t, w)| *w == 0.0 || t.measured()[k]);
        ColorTable::new(size, texels.collect(), (0..size[0] * size[1]).map(used).collect())
    }
}

impl MixFlakes {
    fn realized(&self, realization: &Realization<'_>) -> Flakes {
        let level = |level: &super::MixLevel| FlakeLevel {
            pitch_mm: level.pitch_mm,
            slices: level
                .slices
                .par_iter()
                .map_init(Vec::new, |buffer, s| realization.slice(s, buffer))
                .collect(),
        };
        Flakes {
            grid: self.grid.clone(),
            missing: self.missing,
            size: self.size,
            texel_mm: self.texel_mm,
            levels: self.levels.iter().map(level).collect(),
            inverse_cdf_steps: self.inverse_cdf_steps,
            knots: self.knots,
        }
    }
}
