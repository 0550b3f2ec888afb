//! The octree of a slice: its occupied fine cells.
//!
//! A texel's key interleaves the bits of its lattice coordinates (Morton order), so that the sorted keys are the octree:
//! a cell of depth d is a run of keys with the same leading 3 d bits. Two more bits in front of them tell the body of the
//! slice from the brightest 2 % and 0.25 % of its texels, the sparkles, which keep leaves of their own. (The 99 % and 99.9 %
//! quantiles then lie inside a band. With bands of just 1 % and 0.1 % they lie where two boxes meet, and come out 3 % low.)
//!
//! The fine cells are those of the deepest level that has no more than a few thousand occupied ones: a rare outlier widens
//! the root cube but costs no resolution.

use super::lattice::{BITS, Cube};
use super::moments::Moments;

/// Where the band bits sit in a key.
const BAND_SHIFT: u32 = 3 * BITS;
/// Bands of lightness: body, brightest 2 %, brightest 0.25 %.
pub(super) const BANDS: usize = 3;
/// Depth that is looked at first.
const USUAL_DEPTH: u32 = 10;
/// Edge of a cell, Delta-E, below which no finer one is worth having.
const FINE_ENOUGH: f64 = 0.5;

/// An occupied cell of the octree.
pub(super) struct Cell {
    /// Band and Morton key, without the bits below the cell's depth.
    pub(super) key: u64,
    /// What lies in it.
    pub(super) moments: Moments,
    /// 0 body, 1 brightest 2 %, 2 brightest 0.25 % of the texels.
    pub(super) band: usize,
}

/// The cells of the deepest level with at most `most` occupied ones, in key order. `coordinates`: one plane an axis (L, a,
/// b), of equal length, each below 2^20.
pub(super) fn fine_cells(coordinates: &[Vec<u32>; 3], cube: &Cube, most: usize) -> Vec<Cell> {
    let mut keys = sorted_at_usual_depth(keys(coordinates));
    let mut depth = deepest(&keys, USUAL_DEPTH, most);
    if depth == USUAL_DEPTH && cube.step() * f64::from(1 << (BITS - USUAL_DEPTH)) > FINE_ENOUGH {
        keys.sort_unstable();
        depth = deepest(&keys, BITS, most);
    }
    cells(&keys, depth)
}

/// Band and Morton order of every texel.
fn keys([l, a, b]: &[Vec<u32>; 3]) -> Vec<u64> {
    let [bright, brightest] = sparkle_thresholds(l);
    l.iter()
        .zip(a)
        .zip(b)
        .map(|((l, a), b)| {
            let band = u64::from(*l > bright) + u64::from(*l > brightest);
            band << BAND_SHIFT | spread(*l) << 2 | spread(*a) << 1 | spread(*b)
        })
        .collect()
}

/// Lightness above which at most 2 % and 0.25 % of the texels lie.
fn sparkle_thresholds(lightness: &[u32]) -> [u32; 2] {
    let mut sorted = lightness.to_vec();
    let n = sorted.len();
    let (_, bright, above) = sorted.select_nth_unstable(n - 1 - n / 50);
    let bright = *bright;
    // The n / 50 texels above hold the n / 400 brightest.
    let brightest = match above.len() - n / 400 {
        0 => bright,
        rank => *above.select_nth_unstable(rank - 1).1,
    };
    [bright, brightest]
}

/// Moves bit k of a coordinate to bit 3 k.
#[inline]
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Inverse of [`spread`] for coordinates below 2^20; ignores the other bits.
#[inline]
fn gathered(x: u64) -> u32 {
    let mut x = x & 0x0249_2492_4924_9249;
    x = (x | x >> 2) & 0x10c3_0c30_c30c_30c3;
    x = (x | x >> 4) & 0x100f_00f0_0f00_f00f;
    x = (x | x >> 8) & 0x001f_0000_ff00_00ff;
    x = (x | x >> 16) & 0x001f_0000_0000_ffff;
    (x | x >> 32) as u32
}

/// Lattice point of a key.
#[inline]
fn point(key: u64) -> [u32; 3] {
    // Without the band, whose bits would be taken for coordinates.
    let morton = key & ((1 << BAND_SHIFT) - 1);
    [gathered(morton >> 2), gathered(morton >> 1), gathered(morton)]
}

/// Sorts by band and the first ten levels: three passes of a radix sort, from the least significant digit.
fn sorted_at_usual_depth(mut keys: Vec<u64>) -> Vec<u64> {
    const DIGIT: u32 = 11;
    let lowest = BAND_SHIFT + 2 - 3 * DIGIT;
    let mut other = vec![0; keys.len()];
    for pass in 0..3 {
        let digit = |key: u64| (key >> (lowest + DIGIT * pass)) as usize & ((1 << DIGIT) - 1);
        let mut next = [0u32; 1 << DIGIT];
        for key in &keys {
            next[digit(*key)] += 1;
        }
        let mut sum = 0;
        for place in &mut next {
            (*place, sum) = (sum, sum + *place);
        }
        for key in &keys {
            let place = &mut next[digit(*key)];
            other[*place as usize] = *key;
            *place += 1;
        }
        std::mem::swap(&mut keys, &mut other);
    }
    keys
}

