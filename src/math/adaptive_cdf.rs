//! A distribution on an interval as a cumulative function of few straight pieces.
//!
//! Adaptive numerical cumulative distribution functions (Lawrence, Rusinkiewicz & Ramamoorthi 2005): the pieces are short where
//! the density changes and long where it does not, by Douglas and Peucker's rule on the cumulative function.

/// Densities that are constant between knots. Integral 1.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptiveCdf {
    knots: Vec<f64>,
    /// Probability below each knot: 0 at the first, 1 at the last.
    cumulative: Vec<f64>,
}

impl AdaptiveCdf {
    /// The distribution whose cells between `edges`, ascending, have `masses`, 0 or more and one fewer than edges; nowhere is
    /// its cumulative function farther than `tolerance` from theirs. None where there is no mass.
    pub fn new(edges: &[f64], masses: &[f64], tolerance: f64) -> Option<Self> {
        let mut cumulative = vec![0.0];
        for mass in masses {
            cumulative.push(cumulative[cumulative.len() - 1] + mass);
        }
        let total = *cumulative.last()?;
        if !(total > 0.0 && total.is_finite()) || edges.len() != cumulative.len() {
            return None;
        }
        cumulative.iter_mut().for_each(|c| *c /= total);
        let kept = kept(edges, &cumulative, tolerance);
        let of = |values: &[f64]| kept.iter().map(|k| values[*k]).collect();
        Some(Self { knots: of(edges), cumulative: of(&cumulative) })
    }

    /// The knots, ascending.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The number of the piece and the place where the cumulative function is `u`, 0 to 1.
    pub fn sample(&self, u: f64) -> (usize, f64) {
        let piece = piece(&self.cumulative, u);
        let [low, high] = [self.cumulative[piece], self.cumulative[piece + 1]];
        let along = if high > low { ((u - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        (piece, self.knots[piece] + along * (self.knots[piece + 1] - self.knots[piece]))
    }

    /// The number of the piece at `x`, and the density there; 0 outside.
    pub fn density(&self, x: f64) -> (usize, f64) {
        let piece = piece(&self.knots, x);
        if !(self.knots[0]..=self.knots[self.knots.len() - 1]).contains(&x) {
            return (piece, 0.0);
        }
        let mass = self.cumulative[piece + 1] - self.cumulative[piece];
        (piece, mass / (self.knots[piece + 1] - self.knots[piece]))
    }
}

/// The piece between ascending `ends` that holds `x`, the first or last for what is outside.
fn piece(ends: &[f64], x: f64) -> usize {
    ends.partition_point(|end| *end <= x).clamp(1, ends.len() - 1) - 1
}

/// Which points of the polyline (x, y) to keep so that no other is farther than `tolerance` above or below it.
fn kept(x: &[f64], y: &[f64], tolerance: f64) -> Vec<usize> {
    let mut kept = vec![0];
    let mut ends = vec![x.len() - 1];
    while let (Some(&first), Some(&last)) = (kept.last(), ends.last()) {
        let slope = (y[last] - y[first]) / (x[last] - x[first]);
        let error = |k: usize| (y[k] - y[first] - slope * (x[k] - x[first])).abs();
        let worst = (first + 1..last).max_by(|a, b| error(*a).total_cmp(&error(*b)));
        match worst.filter(|k| error(*k) > tolerance) {
            Some(k) => ends.push(k),
            None => {
                ends.pop();
                kept.push(last);
            }
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A narrow peak on a broad floor over [0, 1], in `n` cells.
    fn peak(n: usize) -> (Vec<f64>, Vec<f64>) {
        let edges: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
        let mass = |k: usize| 0.1 + 50.0 * (-((edges[k] - 0.3) / 0.01).powi(2)).exp();
        let masses = (0..n).map(mass).collect();
        (edges, masses)
    }

    #[test]
    fn few_pieces_are_within_the_tolerance_everywhere() {
        let (edges, masses) = peak(2000);
        let cdf = AdaptiveCdf::new(&edges, &masses, 1e-3).unwrap();
        assert!(cdf.knots().len() < 40, "{}", cdf.knots().len());
        let total: f64 = masses.iter().sum();
        let mut below = 0.0;
        for (edge, mass) in edges.iter().zip(&masses) {
            let (_, x) = cdf.sample(below / total);
            let (piece, density) = cdf.density(*edge);
            let at_edge = cdf.cumulative[piece] + density * (edge - cdf.knots[piece]);
            // Rounding of sums of 2000 terms.
            assert!((at_edge - below / total).abs() <= 1e-3 + 1e-12, "{edge} {x}");
            below += mass;
        }
    }

    #[test]
    fn samples_have_the_density() {
        let (edges, masses) = peak(500);
        let cdf = AdaptiveCdf::new(&edges, &masses, 1e-4).unwrap();
        let n = 100_000;
        // By the midpoint rule 1 / density integrates to the length of the interval.
        let length: f64 = (0..n)
            .map(|k| {
                let (piece, x) = cdf.sample((k as f64 + 0.5) / f64::from(n));
                let (there, density) = cdf.density(x);
                assert!(there == piece);
                1.0 / density / f64::from(n)
            })
            .sum();
        // A jump of 1 / density, at most 500, an n-th wide, at each of some 50 knots.
        assert!((length - 1.0).abs() < 0.05, "{length}");
    }

    #[test]
    fn nothing_has_no_distribution() {
        assert_eq!(AdaptiveCdf::new(&[0.0, 1.0], &[0.0], 1e-3), None);
        assert_eq!(AdaptiveCdf::new(&[0.0, 1.0], &[f64::NAN], 1e-3), None);
        assert_eq!(AdaptiveCdf::new(&[0.0, 1.0], &[], 1e-3), None);
        let one = AdaptiveCdf::new(&[2.0, 4.0], &[3.0], 1e-3).unwrap();
        assert_eq!((one.sample(0.25).1, one.density(3.0).1, one.density(1.9).1), (2.5, 0.5, 0.0));
    }
}
