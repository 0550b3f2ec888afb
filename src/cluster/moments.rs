//! Exact moments of a set of lattice points.

/// A lattice point: L, a, b of 20 bits each in one word, so that it moves in one piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Point(u64);

impl Point {
    /// Bits of a coordinate.
    pub(super) const BITS: u32 = 20;
    const MASK: u64 = (1 << Self::BITS) - 1;

    /// The point with these coordinates, below 2^20.
    pub(super) fn new([l, a, b]: [u32; 3]) -> Self {
        Self(u64::from(l) | u64::from(a) << Self::BITS | u64::from(b) << (2 * Self::BITS))
    }

    /// The coordinate on an axis.
    pub(super) fn on(self, axis: usize) -> u64 {
        self.0 >> (axis as u32 * Self::BITS) & Self::MASK
    }

    /// Whether the coordinate on an axis is above a threshold, below 2^20: `on(axis) > threshold` without moving the point.
    pub(super) fn is_above(self, axis: usize, threshold: u64) -> bool {
        let shift = axis as u32 * Self::BITS;
        self.0 & Self::MASK << shift > threshold << shift
    }
}

/// Count, sums and sums of squares per axis. Integers: 2^24 points of 20 bits fit exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Moments {
    pub(super) count: u64,
    sum: [u64; 3],
    square: [u64; 3],
}

impl Moments {
    /// Of no point.
    pub(super) const EMPTY: Self = Self { count: 0, sum: [0; 3], square: [0; 3] };

    pub(super) fn of(points: &[Point]) -> Self {
        let (mut sum, mut square) = ([0u64; 3], [0u64; 3]);
        for point in points {
            for axis in 0..3 {
                let x = point.on(axis);
                sum[axis] += x;
                square[axis] += x * x;
            }
        }
        Self { count: points.len() as u64, sum, square }
    }

    /// Of the union of two disjoint sets.
    pub(super) fn merged(&self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: [0, 1, 2].map(|axis| self.sum[axis] + other.sum[axis]),
            square: [0, 1, 2].map(|axis| self.square[axis] + other.square[axis]),
        }
    }

    /// Of what is left without a subset.
    pub(super) fn without(&self, other: &Self) -> Self {
        Self {
            count: self.count - other.count,
            sum: [0, 1, 2].map(|axis| self.sum[axis] - other.sum[axis]),
            square: [0, 1, 2].map(|axis| self.square[axis] - other.square[axis]),
        }
    }

    /// Mean per axis; the set is not empty.
    pub(super) fn mean(&self) -> [f64; 3] {
        self.sum.map(|s| s as f64 / self.count as f64)
    }

    /// The integers at or just below the means; the set is not empty.
    pub(super) fn floor_of_mean(&self) -> [u64; 3] {
        self.sum.map(|s| s / self.count)
    }

    /// Count times the sum of squared distances to the mean, per axis; exactly zero where all points agree.
    pub(super) fn scatter(&self) -> [u128; 3] {
        [0, 1, 2].map(|axis| {
            let sum = u128::from(self.sum[axis]);
            u128::from(self.count) * u128::from(self.square[axis]) - sum * sum
        })
    }

    /// Variance per axis.
    pub(super) fn variance(&self) -> [f64; 3] {
        let n = self.count as f64;
        self.scatter().map(|s| s as f64 / (n * n))
    }

    /// n sigma: the number of points times their standard deviation, all axes together.
    pub(super) fn error(&self) -> f64 {
        (self.scatter().iter().sum::<u128>() as f64).sqrt()
    }
}
