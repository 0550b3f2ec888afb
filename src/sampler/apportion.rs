//! Probabilities rounded to whole steps.

use super::exact::checked_sum;
use crate::error::Result;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// How many of equal steps each cluster gets, and what the rounding costs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Apportioned {
    /// Steps of each cluster.
    pub(super) counts: Vec<usize>,
    /// Clusters that have a probability but no step.
    pub(super) lost: Vec<usize>,
    /// Half the sum of the differences between the probabilities and those of the steps.
    pub(super) total_variation: f64,
}

impl Apportioned {
    /// Each cluster gets its share rounded to whole steps, at least one if the share is half a step or more. What is then
    /// missing or too much goes to, or comes from, the clusters with the largest error; a last step is taken only where
    /// there are more such clusters than steps.
    pub(super) fn new(probabilities: &[f64], steps: usize) -> Result<Self> {
        let total = checked_sum(probabilities)?;
        let shares: Vec<f64> = probabilities.iter().map(|p| p / total * steps as f64).collect();
        let counts = apportioned(&shares, steps);
        let errors = counts.iter().zip(&shares).map(|(n, share)| (*n as f64 - share).abs());
        let total_variation = 0.5 * errors.sum::<f64>() / steps as f64;
        let lost = (0..counts.len()).filter(|k| counts[*k] == 0 && shares[*k] > 0.0).collect();
        Ok(Self { counts, lost, total_variation })
    }
}

/// Whole numbers near `shares` that sum to `steps`; the shares do, up to rounding.
fn apportioned(shares: &[f64], steps: usize) -> Vec<usize> {
    let mut counts: Vec<usize> = shares.iter().map(|share| (share + 0.5).floor() as usize).collect();
    let surplus = |counts: &[usize], k: usize| counts[k] as f64 - shares[k];
    let sum: usize = counts.iter().sum();
    // Clusters with a step to spare come first, then those with the largest surplus.
    let giver =
        |counts: &[usize], k: usize| Turn { first: counts[k] > 1, error: surplus(counts, k), cluster: k };
    let taker = |counts: &[usize], k: usize| Turn { first: true, error: -surplus(counts, k), cluster: k };
    if sum > steps {
        let mut turns: BinaryHeap<Turn> =
            (0..counts.len()).filter(|k| counts[*k] > 0).map(|k| giver(&counts, k)).collect();
        for _ in steps..sum {
            let Some(Turn { cluster, .. }) = turns.pop() else { break };
            counts[cluster] -= 1;
            turns.extend((counts[cluster] > 0).then(|| giver(&counts, cluster)));
        }
    } else if sum < steps {
        let mut turns: BinaryHeap<Turn> = (0..counts.len()).map(|k| taker(&counts, k)).collect();
        for _ in sum..steps {
            let Some(Turn { cluster, .. }) = turns.pop() else { break };
            counts[cluster] += 1;
            turns.push(taker(&counts, cluster));
        }
    }
    counts
}

/// Whose turn it is to give or take a step: the largest.
struct Turn {
    first: bool,
    error: f64,
    cluster: usize,
}

impl Ord for Turn {
    fn cmp(&self, other: &Self) -> Ordering {
        let errors = || self.error.total_cmp(&other.error);
        self.first.cmp(&other.first).then_with(errors).then_with(|| other.cluster.cmp(&self.cluster))
    }
}

impl PartialOrd for Turn {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Turn {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Turn {}
