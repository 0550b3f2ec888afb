//! The texels of a slice, cut into a few hundred cells.
//!
//! A k-d tree: the cell of largest error n sigma (number of texels times their standard deviation in Lab; up to a factor the
//! Wasserstein-1 distance that it brings in) is cut in two at its mean, across its axis of largest variance, until there are
//! enough. A rare outlier costs a cut or two, no resolution; cells of one color are never cut.
//!
//! First of all the brightest texels are set apart, the sparkles: they are few, and the error alone would spend little on
//! them. The 99.9 % quantile lies in the middle of the second of their three bands, which is narrow: its box is short in
//! lightness, and lightness alone decides on luminance. Half a texel in a thousand is wide enough: with twice as much the
//! quantile is off by 1.4 % on the average of the fixtures in place of 0.9 %, with half as much by more where it is worst.

use super::moments::{Moments, Point};
use std::collections::BinaryHeap;
use std::ops::Range;

/// Bands of lightness: the body, and the sparkles in three.
pub(super) const BANDS: usize = 4;
/// A band of sparkles begins below the brightest 1 / this of the texels.
const BRIGHTEST: [usize; BANDS - 1] = [50, 800, 1333];

/// Texels that stay together.
pub(super) struct Cell {
    pub(super) moments: Moments,
    /// 0 the body; 1, 2, 3 the sparkles up to the brightest.
    pub(super) band: usize,
    /// Where they lie among the points.
    pub(super) points: Range<usize>,
}

/// Up to `most` cells, none empty, that hold every point once; the points are put into their order. At least `kept` cells
/// lie in each band if it has so many colors; if it is 0 everywhere, there is one band.
pub(super) fn cells(points: &mut [Point], most: usize, kept: [usize; BANDS]) -> Vec<Cell> {
    let mut cutter = Cutter { aside: points.to_vec(), points, cells: Vec::with_capacity(most) };
    let bands = if kept == [0; BANDS] { 0 } else { BANDS - 1 };
    cutter.bands(bands);
    for band in 0..cutter.cells.len() {
        let kept = kept[cutter.cells[band].band];
        cutter.cut(band..band + 1, kept.saturating_sub(1));
    }
    cutter.cut(0..cutter.cells.len(), most.saturating_sub(cutter.cells.len()));
    cutter.cells
}

struct Cutter<'a> {
    points: &'a mut [Point],
    aside: Vec<Point>,
    cells: Vec<Cell>,
}

impl Cutter<'_> {
    /// Starts with the body and so many bands of sparkles.
    fn bands(&mut self, sparkles: usize) {
        let thresholds = thresholds(self.points);
        let mut start = 0;
        for (band, threshold) in thresholds.into_iter().enumerate().take(sparkles) {
            let end = self.partition(start..self.points.len(), 0, threshold);
            self.push(Moments::of(&self.points[start..end]), band, start..end);
            start = end;
        }
        self.push(Moments::of(&self.points[start..]), sparkles, start..self.points.len());
    }

    fn push(&mut self, moments: Moments, band: usize, points: Range<usize>) {
        if !points.is_empty() {
            self.cells.push(Cell { moments, band, points });
        }
    }

    /// Makes so many more cells of those in `among`, or leaves nothing but single colors.
    fn cut(&mut self, among: Range<usize>, more: usize) {
        // Errors are not negative, so that their bits sort them.
        let entry = |cells: &[Cell], k: usize| (cells[k].moments.error().to_bits(), k);
        let mut heap: BinaryHeap<(u64, usize)> = among.map(|k| entry(&self.cells, k)).collect();
        for _ in 0..more {
            let Some((_, k)) = heap.pop().filter(|(error, _)| *error > 0) else {
                break;
            };
            self.halve(k);
            heap.push(entry(&self.cells, k));
            heap.push(entry(&self.cells, self.cells.len() - 1));
        }
    }

    /// Cuts a cell of more than one color: it keeps the lower half, the upper one comes last.
    fn halve(&mut self, k: usize) {
        let Cell { moments, band, ref points } = self.cells[k];
        let points = points.clone();
        let scatter = moments.scatter();
        let axis = (0..3).fold(0, |best, axis| if scatter[axis] > scatter[best] { axis } else { best });
        let middle = self.partition(points.clone(), axis, moments.floor_of_mean()[axis]);
        let (lower, upper) = (points.start..middle, middle..points.end);
        // Integers: what one half has not, the other has, exactly.
        let of_lower = if lower.len() < upper.len() {
            Moments::of(&self.points[lower.clone()])
        } else {
            moments.without(&Moments::of(&self.points[upper.clone()]))
        };
        self.push(moments.without(&of_lower), band, upper);
        self.cells[k] = Cell { moments: of_lower, band, points: lower };
    }

    /// Moves points above the threshold behind the others; returns the first of them.
    fn partition(&mut self, range: Range<usize>, axis: usize, threshold: u64) -> usize {
        let points = &mut self.points[range.clone()];
        let mut high = 0;
        // Both places are written, and one is kept: a branch would be guessed wrong half of the time.
        for k in 0..points.len() {
            let point = points[k];
            points[k - high] = point;
            self.aside[high] = point;
            high += usize::from(point.is_above(axis, threshold));
        }
        let low = points.len() - high;
        points[low..].copy_from_slice(&self.aside[..high]);
        range.start + low
    }
}

