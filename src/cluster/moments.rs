//! Exact moments of a set of lattice points.

/// A lattice point: L, a, b.
pub(super) type Point = [u32; 3];

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
                let x = u64::from(point[axis]);
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
    pub(super) fn floor_of_mean(&self) -> Point {
        self.sum.map(|s| (s / self.count) as u32)
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
