//! The logarithmic error of a set of lobes, with its derivatives, and the bounded least-squares solver that lowers it.
//!
//! Eq. 7 of Rump et al. 2008, read as the mean over samples of `|ln((max(Psi, 0) + eps) / (M + eps))|`. The solver lowers a
//! smooth version of it, soft-L1 with a knee at 0.05, which is eq. 7 for all but the smallest errors.

use crate::brdf::cook_torrance::{beckmann, brightness, v_cavity};
use crate::brdf::{Lobe, LobeGeometry};
use crate::error::{Error, Result};
use basin::{
    BoundedLevenbergMarquardt, BoxBounds, ConstraintDescription, ConstraintSet, Constraints, Executor,
    Jacobian, Residual, RobustLeastSquares, SoftL1Loss,
};
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;
use std::f64::consts::PI;

/// Where the loss turns from square to absolute value: well below the noise of real tables, which is some 0.1.
const KNEE: f64 = 0.05;
/// Steps of the solver; a three-lobe fit takes 20 to 60.
const STEPS: u64 = 200;
/// Relative change of the cost at which the solver stops: far below any difference between two starts that matters.
const TOLERANCE: f64 = 1e-9;

/// One sample as the objective sees it: `M = rest + transmittance * (diffuse/pi + lobes)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub geometry: LobeGeometry,
    pub transmittance: f64,
    /// Part of the model that stays fixed.
    pub rest: f64,
    /// Measured intensity; below zero it counts as zero.
    pub intensity: f64,
}

/// What is fitted: an optional diffuse term and lobes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Terms {
    /// Diffuse intensity, if it is fitted.
    pub diffuse: Option<f64>,
    /// Lobes.
    pub lobes: Vec<Lobe>,
}

impl Terms {
    /// Their sum, 1/sr.
    pub fn brightness(&self, geometry: &LobeGeometry) -> f64 {
        brightness(self.diffuse.unwrap_or(0.0), &self.lobes, geometry)
    }
}

/// What differs between metallic lobes and gloss.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    /// Legal roughness.
    pub roughness: (f64, f64),
}

/// Legal diffuse terms and coefficients: from nothing to see to more than any paint.
const STRENGTH: (f64, f64) = (1e-8, 1e3);

/// The residuals `ln((Psi + eps) / (M + eps))` of a set of points.
pub(super) struct Objective<'a> {
    points: &'a [Point],
    epsilon: f64,
    diffuse: bool,
    lower: DVector<f64>,
    upper: DVector<f64>,
}

/// A result of [`Objective::fit`].
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub terms: Terms,
    /// Eq. 7 over the points fitted.
    pub error: f64,
    /// Steps taken.
    pub steps: u64,
}

impl<'a> Objective<'a> {
    /// The objective over `points` for terms of the shape of `like`.
    pub fn new(points: &'a [Point], epsilon: f64, like: &Terms, range: Range) -> Self {
        let strength = [STRENGTH.0.ln(), STRENGTH.1.ln()];
        let bounds = |side: usize| {
            let roughness = [range.roughness.0.ln(), range.roughness.1.ln()][side];
            let lobe = [strength[side], roughness, side as f64];
            let diffuse = like.diffuse.map(|_| strength[side]);
            DVector::from_iterator(
                usize::from(diffuse.is_some()) + 3 * like.lobes.len(),
                diffuse.into_iter().chain(like.lobes.iter().flat_map(|_| lobe)),
            )
        };
        Self { points, epsilon, diffuse: like.diffuse.is_some(), lower: bounds(0), upper: bounds(1) }
    }

    /// Eq. 7 over the points.
    pub fn error(&self, terms: &Terms) -> f64 {
        let sum: f64 = self.points.iter().map(|p| self.log_ratio(p, terms).abs()).sum();
        sum / self.points.len().max(1) as f64
    }

    /// Lowers the error from `start` on, within the bounds.
    ///
    /// # Errors
    /// The solver's refusal.
    pub fn fit(&self, start: &Terms) -> Result<Fitted> {
        let mut x = pack(start);
        for k in 0..x.len() {
            x[k] = x[k].clamp(self.lower[k], self.upper[k]);
        }
        let problem = RobustLeastSquares::new(Borrowed(self), SoftL1Loss).with_scale(KNEE);
        let solver = BoundedLevenbergMarquardt::new().with_relative_cost_change_tolerance(TOLERANCE);
        let run = Executor::from_start(problem, solver, x).max_iter(STEPS).run();
        let result =
            run.map_err(|e| Error::not_converged("fit", "least squares", format!("{e:?}"), "a minimum"))?;
        let terms = unpack(result.param(), self.diffuse);
        Ok(Fitted { error: self.error(&terms), terms, steps: result.iter() })
    }

    fn log_ratio(&self, p: &Point, terms: &Terms) -> f64 {
        ((p.intensity.max(0.0) + self.epsilon) / (p.model(terms) + self.epsilon)).ln()
    }
}

impl Point {
    fn model(&self, terms: &Terms) -> f64 {
        self.rest + self.transmittance * terms.brightness(&self.geometry)
    }
}

/// Parameters: logarithms of diffuse, coefficients and roughness, F0 as it is.
fn pack(terms: &Terms) -> DVector<f64> {
    let lobes = terms.lobes.iter().flat_map(|l| [l.coefficient.ln(), l.roughness.ln(), l.f0]);
    let all: Vec<f64> = terms.diffuse.iter().map(|a| a.ln()).chain(lobes).collect();
    DVector::from_vec(all)
}

