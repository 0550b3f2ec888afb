//! What weights make of the groups of paints of an arc: the same for all arcs with the same groups.

use crate::mix::Groups;
use std::collections::HashMap;

/// As in mix/realization.rs.
const FADE: f64 = 0.2;

/// Legal weights of a blend, one a paint.
#[derive(Debug, Clone)]
pub(super) struct Weights {
    /// Summing to 1.
    pub all: Vec<f64>,
    /// Shares of the probability.
    pub shares: Vec<f64>,
    /// What weights are beyond shares: not 0 where the blend is extrapolated.
    pub beyond: Vec<f64>,
}

impl Weights {
    pub fn new(weights: &[f64]) -> Self {
        let sum: f64 = weights.iter().sum();
        let above: f64 = weights.iter().map(|w| w.max(0.0)).sum();
        let all: Vec<f64> = weights.iter().map(|w| w / sum).collect();
        let shares: Vec<f64> = weights.iter().map(|w| w.max(0.0) / above).collect();
        let beyond = all.iter().zip(&shares).map(|(w, share)| w - share).collect();
        Self { all, shares, beyond }
    }
}

/// The different groups of the arcs of a mix.
#[derive(Debug, Default)]
pub(super) struct Patterns {
    groups: Vec<Groups>,
    numbers: HashMap<u32, usize>,
}

impl Patterns {
    /// The number of these groups among the different ones.
    pub fn number(&mut self, groups: Groups) -> usize {
        *self.numbers.entry(groups.0).or_insert_with(|| {
            self.groups.push(groups);
            self.groups.len() - 1
        })
    }

    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Words of a pattern: their count, groups, overlaps of pairs.
    pub fn words(paints: usize) -> usize {
        1 + paints * (3 + paints) + paints * (paints - 1) / 2
    }

    /// Words of all patterns, as the shader reads them.
    pub fn at(&self, weights: &Weights, is_hybrid: bool) -> Vec<u32> {
        self.groups.iter().flat_map(|groups| pattern(*groups, weights, is_hybrid)).collect()
    }
}

/// A group of a pattern.
struct Part {
    /// Of the probability of the arc: its own, and with all before it.
    share: f64,
    end: f64,
    /// Share at its end of what lies behind.
    middle: f64,
    /// Of the paints' boxes.
    weights: Vec<f64>,
}

fn pattern(groups: Groups, weights: &Weights, is_hybrid: bool) -> Vec<u32> {
    let paints = weights.all.len();
    let parts = parts(groups, weights, is_hybrid);
    let mut words = vec![parts.len() as u32];
    for part in &parts {
        let numbers = [part.share, part.end, part.middle].into_iter().chain(part.weights.iter().copied());
        words.extend(numbers.map(|x| (x as f32).to_bits()));
    }
    words.resize(1 + paints * (3 + paints), 0);
    words.extend(overlaps(&parts).into_iter().map(|x| (x as f32).to_bits()));
    words.resize(Patterns::words(paints), 0);
    words
}

/// The groups that are there, in the order of u.
fn parts(groups: Groups, weights: &Weights, is_hybrid: bool) -> Vec<Part> {
    let paints = weights.all.len();
    if !is_hybrid || groups.is_one() {
        return vec![Part { share: 1.0, end: 1.0, middle: 0.5, weights: weights.all.clone() }];
    }
    let mut end = 0.0;
    let part = |group: usize| {
        let share: f64 = (0..paints).filter(|k| groups.of(*k) == group).map(|k| weights.shares[k]).sum();
        end += share;
        let weight = |k: usize| {
            let own = if groups.of(k) == group { weights.shares[k] / share } else { 0.0 };
            own + weights.beyond[k]
        };
        let weights = (0..paints).map(weight).collect();
        (share > 0.0).then(|| Part { share, end, middle: middle([end, (1.0 - end).max(0.0)]), weights })
    };
    (0..groups.count(paints)).filter_map(part).collect()
}

/// Twin of `Boundary::middle` of cluster/bands.rs, of sides relative to the arc.
fn middle([before, behind]: [f64; 2]) -> f64 {
    let cut = |side: f64| {
        let short = 1.0 - (side / FADE).sqrt();
        0.5 - 0.5 * short * short
    };
    if behind < FADE {
        cut(behind)
    } else if before < FADE {
        1.0 - cut(before)
    } else {
        0.5
    }
}

