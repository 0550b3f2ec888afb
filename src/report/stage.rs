//! Stages and checks: what was measured, and the bar it has to stay below.

use serde::Serialize;
use std::time::Instant;

/// A measured error and its bar.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What is measured, with its unit.
    pub what: String,
    /// The measured value.
    pub value: f64,
    /// Largest value that passes.
    pub limit: f64,
}

impl Check {
    /// A check.
    pub fn new(what: impl Into<String>, value: f64, limit: f64) -> Self {
        Self { what: what.into(), value, limit }
    }

    /// Whether the value is at most the limit; NaN never passes.
    pub fn passes(&self) -> bool {
        self.value <= self.limit
    }
}

/// One stage of the chain: its cost and its errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stage {
    /// Name of the stage.
    pub name: String,
    /// Wall time, seconds, without the checks.
    pub seconds: f64,
    /// Largest resident memory of the process so far, MiB; none where the system does not tell.
    pub peak_mib: Option<f64>,
    /// Errors.
    pub checks: Vec<Check>,
}

impl Stage {
    /// Runs `work` as a stage and measures its time and memory; checks are added later.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn run<T, E>(name: impl Into<String>, work: impl FnOnce() -> Result<T, E>) -> Result<(Self, T), E> {
        let start = Instant::now();
        let value = work()?;
        let seconds = start.elapsed().as_secs_f64();
        Ok((Self { name: name.into(), seconds, peak_mib: peak_memory_mib(), checks: Vec::new() }, value))
    }

    /// The stage with these checks.
    #[must_use]
    pub fn with(mut self, checks: Vec<Check>) -> Self {
        self.checks.extend(checks);
        self
    }

    /// Whether all checks pass.
    pub fn passes(&self) -> bool {
        self.checks.iter().all(Check::passes)
    }
}

/// Largest of the values; not a number if one of them is not, or if there are none, so that no check passes on nothing.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().reduce(|m, x| if m.is_nan() || x <= m { m } else { x }).unwrap_or(f64::NAN)
}

/// Mean of the values; not a number as with [`largest`].
pub(super) fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(s, n), x| (s + x, n + 1.0));
    sum / count
}

/// Largest resident set of this process so far, MiB (`VmHWM` of Linux).
pub fn peak_memory_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}

/// Stages as a table for people.
impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let memory = self.peak_mib.map_or("?".to_owned(), |m| format!("{m:.0}"));
        writeln!(f, "{:<26} {:>8.2} s {:>6} MiB", self.name, self.seconds, memory)?;
        for check in &self.checks {
            let verdict = if check.passes() { "ok" } else { "FAIL" };
            writeln!(
                f,
                "    {:<64} {:>11.4e}  (bar {:.1e}) {verdict}",
                check.what, check.value, check.limit
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_and_nan_never_pass() {
        assert!(!Check::new("x", largest([]), 1.0).passes());
        assert!(!Check::new("x", mean([]), 1.0).passes());
        assert!(!Check::new("x", largest([0.5, f64::NAN, 0.1]), 1.0).passes());
        assert_eq!(largest([0.5, 2.0, 0.1]), 2.0);
        assert!(Check::new("x", 1.0, 1.0).passes());
        assert!(!Check::new("x", 1.1, 1.0).passes());
        assert!(!Check::new("x", f64::NAN, 1.0).passes());
    }
}