fn unpack(x: &DVector<f64>, diffuse: bool) -> Terms {
    let skip = usize::from(diffuse);
    let lobe = |x: &[f64]| Lobe { coefficient: x[0].exp(), roughness: x[1].exp(), f0: x[2].clamp(0.0, 1.0) };
    Terms {
        diffuse: diffuse.then(|| x[0].exp()),
        lobes: x.as_slice()[skip..].chunks_exact(3).map(lobe).collect(),
    }
}

/// The solver owns its problem; the problem lends its points.
struct Borrowed<'a, 'b>(&'b Objective<'a>);

impl Constraints for Borrowed<'_, '_> {
    type Set = ConstraintSet<BoxBounds<DVector<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.0.lower), Some(&self.0.upper)))
    }
}

impl Residual for Borrowed<'_, '_> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;
    type Error = Infallible;

    fn residual(&self, x: &DVector<f64>) -> std::result::Result<DVector<f64>, Infallible> {
        let terms = unpack(x, self.0.diffuse);
        let points = self.0.points;
        Ok(DVector::from_iterator(points.len(), points.iter().map(|p| self.0.log_ratio(p, &terms))))
    }
}

impl Jacobian for Borrowed<'_, '_> {
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &DVector<f64>) -> std::result::Result<DMatrix<f64>, Infallible> {
        let objective = self.0;
        let terms = unpack(x, objective.diffuse);
        let mut jacobian = DMatrix::zeros(objective.points.len(), x.len());
        for (row, p) in objective.points.iter().enumerate() {
            let scale = -p.transmittance / (p.model(&terms) + objective.epsilon);
            let diffuse = terms.diffuse.map(|a| a / PI);
            let lobes = terms.lobes.iter().flat_map(|lobe| slopes(lobe, &p.geometry));
            for (column, slope) in diffuse.into_iter().chain(lobes).enumerate() {
                jacobian[(row, column)] = scale * slope;
            }
        }
        Ok(jacobian)
    }
}

/// Derivatives of a lobe by the logarithm of its coefficient, the logarithm of its roughness, and F0.
fn slopes(lobe: &Lobe, g: &LobeGeometry) -> [f64; 3] {
    let value = lobe.eval(g);
    let m = (1.0 - g.cos_d).max(0.0);
    let per_fresnel = lobe.coefficient / PI * beckmann(g.tan2_h, g.cos_h, lobe.roughness) * v_cavity(g)
        / (g.cos_i * g.cos_o);
    let a2 = lobe.roughness * lobe.roughness;
    [value, value * 2.0 * (g.tan2_h / a2 - 1.0), per_fresnel * (1.0 - m.powi(5))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::directions;

    fn points(truth: &Terms) -> Vec<Point> {
        let mut points = Vec::new();
        for h in 0..12 {
            for i in 0..8 {
                for p in 0..3 {
                    let (wi, wo) =
                        directions(0.02 + 0.1 * f64::from(h), 0.05 + 0.15 * f64::from(i), 1.5 * f64::from(p));
                    if wi.z > 0.05 && wo.z > 0.05 {
                        let geometry = LobeGeometry::of(wi, wo);
                        points.push(Point { geometry, transmittance: 0.9, rest: 0.001, intensity: 0.0 });
                    }
                }
            }
        }
        points.iter_mut().for_each(|p| p.intensity = p.model(truth));
        points
    }

    fn truth() -> Terms {
        Terms {
            diffuse: Some(0.03),
            lobes: vec![
                Lobe { coefficient: 0.1, roughness: 0.6, f0: 0.2 },
                Lobe { coefficient: 0.2, roughness: 0.2, f0: 0.5 },
            ],
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let points = points(&truth());
        let objective = Objective::new(&points, 1e-4, &truth(), Range { roughness: (0.02, 2.0) });
        let problem = Borrowed(&objective);
        let mut x = pack(&truth());
        x.add_scalar_mut(-0.1);
        let jacobian = problem.jacobian(&x).unwrap();
        for k in 0..x.len() {
            let step = 1e-5;
            let (mut up, mut down) = (x.clone(), x.clone());
            up[k] += step;
            down[k] -= step;
            let difference =
                (problem.residual(&up).unwrap() - problem.residual(&down).unwrap()) / (2.0 * step);
            // Central differences: third derivative (up to some 100 far from the peak) times step^2 / 6.
            assert!((jacobian.column(k) - difference).amax() < 1e-7, "parameter {k}");
        }
    }

    #[test]
    fn exact_data_give_the_lobes_back() {
        let points = points(&truth());
        let start = Terms {
            diffuse: Some(0.1),
            lobes: vec![
                Lobe { coefficient: 0.05, roughness: 0.9, f0: 0.5 },
                Lobe { coefficient: 0.05, roughness: 0.3, f0: 0.3 },
            ],
        };
        let objective = Objective::new(&points, 1e-5, &start, Range { roughness: (0.02, 2.0) });
        let fitted = objective.fit(&start).unwrap();
        // The solver stops on a relative cost change of 1e-9; the cost is quadratic in the parameters there.
        assert!(fitted.error < 1e-4, "{fitted:?}");
        for (a, b) in fitted.terms.lobes.iter().zip(&truth().lobes) {
            assert!((a.roughness / b.roughness - 1.0).abs() < 1e-2, "{a:?} {b:?}");
        }
    }
}