/// Integrals over an arc of probability 1 of the product of the shares of two parts: 1 and 0, 2 and 0, 2 and 1, 3 and 0 ...
///
/// The share of a part is the difference of two ramps, what lies behind its start and what lies behind its end; all rise by 1 over the
/// same width, in which lengths are counted here.
fn overlaps(parts: &[Part]) -> Vec<f64> {
    let width = 2.0 * FADE;
    let length = 1.0 / width;
    // Everything lies behind the first start, nothing behind the last end.
    let mut starts = vec![-1.0];
    starts.extend(parts.iter().map(|p| p.end / width - p.middle));
    if let Some(last) = starts.last_mut() {
        *last = length;
    }
    let both = |a: usize, b: usize| product(starts[a], starts[b], length);
    let pair = |j: usize, l: usize| both(l, j) - both(l, j + 1) - both(l + 1, j) + both(l + 1, j + 1);
    (1..parts.len()).flat_map(|j| (0..j).map(move |l| (j, l))).map(|(j, l)| width * pair(j, l)).collect()
}

/// Integral from 0 to `length` of two ramps that start at `a` and, no earlier, at `b`, and rise from 0 to 1 over a length of 1.
fn product(a: f64, b: f64, length: f64) -> f64 {
    let from = b.clamp(0.0, length);
    let full = (a + 1.0).clamp(from, length);
    let both_full = (b + 1.0).clamp(full, length);
    let rising = |t: f64| t * (t * (t / 3.0 - 0.5 * (a + b)) + a * b);
    let alone = |t: f64| 0.5 * (t - b) * (t - b);
    rising(full) - rising(from) + alone(both_full) - alone(full) + length - both_full
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of what lies behind the end of a part, `at` of the way through an arc.
    fn behind(part: &Part, at: f64) -> f64 {
        (part.middle + (at - part.end) / (2.0 * FADE)).clamp(0.0, 1.0)
    }

    #[test]
    fn shares_integrate_to_probabilities_and_products_to_overlaps() {
        let cases: [(u32, &[f64]); 5] = [
            (0x10, &[0.5, 0.5]),
            (0x01, &[0.97, 0.03]),
            (0x210, &[0.4, 0.3, 0.3]),
            (0x102, &[0.45, 0.1, 0.45]),
            (0x021, &[-0.4, 0.06, 1.34]),
        ];
        for (groups, weights) in cases {
            let parts = parts(Groups(groups), &Weights::new(weights), true);
            let n = 100_000;
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
            let share = |j: usize, at: f64| {
                let before = if j == 0 { 1.0 } else { behind(&parts[j - 1], at) };
                before - if j + 1 == parts.len() { 0.0 } else { behind(&parts[j], at) }
            };
            let integral = |f: &dyn Fn(f64) -> f64| (0..n).map(|k| f(at(k))).sum::<f64>() / f64::from(n);
            for (j, part) in parts.iter().enumerate() {
                // The midpoint rule: off by 1e-10 but for the ends of ramps, by 1e-5 squared at each.
                assert!((integral(&|u| share(j, u)) - part.share).abs() < 1e-8, "{weights:?} {j}");
                let sum: f64 = part.weights.iter().sum();
                assert!((sum - 1.0).abs() < 1e-12);
            }
            let mut seen = overlaps(&parts).into_iter();
            for j in 1..parts.len() {
                for l in 0..j {
                    let exact = integral(&|u| share(j, u) * share(l, u));
                    let overlap = seen.next().unwrap();
                    assert!((overlap - exact).abs() < 1e-8, "{weights:?} {j} {l}: {overlap} {exact}");
                }
            }
            assert_eq!(seen.next(), None);
        }
    }

    #[test]
    fn groups_without_weight_are_not_there() {
        let there = |weights: &[f64]| parts(Groups(0x210), &Weights::new(weights), true).len();
        assert_eq!([there(&[1.0, 0.0, 0.0]), there(&[0.0, 0.5, 0.5]), there(&[-0.5, 0.75, 0.75])], [1, 2, 2]);
        assert_eq!(parts(Groups(0x210), &Weights::new(&[0.2, 0.3, 0.5]), false).len(), 1);
    }
}
