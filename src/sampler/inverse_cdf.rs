//! The inverse distribution function in equal steps (Golla & Klein 2018, section 3.2: 500 of them).

use super::apportion::Apportioned;
use crate::error::{Error, Result};

/// A row of the inverse CDF texture, and what its rounding costs.
#[derive(Debug, Clone, PartialEq)]
pub struct InverseCdf {
    steps: Vec<u16>,
    lost: Vec<usize>,
    total_variation: f64,
}

impl InverseCdf {
    /// Steps used by Golla & Klein.
    pub const DEFAULT_STEPS: usize = 500;
    /// Most steps.
    pub const MAX_STEPS: usize = 65_535;

    /// The table of `steps` equal steps for the probabilities of clusters in their order, scaled to sum to 1.
    ///
    /// Each cluster gets its share rounded to whole steps, at least one if the share is half a step or more. What is then
    /// missing or too much goes to, or comes from, the clusters with the largest error; a last step is taken only where
    /// there are more such clusters than steps.
    ///
    /// # Errors
    /// Steps outside 1-65,535; probabilities that [`super::GuideTable::new`] refuses.
    pub fn new(probabilities: &[f64], steps: usize) -> Result<Self> {
        if !(1..=Self::MAX_STEPS).contains(&steps) {
            return Err(Error::invalid("inverse CDF", "steps", steps, "1 to 65535"));
        }
        let Apportioned { counts, lost, total_variation } = Apportioned::new(probabilities, steps)?;
        let steps = counts.iter().enumerate().flat_map(|(k, n)| std::iter::repeat_n(k as u16, *n)).collect();
        Ok(Self { steps, lost, total_variation })
    }

    /// The cluster at u; u in (0, 1), values outside count as the nearest inside.
    #[inline]
    pub fn lookup(&self, u: f32) -> usize {
        let step = (u * self.steps.len() as f32) as usize;
        usize::from(self.steps[step.min(self.steps.len() - 1)])
    }

    /// The cluster of each step, ascending.
    pub fn steps(&self) -> &[u16] {
        &self.steps
    }

    /// Clusters that have a probability but no step.
    pub fn lost(&self) -> &[usize] {
        &self.lost
    }

    /// Half the sum of the differences between the probabilities and those of the table.
    pub fn total_variation(&self) -> f64 {
        self.total_variation
    }
}
