//! Operators on light in one azimuth mode: what was not scattered on a diagonal, what was in a dense matrix.

use crate::error::{Error, Result};
use nalgebra::DMatrix;

/// Least share of light that leaves a bounce between two layers: a lossless light guide traps the rest for good, and
/// nothing gets into it either.
const LEAST_LOSS: f64 = 1e-15;

/// A linear map from the nodes of one medium to those of another.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    rows: usize,
    columns: usize,
    /// Unscattered part, for the nodes both media have; the rest is 0.
    direct: Vec<f64>,
    /// Scattered part; `None` is 0.
    dense: Option<DMatrix<f64>>,
}

impl Operator {
    /// The operator that returns nothing.
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { rows, columns, direct: vec![0.0; rows.min(columns)], dense: None }
    }

    /// An operator that scatters nothing. `direct` has as many entries as rows and columns allow.
    pub fn diagonal(rows: usize, columns: usize, direct: Vec<f64>) -> Self {
        debug_assert_eq!(direct.len(), rows.min(columns));
        Self { rows, columns, direct, dense: None }
    }

    /// A square operator.
    pub fn square(direct: Vec<f64>, dense: DMatrix<f64>) -> Self {
        debug_assert_eq!((direct.len(), direct.len()), dense.shape());
        Self { rows: direct.len(), columns: direct.len(), direct, dense: Some(dense) }
    }

    /// Whether nothing is returned.
    pub fn is_zero(&self) -> bool {
        self.dense.is_none() && self.direct.iter().all(|d| *d == 0.0)
    }

    /// The scattered part at a row and a column.
    pub fn scattered(&self, row: usize, column: usize) -> f64 {
        self.dense.as_ref().map_or(0.0, |dense| dense[(row, column)])
    }

    /// The unscattered part.
    pub fn direct(&self) -> &[f64] {
        &self.direct
    }

    /// The product: `other` first, then `self`.
    pub fn after(&self, other: &Self) -> Self {
        let (rows, columns) = (self.rows, other.columns);
        let mut direct = vec![0.0; rows.min(columns)];
        direct.iter_mut().zip(self.direct.iter().zip(&other.direct)).for_each(|(d, (a, b))| *d = a * b);
        let mut dense = match (&self.dense, &other.dense) {
            (Some(a), Some(b)) => Some(a * b),
            (None, None) => None,
            _ => Some(DMatrix::zeros(rows, columns)),
        };
        if let (Some(sum), Some(b)) = (&mut dense, &other.dense) {
            for (j, column) in b.column_iter().enumerate() {
                for (i, a) in self.direct.iter().enumerate() {
                    sum[(i, j)] += a * column[i];
                }
            }
        }
        if let (Some(sum), Some(a)) = (&mut dense, &self.dense) {
            for (j, b) in other.direct.iter().enumerate() {
                sum.column_mut(j).axpy(*b, &a.column(j), 1.0);
            }
        }
        Self { rows, columns, direct, dense }
    }

    /// The sum.
    #[must_use]
    pub fn plus(mut self, other: &Self) -> Self {
        self.direct.iter_mut().zip(&other.direct).for_each(|(a, b)| *a += b);
        self.dense = match (self.dense.take(), &other.dense) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or_else(|| b.clone()),
        };
        self
    }

    /// `(1 - self)^-1 x`: all bounces between two layers, `self` being one round.
    ///
    /// # Errors
    /// The bounces do not die out: rounding of layers without any loss.
    pub fn all_rounds(&self, x: &Self) -> Result<Self> {
        let loss: Vec<f64> = self.direct.iter().map(|r| (1.0 - r).max(LEAST_LOSS)).collect();
        let direct: Vec<f64> = x.direct.iter().enumerate().map(|(k, x)| x / loss[k]).collect();
        let Some(round) = &self.dense else {
            let dense =
                x.dense.as_ref().map(|x| DMatrix::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / loss[i]));
            return Ok(Self { rows: x.rows, columns: x.columns, direct, dense });
        };
        // (loss - round) y = x with the unscattered part of y, x / loss, taken out.
        let mut dense = x.dense.clone().unwrap_or_else(|| DMatrix::zeros(x.rows, x.columns));
        for (j, y) in direct.iter().enumerate() {
            dense.column_mut(j).axpy(*y, &round.column(j), 1.0);
        }
        let mut matrix = -round;
        for (k, loss) in loss.iter().enumerate() {
            matrix[(k, k)] += loss;
        }
        if !matrix.lu().solve_mut(&mut dense) {
            let legal = "layers between which light dies out";
            return Err(Error::not_converged("adding", "bounces", "a singular system", legal));
        }
        Ok(Self { rows: x.rows, columns: x.columns, direct, dense: Some(dense) })
    }

    /// The functional `f` after the scattered part alone.
    pub fn scattered_total(&self, f: &[f64]) -> Vec<f64> {
        let columns = self.dense.iter().flat_map(|dense| dense.column_iter());
        let mut out: Vec<f64> =
            columns.map(|column| column.iter().zip(f).map(|(a, f)| a * f).sum()).collect();
        out.resize(self.columns, 0.0);
        out
    }

    /// The functional `f` after this operator: `f^T self`, one value a column.
    pub fn before(&self, f: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.columns];
        out.iter_mut().zip(self.direct.iter().zip(f)).for_each(|(o, (d, f))| *o = d * f);
        out.iter_mut().zip(self.scattered_total(f)).for_each(|(o, s)| *o += s);
        out
    }
}
