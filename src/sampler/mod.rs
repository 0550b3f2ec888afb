//! From a uniform random number to a cluster, and to a color (Golla & Klein 2018, section 3.2).

mod apportion;
mod draw;
mod exact;
mod forward_cdf;
mod inverse_cdf;
#[cfg(feature = "files")]
mod quantile_row;
mod reconstruction;

pub use draw::{color, lab_in_box};
pub use exact::GuideTable;
pub use forward_cdf::ForwardCdf;
pub use inverse_cdf::InverseCdf;
#[cfg(feature = "files")]
pub use quantile_row::QuantileRow;
pub use reconstruction::{
    ReconstructionError, ReconstructionSamples, Spread, reconstruction_error, reconstruction_error_of,
};

use crate::cluster::{Ramp, SliceStatistics, ramps};
use crate::error::Result;

/// How a uniform number finds its cluster.
#[derive(Debug, Clone, PartialEq)]
pub enum Sampler {
    /// Guide table and cumulative row: exact, the default. The ramps behind the clusters, none without bands.
    Exact(GuideTable, Vec<Ramp>),
    /// Inverse CDF in equal steps: the form of Golla & Klein, which drops what is rarer than half a step.
    InverseCdf(InverseCdf),
    /// Forward CDF, found by bisection: the smallest, exact to 2^-16.
    ForwardCdf(ForwardCdf),
}

impl Sampler {
    /// The exact sampler of a slice.
    ///
    /// # Errors
    /// Probabilities that [`GuideTable::new`] refuses.
    pub fn exact(statistics: &SliceStatistics) -> Result<Self> {
        let ramps = ramps(&statistics.clusters, &statistics.fades);
        GuideTable::new(&probabilities(statistics)).map(|table| Self::Exact(table, ramps))
    }

    /// The inverse CDF of a slice in so many steps.
    ///
    /// # Errors
    /// What [`InverseCdf::new`] refuses.
    pub fn inverse_cdf(statistics: &SliceStatistics, steps: usize) -> Result<Self> {
        InverseCdf::new(&probabilities(statistics), steps).map(Self::InverseCdf)
    }

    /// The forward CDF of a slice.
    ///
    /// # Errors
    /// Probabilities that [`GuideTable::new`] refuses.
    pub fn forward_cdf(statistics: &SliceStatistics) -> Result<Self> {
        ForwardCdf::new(&probabilities(statistics)).map(Self::ForwardCdf)
    }

    /// Size of its tables, bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Exact(table, ramps) => {
                4 * table.cumulative().len() + 2 * table.guide().len() + 8 * ramps.len()
            }
            Self::InverseCdf(table) => 2 * table.steps().len(),
            Self::ForwardCdf(row) => 2 * row.starts().len(),
        }
    }

    /// The cluster at u; u in (0, 1), values outside count as the nearest inside.
    #[inline]
    pub fn lookup(&self, u: f32) -> usize {
        match self {
            Self::Exact(table, _) => table.lookup(u),
            Self::InverseCdf(table) => table.lookup(u),
            Self::ForwardCdf(row) => row.lookup(u),
        }
    }
}

fn probabilities(statistics: &SliceStatistics) -> Vec<f64> {
    statistics.clusters.iter().map(|c| c.probability).collect()
}
