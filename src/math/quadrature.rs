//! Gauss-Legendre quadrature, on one interval or on consecutive panels.

use std::sync::LazyLock;

/// Nodes of [`panel`]: a panel no wider than two widths of a Gaussian is integrated to rounding.
const PANEL_NODES: usize = 16;

static PANEL: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(PANEL_NODES, 0.0, 1.0));

/// Nodes and weights of the `n`-point Gauss-Legendre rule on `[a, b]`, nodes ascending. `n >= 1`.
///
/// Newton iteration on the Legendre recurrence; exact for polynomials of degree `2 n - 1`.
pub fn gauss_legendre(n: usize, a: f64, b: f64) -> Vec<(f64, f64)> {
    let (center, half) = (0.5 * (a + b), 0.5 * (b - a));
    (0..n)
        .map(|k| {
            // Tricomi's start for the root, counted from the left end.
            let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut p, mut p_before) = (x, 1.0);
                for degree in 2..=n {
                    let d = degree as f64;
                    (p, p_before) = (((2.0 * d - 1.0) * x * p - (d - 1.0) * p_before) / d, p);
                }
                slope = n as f64 * (x * p - p_before) / (x * x - 1.0);
                if n == 1 {
                    slope = 1.0;
                }
                x -= p / slope;
            }
            (center + half * x, half * 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Nodes and weights of the 16-point rule on `[a, b]`.
pub fn panel(a: f64, b: f64) -> impl Iterator<Item = (f64, f64)> {
    PANEL.iter().map(move |(x, w)| (a + (b - a) * x, (b - a) * w))
}

/// Nodes and weights of the 16-point rule on each of the panels between `breaks`, which ascend; an empty panel counts
/// nothing.
pub fn composite(breaks: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    breaks.windows(2).filter(|pair| pair[1] > pair[0]).flat_map(|pair| panel(pair[0], pair[1]))
}

/// Breaks at the positions of `inner` that lie inside (a, b), with both ends, ascending. Not-a-numbers lie nowhere.
pub fn breaks(a: f64, b: f64, inner: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = inner.into_iter().filter(|x| *x > a && *x < b).collect();
    all.extend([a, b]);
    all.sort_by(f64::total_cmp);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_cut_at_a_kink_are_exact() {
        let all = breaks(0.0, 2.0, [5.0, 0.7, f64::NAN, -1.0, 0.7, 1.5]);
        assert_eq!(all, [0.0, 0.7, 0.7, 1.5, 2.0]);
        let sum: f64 = composite(&all).map(|(x, w)| w * (x - 0.7).abs()).sum();
        // Two triangles; rounding.
        assert!((sum - 0.5 * (0.49 + 1.69)).abs() < 1e-15, "{sum}");
    }

    #[test]
    fn polynomials_are_integrated_exactly() {
        for n in 1..=40 {
            let rule = gauss_legendre(n, 0.0, 1.0);
            for degree in 0..(2 * n as i32).min(60) {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                // Rounding of n terms.
                assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "n {n} degree {degree}");
            }
        }
    }
}
