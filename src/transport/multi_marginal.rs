//! Exact transport between three and more distributions at once, for small numbers of clusters.
//!
//! Paints are coupled one after the other (Golla & Klein 2018, section 4.3), so that the result depends on their order. What
//! that costs is the distance to the optimum over all couplings `x_ijk...`: sums over all indices but one are the masses of
//! that paint, and a coupled group of clusters costs the sum of the costs between its pairs. That sum favors no paint;
//! of two paints it is the transport problem itself.

use super::cost::Cost;
use crate::error::{Error, Result};
use glam::DVec3;
use good_lp::{Expression, ProblemVariables, Solution, SolverModel, variable};

/// Most groups of one cluster of each paint: beyond, the linear program takes seconds.
const MAX_GROUPS: usize = 1 << 12;

/// Clusters of one paint: centers in Lab and probabilities.
#[derive(Debug, Clone, PartialEq)]
pub struct Marginal {
    /// Center of each cluster.
    pub centers: Vec<DVec3>,
    /// Probability of each cluster; all together 1.
    pub masses: Vec<f64>,
}

/// A coupling of all paints.
#[derive(Debug, Clone, PartialEq)]
pub struct MultiMarginalPlan {
    /// For each group its cluster in every paint, and its probability, above 0.
    pub entries: Vec<(Vec<usize>, f64)>,
    /// Sum of the groups' costs times their probabilities; exact to some 1e-9 of the largest cost.
    pub cost: f64,
}

/// Sum of the costs between all pairs of centers.
pub fn pairwise_cost(centers: &[DVec3], cost: Cost) -> f64 {
    let pairs = centers.iter().enumerate().flat_map(|(k, a)| centers[..k].iter().map(move |b| (*a, *b)));
    pairs.map(|(a, b)| cost.between(a, b)).sum()
}

/// The coupling of least total pairwise cost, as a linear program through microlp.
///
/// # Errors
/// Fewer than two paints, a paint without clusters or with other numbers of centers and masses, masses that are negative or
/// whose sum is not 1 to 1e-9, more than 4,096 groups, an illegal cost, a solver that gives up.
pub fn multi_marginal(paints: &[Marginal], cost: Cost) -> Result<MultiMarginalPlan> {
    let cost = cost.validated()?;
    let groups = check(paints)?;
    let members: Vec<Vec<usize>> = (0..groups).map(|group| clusters(paints, group)).collect();
    let costs: Vec<f64> = members
        .iter()
        .map(|clusters| {
            let centers: Vec<DVec3> =
                paints.iter().zip(clusters).map(|(paint, k)| paint.centers[*k]).collect();
            pairwise_cost(&centers, cost)
        })
        .collect();
    let unit = costs.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut variables = ProblemVariables::new();
    let flows = variables.add_vector(variable().min(0.0), groups);
    let objective: Expression = flows.iter().zip(&costs).map(|(&flow, cost)| cost / unit * flow).sum();
    let mut model = variables.minimise(objective).using(good_lp::microlp);
    for (place, paint) in paints.iter().enumerate() {
        let largest = (0..paint.masses.len()).max_by(|&a, &b| paint.masses[a].total_cmp(&paint.masses[b]));
        // But for the first paint, the largest mass follows from the others.
        for cluster in (0..paint.masses.len()).filter(|&k| place == 0 || Some(k) != largest) {
            let own = flows.iter().zip(&members).filter(|(_, clusters)| clusters[place] == cluster);
            let sum: Expression = own.map(|(flow, _)| *flow).sum();
            model = model.with(sum.eq(paint.masses[cluster]));
        }
    }
    let solution = model.solve().map_err(|cause| {
        Error::not_converged("multi-marginal transport", "linear program", cause, "an optimum")
    })?;
    let masses = flows.iter().map(|&flow| solution.value(flow));
    let entries: Vec<(Vec<usize>, f64)> =
        members.into_iter().zip(masses.clone()).filter(|entry| entry.1 > 0.0).collect();
    Ok(MultiMarginalPlan { cost: masses.zip(&costs).map(|(mass, cost)| mass.max(0.0) * cost).sum(), entries })
}

