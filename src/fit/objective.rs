//! The logarithmic error of a set of lobes, with its slopes and curvature.
//!
//! Eq. 7 of Rump et al. 2008, read as the mean over samples of `|r|`, `r = ln((max(Psi, 0) + eps) / (M + eps))`, M the mean of
//! the model over the points of the light. What is lowered is `sqrt(r^2 + k^2) - k`, which is eq. 7 itself for a knee k of 0.
//! The plausible (eq. 8's P) is a box: a wall of a big constant has no slope to follow.

use super::points::Points;
use crate::brdf::cook_torrance::brightness;
use crate::brdf::{Lobe, LobeGeometry};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Samples that one task sums up: the sums, and so the bits, hang on it but not on the number of threads.
const CHUNK: usize = 2048;

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

/// What differs between metallic lobes and gloss: legal roughness and F0, least and greatest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    pub roughness: [f64; 2],
    pub f0: [f64; 2],
}

/// Legal diffuse terms and normal reflectances `s F0`: from nothing to see to more than any paint.
const STRENGTH: (f64, f64) = (1e-8, 1e2);
/// Least F0: from 33 degrees off the half vector on such a lobe is more than half Schlick's rise, which less F0 leaves alone. More,
/// as 0.01 or a dielectric's 0.04, fits worse where there are samples, and where there are none, at grazing angles, as often worse
/// as better.
pub(super) const LEAST_F0: f64 = 1e-4;

/// The error over a set of points, as a function of the parameters of terms of one shape.
pub(super) struct Objective<'a> {
    pub points: &'a Points,
    diffuse: bool,
    /// Bounds of the parameters.
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
}

/// The error at some parameters.
#[derive(Debug, Clone)]
pub(super) struct Local {
    /// Mean loss.
    pub cost: f64,
    /// Its gradient.
    pub gradient: DVector<f64>,
    /// `J' W J / N`, J the derivatives of the residuals and W the loss's curvature: the Hessian but for that of the model.
    pub curvature: DMatrix<f64>,
}

/// What a residual costs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loss {
    pub cost: f64,
    /// Its slope.
    pub pull: f64,
    /// Its curvature.
    pub bend: f64,
}

impl Loss {
    /// `sqrt(r^2 + k^2) - k`.
    pub fn soft(r: f64, knee: f64) -> Self {
        let height = r.hypot(knee);
        if height > 0.0 {
            Self { cost: height - knee, pull: r / height, bend: knee * knee / height.powi(3) }
        } else {
            Self { cost: 0.0, pull: 0.0, bend: 0.0 }
        }
    }
}

impl<'a> Objective<'a> {
    /// The objective over `points` for terms of the shape of `like`.
    pub fn new(points: &'a Points, like: &Terms, range: Range) -> Self {
        let bounds = |strength: f64, roughness: f64, drop: f64| {
            let lobe = [strength.ln(), roughness.ln(), drop];
            let diffuse = like.diffuse.map(|_| strength.ln());
            let all: Vec<f64> = diffuse.into_iter().chain(like.lobes.iter().flat_map(|_| lobe)).collect();
            DVector::from_vec(all)
        };
        let lower = bounds(STRENGTH.0, range.roughness[0], -range.f0[1].ln());
        let upper = bounds(STRENGTH.1, range.roughness[1], -range.f0[0].ln());
        Self { points, diffuse: like.diffuse.is_some(), lower, upper }
    }

    /// Eq. 7 over the points.
    pub fn error(&self, terms: &Terms) -> f64 {
        let sum: f64 = (0..self.points.len()).map(|k| self.residual(k, terms).abs()).sum();
        sum / self.points.len().max(1) as f64
    }

    /// The parameters of `terms`, inside the bounds: logarithms of diffuse, of `s F0` and of roughness, and `-ln F0`.
    /// What all angles but grazing ones see is `s F0`; with F0 apart, the long valley between both lies along an axis.
    pub fn pack(&self, terms: &Terms) -> DVector<f64> {
        let lobes = terms.lobes.iter().flat_map(|l| {
            let f0 = l.f0.max(LEAST_F0);
            [(l.coefficient * f0).ln(), l.roughness.ln(), -f0.ln()]
        });
        let all: Vec<f64> = terms.diffuse.iter().map(|a| a.ln()).chain(lobes).collect();
        self.clamp(DVector::from_vec(all))
    }

