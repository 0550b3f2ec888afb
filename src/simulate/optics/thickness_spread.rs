//! How the thickness of a flake's layer varies from flake to flake.
//!
//! A Gaussian about the mean, cut symmetrically at three standard deviations or, for spreads above a third, where the
//! thickness would be negative: the mean stays what the recipe says. (What is left has a standard deviation smaller by 1.3 %,
//! and by 12 % at the widest spread, 0.5, where the cut is at two.) Averages over it are taken with the Gauss rule of that
//! very law, whose nodes are the thicknesses and whose weights the shares of a few classes of flakes.

use crate::math::quadrature::composite;
use nalgebra::{DMatrix, SymmetricEigen};

/// Nodes, over the mean thickness, and weights (their sum is 1) of the `n`-point Gauss rule of a relative standard deviation
/// `spread`, 0 to 0.5: exact for polynomials of the thickness up to degree `2 n - 1`.
///
/// Golub & Welsch 1969, from the recurrence of the law's orthogonal polynomials (Stieltjes' procedure).
pub fn gauss_rule(spread: f64, n: usize) -> Vec<(f64, f64)> {
    if spread == 0.0 || n <= 1 {
        return vec![(1.0, 1.0)];
    }
    let cut = spread.recip().min(3.0);
    // Narrow panels: exact to rounding for the Gaussian times any of the polynomials.
    let panels: Vec<f64> = (0..=16).map(|k| cut * (f64::from(k) / 8.0 - 1.0)).collect();
    let law: Vec<(f64, f64)> = composite(&panels).map(|(t, w)| (t, w * (-0.5 * t * t).exp())).collect();
    let mut jacobi = DMatrix::zeros(n, n);
    // Values of two consecutive polynomials at the law's points; symmetry leaves one coefficient.
    let (mut before, mut now) = (vec![0.0; law.len()], vec![1.0; law.len()]);
    let mut norm: f64 = law.iter().map(|x| x.1).sum();
    let mut coefficient = 0.0;
    for k in 1..n {
        for ((old, new), (t, _)) in before.iter_mut().zip(&mut now).zip(&law) {
            (*old, *new) = (*new, t * *new - coefficient * *old);
        }
        let next: f64 = now.iter().zip(&law).map(|(p, (_, w))| w * p * p).sum();
        coefficient = next / norm;
        norm = next;
        jacobi[(k, k - 1)] = coefficient.sqrt();
        jacobi[(k - 1, k)] = coefficient.sqrt();
    }
    let eigen = SymmetricEigen::new(jacobi);
    let mut rule: Vec<(f64, f64)> =
        (0..n).map(|k| (1.0 + spread * eigen.eigenvalues[k], eigen.eigenvectors[(0, k)].powi(2))).collect();
    rule.sort_by(|a, b| a.0.total_cmp(&b.0));
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_law() {
        for spread in [0.02, 0.2, 0.25, 0.4, 0.5] {
            let cut = f64::min(3.0, 1.0 / spread);
            let panels: Vec<f64> = (0..=20).map(|k| cut * (f64::from(k) / 10.0 - 1.0)).collect();
            let law: Vec<_> = composite(&panels).map(|(t, w)| (t, w * (-0.5 * t * t).exp())).collect();
            let total: f64 = law.iter().map(|x| x.1).sum();
            for n in [2usize, 3, 8, 24] {
                let rule = gauss_rule(spread, n);
                assert!(rule.iter().all(|x| x.0 >= 0.0 && x.1 > 0.0), "{spread} {n}: {rule:?}");
                for degree in 0..(2 * n as i32).min(20) {
                    let ours: f64 =
                        rule.iter().map(|(x, w)| w * ((x - 1.0) / (spread * cut)).powi(degree)).sum();
                    let exact = law.iter().map(|(t, w)| w * (t / cut).powi(degree)).sum::<f64>() / total;
                    // Rounding of the eigenvalues.
                    assert!((ours - exact).abs() < 1e-13, "{spread} {n} {degree}: {ours} {exact}");
                }
            }
        }
        assert_eq!(gauss_rule(0.0, 8), [(1.0, 1.0)]);
    }
}
