//! Coupled paints: every weight vector gives a paint, at once.
//!
//! Golla & Klein 2018, section 4: per slice an optimal transport between the clusters of two paints gives arcs `(x_ij,
//! (C_i, D_j))`; a realization keeps the probability x_ij and moves the box of the arc linearly from C_i to D_j (eqs 14,
//! 15). More paints are added one by one, each coupled to the realization at equal weights (section 4.3).

mod blend;
mod couple;
mod difference;
#[cfg(feature = "files")]
mod file;

pub use couple::{CoupleReport, couple};
#[cfg(feature = "files")]
pub use file::KIND;

use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::btf::AngleGrid;
use crate::cluster::SliceStatistics;
use crate::error::{Error, Result};
use crate::paint::{Layout, MissingSlice, check_smooth};
use glam::DVec3;
use serde_json::Value;

/// Two to eight paints, coupled.
#[derive(Debug, Clone, PartialEq)]
pub struct Mix {
    /// The paints, in the order of the weights.
    pub constituents: Vec<Constituent>,
    /// The coupled flakes; none if no paint has any.
    pub flakes: Option<MixFlakes>,
}

/// What a mix keeps of one paint besides its clusters.
#[derive(Debug, Clone, PartialEq)]
pub struct Constituent {
    /// Name shown to the user, usually that of the file.
    pub name: String,
    /// The clear coat.
    pub coat: ClearCoat,
    /// Diffuse intensity.
    pub diffuse: f64,
    /// Lobes, by index matched to those of the other paints.
    pub lobes: Vec<Lobe>,
    /// Color table.
    pub colors: ColorTable,
    /// Provenance of the paint.
    pub provenance: Value,
}

/// Coupled flake statistics.
#[derive(Debug, Clone, PartialEq)]
pub struct MixFlakes {
    /// The common angle grid.
    pub grid: AngleGrid,
    /// What an angle pair without a slice gives.
    pub missing: MissingSlice,
    /// The common slice size, texels.
    pub size: [usize; 2],
    /// The common side of a texel, millimetres.
    pub texel_mm: f64,
    /// Steps of the inverse CDF table written for engines.
    pub inverse_cdf_steps: usize,
    /// Spacing of the knots over the projected half vector, see [`crate::paint::Flakes::knot_spacing`].
    pub knot_spacing: Option<f64>,
    /// Levels of detail, finest first.
    pub levels: Vec<MixLevel>,
}

/// One level of detail of a mix.
#[derive(Debug, Clone, PartialEq)]
pub struct MixLevel {
    /// Pitch of the random lattice, millimetres: the geometric mean over the paints, and the same for all weights, so that
    /// moving a slider never moves the lattice.
    pub pitch_mm: f64,
    /// Coupled statistics of every slice, in grid order.
    pub slices: Vec<MixSlice>,
}

/// Coupled statistics of one slice.
#[derive(Debug, Clone, PartialEq)]
pub struct MixSlice {
    /// Arcs in ascending lightness of their box at equal weights: the order in which u runs through them at every weight, so
    /// that hue never jumps.
    pub arcs: Vec<Arc>,
    /// Mean of the slice for each paint, linear Rec.709, 1/sr; every blend is brought to the linear blend of these.
    pub means: Vec<DVec3>,
    /// Duality gap of the transports behind the arcs, Lab units: 0 up to rounding proves the optimum.
    pub gap: f64,
}

/// An interpolatable cluster.
#[derive(Debug, Clone, PartialEq)]
pub struct Arc {
    /// Probability x_ij, the same at every weight, above 0.
    pub probability: f64,
    /// For each paint the box this arc is in at its end: smallest and largest corner, signed Lab.
    pub boxes: Vec<[[f32; 3]; 2]>,
}

impl Mix {
    /// Fewest and most paints.
    pub const PAINTS: std::ops::RangeInclusive<usize> = 2..=8;

    /// Most arcs of a slice: a row of an inverse CDF table has 16-bit entries.
    pub const MAX_ARCS: usize = SliceStatistics::MAX_CLUSTERS;

    /// # Errors
    /// Anything that is out of range or does not fit together, named.
    pub fn validate(&self) -> Result<()> {
        let n = self.constituents.len();
        if !Self::PAINTS.contains(&n) {
            return Err(Error::invalid("mix", "number of paints", n, "2 to 8"));
        }
        let refracts = self.constituents[0].coat.refracts;
        for c in &self.constituents {
            check_smooth(&c.coat, c.diffuse, &c.lobes).map_err(|e| e.within(&c.name))?;
            if c.coat.refracts != refracts {
                let legal = format!("{refracts}, as for {}", self.constituents[0].name);
                return Err(Error::invalid(&c.name, "refracting clear coat", c.coat.refracts, legal));
            }
        }
        self.flakes.as_ref().map_or(Ok(()), |f| f.validate(n)).map_err(|e| e.within("mix"))
    }
}

impl MixFlakes {
    fn layout(&self) -> Layout<'_> {
        Layout {
            grid: &self.grid,
            missing: self.missing,
            size: self.size,
            texel_mm: self.texel_mm,
            inverse_cdf_steps: self.inverse_cdf_steps,
            knot_spacing: self.knot_spacing,
            levels: self.levels.iter().map(|l| (l.pitch_mm, l.slices.len())).collect(),
        }
    }

    fn validate(&self, paints: usize) -> Result<()> {
        self.layout().validate()?;
        for (l, level) in self.levels.iter().enumerate() {
            for (k, slice) in level.slices.iter().enumerate() {
                slice.validate(paints).map_err(|e| e.within(format!("flakes: level {l}: slice {k}")))?;
            }
        }
        Ok(())
    }
}

impl MixSlice {
    fn validate(&self, paints: usize) -> Result<()> {
        if self.means.len() != paints || self.arcs.iter().any(|a| a.boxes.len() != paints) {
            let found = format!("{} means", self.means.len());
            return Err(Error::invalid("", "boxes and means", found, format!("{paints} of each")));
        }
        if !(1..=Mix::MAX_ARCS).contains(&self.arcs.len()) {
            return Err(Error::invalid("", "arcs", self.arcs.len(), "1 to 65535"));
        }
        for (k, arc) in self.arcs.iter().enumerate() {
            let place = || format!("arc {k}");
            if !(arc.probability > 0.0 && arc.probability <= 1.0 + 1e-9) {
                return Err(Error::invalid(place(), "probability", arc.probability, "above 0, up to 1"));
            }
            for corners in &arc.boxes {
                SliceStatistics::check_corners(corners).map_err(|e| e.within(place()))?;
            }
        }
        let sum: f64 = self.arcs.iter().map(|a| a.probability).sum();
        if (sum - 1.0).abs() > 1e-9 {
            return Err(Error::invalid("", "sum of probabilities", sum, "1 within 1e-9"));
        }
        let most = f64::from(SliceStatistics::MAX_OFFSET);
        if let Some(mean) = self.means.iter().find(|m| !m.to_array().iter().all(|c| c.abs() <= most)) {
            return Err(Error::invalid("", "mean", mean, format!("numbers within +-{most:e}")));
        }
        if !self.gap.is_finite() {
            return Err(Error::invalid("", "gap", self.gap, "a finite number"));
        }
        Ok(())
    }
}
