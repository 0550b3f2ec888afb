//! A monotone curve through points with errors: a power with a toe, and a smooth remainder.

use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// Cells of the remainder, a few a point.
const CELLS: usize = 64;
/// Toes that are tried, as shares of the largest light, and exponents.
const TOES: [f64; 8] = [1e-6, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1];
const POWERS: [f64; 9] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.2];
/// Stiffness of the remainder, from what leaves a line to what goes through every point.
const STIFFNESS: [f64; 2] = [1e9, 1e-9];
/// Bisections of its logarithm.
const BISECTIONS: usize = 24;

/// The curve.
#[derive(Debug, Clone)]
pub struct SmoothCurve {
    /// Toe b, in units of the light.
    pub toe: f64,
    /// Root mean square distance of the points, and its expectation.
    pub rms: [f64; 2],
    power: f64,
    /// c0 and c1.
    line: [f64; 2],
    /// The remainder at the cells' ends, from `from` in steps of `step` of log (x + b).
    remainder: Vec<f64>,
    from: f64,
    step: f64,
}

impl SmoothCurve {
    /// The curve through points `[light, response, standard error]`, at least four, light ascending from 0 or more.
    ///
    /// # Errors
    /// Responses that do not rise.
    pub fn fit(points: &[[f64; 3]]) -> Result<Self> {
        let rises = |pair: &[[f64; 3]]| pair[1][1] > pair[0][1] - 5.0 * pair[0][2].hypot(pair[1][2]);
        let ends = points.first().zip(points.last());
        if !(points.windows(2).all(rises) && ends.is_some_and(|(a, b)| b[1] > a[1] + 5.0 * a[2].hypot(b[2])))
        {
            let found: Vec<String> = points.iter().map(|p| format!("{:.4}", p[1])).collect();
            return Err(Error::invalid(
                "",
                "levels of the gray fields",
                found.join(" "),
                "rising with the time",
            ));
        }
        let [top, ..] = points[points.len() - 1];
        let (toe, power) = shape(points, top);
        let line = line(points, toe, power).1;
        let from = (points[0][0] + toe).ln();
        let step = ((2.0 * top + toe).ln() - from) / CELLS as f64;
        let mut curve = Self { toe, rms: [0.0; 2], power, line, remainder: vec![0.0; CELLS + 1], from, step };
        curve.smooth(points);
        let count = points.len() as f64;
        let square = points.iter().map(|p| (p[1] - curve.says(p[0])).powi(2)).sum::<f64>();
        let expected = points.iter().map(|p| p[2] * p[2]).sum::<f64>();
        curve.rms = [square, expected].map(|s| (s / count).sqrt());
        Ok(curve)
    }

    /// What is said of light, not yet cut to 0 and 1.
    fn raw(&self, light: f64) -> f64 {
        let above = (light + self.toe).max(1e-12 * self.toe);
        let (cell, share) = self.cell(above);
        let remainder = self.remainder[cell] + share * (self.remainder[cell + 1] - self.remainder[cell]);
        self.line[0] + self.line[1] * above.powf(self.power) + remainder
    }

    /// What is said of light, 0 to 1.
    pub fn says(&self, light: f64) -> f64 {
        self.raw(light).clamp(0.0, 1.0)
    }

    /// Change of what is said with light, by a difference.
    pub fn slope(&self, light: f64) -> f64 {
        let step = 1e-3 * (light + self.toe);
        (self.raw(light + step) - self.raw(light - step)) / (2.0 * step)
    }

