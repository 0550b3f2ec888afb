//! How well a fit knows its parameters.
//!
//! The fit is an M-estimator: with `r` the residuals, `J` their derivatives and `phi` the loss, its parameters scatter about the
//! true ones with the covariance `H^-1 S H^-1 / N`, `H = mean phi'' J'J`, `S = mean phi'^2 J'J` (Huber 1967, the sandwich), whatever
//! the distribution of the residuals. It holds for independent samples: those of one image or one table that miss the model
//! together know less than it says. A parameter that the samples press against its bound is taken as known, and so is one whose
//! bounds leave it no room.

use super::lobes::inner_knee;
use super::objective::{Loss, Objective, Terms};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Standard deviations on both sides of 95 %.
const NORMAL_95: f64 = 1.959964;
/// Standard deviation of a logarithm from which a direction counts as not identified: 95 % lie within a factor of 2.7.
const UNKNOWN: f64 = 0.5;
/// Knee of the loss whose curvature is taken, in units of the error: wide enough for many residuals to lie inside.
const SMOOTH: f64 = 0.2;
/// Curvature that counts as none, against the strongest: variances stay finite.
const UNSEEN: f64 = 1e-24;
/// The same of parameters together, each in its own unit: below is rounding.
const SINGULAR: f64 = 1e-12;
/// Largest exponent of a factor: intervals stay finite.
const LARGEST: f64 = 100.0;
/// Width of the range of a parameter's logarithm below which it was given, not sought: a hundredth.
const GIVEN: f64 = 0.01;
/// Least share of a parameter that is named in such a direction.
const NAMED: f64 = 0.25;

/// How well parameters are known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Diffuse, and of every lobe coefficient, roughness, F0 and `coefficient * F0`, what it reflects at normal incidence.
    pub parameters: Vec<Parameter>,
    /// Correlation of their logarithms, row by row; 0 with a parameter that is on its bound or was given.
    pub correlation: Vec<Vec<f64>>,
    /// Ways to change several parameters that the measurement hardly sees.
    pub unidentified: Vec<Direction>,
}

/// One parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// As "lobe 1 F0"; lobes count from 1.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Standard error of its logarithm, the relative one if it is small; `None` where it is on a bound or was given.
    pub relative_error: Option<f64>,
    /// The 95 % interval; the value itself where it is on a bound or was given.
    pub interval: [f64; 2],
}

/// A way to change several parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Direction {
    /// Standard deviation along it, of logarithms.
    pub deviation: f64,
    /// The parameters that change, and how: the squares of all sum to 1, those below 1/16 left out.
    pub parts: Vec<(String, f64)>,
}

impl Parameter {
    /// Whether a value lies in the interval.
    pub fn holds(&self, value: f64) -> bool {
        (self.interval[0]..=self.interval[1]).contains(&value)
    }
}

impl Uncertainty {
    /// Both, as independent of each other.
    pub(super) fn and(mut self, other: Self) -> Self {
        let (mine, theirs) = (self.parameters.len(), other.parameters.len());
        self.correlation.iter_mut().for_each(|row| row.extend(vec![0.0; theirs]));
        let moved = other.correlation.into_iter().map(|row| [vec![0.0; mine], row].concat());
        self.correlation.extend(moved);
        self.parameters.extend(other.parameters);
        self.unidentified.extend(other.unidentified);
        self
    }
}

/// How well `objective` knows `terms`, its minimum; `what` its lobes are called.
pub(super) fn of(objective: &Objective, terms: &Terms, what: &str) -> Uncertainty {
    let x = objective.pack(terms);
    let covariance = covariance(objective, terms, &x);
    let (names, values, map) = logarithms(terms, what);
    let spread = &map * covariance * map.transpose();
    let deviation: Vec<f64> = spread.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
    let parameter = |k: usize| {
        let known = deviation[k] > 0.0;
        let factor = (NORMAL_95 * deviation[k]).min(LARGEST).exp();
        // A reflectance is at most 1.
        let most = if names[k].ends_with(" F0") && !names[k].contains('*') { 1.0 } else { f64::INFINITY };
        Parameter {
            name: names[k].clone(),
            value: values[k],
            relative_error: known.then_some(deviation[k]),
            interval: [values[k] / factor, (values[k] * factor).min(most)],
        }
    };
    let correlate = |a: usize, b: usize| {
        let scale = deviation[a] * deviation[b];
        if scale > 0.0 { spread[(a, b)] / scale } else { 0.0 }
    };
    let n = names.len();
    Uncertainty {
        parameters: (0..n).map(parameter).collect(),
        correlation: (0..n).map(|a| (0..n).map(|b| correlate(a, b)).collect()).collect(),
        unidentified: unidentified(&names, &spread),
    }
}

