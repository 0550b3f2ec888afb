//! A smooth vector-valued function of one variable, tabulated once: Chebyshev interpolation on adaptive panels.

use crate::error::{Error, Result};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Nodes a panel, ends included.
const NODES: usize = 16;
/// A panel is halved at most this often.
const DEPTH: usize = 12;
/// Most panels: 5 MB of spectra, and with the thickest stacks some seconds.
const MAX_PANELS: usize = 1024;

/// Chebyshev points of the second kind on [-1, 1], ascending.
static POINTS: LazyLock<[f64; NODES]> =
    LazyLock::new(|| std::array::from_fn(|k| -(PI * k as f64 / (NODES - 1) as f64).cos()));

/// `N` values as functions of x. Evaluation outside the range extrapolates the outermost panel and is not meant.
#[derive(Debug, Clone, PartialEq)]
pub struct Piecewise<const N: usize> {
    breaks: Vec<f64>,
    panels: Vec<[[f64; N]; NODES]>,
}

impl<const N: usize> Piecewise<N> {
    /// Tabulates `f` over the panels between `breaks` (ascending, two or more), halving each until the interpolant is within
    /// `tolerance` times the largest value of its component at three points between the nodes. `what` names the function in
    /// errors.
    ///
    /// # Errors
    /// The tolerance is not met by 12 halvings or 1024 panels.
    pub fn fit(
        what: &str,
        breaks: &[f64],
        tolerance: f64,
        f: impl Fn(f64) -> [f64; N] + Sync,
    ) -> Result<Self> {
        let first: Vec<_> = breaks.par_windows(2).map(|pair| sample(pair[0], pair[1], &f)).collect();
        let mut scale = [0.0f64; N];
        for row in first.iter().flatten() {
            scale.iter_mut().zip(row).for_each(|(s, v)| *s = s.max(v.abs()));
        }
        let fits = |x: f64, panel_value: &[f64; N]| {
            let exact = f(x);
            (0..N).all(|k| (exact[k] - panel_value[k]).abs() <= tolerance * scale[k])
        };
        let parts: Vec<(Self, bool)> = breaks
            .par_windows(2)
            .zip(first)
            .map(|(pair, panel)| {
                let mut part = Self { breaks: vec![pair[0]], panels: Vec::new() };
                let good = part.refine(pair[0], pair[1], panel, &fits, &f, DEPTH);
                (part, good)
            })
            .collect();
        let mut table = Self { breaks: vec![breaks[0]], panels: Vec::new() };
        for (part, good) in parts {
            table.breaks.extend(&part.breaks[1..]);
            table.panels.extend(part.panels);
            if !good || table.panels.len() > MAX_PANELS {
                let found = format!("more, near {}", table.breaks[table.breaks.len() - 1]);
                let legal = format!("{tolerance:e} of the peak within {MAX_PANELS} panels");
                return Err(Error::not_converged("table", what, found, legal));
            }
        }
        Ok(table)
    }

    /// Adds the panel from `a` to `b`, in halves where one does not fit; false, with what was reached kept, where none does.
    fn refine(
        &mut self,
        a: f64,
        b: f64,
        panel: [[f64; N]; NODES],
        fits: &impl Fn(f64, &[f64; N]) -> bool,
        f: &impl Fn(f64) -> [f64; N],
        depth: usize,
    ) -> bool {
        // Off the nodes, one near each end, where interpolation is worst, and one inside.
        let good =
            [-0.99, 0.1, 0.99].iter().all(|t| fits(a + 0.5 * (b - a) * (t + 1.0), &interpolate(&panel, *t)));
        if self.panels.len() == MAX_PANELS || (!good && depth == 0) {
            return false;
        }
        if good {
            self.breaks.push(b);
            self.panels.push(panel);
            return true;
        }
        let middle = 0.5 * (a + b);
        self.refine(a, middle, sample(a, middle, f), fits, f, depth - 1)
            && self.refine(middle, b, sample(middle, b, f), fits, f, depth - 1)
    }

    /// Where [`Piecewise::from_values`] wants the function that is to be tabulated between `breaks` (ascending, two or more):
    /// 16 places a panel, ends included.
    pub fn nodes(breaks: &[f64]) -> Vec<f64> {
        let panels = breaks.windows(2);
        panels.flat_map(|pair| POINTS.map(|t| pair[0] + 0.5 * (pair[1] - pair[0]) * (t + 1.0))).collect()
    }

    /// The interpolant through given values at the [nodes](Piecewise::nodes) of `breaks`; values beyond those are ignored and
    /// missing ones 0.
    pub fn from_values(breaks: &[f64], values: &[[f64; N]]) -> Self {
        let panels = (1..breaks.len())
            .map(|p| std::array::from_fn(|k| values.get((p - 1) * NODES + k).copied().unwrap_or([0.0; N])));
        Self { breaks: breaks.to_vec(), panels: panels.collect() }
    }

    /// What the value at each node of `breaks` counts in the sum of `weight * f(x)` over all `(x, weight)` that `visit` hands
    /// to the function it is given.
    pub fn node_weights(breaks: &[f64], visit: impl FnOnce(&mut dyn FnMut(f64, f64))) -> Vec<f64> {
        gather(breaks, visit).into_iter().flatten().collect()
    }

    /// The function at `x`.
    pub fn eval(&self, x: f64) -> [f64; N] {
        let (k, t) = locate(&self.breaks, x);
        interpolate(&self.panels[k], t)
    }

