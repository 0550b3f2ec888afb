//! From a uniform random number to a cluster, and to a color (Golla & Klein 2018, section 3.2).

mod draw;
mod exact;
mod inverse_cdf;
mod reconstruction;

pub use draw::{color, lab_in_box};
pub use exact::GuideTable;
pub use inverse_cdf::InverseCdf;
pub use reconstruction::{ReconstructionError, ReconstructionSamples, Spread, reconstruction_error};

use crate::cluster::SliceStatistics;
use crate::error::Result;

/// How a uniform number finds its cluster.
#[derive(Debug, Clone, PartialEq)]
pub enum Sampler {
    /// Guide table and cumulative row: exact, the default.
    Exact(GuideTable),
    /// Inverse CDF in equal steps: the form of Golla & Klein, which drops what is rarer than half a step.
    InverseCdf(InverseCdf),
}

impl Sampler {
    /// The exact sampler of a slice.
    ///
    /// # Errors
    /// Probabilities that [`GuideTable::new`] refuses.
    pub fn exact(statistics: &SliceStatistics) -> Result<Self> {
        GuideTable::new(&probabilities(statistics)).map(Self::Exact)
    }

    /// The inverse CDF of a slice in so many steps.
    ///
    /// # Errors
    /// What [`InverseCdf::new`] refuses.
    pub fn inverse_cdf(statistics: &SliceStatistics, steps: usize) -> Result<Self> {
        InverseCdf::new(&probabilities(statistics), steps).map(Self::InverseCdf)
    }

    /// The cluster at u; u in (0, 1), values outside count as the nearest inside.
    #[inline]
    pub fn lookup(&self, u: f32) -> usize {
        match self {
            Self::Exact(table) => table.lookup(u),
            Self::InverseCdf(table) => table.lookup(u),
        }
    }
}

fn probabilities(statistics: &SliceStatistics) -> Vec<f64> {
    statistics.clusters.iter().map(|c| c.probability).collect()
}