    /// The terms of parameters.
    pub fn unpack(&self, x: &DVector<f64>) -> Terms {
        let lobe = |x: &[f64]| {
            let f0 = (-x[2]).exp();
            Lobe { coefficient: x[0].exp() / f0, roughness: x[1].exp(), f0 }
        };
        let skip = usize::from(self.diffuse);
        let lobes = x.as_slice()[skip..].chunks_exact(3).map(lobe).collect();
        Terms { diffuse: self.diffuse.then(|| x[0].exp()), lobes }
    }

    /// The nearest parameters inside the bounds.
    pub fn clamp(&self, x: DVector<f64>) -> DVector<f64> {
        x.zip_zip_map(&self.lower, &self.upper, |x, low, high| x.clamp(low, high))
    }

    /// Loss, gradient and curvature at `x`.
    pub fn local(&self, x: &DVector<f64>, loss: impl Fn(f64) -> Loss + Sync) -> Local {
        let terms = self.unpack(x);
        let n = self.points.len();
        let chunks: Vec<Sums> = (0..n.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let mut sums = Sums::new(x.len());
                let mut slopes = vec![0.0; x.len()];
                for k in chunk * CHUNK..n.min((chunk + 1) * CHUNK) {
                    let r = self.slopes(k, &terms, &mut slopes);
                    sums.push(loss(r), &slopes);
                }
                sums
            })
            .collect();
        let mut all = Sums::new(x.len());
        chunks.iter().for_each(|chunk| all.add(chunk));
        all.mean(n)
    }

    fn model(&self, k: usize, terms: &Terms) -> f64 {
        let mut sum = self.points.rest[k] + self.points.diffuse[k] * terms.diffuse.unwrap_or(0.0);
        for lobe in &terms.lobes {
            sum += self.points.lights(k).iter().map(|light| light.lobe(lobe)[0]).sum::<f64>();
        }
        sum
    }

    /// The residual of sample `k`.
    pub fn residual(&self, k: usize, terms: &Terms) -> f64 {
        self.points.measured[k] - (self.model(k, terms) + self.points.epsilon).ln()
    }

    /// The residual of sample `k` and, into `slopes`, its derivatives by the parameters.
    pub fn slopes(&self, k: usize, terms: &Terms, slopes: &mut [f64]) -> f64 {
        let diffuse = self.points.diffuse[k] * terms.diffuse.unwrap_or(0.0);
        let mut model = self.points.rest[k] + diffuse;
        let skip = usize::from(self.diffuse);
        slopes[..skip].fill(diffuse);
        for (lobe, slopes) in terms.lobes.iter().zip(slopes[skip..].chunks_exact_mut(3)) {
            let mut sum = [0.0; 3];
            for light in self.points.lights(k) {
                sum.iter_mut().zip(light.lobe(lobe)).for_each(|(sum, part)| *sum += part);
            }
            model += sum[0];
            // At a fixed s F0 a larger -ln F0 is a larger s and a smaller F0.
            slopes.copy_from_slice(&[sum[0], sum[1], sum[0] - sum[2] * lobe.f0]);
        }
        let scale = -1.0 / (model + self.points.epsilon);
        slopes.iter_mut().for_each(|slope| *slope *= scale);
        self.points.measured[k] - (model + self.points.epsilon).ln()
    }
}

/// Sums over samples; of the symmetric matrix the lower triangle.
struct Sums {
    cost: f64,
    gradient: Vec<f64>,
    curvature: Vec<f64>,
}

impl Sums {
    fn new(n: usize) -> Self {
        Self { cost: 0.0, gradient: vec![0.0; n], curvature: vec![0.0; n * (n + 1) / 2] }
    }

    /// Adds a sample's loss; `slopes` are the derivatives of its residual.
    fn push(&mut self, loss: Loss, slopes: &[f64]) {
        self.cost += loss.cost;
        let mut rest = self.curvature.as_mut_slice();
        for (row, (a, gradient)) in slopes.iter().zip(&mut self.gradient).enumerate() {
            *gradient += loss.pull * a;
            let bent = loss.bend * a;
            let (line, after) = rest.split_at_mut(row + 1);
            line.iter_mut().zip(slopes).for_each(|(sum, b)| *sum += bent * b);
            rest = after;
        }
    }