    /// The sum of `weight * f(x)` over all `(x, weight)` that `visit` hands to the function it is given. Weights are gathered
    /// at the nodes first: for spectra, many times faster than evaluating at every x.
    pub fn weighted_sum(&self, visit: impl FnOnce(&mut dyn FnMut(f64, f64))) -> [f64; N] {
        let mut sum = [0.0; N];
        for (weights, panel) in gather(&self.breaks, visit).iter().zip(&self.panels) {
            add_weighted(weights, panel, &mut sum);
        }
        sum
    }

    /// The `M` components from the one numbered `first` on, as a table of their own.
    pub fn part<const M: usize>(&self, first: usize) -> Piecewise<M> {
        let rows = |panel: &[[f64; N]; NODES]| panel.map(|row| std::array::from_fn(|k| row[first + k]));
        Piecewise { breaks: self.breaks.clone(), panels: self.panels.iter().map(rows).collect() }
    }
}

/// The panel that holds `x`, and where in it, -1 to 1.
fn locate(breaks: &[f64], x: f64) -> (usize, f64) {
    let last = breaks.len() - 2;
    let k = breaks.partition_point(|b| *b <= x).saturating_sub(1).min(last);
    let (a, b) = (breaks[k], breaks[k + 1]);
    (k, 2.0 * (x - a) / (b - a) - 1.0)
}

/// What each node counts in a weighted sum over places, panel after panel.
fn gather(breaks: &[f64], visit: impl FnOnce(&mut dyn FnMut(f64, f64))) -> Vec<[f64; NODES]> {
    let mut gathered = vec![[0.0; NODES]; breaks.len() - 1];
    visit(&mut |x, weight| {
        let (k, t) = locate(breaks, x);
        gathered[k].iter_mut().zip(cardinal(t)).for_each(|(g, c)| *g += weight * c);
    });
    gathered
}

fn sample<const N: usize>(a: f64, b: f64, f: &impl Fn(f64) -> [f64; N]) -> [[f64; N]; NODES] {
    std::array::from_fn(|k| f(a + 0.5 * (b - a) * (POINTS[k] + 1.0)))
}

fn interpolate<const N: usize>(panel: &[[f64; N]; NODES], t: f64) -> [f64; N] {
    let mut sum = [0.0; N];
    add_weighted(&cardinal(t), panel, &mut sum);
    sum
}

fn add_weighted<const N: usize>(weights: &[f64; NODES], panel: &[[f64; N]; NODES], sum: &mut [f64; N]) {
    for (weight, values) in weights.iter().zip(panel) {
        sum.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
    }
}

/// What each node's value counts at `t`: barycentric weights, of alternating sign and halved at the ends, over the distance,
/// normalized (Berrut & Trefethen 2004).
fn cardinal(t: f64) -> [f64; NODES] {
    let mut weights = [0.0; NODES];
    let mut total = 0.0;
    for (k, point) in POINTS.iter().enumerate() {
        let distance = t - point;
        if distance == 0.0 {
            weights = [0.0; NODES];
            weights[k] = 1.0;
            return weights;
        }
        let end = if k == 0 || k == NODES - 1 { 0.5 } else { 1.0 };
        weights[k] = if k % 2 == 0 { end / distance } else { -end / distance };
        total += weights[k];
    }
    weights.map(|w| w / total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_peaks_and_fringes_are_resolved() {
        let f = |x: f64| [(-0.5 * (x / 0.005).powi(2)).exp(), (300.0 * x).cos()];
        let table = Piecewise::fit("test", &[0.0, 0.02, 1.5], 1e-10, f).unwrap();
        for k in 0..5000 {
            let x = 1.5 * f64::from(k) / 4999.0;
            let (a, b) = (table.eval(x), f(x));
            // The three test points do not see the very worst place: ten times the tolerance.
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9, "{x}: {a:?} {b:?}");
        }
        let points = [(0.0, 2.0), (0.003, -1.0), (1.3, 0.5), (1.5, 4.0)];
        let sum = table.weighted_sum(|add| points.iter().for_each(|(x, w)| add(*x, *w)));
        let direct: f64 = points.iter().map(|(x, w)| w * table.eval(*x)[1]).sum();
        // The same sum in another order.
        assert!((sum[1] - direct).abs() < 1e-13, "{sum:?} {direct}");
    }

    #[test]
    fn a_function_no_panel_follows_is_refused_by_name() {
        // A jump, fringes finer than any panel and than 1024 of them, and no number at all.
        let jump = Piecewise::fit("jump", &[0.0, 1.0], 1e-10, |x| [f64::from(u8::from(x > 0.3))]);
        let fringe = Piecewise::fit("fringe", &[0.0, 1.0, 2.0], 1e-10, |x| [(1e6 * x).cos()]);
        let none = Piecewise::fit("none", &[0.0, 1.0], 1e-10, |x| [(x - 0.5).sqrt()]);
        let many = Piecewise::fit("many", &[0.0, 1.0], 1e-10, |x| [(1e4 * x).cos()]);
        for (table, name) in [(jump, "jump"), (fringe, "fringe"), (many, "many"), (none, "none")] {
            let message = table.unwrap_err().to_string();
            assert!(message.contains(name) && message.contains("did not converge"), "{message}");
        }
    }
}
