//! The inverse distribution function in equal steps (Golla & Klein 2018, section 3.2: 500 of them).

use super::exact::checked_sum;
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
        let total = checked_sum(probabilities)?;
        let shares: Vec<f64> = probabilities.iter().map(|p| p / total * steps as f64).collect();
        let counts = apportioned(&shares, steps);
        let row = counts.iter().enumerate().flat_map(|(k, n)| std::iter::repeat_n(k as u16, *n)).collect();
        let errors = counts.iter().zip(&shares).map(|(n, share)| (*n as f64 - share).abs());
        let total_variation = 0.5 * errors.sum::<f64>() / steps as f64;
        let lost = (0..counts.len()).filter(|k| counts[*k] == 0 && shares[*k] > 0.0).collect();
        Ok(Self { steps: row, lost, total_variation })
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

/// Whole numbers near `shares` that sum to `steps`; the shares do, up to rounding.
fn apportioned(shares: &[f64], steps: usize) -> Vec<usize> {
    let mut counts: Vec<usize> = shares.iter().map(|share| (share + 0.5).floor() as usize).collect();
    let surplus = |counts: &[usize], k: usize| counts[k] as f64 - shares[k];
    let mut sum: usize = counts.iter().sum();
    while sum > steps {
        // Clusters with a step to spare come first, then those with the largest surplus.
        let key = |k: &usize| (counts[*k] > 1, surplus(&counts, *k));
        let from = (0..counts.len()).filter(|k| counts[*k] > 0).max_by(|a, b| by_pair(key(a), key(b)));
        counts[from.unwrap_or_default()] -= 1;
        sum -= 1;
    }
    while sum < steps {
        let to = (0..counts.len()).min_by(|a, b| surplus(&counts, *a).total_cmp(&surplus(&counts, *b)));
        counts[to.unwrap_or_default()] += 1;
        sum += 1;
    }
    counts
}

fn by_pair(a: (bool, f64), b: (bool, f64)) -> std::cmp::Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}
