//! From a few hundred cells to a few clusters: those two merge whose union adds least to the error, the sum of n sigma over
//! the clusters, until as many are left as wanted. What lies in the way of a cut comes together again.
//!
//! Measured on energetic slices of the eleven fixtures with flakes, 128 x 128, n = 50, Wasserstein-1 above its floor (Delta-E),
//! largest |ln| of the standard deviation and of the 99.9 % quantile of the luminance, means over fixtures, from 200 cells (from
//! 125, as it is, the merging costs a third, and two fixtures changed by 0.1 and 0.4, hardly beyond chance):
//!
//! | clusters | excess | std | q99.9 |
//! |---|---|---|---|
//! | these | 0.96 | 0.003 | 0.024 |
//! | k-means | 1.59 | 0.008 | 0.095 |
//! | Wu's quantizer | 1.85 | 0.013 | 0.110 |
//! | these with bounding boxes | 4.81 | 0.063 | 0.053 |
//! | another texture of the same paint | 4.4 | 0.10 | 0.13 |
//!
//! On the six hardest, cubes of an octree in place of cuts at the mean had half as much again to twice the excess. Other
//! criteria make no difference beyond chance (0.1): what correlation inside a box costs in place of sigma, other powers of n,
//! best cuts in place of cuts at the mean, cells moved between clusters afterwards. What is left is the limit of so many
//! boxes along the axes: it falls as n^-0.6, and needs 100 to 200 of them for half of it. Of the excess, 25 % goes if a box
//! has its members' own distribution along each axis, 30 % if it has their covariance, all of it if members are drawn. Boxes
//! a fifth narrower in a and b would save 13 to 20 %, but lose up to 5 % of the standard deviation of b.

use super::cells::{BANDS, Cell};
use super::moments::Moments;

/// Which of at most `n` clusters, none empty, each cell belongs to. A band of sparkles keeps at least as many clusters as
/// `kept` says; if that is 0 everywhere, there is one band.
pub(super) fn clusters(cells: &[Cell], n: usize, kept: [usize; BANDS]) -> Vec<usize> {
    if cells.len() <= n {
        return (0..cells.len()).collect();
    }
    let mut bands: Vec<Sets> = (0..BANDS).map(|band| Sets::of_band(cells, band)).collect();
    for _ in n..cells.len() {
        let open = bands.iter_mut().zip(kept).filter(|(sets, kept)| sets.count.len() > (*kept).max(1));
        let cheapest = open.map(|(sets, _)| (sets.cheapest(), sets)).min_by(|(x, _), (y, _)| x.total_cmp(y));
        let Some((cost, sets)) = cheapest else {
            break;
        };
        sets.merge_at(cost);
    }
    let (mut out, mut first) = (vec![0; cells.len()], 0);
    for sets in &bands {
        sets.cells.iter().zip(&sets.set).for_each(|(cell, set)| out[*cell] = first + *set as usize);
        first += sets.count.len();
    }
    out
}

/// The sets of a band as planes, so that a row of costs is one vector loop, and the cheapest partner of each. f32 is enough:
/// a cost decides between sets of hundreds of texels.
struct Sets {
    /// The cells of the band.
    cells: Vec<usize>,
    /// The set that each of them belongs to.
    set: Vec<u32>,
    count: Vec<f32>,
    mean: [Vec<f32>; 3],
    /// Sum of squared distances to the mean.
    scatter: Vec<f32>,
    /// n sigma.
    error: Vec<f32>,
    /// Least cost of a merger of each set, or less where its partner is lost; infinite for the only one.
    best: Vec<f32>,
    /// With whom.
    partner: Vec<u32>,
    row: Vec<f32>,
}

/// In place of a partner that is to be looked for.
const LOST: u32 = u32::MAX;