/// The deepest level up to `limit` with at most `most` occupied cells; the keys are sorted down to `limit`.
fn deepest(keys: &[u64], limit: u32, most: usize) -> u32 {
    let mut first_apart = [0usize; BITS as usize + 2];
    for pair in keys.windows(2) {
        // Depth at which the two lie in different cells for the first time: 0 in different bands, beyond the last if equal.
        let common = (pair[0] ^ pair[1]).leading_zeros().max(63 - BAND_SHIFT) - (63 - BAND_SHIFT);
        first_apart[common.div_ceil(3) as usize] += 1;
    }
    let mut cells = 1 + first_apart[0];
    let fits = |more: &&usize| {
        cells += **more;
        cells <= most
    };
    first_apart[1..=limit as usize].iter().take_while(fits).count() as u32
}

/// The occupied cells of a level; the keys are sorted down to it.
fn cells(keys: &[u64], depth: u32) -> Vec<Cell> {
    let shift = 3 * (BITS - depth);
    keys.chunk_by(|a, b| a >> shift == b >> shift)
        .map(|run| {
            let mut moments = Moments::EMPTY;
            for key in run {
                moments.add(point(*key));
            }
            Cell { key: run[0] >> shift, moments, band: (run[0] >> BAND_SHIFT) as usize }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Planes of a few hundred lattice points, many of them alike.
    fn planes() -> impl Strategy<Value = [Vec<u32>; 3]> {
        prop::collection::vec((0..1u32 << BITS, 0..64u32, 0..1u32 << BITS, any::<bool>()), 1..600).prop_map(
            |points| {
                let pick = |near: bool, x: u32| if near { 7 + x % 5 } else { x };
                let l = points.iter().map(|p| pick(p.3, p.0)).collect();
                let a = points.iter().map(|p| p.1).collect();
                let b = points.iter().map(|p| pick(p.3, p.2)).collect();
                [l, a, b]
            },
        )
    }

    proptest! {
        #[test]
        fn keys_give_back_their_points(l in 0..1u32 << BITS, a in 0..1u32 << BITS, b in 0..1u32 << BITS, band in 0..3u64) {
            let key = band << BAND_SHIFT | spread(l) << 2 | spread(a) << 1 | spread(b);
            prop_assert_eq!(point(key), [l, a, b]);
        }

        #[test]
        fn cells_hold_every_point_once(planes in planes(), most in 8..400usize) {
            let cube = Cube::around(&planes.clone().map(|p| p.iter().map(|x| *x as f32).collect()));
            let cells = fine_cells(&planes, &cube, most);
            prop_assert!(cells.len() <= most.max(BANDS));
            prop_assert!(cells.windows(2).all(|pair| pair[0].key < pair[1].key));
            let all = cells.iter().fold(Moments::EMPTY, |sum, cell| sum.merged(&cell.moments));
            prop_assert_eq!(all.count as usize, planes[0].len());
            for (axis, plane) in planes.iter().enumerate() {
                prop_assert_eq!(all.sum[axis], plane.iter().map(|x| u64::from(*x)).sum::<u64>());
                prop_assert_eq!(all.square[axis], plane.iter().map(|x| u64::from(*x).pow(2)).sum::<u64>());
            }
        }

        #[test]
        fn the_radix_sort_sorts_the_leading_levels(keys in prop::collection::vec(0..1u64 << 62, 0..500)) {
            let shift = 3 * (BITS - USUAL_DEPTH);
            let sorted = sorted_at_usual_depth(keys.clone());
            prop_assert!(sorted.windows(2).all(|pair| pair[0] >> shift <= pair[1] >> shift));
            let (mut ours, mut theirs) = (sorted, keys);
            ours.sort_unstable();
            theirs.sort_unstable();
            prop_assert_eq!(ours, theirs);
        }
    }

    #[test]
    fn an_outlier_costs_no_resolution() {
        let mut l: Vec<u32> = (0..1000).map(|k| k % 10).collect();
        l.push((1 << BITS) - 1);
        let planes = [l.clone(), vec![0; 1001], vec![0; 1001]];
        let cube = Cube::around(&[vec![0.0, 1e5], vec![0.0], vec![0.0]]);
        // Ten levels cannot tell 0 from 9 here.
        assert_eq!(fine_cells(&planes, &cube, 64).len(), 11);
    }

    #[test]
    fn sparkles_are_the_brightest_texels() {
        let l: Vec<u32> = (0..5000).map(|k| k * 7919 % 5000).collect();
        assert_eq!(sparkle_thresholds(&l), [4899, 4987]);
        // Ties at the threshold stay in the body; a single texel has no sparkle.
        assert_eq!(sparkle_thresholds(&[3; 5000]), [3, 3]);
        assert_eq!(sparkle_thresholds(&[3]), [3, 3]);
    }
}
