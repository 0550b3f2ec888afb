//! Dots by a blue-noise threshold: every dot for itself, by one number that its place has.
//!
//! The mask comes from void and cluster (Ulichney 1993, "The void-and-cluster method for dither array generation"): ranks of
//! a torus of 64 x 64 places such that, for every n, the places of the n lowest are spread evenly. A dot compares its
//! threshold with the coverages added up, so that one threshold decides between all inks and none can overlap.
//!
//! The order is green, red, blue, blank. What lies below a level is spread evenly: green, the brightest and most seen of the
//! three; green and red; and all ink against blank. Red and blue alone are differences of two such sets: these have little
//! power at low frequencies, too, but less order between neighbors.

use super::halftone::{Halftone, dots_of};
use super::separation::Separation;
use crate::error::Result;
use crate::math::hash::{pcg4d, unit};
use rayon::prelude::*;

/// Places along a side of the mask; a power of two.
const SIDE: usize = 64;
/// Places of the mask.
const PLACES: usize = SIDE * SIDE;
/// Width of the Gaussian that tells voids from clusters, places (Ulichney's choice).
const SIGMA: f64 = 1.5;
/// Primaries in the order in which coverages are added up.
const ORDER: [u8; 3] = [2, 1, 3];

/// The dots of a separation, every pixel `cell` x `cell` of them. Each dot depends on its own pixel alone.
///
/// A pixel is not rounded: as many of its dots are printed as have thresholds below its tone, which is the tone on average.
///
/// # Errors
/// A cell outside 1 to 32, more than [`MAX_DOTS`](super::MAX_DOTS) dots.
pub fn blue_noise(separation: &Separation, cell: usize, seed: u32) -> Result<Halftone> {
    let size = dots_of(separation.size(), cell)?;
    let mask = ThresholdMask::new(seed);
    let dot = |k: usize| {
        let (x, y) = (k % size[0], k / size[0]);
        primary(separation.tone(x / cell, y / cell), mask.threshold(x, y))
    };
    Halftone::new(size, (0..size[0] * size[1]).into_par_iter().map(dot).collect())
}

/// The primary whose interval of added coverages holds a threshold, 0 if none does.
fn primary(tone: [f64; 3], threshold: f64) -> u8 {
    let mut sum = 0.0;
    for primary in ORDER {
        sum += tone[usize::from(primary) - 1];
        if threshold < sum {
            return primary;
        }
    }
    0
}

/// Thresholds of dots: a torus of 64 x 64 ranks that repeats.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ThresholdMask {
    ranks: Vec<u16>,
    seed: u32,
}

impl ThresholdMask {
    /// The mask that a seed gives.
    pub fn new(seed: u32) -> Self {
        let mut points = Points::initial(seed);
        let initial = points.clone();
        let mut ranks = vec![0; PLACES];
        let count = points.is_on.iter().filter(|on| **on).count();
        for rank in (0..count).rev() {
            let place = points.tightest_cluster();
            points.toggle(place);
            ranks[place] = rank as u16;
        }
        points = initial;
        // Ulichney looks for clusters of blank places from the middle on: with this filter they are the voids of the others.
        for rank in count..PLACES {
            let place = points.largest_void();
            points.toggle(place);
            ranks[place] = rank as u16;
        }
        Self { ranks, seed }
    }

    /// Threshold of a dot, within (0, 1): its rank, and a random number between that and the next, lest repetitions of the mask
    /// round a tone alike.
    pub fn threshold(&self, column: usize, row: usize) -> f64 {
        let rank = self.ranks[row % SIDE * SIDE + column % SIDE];
        let within = unit(pcg4d([column as u32, row as u32, self.seed, 1])[0]);
        (f64::from(rank) + f64::from(within)) / PLACES as f64
    }
}

/// Places of the torus that are on, and how crowded each place is.
#[derive(Clone)]
struct Points {
    is_on: Vec<bool>,
    crowding: Vec<f64>,
    /// What a point adds to the place so many columns and rows away.
    filter: Vec<f64>,
}

