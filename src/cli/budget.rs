//! `--error` and `--time`: a budget, for which the settings are picked.

use super::output;
use crate::error::{Error, Result};
use crate::tradeoff::{Budget, Choice};
use std::time::Duration;

/// What may be spent, or how far it may be off.
#[derive(clap::Args)]
pub struct BudgetArguments {
    /// Pick the cheapest settings that are off by no more than this, Delta-E; they are tried on a piece of the input, and said.
    #[arg(
        long,
        value_name = "DELTA_E",
        allow_negative_numbers = true,
        conflicts_with = "time",
        help_heading = "Budget"
    )]
    error: Option<f64>,
    /// Pick the best settings that take no longer than this, e.g. 100ms or 2s; trying them takes time of its own.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration, help_heading = "Budget")]
    time: Option<Duration>,
}

impl BudgetArguments {
    /// Whether there is one.
    pub fn is_given(&self) -> bool {
        self.error.is_some() || self.time.is_some()
    }

    /// The budget, if one is given.
    ///
    /// # Errors
    /// An error that is not above 0; no time.
    pub fn budget(&self) -> Result<Option<Budget>> {
        match (self.error, self.time) {
            (Some(error), _) if !(error > 0.0 && error.is_finite()) => {
                Err(Error::invalid("--error", "Delta-E", error, "above 0"))
            }
            (_, Some(Duration::ZERO)) => Err(Error::invalid("--time", "time", "0", "above 0")),
            (Some(error), _) => Ok(Some(Budget::Error(error))),
            (None, time) => Ok(time.map(Budget::Time)),
        }
    }
}

/// Says what was picked, and what else was tried.
pub fn picked<K>(what: &str, choice: Choice<K>) -> K {
    let Choice { knob, tried, picked, keeps } = choice;
    for (k, one) in tried.iter().enumerate() {
        let mark = if k == picked { "picked" } else { "tried" };
        // Nothing better was tried that could tell.
        let bound = if k + 1 == tried.len() { "below " } else { "" };
        let error =
            if one.error.is_finite() { format!("{bound}{:.2}", one.error) } else { "unknown".to_owned() };
        output::note!("{mark}: {what} {}: error {error} Delta-E, about {}", one.setting, time(one.seconds));
    }
    if !keeps {
        output::note!("note: no setting of {what} keeps the budget; this is the nearest to it");
    }
    knob
}

fn time(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.0} ms", 1e3 * seconds) } else { format!("{seconds:.1} s") }
}