    fn add(&mut self, other: &Self) {
        self.cost += other.cost;
        self.gradient.iter_mut().zip(&other.gradient).for_each(|(a, b)| *a += b);
        self.curvature.iter_mut().zip(&other.curvature).for_each(|(a, b)| *a += b);
    }

    fn mean(self, samples: usize) -> Local {
        let n = self.gradient.len();
        let scale = 1.0 / samples.max(1) as f64;
        let triangle = &self.curvature;
        let curvature =
            DMatrix::from_fn(n, n, |a, b| scale * triangle[a.max(b) * (a.max(b) + 1) / 2 + a.min(b)]);
        Local { cost: scale * self.cost, curvature, gradient: DVector::from_vec(self.gradient) * scale }
    }
}

#[cfg(test)]
mod tests {
    use super::super::optimizer::Optimizer;
    use super::*;
    use crate::math::half_difference::directions;
    use glam::DVec3;

    fn truth() -> Terms {
        Terms {
            diffuse: Some(0.03),
            lobes: vec![
                Lobe { coefficient: 0.1, roughness: 0.6, f0: 0.2 },
                Lobe { coefficient: 0.2, roughness: 0.2, f0: 0.5 },
            ],
        }
    }

    /// Exact samples, each under two points of light.
    fn points() -> Points {
        let mut points = Points::new(1e-5);
        for k in 0..12 * 8 * 3 {
            let (h, i, p) = (f64::from(k % 12), f64::from(k / 12 % 8), f64::from(k / 96));
            let (wi, wo) = directions(0.02 + 0.1 * h, 0.05 + 0.15 * i, 1.5 * p);
            let other = (wi + DVec3::new(0.02, 0.01, 0.0)).normalize();
            if wi.z > 0.05 && wo.z > 0.05 && other.z > 0.05 {
                let lights = [(LobeGeometry::of(wi, wo), 0.6), (LobeGeometry::of(other, wo), 0.3)];
                let light: f64 = lights.iter().map(|(g, weight)| weight * truth().brightness(g)).sum();
                points.push(light + 0.001, 0.001, lights);
            }
        }
        points
    }

    #[test]
    fn slopes_agree_with_differences() {
        let points = points();
        let objective =
            Objective::new(&points, &truth(), Range { roughness: [0.02, 2.0], f0: [LEAST_F0, 1.0] });
        let x = objective.pack(&truth()).add_scalar(-0.1);
        let step = 1e-5;
        for k in 0..points.len() {
            let mut slopes = vec![0.0; x.len()];
            objective.slopes(k, &objective.unpack(&x), &mut slopes);
            for (c, slope) in slopes.iter().enumerate() {
                let at = |side: f64| {
                    let mut moved = x.clone();
                    moved[c] += side * step;
                    objective.residual(k, &objective.unpack(&moved))
                };
                let difference = (at(1.0) - at(-1.0)) / (2.0 * step);
                // Central differences: a third derivative of up to some 100, far from the peak, times step^2 / 6.
                assert!((slope - difference).abs() < 1e-7, "sample {k}, parameter {c}: {slope} {difference}");
            }
        }
    }

    #[test]
    fn exact_data_give_the_lobes_back() {
        let points = points();
        let start = Terms {
            diffuse: Some(0.1),
            lobes: vec![
                Lobe { coefficient: 0.05, roughness: 0.9, f0: 0.5 },
                Lobe { coefficient: 0.05, roughness: 0.3, f0: 0.3 },
            ],
        };
        let objective =
            Objective::new(&points, &start, Range { roughness: [0.02, 2.0], f0: [LEAST_F0, 1.0] });
        let round = Optimizer::LevenbergMarquardt.fit(&objective, &start, 0.05).unwrap();
        let fitted = Optimizer::LevenbergMarquardt.fit(&objective, &round.terms, 1e-3).unwrap();
        // The knee rounds off what is below it.
        assert!(fitted.error < 1e-4, "{fitted:?}");
        for (a, b) in fitted.terms.lobes.iter().zip(&truth().lobes) {
            assert!((a.roughness / b.roughness - 1.0).abs() < 1e-2, "{a:?} {b:?}");
        }
    }
}