impl Points {
    /// A tenth of all places, moved from clusters into voids until none moves any more.
    fn initial(seed: u32) -> Self {
        let distance = |k: usize| k.min(SIDE - k).pow(2) as f64;
        let filter = (0..PLACES)
            .map(|k| libm::exp(-(distance(k % SIDE) + distance(k / SIDE)) / (2.0 * SIGMA * SIGMA)))
            .collect();
        let mut points = Self { is_on: vec![false; PLACES], crowding: vec![0.0; PLACES], filter };
        for place in 0..PLACES {
            if unit(pcg4d([place as u32, 0, seed, 2])[0]) < 0.1 {
                points.toggle(place);
            }
        }
        // It always ends, as each move lowers the energy; the cap is against roundoff.
        for _ in 0..PLACES {
            let cluster = points.tightest_cluster();
            points.toggle(cluster);
            let void = points.largest_void();
            points.toggle(void);
            if void == cluster {
                break;
            }
        }
        points
    }

    fn toggle(&mut self, place: usize) {
        let sign = if self.is_on[place] { -1.0 } else { 1.0 };
        self.is_on[place] = !self.is_on[place];
        let (x, y) = (place % SIDE, place / SIDE);
        for (k, crowding) in self.crowding.iter_mut().enumerate() {
            let (dx, dy) = ((k + SIDE - x) % SIDE, (k / SIDE + SIDE - y) % SIDE);
            *crowding += sign * self.filter[dy * SIDE + dx];
        }
    }

    /// The most crowded place that is on.
    fn tightest_cluster(&self) -> usize {
        self.extreme(true, |a, b| a > b)
    }

    /// The least crowded place that is off.
    fn largest_void(&self) -> usize {
        self.extreme(false, |a, b| a < b)
    }

    /// The first place, on or off, whose crowding no other one beats.
    fn extreme(&self, on: bool, beats: impl Fn(f64, f64) -> bool) -> usize {
        let places = (0..PLACES).filter(|k| self.is_on[*k] == on);
        places
            .reduce(|best, k| if beats(self.crowding[k], self.crowding[best]) { k } else { best })
            .unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proof::InkLimit;

    #[test]
    fn every_rank_has_one_place_and_every_seed_its_mask() {
        let mask = ThresholdMask::new(7);
        let mut ranks = mask.ranks.clone();
        ranks.sort_unstable();
        assert!(ranks.iter().enumerate().all(|(k, rank)| k == usize::from(*rank)));
        assert_eq!(mask, ThresholdMask::new(7));
        assert_ne!(mask.ranks, ThresholdMask::new(8).ranks);
    }

    #[test]
    fn places_of_low_ranks_keep_apart() {
        let mask = ThresholdMask::new(1);
        let apart = |a: usize, b: usize| {
            let along = |d: usize| d.min(SIDE - d).pow(2);
            along((a % SIDE).abs_diff(b % SIDE)) + along((a / SIDE).abs_diff(b / SIDE))
        };
        let low: Vec<usize> = (0..PLACES).filter(|k| mask.ranks[*k] < 256).collect();
        let nearest = |a: &usize| low.iter().filter(|b| *b != a).map(|b| apart(*a, *b)).min().unwrap();
        // One of sixteen: hexagons would be sqrt(16 * 2 / sqrt(3)) = 4.3 apart; at random, a third have a neighbor within 1.5.
        assert!(low.iter().map(nearest).min().unwrap() > 4);
    }

    #[test]
    fn coverages_are_added_in_order() {
        let tone = [0.25, 0.5, 0.125];
        for (threshold, expected) in
            [(0.0, 2), (0.49, 2), (0.5, 1), (0.74, 1), (0.75, 3), (0.874, 3), (0.875, 0)]
        {
            assert_eq!(primary(tone, threshold), expected, "{threshold}");
        }
    }

    #[test]
    fn dots_are_the_same_on_any_number_of_threads() {
        let pixels: Vec<[f32; 3]> = (0..70 * 50).map(|k| [k as f32 / 7000.0, 0.2, 0.1]).collect();
        let separation = Separation::new([70, 50], &pixels, InkLimit::Scale).unwrap();
        let with = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| blue_noise(&separation, 2, 3).unwrap())
        };
        assert_eq!(with(1), with(8));
    }
}
