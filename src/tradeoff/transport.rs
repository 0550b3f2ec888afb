//! Transport between slices: solvers.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use crate::error::Result;
use crate::report::{energetic_slices, problem};
use crate::transport::{Plan, Problem, SinkhornOptions, Solver, sinkhorn, solve};

/// Weights of Sinkhorn's entropy, in mean costs.
const REGULARIZATIONS: [f64; 3] = [0.1, 0.01, 0.001];

pub(super) fn curves(subject: &Subject, effort: &Effort) -> Result<Vec<Curve>> {
    let flakes = [&subject.chain, &subject.other].map(|chain| chain.paint.flakes.as_ref());
    let [Some(a), Some(b)] = flakes else { return Ok(Vec::new()) };
    let slices = energetic_slices(&subject.chain.btf);
    let pairs = slices
        .iter()
        .map(|k| problem(&a.levels[0].slices[*k], &b.levels[0].slices[*k]))
        .collect::<Result<Vec<Problem>>>()?;
    let bounds = pairs
        .iter()
        .map(|pair| Ok(solve(pair, Solver::NetworkSimplex)?.certificate.dual_bound))
        .collect::<Result<Vec<f64>>>()?;
    let pairs = &pairs;
    let exact = Solver::compiled_in().map(|solver| {
        let work = move || pairs.iter().map(|pair| solve(pair, solver)).collect::<Result<Vec<Plan>>>();
        Trial::new(solver, solver == Solver::default(), work)
    });
    let entropic = REGULARIZATIONS.map(|share| {
        let one = move |pair: &Problem| {
            let regularization = share * pair.mean_cost();
            sinkhorn(pair, SinkhornOptions { regularization, iterations: 1000, tolerance: 1e-9 })
        };
        Trial::new(format!("Sinkhorn, {share} mean cost"), false, move || pairs.iter().map(one).collect())
    });
    let trials: Vec<Trial<Vec<Plan>>> = exact.chain(entropic).collect();
    let head = Head {
        stage: "Transport",
        knob: "solver (--solver)",
        error: "cost above the proven lower bound, and error of the marginals if that is larger, relative; the worst of the strongest \
                slices",
        why: "The network simplex is exact, gives the certificate that proves it, and is faster than the approximation: slices \
              have some fifty clusters, where an exact solution takes less than a sweep of entropic updates.",
    };
    let judge = |plans: &Vec<Plan>| {
        let errors = plans.iter().zip(pairs).zip(&bounds).map(|((plan, pair), bound)| {
            let cost = (plan.certificate.cost - bound).abs() / bound.max(1e-3 * pair.mean_cost());
            cost.max(plan.certificate.marginal_error)
        });
        Ok((errors.fold(0.0, f64::max), None))
    };
    Ok(vec![curve(head, &trials, *effort, judge)?])
}
