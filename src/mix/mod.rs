//! Coupled paints: every weight vector gives a paint, at once.
//!
//! Golla & Klein 2018, section 4: per slice an optimal transport between the clusters of two paints gives arcs `(x_ij,
//! (C_i, D_j))`; a realization keeps the probability x_ij and moves the box of the arc linearly from C_i to D_j (eqs 14,
//! 15). More paints are added one by one, each coupled to the realization at equal weights (section 4.3).

mod blend;
mod cells;
mod channels;
mod common;
mod couple;
mod couple_slice;
mod difference;
#[cfg(feature = "files")]
mod file;
mod groups;
mod lobes;
mod path;
mod realization;
mod weights;

pub use blend::BlendOptions;
pub use channels::{Channels, whitened};
pub use common::CommonForm;
pub use couple::{CoupleOptions, CoupleReport, add, couple};
#[cfg(feature = "files")]
pub use file::KIND;
pub use groups::Groups;
pub use lobes::LobePath;
pub use path::Path;
pub use weights::distance_weights;

use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::btf::AngleGrid;
use crate::cluster::SliceStatistics;
use crate::error::{Error, Result};
use crate::paint::{Knots, Layout, MissingSlice, check_smooth};
use crate::transport::Cost;
use glam::DVec3;
use serde_json::Value;

/// Two to eight paints, coupled.
#[derive(Debug, Clone, PartialEq)]
pub struct Mix {
    /// The paints, in the order of the weights.
    pub constituents: Vec<Constituent>,
    /// The coupled flakes; none if no paint has any.
    pub flakes: Option<MixFlakes>,
    /// The path that a blend takes unless another is asked for.
    pub path: Path,
    /// Ground cost of the coupling.
    pub cost: Cost,
    /// Distance from which on [`Path::Hybrid`] exchanges probability instead of moving a box, Delta-E.
    pub threshold: f64,
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
    /// Lobes.
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
    /// How random numbers follow the half vector, see [`crate::paint::Flakes::knots`]: the mean of the paints.
    pub knots: Option<Knots>,
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

/// Coupled statistics of one slice: arcs, or interpolatable clusters, as one array a quantity, since a blend runs through
/// all of them while a slider is dragged.
#[derive(Debug, Clone, PartialEq)]
pub struct MixSlice {
    /// Probability x_ij of every arc, the same at every weight, above 0; ascending lightness of the box at equal weights:
    /// the order in which u runs through the arcs at every weight, so that hue never jumps.
    ///
    /// None: the slice was left out of a paint, and is left out of every blend.
    pub probabilities: Vec<f64>,
    /// For each paint the box every arc is in at its end: smallest and largest corner, signed Lab.
    pub boxes: Vec<Vec<[[f32; 3]; 2]>>,
    /// For every arc, which paints are near each other.
    pub groups: Vec<Groups>,
    /// Mean of the slice for each paint, linear Rec.709, 1/sr; every blend is brought to the linear blend of these.
    pub means: Vec<DVec3>,
    /// Standard deviation an RGB channel of each paint's draws, before its gain, 1/sr.
    pub deviations: Vec<DVec3>,
    /// Gain of each paint: 1 but where a paint is itself a blend.
    pub gains: Vec<[f32; 3]>,
    /// Duality gap of the transports behind the arcs, units of the ground cost: 0 up to rounding proves the optimum.
    pub gap: f64,
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
        if !(self.threshold > 0.0 && self.threshold.is_finite()) {
            return Err(Error::invalid("mix", "threshold", self.threshold, "a finite number above 0"));
        }
        self.cost.validated().map_err(|e| e.within("mix"))?;
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
            knots: self.knots,
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
    /// Whether the slice was left out.
    pub fn is_left_out(&self) -> bool {
        self.probabilities.is_empty()
    }

    fn validate(&self, paints: usize) -> Result<()> {
        let arcs = self.probabilities.len();
        let lengths = [self.boxes.len(), self.means.len(), self.deviations.len(), self.gains.len()];
        if lengths.iter().any(|n| *n != paints) {
            return Err(Error::invalid(
                "",
                "boxes, means, deviations, gains",
                format!("{lengths:?}"),
                format!("{paints} of each"),
            ));
        }
        if arcs > Mix::MAX_ARCS {
            return Err(Error::invalid("", "arcs", arcs, "0 to 65535"));
        }
        if self.groups.len() != arcs || self.boxes.iter().any(|b| b.len() != arcs) {
            return Err(Error::invalid(
                "",
                "boxes and groups",
                "other numbers",
                format!("{arcs}, one an arc"),
            ));
        }
        for (k, (p, groups)) in self.probabilities.iter().zip(&self.groups).enumerate() {
            let place = || format!("arc {k}");
            if !(*p > 0.0 && *p <= 1.0 + 1e-9) {
                return Err(Error::invalid(place(), "probability", p, "above 0, up to 1"));
            }
            groups.validate(paints).map_err(|e| e.within(place()))?;
            for boxes in &self.boxes {
                SliceStatistics::check_corners(&boxes[k]).map_err(|e| e.within(place()))?;
            }
        }
        let clusters: usize = self.groups.iter().map(|groups| groups.count(paints)).sum();
        if clusters > SliceStatistics::MAX_CLUSTERS {
            let legal = format!("up to {}", SliceStatistics::MAX_CLUSTERS);
            return Err(Error::invalid("", "groups of all arcs", clusters, legal));
        }
        self.validate_moments()
    }

    fn validate_moments(&self) -> Result<()> {
        let sum: f64 = self.probabilities.iter().sum();
        if !self.is_left_out() && (sum - 1.0).abs() > 1e-9 {
            return Err(Error::invalid("", "sum of probabilities", sum, "1 within 1e-9"));
        }
        let most = f64::from(SliceStatistics::MAX_OFFSET);
        if let Some(mean) = self.means.iter().find(|m| !m.to_array().iter().all(|c| c.abs() <= most)) {
            return Err(Error::invalid("", "mean", mean, format!("numbers within +-{most:e}")));
        }
        if let Some(bad) =
            self.deviations.iter().find(|d| !d.to_array().iter().all(|c| (0.0..=most).contains(c)))
        {
            return Err(Error::invalid("", "deviation", bad, format!("0 to {most:e}")));
        }
        if let Some(bad) =
            self.gains.iter().find(|g| !g.iter().all(|c| (0.0..=SliceStatistics::MAX_GAIN).contains(c)))
        {
            let legal = format!("0 to {}", SliceStatistics::MAX_GAIN);
            return Err(Error::invalid("", "gain", format!("{bad:?}"), legal));
        }
        if !self.gap.is_finite() {
            return Err(Error::invalid("", "gap", self.gap, "a finite number"));
        }
        Ok(())
    }
}
