//! `carpaint report --hard-cases`.

use super::output;
use crate::error::Result;
use crate::hard_cases::{HardCase, hard_cases};
use std::process::ExitCode;

/// Prints all cases; exit code 1 if one is past its bar.
pub fn print_hard_cases(json: bool) -> Result<ExitCode> {
    let cases = hard_cases()?;
    if json {
        output::json(&cases.iter().map(Row::from).collect::<Vec<_>>())?;
    } else {
        print_table(&cases);
    }
    Ok(if cases.iter().all(HardCase::passes) { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// A case and its verdict.
#[derive(serde::Serialize)]
struct Row<'a> {
    #[serde(flatten)]
    case: &'a HardCase,
    passes: bool,
}

impl<'a> From<&'a HardCase> for Row<'a> {
    fn from(case: &'a HardCase) -> Self {
        Self { case, passes: case.passes() }
    }
}

fn print_table(cases: &[HardCase]) {
    let width =
        |text: fn(&HardCase) -> &str| cases.iter().map(|c| text(c).chars().count()).max().unwrap_or(0);
    let [name, formula] = [width(|c| c.name), width(|c| c.formula)];
    output::say!("{:<name$}  {:<formula$}     naive    stable       bar", "case", "textbook form");
    for case in cases {
        let verdict = if case.passes() { "ok" } else { "FAIL" };
        output::say!(
            "{:<name$}  {:<formula$}  {:>8}  {:>8}  {:>8.1e}  {verdict}",
            case.name,
            case.formula,
            case.naive,
            case.stable,
            case.bar
        );
    }
}
