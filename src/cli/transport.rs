//! `carpaint transport`.

use super::{MAX_JSON_BYTES, output, progress::Bar};
use crate::error::{Error, Result};
use crate::file::read_text;
use crate::transport::{Certificate, Cost, Plan, Problem, Solver, solve};
use glam::DVec3;
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Solve transport problems and certify the optimum.
///
/// PROBLEM is a JSON object with `source_centres` and `target_centres` (lists of [L, a, b]) and their masses `p` and `q`,
/// optionally a `name`; or a list of such objects; or an object that has that list as `instances`. Other fields are
/// ignored.
#[derive(clap::Args)]
pub struct Arguments {
    /// File with one problem or several.
    #[arg(value_name = "PROBLEM.json")]
    problem: PathBuf,
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
    #[arg(long, value_name = "NAME", default_value_t, help = Solver::names())]
    solver: Solver,
    /// euclidean, squared or capped:T: the distance d, its square, or min(d, T), Delta-E.
    #[arg(long, value_name = "NAME", default_value_t)]
    cost: Cost,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let text = read_text(&self.problem, MAX_JSON_BYTES)?;
        let instances = parse(&text, self.cost).map_err(|e| e.in_file(&self.problem))?;
        let mut solved = Vec::with_capacity(instances.len());
        {
            let bar = Bar::new("transport", instances.len());
            let tick = bar.tick();
            for instance in instances {
                solved.push(Solved::new(instance, self.solver).map_err(|e| e.in_file(&self.problem))?);
                tick();
            }
        }
        if self.json {
            let rows: Vec<Value> = solved.iter().map(Solved::json).collect();
            output::say!("{:#}", json!({ "solver": self.solver.to_string(), "instances": rows }));
        } else {
            output::say!("{}", Solved::HEADER);
            solved.iter().for_each(|solved| output::say!("{}", solved.row()));
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The fields of one reference row that follow from its masses and centers.
pub(crate) fn eval_row(row: &Value) -> Result<Value> {
    let plan = solve(&problem(row, Cost::default())?, Solver::default())?;
    Ok(Value::Object(outcome(&plan.certificate)))
}

fn outcome(certificate: &Certificate) -> Map<String, Value> {
    let fields = [
        ("optimal_cost", json!(certificate.cost)),
        ("dual_lower_bound", json!(certificate.dual_bound)),
        ("plan_nonzeros", json!(certificate.positive_entries)),
        ("marginal_error", json!(certificate.marginal_error)),
    ];
    fields.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// A problem under its name.
struct Instance {
    name: String,
    problem: Problem,
}

/// Most pairs of a source and a target that are put as a linear program: with more, its general solver runs for hours.
const MAX_LINEAR_PROGRAM: usize = 1 << 18;

/// What one instance gave.
struct Solved {
    instance: Instance,
    plan: Plan,
    time_ms: f64,
}

impl Solved {
    const HEADER: &str = "name                      n_s  n_t                  cost       gap  reduced  entries  marginal       time";

    fn new(instance: Instance, solver: Solver) -> Result<Self> {
        let start = Instant::now();
        let pairs = instance.problem.supply().len() * instance.problem.demand().len();
        if matches!(solver, Solver::GoodLp(_)) && pairs > MAX_LINEAR_PROGRAM {
            let legal = format!("up to {MAX_LINEAR_PROGRAM} for {solver}; network-simplex takes more");
            return Err(Error::unsupported(&instance.name, "pairs of source and target", pairs, legal));
        }
        let plan = solve(&instance.problem, solver).map_err(|e| e.within(&instance.name))?;
        Ok(Self { instance, plan, time_ms: 1e3 * start.elapsed().as_secs_f64() })
    }

    fn row(&self) -> String {
        let c = &self.plan.certificate;
        let (sources, targets) = self.size();
        format!(
            "{:<24} {sources:>4} {targets:>4} {:>21.15} {:>9.1e} {:>8.0e} {:>8} {:>9.1e} {:>7.3} ms",
            self.instance.name,
            c.cost,
            c.gap,
            c.worst_reduced_cost,
            c.positive_entries,
            c.marginal_error,
            self.time_ms
        )
    }

    fn json(&self) -> Value {
        let (sources, targets) = self.size();
        let mut row = outcome(&self.plan.certificate);
        row.extend([
            ("name".to_owned(), json!(self.instance.name)),
            ("n_s".to_owned(), json!(sources)),
            ("n_t".to_owned(), json!(targets)),
            ("gap".to_owned(), json!(self.plan.certificate.gap)),
            ("worst_reduced_cost".to_owned(), json!(self.plan.certificate.worst_reduced_cost)),
            ("time_ms".to_owned(), json!(self.time_ms)),
        ]);
        Value::Object(row)
    }

    fn size(&self) -> (usize, usize) {
        (self.instance.problem.supply().len(), self.instance.problem.demand().len())
    }
}

fn parse(text: &str, cost: Cost) -> Result<Vec<Instance>> {
    let value: Value = serde_json::from_str(text)
        .map_err(|e| Error::invalid("JSON", "text", e, "one object or a list of objects"))?;
    rows(&value)?.iter().enumerate().map(|(k, row)| instance(k, row, cost)).collect()
}

/// The objects of all instances.
fn rows(value: &Value) -> Result<&[Value]> {
    let rows = match value {
        Value::Array(rows) => rows,
        Value::Object(fields) => match fields.get("instances") {
            None => return Ok(std::slice::from_ref(value)),
            Some(Value::Array(rows)) => rows,
            Some(other) => {
                return Err(Error::invalid("instances", "value", shown(other), "a list of objects"));
            }
        },
        other => {
            return Err(Error::invalid("JSON", "value", shown(other), "one object or a list of objects"));
        }
    };
    if rows.is_empty() {
        return Err(Error::invalid("instances", "number", 0, "at least 1"));
    }
    Ok(rows)
}

fn instance(index: usize, row: &Value, cost: Cost) -> Result<Instance> {
    let name = match row.get("name") {
        None => format!("instance {index}"),
        Some(Value::String(name)) => name.clone(),
        Some(other) => {
            let place = format!("instance {index}: name");
            return Err(Error::invalid(place, "value", shown(other), "a text"));
        }
    };
    let place = if row.get("name").is_some() { format!("instance {index} ({name})") } else { name.clone() };
    let problem = problem(row, cost).map_err(|e| e.within(place))?;
    Ok(Instance { name, problem })
}

fn problem(row: &Value, cost: Cost) -> Result<Problem> {
    Problem::from_centers(
        &list(row, "source_centres", "a list of three numbers", center)?,
        &list(row, "p", "a number", Value::as_f64)?,
        &list(row, "target_centres", "a list of three numbers", center)?,
        &list(row, "q", "a number", Value::as_f64)?,
        cost,
    )
}

fn center(value: &Value) -> Option<DVec3> {
    let components: Option<Vec<f64>> = value.as_array()?.iter().map(Value::as_f64).collect();
    <[f64; 3]>::try_from(components?).ok().map(DVec3::from)
}

fn list<T>(row: &Value, field: &str, legal: &str, read: impl Fn(&Value) -> Option<T>) -> Result<Vec<T>> {
    let items = match row.get(field) {
        Some(Value::Array(items)) => items,
        other => {
            let found = other.map_or("nothing".to_owned(), shown);
            return Err(Error::invalid(field, "value", found, format!("a list, each item {legal}")));
        }
    };
    let item = |(k, item): (usize, &Value)| {
        read(item).ok_or_else(|| Error::invalid(format!("{field}[{k}]"), "value", shown(item), legal))
    };
    items.iter().enumerate().map(item).collect()
}

/// JSON as an error shows it: the beginning, if it is long.
fn shown(value: &Value) -> String {
    const LONGEST: usize = 60;
    let text = value.to_string();
    let mut beginning: String = text.chars().take(LONGEST).collect();
    if beginning.len() < text.len() {
        beginning.push_str(" ...");
    }
    beginning
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_evaluated_under_the_names_of_the_reference() {
        let row =
            json!({ "source_centres": [[50, 0, 0]], "target_centres": [[50, 3, 4]], "p": [1], "q": [1] });
        let expected = json!({ "optimal_cost": 5.0, "dual_lower_bound": 5.0, "plan_nonzeros": 1, "marginal_error": 0.0 });
        assert_eq!(eval_row(&row).expect("legal"), expected);
        let message = eval_row(&json!({})).expect_err("no fields").to_string();
        assert!(message.starts_with("source_centres: value: found nothing"), "{message}");
    }
}
