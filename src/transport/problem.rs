//! The transport problem and its laws.

use super::cost::Cost;
use super::lanes;
use super::sum::Sum;
use crate::error::{Error, Result};
use glam::DVec3;

/// Masses to be moved and what moving them costs (Golla & Klein 2018, eqs 8-13).
///
/// Totals need not be 1. Masses of 0 are legal and carry no flow.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    supply: Vec<f64>,
    demand: Vec<f64>,
    cost: Vec<f64>,
    mean_cost: f64,
    largest_cost: f64,
}

impl Problem {
    /// Most pairs of a source and a target: costs fill half a gibibyte.
    pub const MAX_PAIRS: usize = 1 << 26;
    /// Largest mass and largest cost, so that no product of them overflows.
    pub const LARGEST: f64 = 1e150;
    /// Largest relative difference of the two totals.
    pub const TOTAL_TOLERANCE: f64 = 1e-9;

    /// Masses `p` of the sources, `q` of the targets, and costs `w` of a unit of mass, source by source.
    ///
    /// The sources count: where the totals differ by more than the rounding of a sum, all demands are scaled to the
    /// total of the supplies; what rounding leaves is borne by the largest demand.
    ///
    /// # Errors
    /// No or too many sources or targets, a mass or cost that is outside 0 to [`Problem::LARGEST`], a total of 0,
    /// totals that differ by more than [`Problem::TOTAL_TOLERANCE`], a matrix of another size.
    pub fn new(p: Vec<f64>, mut q: Vec<f64>, w: Vec<f64>) -> Result<Self> {
        let pairs = check_size(&p, &q)?;
        if w.len() != pairs {
            let legal = format!("{pairs} ({} x {})", p.len(), q.len());
            return Err(Error::invalid("w", "number of costs", w.len(), legal));
        }
        let (supplied, demanded) = (total("p", &p)?, total("q", &q)?);
        let ratio = supplied / demanded;
        if (ratio - 1.0).abs() > Self::TOTAL_TOLERANCE {
            let legal = format!("the total of p, {supplied}, within {:e} of it", Self::TOTAL_TOLERANCE);
            return Err(Error::invalid("q", "total mass", demanded, legal));
        }
        // Equal masses on both sides stay equal, to the bit, when only the rounding of a normalization differs.
        if (ratio - 1.0).abs() > 4.0 * f64::EPSILON {
            q.iter_mut().for_each(|mass| *mass *= ratio);
        }
        if let Some(k) = w.iter().position(|&cost| !legal_amount(cost)) {
            let place = format!("w[{}][{}]", k / q.len(), k % q.len());
            return Err(Error::invalid(place, "cost", w[k], LEGAL_AMOUNT));
        }
        let mean_cost = lanes::sum(&w) / w.len() as f64;
        let largest_cost = lanes::largest(&w);
        Ok(Self { supply: p, demand: q, cost: w, mean_cost, largest_cost })
    }

    /// The same with the cost given as a function of source and target.
    ///
    /// # Errors
    /// Those of [`Problem::new`].
    pub fn from_fn(p: &[f64], q: &[f64], w: impl Fn(usize, usize) -> f64) -> Result<Self> {
        let mut cost = Vec::with_capacity(check_size(p, q)?);
        for i in 0..p.len() {
            cost.extend((0..q.len()).map(|j| w(i, j)));
        }
        Self::new(p.to_vec(), q.to_vec(), cost)
    }

    /// Clusters with centers in Lab and probabilities `p` and `q`, at the given cost of the way between two centers (eq. 8).
    ///
    /// # Errors
    /// Another number of centers than masses, a coordinate beyond a tenth of [`Problem::LARGEST`], an illegal cap; those
    /// of [`Problem::new`].
    pub fn from_centers(
        source: &[DVec3],
        p: &[f64],
        target: &[DVec3],
        q: &[f64],
        cost: Cost,
    ) -> Result<Self> {
        let cost = cost.validated()?;
        for (name, centers, mass_name, masses) in [("source", source, "p", p), ("target", target, "q", q)] {
            if centers.len() != masses.len() {
                let legal = format!("{}, as many as {mass_name} has", masses.len());
                return Err(Error::invalid(format!("{name} centers"), "number", centers.len(), legal));
            }
            let legal_coordinate = |x: f64| x.abs() <= 0.1 * Self::LARGEST;
            if let Some(k) = centers.iter().position(|c| !c.to_array().into_iter().all(legal_coordinate)) {
                let place = format!("{name} centers[{k}]");
                return Err(Error::invalid(place, "coordinates", centers[k], "each -1e149 to 1e149"));
            }
        }
        let mut costs = Vec::with_capacity(check_size(p, q)?);
        let coordinates = [0, 1, 2].map(|k| target.iter().map(|center| center[k]).collect());
        source.iter().for_each(|from| cost.extend_row(&mut costs, *from, &coordinates));
        Self::new(p.to_vec(), q.to_vec(), costs)
    }