/// Lightness above which at most the brightest texels of each band lie.
fn thresholds(points: &[Point]) -> [u64; BANDS - 1] {
    let mut lightness: Vec<u32> = points.iter().map(|p| p.on(0) as u32).collect();
    let n = lightness.len();
    let rank = |share: usize| n - 1 - n / share;
    let first = rank(BRIGHTEST[0]);
    lightness.select_nth_unstable(first);
    lightness[first..].sort_unstable();
    BRIGHTEST.map(|share| u64::from(lightness[rank(share)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cells_hold_every_point_once(
            points in prop::collection::vec([0..1u32 << 20, 0..9u32, 0..1u32 << 20], 1..600),
            most in 8..400usize,
            kept in prop_oneof![Just([0; BANDS]), Just([1, 3, 1, 1])],
        ) {
            let mut points: Vec<Point> = points.into_iter().map(Point::new).collect();
            let mut before = points.clone();
            let cells = cells(&mut points, most, kept);
            prop_assert!(cells.len() <= most);
            let mut covered = 0;
            let mut order: Vec<&Cell> = cells.iter().collect();
            order.sort_by_key(|cell| cell.points.start);
            for cell in order {
                prop_assert_eq!(cell.points.start, covered);
                prop_assert!(!cell.points.is_empty());
                prop_assert_eq!(cell.moments, Moments::of(&points[cell.points.clone()]));
                covered = cell.points.end;
            }
            prop_assert_eq!(covered, points.len());
            before.sort_unstable();
            points.sort_unstable();
            prop_assert_eq!(before, points);
        }
    }

    #[test]
    fn an_outlier_costs_no_resolution() {
        let mut points: Vec<Point> = (0..1000).map(|k| Point::new([k % 10, 0, 0])).collect();
        points.push(Point::new([(1 << 20) - 1, 0, 0]));
        let cells = cells(&mut points, 64, [0; BANDS]);
        assert_eq!(cells.len(), 11);
        assert!(cells.iter().all(|cell| cell.moments.error() == 0.0));
    }

    #[test]
    fn sparkles_are_the_brightest_texels() {
        let points: Vec<Point> = (0..5000).map(|k| Point::new([k * 7919 % 5000, 0, 0])).collect();
        assert_eq!(thresholds(&points), [4899, 4993, 4996]);
        // Ties at the threshold stay in the body; a single texel has no sparkle.
        assert_eq!(thresholds(&[Point::new([3; 3]); 5000]), [3; 3]);
        assert_eq!(thresholds(&[Point::new([3; 3])]), [3; 3]);
    }

    #[test]
    fn bands_keep_their_cells() {
        let mut points: Vec<Point> = (0..10_000).map(|k| Point::new([k, k * 7919 % 9973 * 100, 0])).collect();
        let cells = cells(&mut points, 100, [1, 6, 2, 2]);
        let of = |band: usize| cells.iter().filter(|cell| cell.band == band).count();
        assert!(of(1) >= 6 && of(2) >= 2 && of(3) >= 2);
        assert_eq!(cells.len(), 100);
        let texels = |band: usize| -> u64 {
            cells.iter().filter(|cell| cell.band == band).map(|cell| cell.moments.count).sum()
        };
        assert_eq!([0, 1, 2, 3].map(texels), [9800, 188, 5, 7]);
    }
}