/// The sandwich over the parameters that are free.
fn covariance(objective: &Objective, terms: &Terms, x: &DVector<f64>) -> DMatrix<f64> {
    let n = x.len();
    let knee = inner_knee(SMOOTH, objective.error(terms));
    let local = objective.local(x, |r| Loss::soft(r, knee));
    let scatter = objective.local(x, |r| {
        let loss = Loss::soft(r, knee);
        Loss { bend: loss.pull * loss.pull, ..loss }
    });
    let samples = objective.points.len().max(1) as f64;
    let on_bound = |k: usize| {
        let width = objective.upper[k] - objective.lower[k];
        if width < GIVEN {
            return true;
        }
        let room = 1e-6 * width;
        let there = x[k] <= objective.lower[k] + room || x[k] >= objective.upper[k] - room;
        // Chance alone takes what is not seen to a bound, too.
        there && local.gradient[k].abs() > 2.0 * (scatter.curvature[(k, k)] / samples).sqrt()
    };
    let free: Vec<usize> = (0..n).filter(|k| !on_bound(*k)).collect();
    if free.is_empty() {
        return DMatrix::zeros(n, n);
    }
    let part =
        |full: &DMatrix<f64>| DMatrix::from_fn(free.len(), free.len(), |a, b| full[(free[a], free[b])]);
    // In units of what each parameter alone is known to: one that no sample sees is unknown, whatever the others are.
    let curvature = part(&local.curvature);
    let strongest = curvature.diagonal().amax().max(f64::MIN_POSITIVE);
    let units = curvature.diagonal().map(|c| 1.0 / c.max(UNSEEN * strongest).sqrt());
    let eigen = DMatrix::from_fn(free.len(), free.len(), |a, b| units[a] * curvature[(a, b)] * units[b])
        .symmetric_eigen();
    let inverse = DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| 1.0 / v.max(SINGULAR)));
    let bread = DMatrix::from_diagonal(&units)
        * &eigen.eigenvectors
        * inverse
        * eigen.eigenvectors.transpose()
        * DMatrix::from_diagonal(&units);
    let small = &bread * part(&scatter.curvature) * &bread / samples;
    let mut covariance = DMatrix::zeros(n, n);
    for (a, row) in free.iter().enumerate() {
        for (b, column) in free.iter().enumerate() {
            covariance[(*row, *column)] = small[(a, b)];
        }
    }
    covariance
}

/// Names and values of the parameters as people know them, and their logarithms as a linear map of [`Objective::pack`]'s.
fn logarithms(terms: &Terms, what: &str) -> (Vec<String>, Vec<f64>, DMatrix<f64>) {
    let skip = usize::from(terms.diffuse.is_some());
    let n = skip + 3 * terms.lobes.len();
    let (mut names, mut values, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |name: String, value: f64, row: &[(usize, f64)]| {
        names.push(name);
        values.push(value);
        let mut full = vec![0.0; n];
        row.iter().for_each(|(k, weight)| full[*k] = *weight);
        rows.extend(full);
    };
    if let Some(diffuse) = terms.diffuse {
        add("diffuse".to_owned(), diffuse, &[(0, 1.0)]);
    }
    for (k, lobe) in terms.lobes.iter().enumerate() {
        let at = skip + 3 * k;
        let name =
            if terms.lobes.len() == 1 && skip == 0 { what.to_owned() } else { format!("{what} {}", k + 1) };
        add(format!("{name} coefficient"), lobe.coefficient, &[(at, 1.0), (at + 2, 1.0)]);
        add(format!("{name} roughness"), lobe.roughness, &[(at + 1, 1.0)]);
        add(format!("{name} F0"), lobe.f0, &[(at + 2, -1.0)]);
        add(format!("{name} coefficient * F0"), lobe.coefficient * lobe.f0, &[(at, 1.0)]);
    }
    let map = DMatrix::from_row_iterator(names.len(), n, rows);
    (names, values, map)
}

/// The principal directions of the covariance along which next to nothing is known.
fn unidentified(names: &[String], spread: &DMatrix<f64>) -> Vec<Direction> {
    // The products follow from their factors.
    let own: Vec<usize> = (0..names.len()).filter(|k| !names[*k].contains('*')).collect();
    if own.is_empty() {
        return Vec::new();
    }
    let eigen = DMatrix::from_fn(own.len(), own.len(), |a, b| spread[(own[a], own[b])]).symmetric_eigen();
    let mut found: Vec<Direction> = (0..own.len())
        .filter(|k| eigen.eigenvalues[*k] > UNKNOWN * UNKNOWN)
        .map(|k| {
            let direction = eigen.eigenvectors.column(k);
            let parts = own.iter().zip(direction.iter());
            let named = parts
                .filter(|(_, share)| share.abs() > NAMED)
                .map(|(at, share)| (names[*at].clone(), *share));
            Direction { deviation: eigen.eigenvalues[k].sqrt(), parts: named.collect() }
        })
        .collect();
    found.sort_by(|a, b| b.deviation.total_cmp(&a.deviation));
    found
}