impl Sets {
    fn of_band(cells: &[Cell], band: usize) -> Self {
        let of_band = || cells.iter().enumerate().filter(|(_, cell)| cell.band == band);
        let mut sets = Self::with_room(of_band().count());
        of_band().for_each(|(k, cell)| sets.push(k, &cell.moments));
        sets
    }

    fn with_room(n: usize) -> Self {
        let plane = || Vec::with_capacity(n);
        Self {
            cells: Vec::with_capacity(n),
            set: Vec::with_capacity(n),
            count: plane(),
            mean: [plane(), plane(), plane()],
            scatter: plane(),
            error: plane(),
            best: plane(),
            partner: Vec::with_capacity(n),
            row: plane(),
        }
    }

    /// One more set, of one cell.
    fn push(&mut self, cell: usize, moments: &Moments) {
        let k = self.count.len();
        self.cells.push(cell);
        self.set.push(k as u32);
        self.count.push(moments.count as f32);
        self.mean.iter_mut().zip(moments.mean()).for_each(|(plane, mean)| plane.push(mean as f32));
        let error = moments.error();
        self.scatter.push((error * error / moments.count as f64) as f32);
        self.error.push(error as f32);
        self.best.push(f32::INFINITY);
        self.partner.push(LOST);
        self.row.push(f32::INFINITY);
        self.find_partner(k);
        self.offer(k);
    }

    /// The least cost of a merger, the partner being known. A lost partner is looked for only when it may matter: the other
    /// sets cost no less than when it was found, and the union that took it in has made its offer.
    fn cheapest(&mut self) -> f32 {
        loop {
            let cost = least(&self.best);
            let a = position(&self.best, cost);
            if self.partner[a] != LOST || cost == f32::INFINITY {
                return cost;
            }
            self.find_partner(a);
        }
    }

    /// Merges the pair of this cost, the cheapest; there are two sets or more.
    fn merge_at(&mut self, cost: f32) {
        let a = position(&self.best, cost);
        let b = self.partner[a] as usize;
        self.unite(a, b);
        let a = self.remove(a, b);
        self.find_partner(a);
        self.offer(a);
    }

    /// Makes `a`, whose costs are in `row`, the partner of those that have no cheaper one.
    fn offer(&mut self, a: usize) {
        for ((cost, best), partner) in self.row.iter().zip(&mut self.best).zip(&mut self.partner) {
            let better = cost < best;
            *partner = if better { a as u32 } else { *partner };
            *best = if better { *cost } else { *best };
        }
    }

    /// Set `a` takes in set `b`.
    fn unite(&mut self, a: usize, b: usize) {
        let (m, n) = (self.count[a], self.count[b]);
        let share = n / (m + n);
        let mut squared = 0.0;
        for plane in &mut self.mean {
            let difference = plane[b] - plane[a];
            squared += difference * difference;
            plane[a] += share * difference;
        }
        self.count[a] = m + n;
        self.scatter[a] += self.scatter[b] + m * share * squared;
        self.error[a] = (self.count[a] * self.scatter[a]).sqrt();
    }

    /// Puts the last set in the place of `b`, whose cells go to `a`; who had either for a partner has lost it. Returns where
    /// `a` is now.
    fn remove(&mut self, a: usize, b: usize) -> usize {
        let [x, y, z] = &mut self.mean;
        for plane in
            [&mut self.count, x, y, z, &mut self.scatter, &mut self.error, &mut self.best, &mut self.row]
        {
            plane.swap_remove(b);
        }
        self.partner.swap_remove(b);
        let (removed, last) = (b as u32, self.count.len() as u32);
        let kept = if a as u32 == last { removed } else { a as u32 };
        for partner in &mut self.partner {
            let lost = *partner == a as u32 || *partner == removed;
            let moved = if *partner == last { removed } else { *partner };
            *partner = if lost { LOST } else { moved };
        }
        for set in &mut self.set {
            let moved = if *set == last { removed } else { *set };
            *set = if *set == removed { kept } else { moved };
        }
        kept as usize
    }

