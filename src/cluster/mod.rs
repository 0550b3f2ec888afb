//! Per-slice statistics: a few cuboid clusters in signed Lab with their probabilities (Golla & Klein 2018, section 3.2).

mod bands;
mod cells;
mod deviation;
mod hermite;
mod lattice;
mod levels;
mod mean;
mod moments;
mod reduction;
mod slice;
mod statistics;

pub use bands::{Ramp, ramps};
pub use deviation::deviation_of_draws;
pub(crate) use hermite::Series;
pub use levels::{LevelStatistics, cluster_levels};
pub use mean::mean_of_boxes;
pub use slice::{DEFAULT_CLUSTERS, MAX_CLUSTERS, cluster_slice};
pub use statistics::{BoxRule, Cluster, SliceStatistics};
