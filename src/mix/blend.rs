//! From weights to a paint (Golla & Klein 2018, section 4.2).

use super::{Arc, Constituent, Mix, MixFlakes, MixSlice};
use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::cluster::{Cluster, SliceStatistics, mean_of_boxes};
use crate::color::{lab_from_rgb, rgb_from_lab};
use crate::error::{Error, Result};
use crate::paint::{FlakeLevel, Flakes, Paint};
use glam::DVec3;
use rayon::prelude::*;
use serde_json::json;

impl Mix {
    /// The paint at these weights, one a paint, summing to 1; weights outside [0, 1] extrapolate.
    ///
    /// Boxes move linearly in Lab (eqs 14, 15), color tables too; the mean of every slice is the linear blend of the ends'
    /// means. Coefficients and F0 are linear, roughness is geometric: linear in both would leave the legal range under
    /// extrapolation. A paint blended with weight 1 is itself to the bit, and so is a quantity that all paints share.
    ///
    /// # Errors
    /// Weights that do not fit the number of paints, are outside [-1000, 1000], or do not sum to 1 within 1e-5.
    pub fn blend(&self, weights: &[f64]) -> Result<Paint> {
        let w = Weights::new(weights, self.constituents.len())?;
        let c = &self.constituents;
        let lobes = (0..c.iter().map(|p| p.lobes.len()).max().unwrap_or(0))
            .map(|k| w.lobe(&c.iter().map(|p| p.lobes.get(k)).collect::<Vec<_>>()))
            .collect();
        let names: Vec<_> = c.iter().map(|p| p.name.as_str()).collect();
        Ok(Paint {
            coat: w.coat(c),
            diffuse: w.linear(c.iter().map(|p| p.diffuse)),
            lobes,
            colors: w.color_table(c)?,
            flakes: self.flakes.as_ref().map(|f| w.flakes(f)),
            provenance: json!({ "made": "blend", "paints": names, "weights": weights,
                "carpaint": env!("CARGO_PKG_VERSION") }),
        })
    }
}

impl Mix {
    /// Share of the flakes' probability, 0 to 1, whose box would turn inside out on some axis at these weights (extrapolated
    /// past the narrower paint) and is kept flat there; mean over the slices of the finest level.
    ///
    /// # Errors
    /// As [`Mix::blend`].
    pub fn inverted_mass(&self, weights: &[f64]) -> Result<f64> {
        let w = Weights::new(weights, self.constituents.len())?;
        let Some(level) = self.flakes.as_ref().and_then(|f| f.levels.first()) else { return Ok(0.0) };
        let inverts = |arc: &Arc| {
            let width =
                |c: usize| w.linear(arc.boxes.iter().map(|b| f64::from(b[1][c]) - f64::from(b[0][c])));
            // Widths below f32's resolution of a corner are none.
            (0..3).any(|c| width(c) < -1e-4)
        };
        let mass = |s: &MixSlice| s.arcs.iter().filter(|a| inverts(a)).map(|a| a.probability).sum::<f64>();
        Ok(level.slices.iter().map(mass).sum::<f64>() / level.slices.len() as f64)
    }
}

/// Checked weights that sum to 1.
struct Weights(Vec<f64>);

impl Weights {
    fn new(weights: &[f64], paints: usize) -> Result<Self> {
        if weights.len() != paints {
            return Err(Error::invalid("weights", "number", weights.len(), format!("{paints}, one a paint")));
        }
        if let Some(bad) = weights.iter().find(|w| w.is_nan() || w.abs() > 1e3) {
            return Err(Error::invalid("weights", "value", bad, "a number from -1000 to 1000"));
        }
        let sum: f64 = weights.iter().sum();
        // People type thirds as 0.333333; what is missing is shared out, so that no mean is lost.
        if (sum - 1.0).abs() > 1e-5 {
            return Err(Error::invalid("weights", "sum", sum, "1"));
        }
        let scale = if (sum - 1.0).abs() > 1e-12 { sum } else { 1.0 };
        Ok(Self(weights.iter().map(|w| w / scale).collect()))
    }

    /// Sum of weight times value. Values that all paints with a weight share come back as they are.
    fn linear(&self, values: impl Iterator<Item = f64> + Clone) -> f64 {
        let mut used = self.0.iter().zip(values.clone()).filter(|(w, _)| **w != 0.0).map(|(_, v)| v);
        match used.next() {
            Some(first) if used.all(|v| v == first) => first,
            _ => self.0.iter().zip(values).map(|(w, v)| w * v).sum(),
        }
    }