    /// Masses of the sources.
    pub fn supply(&self) -> &[f64] {
        &self.supply
    }

    /// Masses of the targets, scaled to the total of the supplies.
    pub fn demand(&self) -> &[f64] {
        &self.demand
    }

    /// Cost of moving a unit of mass from source `i` to every target.
    pub fn cost_row(&self, i: usize) -> &[f64] {
        &self.cost[i * self.demand.len()..][..self.demand.len()]
    }

    /// Cost of moving a unit of mass from source `i` to target `j`.
    pub fn cost(&self, i: usize, j: usize) -> f64 {
        self.cost_row(i)[j]
    }

    /// Mean over all pairs of the cost of a unit of mass: the scale against which errors are judged.
    pub fn mean_cost(&self) -> f64 {
        self.mean_cost
    }

    /// Largest cost of a unit of mass.
    pub fn largest_cost(&self) -> f64 {
        self.largest_cost
    }
}

const LEGAL_AMOUNT: &str = "0 to 1e150";

fn legal_amount(x: f64) -> bool {
    (0.0..=Problem::LARGEST).contains(&x)
}

fn check_size(p: &[f64], q: &[f64]) -> Result<usize> {
    for (place, masses) in [("p", p), ("q", q)] {
        if masses.is_empty() {
            return Err(Error::invalid(place, "number of masses", 0, "at least 1"));
        }
    }
    match p.len().checked_mul(q.len()) {
        Some(pairs) if pairs <= Problem::MAX_PAIRS => Ok(pairs),
        _ => {
            let found = format!("{} x {}", p.len(), q.len());
            Err(Error::invalid("p, q", "number of pairs", found, format!("at most {}", Problem::MAX_PAIRS)))
        }
    }
}

fn total(name: &str, masses: &[f64]) -> Result<f64> {
    if let Some(k) = masses.iter().position(|&mass| !legal_amount(mass)) {
        return Err(Error::invalid(format!("{name}[{k}]"), "mass", masses[k], LEGAL_AMOUNT));
    }
    let total = masses.iter().copied().collect::<Sum>().value();
    if total > 0.0 { Ok(total) } else { Err(Error::invalid(name, "total mass", total, "above 0")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(p: &[f64], q: &[f64], cost: f64) -> String {
        Problem::from_fn(p, q, |i, _| if i == 0 { cost } else { 1.0 }).expect_err("illegal").to_string()
    }

    #[test]
    fn faults_name_place_value_and_range() {
        assert_eq!(message(&[1.0], &[0.5, -0.5], 1.0), "q[1]: mass: found -0.5, expected 0 to 1e150");
        assert!(message(&[f64::NAN], &[1.0], 1.0).starts_with("p[0]: mass: found NaN"));
        assert!(message(&[f64::INFINITY], &[1.0], 1.0).starts_with("p[0]: mass: found inf"));
        assert!(message(&[0.0], &[1.0], 1.0).starts_with("p: total mass: found 0"));
        assert!(message(&[2e150], &[1.0], 1.0).starts_with("p[0]: mass: found 2000000"));
        assert!(message(&[], &[1.0], 1.0).starts_with("p: number of masses: found 0"));
        assert!(message(&[1.0], &[1.0 + 2e-9], 1.0).starts_with("q: total mass: found 1.000000002"));
        assert!(message(&[1.0], &[0.5, 0.5], -1.0).starts_with("w[0][0]: cost: found -1"));
        assert!(message(&[1.0], &[0.5, 0.5], f64::NAN).starts_with("w[0][0]: cost: found NaN"));
        let wrong_size = Problem::new(vec![1.0], vec![1.0], vec![]).expect_err("illegal").to_string();
        assert_eq!(wrong_size, "w: number of costs: found 0, expected 1 (1 x 1)");
        let centers =
            Problem::from_centers(&[], &[1.0], &[DVec3::ZERO], &[1.0], Cost::Euclidean).expect_err("illegal");
        let far = Problem::from_centers(&[DVec3::MAX], &[1.0], &[DVec3::ZERO], &[1.0], Cost::Euclidean)
            .expect_err("illegal");
        assert!(far.to_string().starts_with("source centers[0]: coordinates: found ["));
        assert_eq!(centers.to_string(), "source centers: number: found 0, expected 1, as many as p has");
    }

    #[test]
    fn demands_are_scaled_to_the_supplies() {
        let problem = Problem::from_fn(&[2.0], &[1.0 + 1e-10, 1.0], |_, _| 1.0).expect("legal");
        let sum: f64 = problem.demand().iter().sum();
        // One rounding each of ratio, products and sum.
        assert!((sum / 2.0 - 1.0).abs() < 4.0 * f64::EPSILON);
        // Rounding alone is no reason to touch them.
        let q = [0.1; 10];
        assert_eq!(Problem::from_fn(&[1.0], &q, |_, _| 1.0).expect("legal").demand(), q);
    }
}
