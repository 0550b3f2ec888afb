//! The optimizers of the fit.

use super::objective::{Objective, Terms};
use super::trust_region::{self, Minimum, Model};
use crate::error::{Error, Result};
use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, Constraints, Executor, Jacobian, Residual,
    RobustLeastSquares, SoftL1Loss, TrustRegionReflective,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::convert::Infallible;

/// What lowers the error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Optimizer {
    /// Quasi-Newton with symmetric rank-one updates on eq. 7 as it is, as Rump et al. 2008 did.
    Sr1,
    /// Levenberg-Marquardt in a box, on eq. 7 with a rounded knee.
    #[default]
    LevenbergMarquardt,
    /// Branch, Coleman and Li's trust-region reflective method, of the crate `basin`, on the same.
    TrustRegionReflective,
}

impl Optimizer {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Sr1, Self::LevenbergMarquardt, Self::TrustRegionReflective];

    /// Lowers the error from `start` on.
    ///
    /// # Errors
    /// The refusal of basin's solver.
    pub(super) fn fit(self, objective: &Objective, start: &Terms, knee: f64) -> Result<Fitted> {
        let x = objective.pack(start);
        let minimum = match self {
            Self::Sr1 => trust_region::minimize(objective, &x, 0.0, Model::Sr1),
            Self::LevenbergMarquardt => trust_region::minimize(objective, &x, knee, Model::GaussNewton),
            Self::TrustRegionReflective => reflective(objective, x, knee)?,
        };
        let terms = objective.unpack(&minimum.x);
        Ok(Fitted { error: objective.error(&terms), terms, steps: minimum.steps })
    }
}

/// What an optimizer found.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub terms: Terms,
    /// Eq. 7 over the points fitted.
    pub error: f64,
    /// Evaluations taken.
    pub steps: u64,
}

/// Steps of basin's solver at most, and the relative change of the loss at which it stops.
const STEPS: u64 = 200;
const TOLERANCE: f64 = 1e-9;

fn reflective(objective: &Objective, x: DVector<f64>, knee: f64) -> Result<Minimum> {
    let problem = RobustLeastSquares::new(Residuals(objective), SoftL1Loss).with_scale(knee);
    let solver = TrustRegionReflective::new().with_relative_cost_change_tolerance(TOLERANCE);
    let run = Executor::from_start(problem, solver, x).max_iter(STEPS).run();
    let result =
        run.map_err(|e| Error::not_converged("fit", "least squares", format!("{e:?}"), "a minimum"))?;
    Ok(Minimum { x: result.param().clone(), steps: result.iter() })
}

/// The residuals, whose loss is basin's to know: twice soft-L1 over `k^2` is `Loss::soft` over k.
struct Residuals<'a, 'b>(&'b Objective<'a>);

impl Constraints for Residuals<'_, '_> {
    type Set = ConstraintSet<BoxBounds<DVector<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.0.lower), Some(&self.0.upper)))
    }
}

impl Residual for Residuals<'_, '_> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;
    type Error = Infallible;

    fn residual(&self, x: &DVector<f64>) -> std::result::Result<DVector<f64>, Infallible> {
        let terms = self.0.unpack(x);
        let n = self.0.points.len();
        Ok(DVector::from_iterator(n, (0..n).map(|k| self.0.residual(k, &terms))))
    }
}

impl Jacobian for Residuals<'_, '_> {
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &DVector<f64>) -> std::result::Result<DMatrix<f64>, Infallible> {
        let terms = self.0.unpack(x);
        let mut jacobian = DMatrix::zeros(self.0.points.len(), x.len());
        let mut slopes = vec![0.0; x.len()];
        for (k, mut row) in jacobian.row_iter_mut().enumerate() {
            self.0.slopes(k, &terms, &mut slopes);
            row.iter_mut().zip(&slopes).for_each(|(entry, slope)| *entry = *slope);
        }
        Ok(jacobian)
    }
}