/// Number of groups.
fn check(paints: &[Marginal]) -> Result<usize> {
    if paints.len() < 2 {
        return Err(Error::invalid(
            "multi-marginal transport",
            "number of paints",
            paints.len(),
            "at least 2",
        ));
    }
    for (k, Marginal { centers, masses }) in paints.iter().enumerate() {
        let place = format!("paint {k}");
        if masses.is_empty() || centers.len() != masses.len() {
            let legal = format!("{}, at least 1, as many as masses", masses.len().max(1));
            return Err(Error::invalid(place, "number of centers", centers.len(), legal));
        }
        if let Some(mass) = masses.iter().find(|mass| !(0.0..=1.0 + 1e-9).contains(*mass)) {
            return Err(Error::invalid(place, "mass", mass, "0 to 1"));
        }
        let total: f64 = masses.iter().sum();
        if (total - 1.0).abs() > 1e-9 {
            return Err(Error::invalid(place, "total mass", total, "1"));
        }
    }
    let groups = paints.iter().try_fold(1_usize, |groups, paint| groups.checked_mul(paint.masses.len()));
    groups.filter(|groups| *groups <= MAX_GROUPS).ok_or_else(|| {
        let sizes: Vec<String> = paints.iter().map(|paint| paint.masses.len().to_string()).collect();
        let legal = format!("at most {MAX_GROUPS}");
        Error::invalid("multi-marginal transport", "number of groups", sizes.join(" x "), legal)
    })
}

/// The cluster of every paint in a group.
fn clusters(paints: &[Marginal], mut group: usize) -> Vec<usize> {
    let digit = |paint: &Marginal| {
        let n = paint.masses.len();
        let cluster = group % n;
        group /= n;
        cluster
    };
    paints.iter().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::{Problem, Solver, solve};

    fn gray(lightness: &[f64], masses: &[f64]) -> Marginal {
        let centers = lightness.iter().map(|l| DVec3::new(*l, 0.0, 0.0)).collect();
        Marginal { centers, masses: masses.to_vec() }
    }

    #[test]
    fn two_paints_are_the_transport_problem() {
        let (a, b) = (gray(&[10.0, 50.0, 90.0], &[0.25, 0.25, 0.5]), gray(&[20.0, 60.0], &[0.625, 0.375]));
        let problem = Problem::from_centers(&a.centers, &a.masses, &b.centers, &b.masses, Cost::Euclidean);
        let exact = solve(&problem.expect("legal"), Solver::default()).expect("solvable").certificate.cost;
        let plan = multi_marginal(&[a, b], Cost::Euclidean).expect("solvable");
        // The tolerance of the linear program.
        assert!((plan.cost - exact).abs() < 1e-7, "{} {exact}", plan.cost);
    }

    /// On a line the monotone coupling is optimal for all pairs at once.
    #[test]
    fn gray_paints_are_coupled_in_order() {
        let paints = [
            gray(&[10.0, 40.0], &[0.5, 0.5]),
            gray(&[30.0, 20.0], &[0.5, 0.5]),
            gray(&[90.0, 60.0, 70.0], &[0.25, 0.5, 0.25]),
        ];
        let plan = multi_marginal(&paints, Cost::Euclidean).expect("solvable");
        let expected = [(vec![0, 1, 1], 0.5), (vec![1, 0, 2], 0.25), (vec![1, 0, 0], 0.25)];
        let cost: f64 = expected
            .iter()
            .map(|(clusters, mass)| {
                let centers: Vec<DVec3> = paints.iter().zip(clusters).map(|(p, k)| p.centers[*k]).collect();
                mass * pairwise_cost(&centers, Cost::Euclidean)
            })
            .sum();
        assert!((plan.cost - cost).abs() < 1e-7, "{} {cost}", plan.cost);
        assert!((plan.entries.iter().map(|entry| entry.1).sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn illegal_paints_are_refused() {
        let one = || gray(&[1.0], &[1.0]);
        let many = || gray(&[1.0; 20], &[0.05; 20]);
        for paints in [
            vec![one()],
            vec![one(), gray(&[], &[])],
            vec![one(), gray(&[1.0, 2.0], &[1.0])],
            vec![one(), gray(&[1.0, 2.0], &[0.5, 0.4])],
            vec![one(), gray(&[1.0, 2.0], &[1.5, -0.5])],
            vec![many(), many(), many()],
        ] {
            assert!(multi_marginal(&paints, Cost::Euclidean).is_err());
        }
        assert!(multi_marginal(&[one(), one()], Cost::Capped(-1.0)).is_err());
    }
}
