//! Transport between slices: solvers, ours and others'.

use super::Subject;
use super::measure::{Curve, Effort, Head, Trial, curve};
use super::peers::Peer;
use crate::error::Result;
use crate::report::{energetic_slices, problem};
use crate::transport::{Plan, Problem, SinkhornOptions, Solver, sinkhorn, solve};
use serde_json::{Value, json};

/// Weights of Sinkhorn's entropy, in mean costs.
const REGULARIZATIONS: [f64; 3] = [0.1, 0.01, 0.001];

/// Flamary et al. 2021, POT: Bonneel's network simplex in C++.
const POT: &str = r#"
import numpy, ot
problems = [[numpy.array(part) for part in one] for one in problem]
def run():
    return [float((ot.emd(p, q, w, numItermax=10**8, numThreads=1) * w).sum()) for p, q, w in problems]
"#;

/// HiGHS through SciPy (Huangfu & Hall 2018).
const SCIPY: &str = r#"
import numpy
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, eye, kron, vstack
def ready(p, q, w):
    p, q, w = (numpy.array(part) for part in (p, q, w))
    rows = kron(eye(len(p)), numpy.ones((1, len(q))))
    columns = kron(numpy.ones((1, len(p))), eye(len(q)))
    return w.ravel(), csr_matrix(vstack([rows, columns])), numpy.concatenate([p, q])
problems = [ready(*one) for one in problem]
def run():
    return [float(linprog(w, A_eq=a, b_eq=b, method="highs").fun) for w, a, b in problems]
"#;

/// Cost and largest error of a marginal of each problem.
type Found = Vec<[f64; 2]>;

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
    let peers = peers(&pairs);
    let pairs = &pairs;
    let all = move |one: &dyn Fn(&Problem) -> Result<Plan>| -> Result<Found> {
        let found = |plan: Plan| [plan.certificate.cost, plan.certificate.marginal_error];
        pairs.iter().map(|pair| one(pair).map(found)).collect()
    };
    let exact = Solver::compiled_in().map(|solver| {
        Trial::new(solver, solver == Solver::default(), move || all(&|pair| solve(pair, solver)))
    });
    let entropic = REGULARIZATIONS.map(|share| {
        let one = move |pair: &Problem| {
            let regularization = share * pair.mean_cost();
            sinkhorn(pair, SinkhornOptions { regularization, iterations: 1000, tolerance: 1e-9 })
        };
        Trial::new(format!("Sinkhorn, {share} mean cost"), false, move || all(&one))
    });
    let others = peers.iter().map(|peer| {
        let costs = || {
            let (costs, time) = peer.run()?;
            Ok((costs.into_iter().map(|cost| [cost, 0.0]).collect(), time))
        };
        Trial::timed(peer.name(), costs)
    });
    let trials: Vec<Trial<Found>> = exact.chain(entropic).chain(others).collect();
    let head = Head {
        stage: "Transport",
        knob: "solver (--solver)",
        error: "cost above the proven lower bound, and error of the marginals if that is larger, relative; the worst of the strongest \
                slices",
        why: "The network simplex is exact, gives the certificate that proves it, and is faster than the approximation: slices \
              have some fifty clusters, where an exact solution takes less than a sweep of entropic updates.",
    };
    let judge = |found: &Found| {
        let errors = found.iter().zip(pairs).zip(&bounds).map(|(([cost, marginals], pair), bound)| {
            ((cost - bound).abs() / bound.max(1e-3 * pair.mean_cost())).max(*marginals)
        });
        Ok((errors.fold(0.0, f64::max), None))
    };
    Ok(vec![curve(head, &trials, *effort, judge)?])
}

/// Those that Python has, with masses and costs of the same problems; their times hold no building of costs, ours do.
fn peers(pairs: &[Problem]) -> Vec<Peer> {
    let rows = |pair: &Problem| -> Value {
        let [p, q] = [pair.supply(), pair.demand()];
        let costs: Vec<&[f64]> = (0..p.len()).map(|i| pair.cost_row(i)).collect();
        json!([p, q, costs])
    };
    let problems: Value = pairs.iter().map(rows).collect();
    [("POT ot.emd", POT), ("SciPy linprog (HiGHS)", SCIPY)]
        .into_iter()
        .filter_map(|(name, script)| Peer::start(name, script, &problems))
        .collect()
}