    /// The light at which 1 is said.
    pub fn saturation(&self) -> f64 {
        // Where the remainder ends it goes on straight; eight times the last field at most.
        let top = (self.from + self.step * CELLS as f64).exp();
        let (mut low, mut high) = (0.0, 4.0 * top);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            *(if self.raw(middle) < 1.0 { &mut low } else { &mut high }) = middle;
        }
        high
    }

    /// Cell of light above the toe, and place in it; beyond the ends it goes on straight.
    fn cell(&self, above: f64) -> (usize, f64) {
        let place = (above.ln() - self.from) / self.step;
        let cell = place.clamp(0.0, (CELLS - 1) as f64).floor();
        // Below the first point the remainder stays what it is there: that is a small part of the curve, too.
        (cell as usize, (place - cell).max(0.0))
    }

    /// The stiffest remainder within the points' errors.
    fn smooth(&mut self, points: &[[f64; 3]]) {
        let mut normal = DMatrix::<f64>::zeros(CELLS + 1, CELLS + 1);
        let mut side = DVector::<f64>::zeros(CELLS + 1);
        for [light, said, error] in points {
            let (cell, share) = self.cell(light + self.toe);
            let (w, left) = (error.max(1e-9).powi(-2), said - self.raw(*light));
            for (k, a) in [(cell, 1.0 - share), (cell + 1, share)] {
                side[k] += w * a * left;
                for (j, b) in [(cell, 1.0 - share), (cell + 1, share)] {
                    normal[(k, j)] += w * a * b;
                }
            }
        }
        let scale = normal.diagonal().max();
        let mut bends = DMatrix::<f64>::zeros(CELLS + 1, CELLS + 1);
        for k in 1..CELLS {
            let row = [(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)];
            row.iter().for_each(|(i, a)| row.iter().for_each(|(j, b)| bends[(*i, *j)] += a * b));
        }
        let solve = |stiffness: f64| {
            let stiff = &normal + &bends * (stiffness.exp() * scale);
            let solved = stiff.cholesky().map(|c| c.solve(&side));
            solved.map(|remainder| remainder.as_slice().to_vec())
        };
        let [mut stiff, mut loose] = STIFFNESS.map(f64::ln);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (stiff + loose);
            let misfit = solve(middle).map_or(f64::INFINITY, |remainder| {
                self.remainder = remainder;
                points.iter().map(|p| ((p[1] - self.raw(p[0])) / p[2].max(1e-9)).powi(2)).sum()
            });
            *(if misfit <= points.len() as f64 { &mut loose } else { &mut stiff }) = middle;
        }
        self.remainder = solve(loose).unwrap_or_else(|| vec![0.0; CELLS + 1]);
    }
}

/// Toe and exponent of the least error: the best of a table, then smaller and smaller steps along both.
fn shape(points: &[[f64; 3]], top: f64) -> (f64, f64) {
    let error = |[toe, power]: [f64; 2]| line(points, toe.exp(), power).0;
    let table = TOES.iter().flat_map(|toe| POWERS.map(|power| [(toe * top).ln(), power]));
    let mut best = table.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap_or([top.ln(), 1.0]);
    let mut reach = [1.0, 0.1];
    while reach[1] > 1e-6 {
        let moves = [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 1.0],
            [-1.0, -1.0],
            [1.0, -1.0],
            [-1.0, 1.0],
        ];
        let moved = moves.map(|m| [0, 1].map(|k| best[k] + m[k] * reach[k]));
        let legal =
            |m: &[f64; 2]| (1e-8f64..=1.0).contains(&(m[0].exp() / top)) && (0.05..=3.0).contains(&m[1]);
        let next = moved.into_iter().filter(legal).min_by(|a, b| error(*a).total_cmp(&error(*b)));
        match next.filter(|n| error(*n) < error(best)) {
            Some(next) => best = next,
            None => reach = reach.map(|r| 0.5 * r),
        }
    }
    (best[0].exp(), best[1])
}

/// Weighted error and coefficients of the best `c0 + c1 (x + toe)^power`.
fn line(points: &[[f64; 3]], toe: f64, power: f64) -> (f64, [f64; 2]) {
    // All points count alike in proportion to what they say: the remainder takes the rest, which is to be small everywhere.
    let [mut s, mut sx, mut sxx, mut sy, mut sxy, mut syy] = [0.0; 6];
    for [light, said, error] in points {
        let (x, w) = ((light + toe).powf(power), (0.02 * said).hypot(*error).max(1e-6).powi(-2));
        [s, sx, sxx] = [s + w, sx + w * x, sxx + w * x * x];
        [sy, sxy, syy] = [sy + w * said, sxy + w * x * said, syy + w * said * said];
    }
    let (mx, my) = (sx / s, sy / s);
    let (vxx, vxy, vyy) = (sxx / s - mx * mx, sxy / s - mx * my, syy / s - my * my);
    let slope = if vxx > 0.0 { vxy / vxx } else { 0.0 };
    (vyy - slope * vxy, [my - slope * mx, slope])
}
