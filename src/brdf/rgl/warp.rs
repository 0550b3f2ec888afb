//! Warps of the unit square by bilinear densities, marginal and conditional (Dupuy & Jakob 2018, section 4).
//!
//! A density p is bilinear between n x m nodes of the unit square. `(x, y)` goes to `(X, Y)`, Y the distribution function of the
//! marginal density of y, X that of the density of x at this y: both are integrals of straight lines. Between the densities of two
//! angles of incidence p is mixed, not the warp.

/// A density, integrating to 1 over the square when cells have area 1 (n - 1 by m - 1 of them).
pub(super) struct Density {
    /// Columns (x) and rows (y) of nodes, each 2 or more.
    size: [usize; 2],
    /// Row by row.
    values: Vec<f64>,
    /// Integral along each row up to each node.
    along_row: Vec<f64>,
    /// Integral over the rows below each row.
    below: Vec<f64>,
}

impl Density {
    /// A density from values at its nodes, row by row, none negative; the same everywhere if all are 0.
    pub fn new(size: [usize; 2], values: &[f32]) -> Self {
        let [n, m] = size;
        let mut values: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        if values.iter().all(|v| *v == 0.0) {
            values.fill(1.0);
        }
        let mut along_row = vec![0.0; n * m];
        for row in 0..m {
            for x in 1..n {
                let k = row * n + x;
                along_row[k] = along_row[k - 1] + 0.5 * (values[k - 1] + values[k]);
            }
        }
        let mut below = vec![0.0; m];
        for row in 1..m {
            below[row] = below[row - 1] + 0.5 * (along_row[row * n - 1] + along_row[(row + 1) * n - 1]);
        }
        let total = below[m - 1];
        [&mut values, &mut along_row, &mut below].into_iter().flatten().for_each(|v| *v /= total);
        Self { size, values, along_row, below }
    }
}

/// A mix of two densities over the same nodes.
pub(super) struct Mixed<'a> {
    pub low: &'a Density,
    pub high: &'a Density,
    /// Weight of `high`, 0 to 1.
    pub part: f64,
}

impl Mixed<'_> {
    fn of(&self, list: impl Fn(&Density) -> f64) -> f64 {
        (1.0 - self.part) * list(self.low) + self.part * list(self.high)
    }

    /// Of the conditional density at height `t` above `row`: value at node x, and integral up to it.
    fn across(&self, row: usize, t: f64, x: usize) -> [f64; 2] {
        let k = row * self.low.size[0] + x;
        let next = k + self.low.size[0];
        let between = |list: fn(&Density) -> &Vec<f64>| {
            self.of(|density| (1.0 - t) * list(density)[k] + t * list(density)[next])
        };
        [between(|d| &d.values), between(|d| &d.along_row)]
    }

    /// Of the marginal density: value at a row, and integral up to it.
    fn upwards(&self, row: usize) -> [f64; 2] {
        let n = self.low.size[0];
        [self.of(|d| d.along_row[(row + 1) * n - 1]), self.of(|d| d.below[row])]
    }

    /// Where a point of the square goes.
    pub fn warp(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [n, m] = self.low.size;
        let (row, t) = cell(y, m);
        let warped_y = share(self.upwards(row), self.upwards(row + 1)[0], t);
        let (column, s) = cell(x, n);
        let node = |k: usize| self.across(row, t, k);
        let all = node(n - 1)[1];
        let warped_x = if all > 0.0 { share(node(column), node(column + 1)[0], s) / all } else { x };
        [warped_x, warped_y]
    }

    /// Whence a point of the square comes: the inverse of [`Self::warp`].
    pub fn unwarp(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [n, m] = self.low.size;
        let row = last_below(m, |k| self.upwards(k)[1] <= y);
        let t = root(self.upwards(row), self.upwards(row + 1)[0], y);
        let node = |k: usize| self.across(row, t, k);
        let all = node(n - 1)[1];
        if all <= 0.0 {
            return [x, (row as f64 + t) / (m - 1) as f64];
        }
        let column = last_below(n, |k| node(k)[1] <= x * all);
        let s = root(node(column), node(column + 1)[0], x * all);
        [(column as f64 + s) / (n - 1) as f64, (row as f64 + t) / (m - 1) as f64]
    }
}

/// Cell of a position of 0 to 1 among `n` nodes, and how far into it.
pub(super) fn cell(position: f64, n: usize) -> (usize, f64) {
    let x = position.clamp(0.0, 1.0) * (n - 1) as f64;
    let low = (x as usize).min(n - 2);
    (low, x - low as f64)
}

/// Integral up to `t` into a cell whose density goes from `from` to `to`, upon `before`.
fn share([from, before]: [f64; 2], to: f64, t: f64) -> f64 {
    before + t * (from + 0.5 * t * (to - from))
}

/// The `t` of 0 to 1 at which [`share`] is `sum`: the root of the quadratic that has no cancellation.
fn root([from, before]: [f64; 2], to: f64, sum: f64) -> f64 {
    let rest = (sum - before).max(0.0);
    let steepness = (from * from + 2.0 * rest * (to - from)).max(0.0).sqrt();
    let divisor = from + steepness;
    if divisor > 0.0 { (2.0 * rest / divisor).min(1.0) } else { 0.0 }
}

/// The last of cells 0 to n - 2 whose lower node `is_below`.
fn last_below(n: usize, is_below: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, n - 1);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if is_below(middle) { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn warps_are_inverted(
            values in prop::collection::vec(0.01f32..10.0, 24),
            (x, y, part) in (0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64),
        ) {
            let (low, high) = (Density::new([4, 3], &values[..12]), Density::new([4, 3], &values[12..]));
            let mixed = Mixed { low: &low, high: &high, part };
            let [back_x, back_y] = mixed.unwarp(mixed.warp([x, y]));
            // Roundings through a root whose slope is at most the ratio of densities, 1000.
            prop_assert!((back_x - x).abs() < 1e-11 && (back_y - y).abs() < 1e-11, "{back_x} {back_y}");
        }
    }

    #[test]
    fn an_even_density_changes_nothing_and_a_ramp_is_squared() {
        let even = Density::new([3, 5], &[2.0; 15]);
        let mixed = Mixed { low: &even, high: &even, part: 0.3 };
        let [x, y] = mixed.warp([0.3, 0.7]);
        assert!((x - 0.3).abs() < 1e-15 && (y - 0.7).abs() < 1e-15);
        // p = 2x: distribution function x^2; and nothing of a row that is 0 breaks it.
        let ramp = Density::new([3, 2], &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0]);
        let mixed = Mixed { low: &ramp, high: &ramp, part: 0.0 };
        assert!((mixed.warp([0.3, 0.5])[0] - 0.09).abs() < 1e-15);
        assert!((mixed.unwarp([0.09, 0.5])[0] - 0.3).abs() < 1e-15);
        let hollow = Density::new([2, 3], &[0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
        let mixed = Mixed { low: &hollow, high: &hollow, part: 0.0 };
        for at in [[0.0, 0.0], [0.5, 0.25], [1.0, 1.0]] {
            assert!(mixed.warp(at).iter().chain(&mixed.unwarp(at)).all(|v| (0.0..=1.0).contains(v)));
        }
        let zero = Density::new([2, 2], &[0.0; 4]);
        let mixed = Mixed { low: &zero, high: &zero, part: 0.0 };
        assert_eq!(mixed.warp([0.25, 0.5]), [0.25, 0.5]);
    }
}
