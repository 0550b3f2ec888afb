//! Exact moments of a set of lattice points.

/// Count, sums, sums of squares and extremes per axis (L, a, b). Integers: 2^24 points of 20 bits fit exactly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moments {
    pub(super) count: u64,
    pub(super) sum: [u64; 3],
    pub(super) square: [u64; 3],
    pub(super) min: [u32; 3],
    pub(super) max: [u32; 3],
}

impl Moments {
    /// Of no point.
    pub(super) const EMPTY: Self =
        Self { count: 0, sum: [0; 3], square: [0; 3], min: [u32::MAX; 3], max: [0; 3] };

    /// Takes one point in.
    #[inline]
    pub(super) fn add(&mut self, point: [u32; 3]) {
        self.count += 1;
        for (axis, x) in point.into_iter().enumerate() {
            self.sum[axis] += u64::from(x);
            self.square[axis] += u64::from(x) * u64::from(x);
            self.min[axis] = self.min[axis].min(x);
            self.max[axis] = self.max[axis].max(x);
        }
    }

    /// Of the union of two disjoint sets.
    pub(super) fn merged(mut self, other: &Self) -> Self {
        self.count += other.count;
        for axis in 0..3 {
            self.sum[axis] += other.sum[axis];
            self.square[axis] += other.square[axis];
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
        self
    }

    /// Mean per axis; the set is not empty.
    pub(super) fn mean(&self) -> [f64; 3] {
        self.sum.map(|s| s as f64 / self.count as f64)
    }

    /// Variance per axis; exactly zero where all points agree.
    pub(super) fn variance(&self) -> [f64; 3] {
        let n = u128::from(self.count);
        [0, 1, 2].map(|axis| {
            let sum = u128::from(self.sum[axis]);
            (n * u128::from(self.square[axis]) - sum * sum) as f64 / (n * n) as f64
        })
    }
}