    /// Finds the best partner of `a`; leaves the cost of every partner in `row`.
    fn find_partner(&mut self, a: usize) {
        let (m, scatter, error) = (self.count[a], self.scatter[a], self.error[a]);
        let [x, y, z] = [0, 1, 2].map(|axis| self.mean[axis][a]);
        let means = self.mean[0].iter().zip(&self.mean[1]).zip(&self.mean[2]);
        let others = self.count.iter().zip(&self.scatter).zip(&self.error).zip(means);
        for (cost, (((n, s), e), ((l, a), b))) in self.row.iter_mut().zip(others) {
            let squared = (l - x) * (l - x) + (a - y) * (a - y) + (b - z) * (b - z);
            // n sigma of the union: the square root of its count times its scatter.
            *cost = ((m + n) * (scatter + s) + m * n * squared).sqrt() - error - e;
        }
        self.row[a] = f32::INFINITY;
        self.best[a] = least(&self.row);
        self.partner[a] = position(&self.row, self.best[a]) as u32;
    }
}

/// The smallest of the costs; infinite if there are none.
fn least(costs: &[f32]) -> f32 {
    let smaller = |x: f32, y: f32| if y < x { y } else { x };
    // Eight at a time: a compiler must assume that the order of comparisons matters.
    let (chunks, rest) = costs.as_chunks::<8>();
    let lanes = chunks
        .iter()
        .fold([f32::INFINITY; 8], |lanes, chunk| std::array::from_fn(|k| smaller(lanes[k], chunk[k])));
    lanes.into_iter().chain(rest.iter().copied()).fold(f32::INFINITY, smaller)
}

/// Where this cost is first found.
fn position(costs: &[f32], cost: f32) -> usize {
    costs.iter().position(|c| *c == cost).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::super::cells::cells;
    use super::super::moments::Point;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_cluster_is_empty(
            points in prop::collection::vec([0..1000u32, 0..1000u32, 0..1000u32], 1..300),
            n in 4..200usize,
            kept in prop_oneof![Just([0; BANDS]), Just([1, 1, 1, 1])],
        ) {
            let mut points: Vec<Point> = points.into_iter().map(Point::new).collect();
            let cells = cells(&mut points, 3 * n, kept);
            let clusters = clusters(&cells, n, kept);
            prop_assert_eq!(clusters.len(), cells.len());
            let mut used = clusters;
            used.sort_unstable();
            used.dedup();
            prop_assert!(used.into_iter().eq(0..n.min(cells.len())));
        }
    }

    #[test]
    fn sparkles_keep_their_clusters() {
        // A body of large scatter and sparkles of little, which the error alone would leave one cluster.
        let body = (0..9000).map(|k| [k * 7919 % 1000 * 100, k * 104_729 % 997 * 100, 0]);
        let sparkles = (0..180).map(|k| [200_000 + k, 0, 0]);
        let mut points: Vec<Point> = body.chain(sparkles).map(Point::new).collect();
        let kept = [1, 3, 1, 1];
        let cells = cells(&mut points, 192, kept);
        let clusters = clusters(&cells, 48, kept);
        let band = |cluster: usize| clusters.iter().position(|c| *c == cluster).map(|k| cells[k].band);
        let of = |wanted: usize| (0..48).filter(|c| band(*c) == Some(wanted)).count();
        assert_eq!([0, 1, 2, 3].map(of), [43, 3, 1, 1]);
    }

    #[test]
    fn far_groups_come_apart() {
        let mut points: Vec<Point> = (0..30).map(|k| Point::new([k / 10 * 100_000 + k, 0, 0])).collect();
        let cells = cells(&mut points, 12, [0; BANDS]);
        let mut counts = [0; 3];
        let of_cells = clusters(&cells, 3, [0; BANDS]);
        of_cells.into_iter().zip(&cells).for_each(|(c, cell)| counts[c] += cell.moments.count);
        assert_eq!(counts, [10, 10, 10]);
    }
}
