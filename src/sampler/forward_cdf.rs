//! The forward distribution function, one number a cluster, found by bisection: the layout of Golla & Klein 2017.

use super::apportion::Apportioned;
use crate::error::Result;

/// The smallest sampler: two bytes a cluster.
///
/// Resolution: 2^-16, rounded as the steps of [`super::InverseCdf`] are. The probabilities of a slice of up to 65,536 texels,
/// a power of two, are met exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct ForwardCdf {
    /// First of 65,536 steps of each cluster, ascending; that of a cluster without a step is the next one's.
    starts: Vec<u16>,
    lost: Vec<usize>,
    total_variation: f64,
}

impl ForwardCdf {
    /// Steps of (0, 1).
    pub const STEPS: usize = 1 << 16;

    /// The row of the probabilities of clusters, in their order; they are scaled to sum to 1.
    ///
    /// # Errors
    /// Probabilities that [`super::GuideTable::new`] refuses.
    pub fn new(probabilities: &[f64]) -> Result<Self> {
        let Apportioned { counts, lost, total_variation } = Apportioned::new(probabilities, Self::STEPS)?;
        let mut start = 0;
        let starts = counts.iter().map(|count| {
            start += count;
            start - count
        });
        // Those after the last step have none.
        let starts = starts.map_while(|start| u16::try_from(start).ok()).collect();
        Ok(Self { starts, lost, total_variation })
    }

    /// The cluster at u; u in (0, 1), values outside count as the nearest inside.
    #[inline]
    pub fn lookup(&self, u: f32) -> usize {
        let step = ((u * Self::STEPS as f32) as usize).min(Self::STEPS - 1);
        self.starts.partition_point(|start| usize::from(*start) <= step) - 1
    }

    /// First step of each cluster up to the last that has one; ascending from 0.
    pub fn starts(&self) -> &[u16] {
        &self.starts
    }

    /// Clusters that have a probability but no step.
    pub fn lost(&self) -> &[usize] {
        &self.lost
    }

    /// Half the sum of the differences between the probabilities and those of the row.
    pub fn total_variation(&self) -> f64 {
        self.total_variation
    }
}