    /// Weighted geometric mean of positive values.
    fn geometric(&self, values: impl Iterator<Item = f64> + Clone) -> f64 {
        let mut used = self.0.iter().zip(values.clone()).filter(|(w, _)| **w != 0.0).map(|(_, v)| v);
        match used.next() {
            Some(first) if used.all(|v| v == first) => first,
            _ => self.0.iter().zip(values).map(|(w, v)| w * v.ln()).sum::<f64>().exp(),
        }
    }

    /// One lobe; a paint without it contributes nothing, at the roughness and F0 of the first that has it.
    fn lobe(&self, lobes: &[Option<&Lobe>]) -> Lobe {
        let absent =
            lobes.iter().flatten().next().map_or(Lobe { coefficient: 0.0, roughness: 1.0, f0: 0.0 }, |l| {
                Lobe { coefficient: 0.0, ..**l }
            });
        let all = lobes.iter().map(|l| l.copied().unwrap_or(absent));
        Lobe {
            coefficient: self.linear(all.clone().map(|l| l.coefficient)),
            // Extreme extrapolation stays within what a lobe may be.
            roughness: self.geometric(all.clone().map(|l| l.roughness)).clamp(1e-4, 100.0),
            f0: self.linear(all.map(|l| l.f0)).clamp(0.0, 1.0),
        }
    }

    fn coat(&self, constituents: &[Constituent]) -> ClearCoat {
        let coats = constituents.iter().map(|c| c.coat);
        let gloss: Vec<Option<&Lobe>> = constituents.iter().map(|c| c.coat.gloss.as_ref()).collect();
        ClearCoat {
            ior: self.linear(coats.clone().map(|c| c.ior)).clamp(1.0, 4.0),
            refracts: constituents[0].coat.refracts,
            mirror: self.linear(coats.map(|c| c.mirror)).clamp(0.0, 1.0),
            gloss: gloss.iter().any(Option::is_some).then(|| self.lobe(&gloss)),
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

    /// One color, linear in Lab; a color that all paints with a weight share comes back as it is.
    fn color(&self, colors: &[[f32; 3]]) -> [f32; 3] {
        let mut used = self.0.iter().zip(colors).filter(|(w, _)| **w != 0.0).map(|(_, c)| c);
        match used.next() {
            Some(first) if used.all(|c| c == first) => *first,
            _ => {
                let lab = self.vector(colors.iter().map(|c| lab_from_rgb(DVec3::from(c.map(f64::from)))));
                rgb_from_lab(lab).as_vec3().to_array()
            }
        }
    }

    fn vector(&self, values: impl Iterator<Item = DVec3>) -> DVec3 {
        self.0.iter().zip(values).map(|(w, v)| v * *w).sum()
    }

    fn flakes(&self, flakes: &MixFlakes) -> Flakes {
        let levels = flakes
            .levels
            .iter()
            .map(|level| FlakeLevel {
                pitch_mm: level.pitch_mm,
                slices: level.slices.par_iter().map(|s| self.slice(s)).collect(),
            })
            .collect();
        Flakes {
            grid: flakes.grid.clone(),
            missing: flakes.missing,
            size: flakes.size,
            texel_mm: flakes.texel_mm,
            levels,
            inverse_cdf_steps: flakes.inverse_cdf_steps,
            knot_spacing: flakes.knot_spacing,
        }
    }

    /// Moves every box (eqs 14, 15); neighbours in the order of u that end up in the same box become one cluster.
    fn slice(&self, slice: &MixSlice) -> SliceStatistics {
        let mut clusters: Vec<Cluster> = Vec::with_capacity(slice.arcs.len());
        for arc in &slice.arcs {
            let corner = |end: usize| -> [f32; 3] {
                std::array::from_fn(|c| self.linear(arc.boxes.iter().map(|b| f64::from(b[end][c]))) as f32)
            };
            let (mut min, mut max) = (corner(0), corner(1));
            for (low, high) in min.iter_mut().zip(&mut max).filter(|(low, high)| low > high) {
                // Past the narrower paint a box would turn inside out and grow again: it stays a point instead.
                *low = 0.5 * (*low + *high);
                *high = *low;
            }
            match clusters.last_mut() {
                Some(last) if last.min == min && last.max == max => last.probability += arc.probability,
                _ => clusters.push(Cluster { probability: arc.probability, min, max }),
            }
        }
        let mean = self.vector(slice.means.iter().copied());
        let offset = (mean - mean_of_boxes(&clusters)).as_vec3().to_array();
        SliceStatistics::new(clusters, offset)
    }
}
