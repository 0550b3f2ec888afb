//! An exact sampler of constant expected cost: the cumulative distribution and a guide table into it (Chen & Asau 1974).

use crate::error::{Error, Result};

/// Cumulative row and guide table of one slice.
///
/// Resolution: the cumulative row is f32, and u is an odd multiple of 2^-24, so a probability is met within 2^-24 (6e-8),
/// and a cluster rarer than that may never be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct GuideTable {
    /// Probability of a cluster or one before it; the last is 1.
    cumulative: Vec<f32>,
    /// First candidate for each of 2^k equal parts of (0, 1).
    guide: Vec<u16>,
}

impl GuideTable {
    /// A table of the probabilities of clusters, in their order; they are scaled to sum to 1.
    ///
    /// # Errors
    /// No or more than 65,535 probabilities; one that is negative or no number; none above 0.
    pub fn new(probabilities: &[f64]) -> Result<Self> {
        let total = checked_sum(probabilities)?;
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = probabilities
            .iter()
            .map(|p| {
                sum += p;
                (sum / total) as f32
            })
            .collect();
        // From the last cluster with a probability on the row is 1 whatever the rounding.
        let last = probabilities.iter().rposition(|p| *p > 0.0).unwrap_or_default();
        cumulative[last..].fill(1.0);
        // A power of two: products with u are exact, so that a part never starts behind its first candidate.
        let parts = probabilities.len().next_power_of_two();
        let first = |part: usize| {
            let from = part as f32 / parts as f32;
            cumulative.partition_point(|c| *c <= from) as u16
        };
        let guide = (0..parts).map(first).collect();
        Ok(Self { cumulative, guide })
    }

    /// The first cluster whose cumulative probability exceeds u. u in (0, 1), values outside count as the nearest inside.
    #[inline]
    pub fn lookup(&self, u: f32) -> usize {
        let part = ((u * self.guide.len() as f32) as usize).min(self.guide.len() - 1);
        let mut k = usize::from(self.guide[part]);
        while u >= self.cumulative[k] && self.cumulative[k] < 1.0 {
            k += 1;
        }
        k
    }

    /// The cumulative row: ascending, the last entry 1.
    pub fn cumulative(&self) -> &[f32] {
        &self.cumulative
    }

    /// The first candidate for each of 2^k equal parts of (0, 1).
    pub fn guide(&self) -> &[u16] {
        &self.guide
    }
}

/// Sum of probabilities that can be sampled.
pub(super) fn checked_sum(probabilities: &[f64]) -> Result<f64> {
    let n = probabilities.len();
    if !(1..=usize::from(u16::MAX)).contains(&n) {
        return Err(Error::invalid("sampler", "number of clusters", n, "1 to 65535"));
    }
    if let Some(k) = probabilities.iter().position(|p| !(*p >= 0.0 && p.is_finite())) {
        let place = format!("sampler: cluster {k}");
        return Err(Error::invalid(place, "probability", probabilities[k], "0 or more, finite"));
    }
    let sum: f64 = probabilities.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(Error::invalid("sampler", "sum of probabilities", sum, "above 0, finite"));
    }
    Ok(sum)
}
