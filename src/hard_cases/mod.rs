//! Hard cases of numerical stability: where a formula as textbooks print it loses its digits, and what ours keeps.
//!
//! A [`HardCase`] is a formula, arguments at which its naive form fails, the error of that form and the error of the function
//! that this library computes with: called, never copied. Truth is the formula in numbers of 77 digits ([`extended`]), for the
//! very arguments, rounded as they are, that both forms get; or, where a case is no formula but a law (a plan keeps its masses,
//! a blend its mean), the law.
//!
//! `carpaint report --hard-cases` prints the table.

mod angles;
mod attenuation;
mod color;
pub mod extended;
mod fresnel;
mod layers;
mod microfacets;
mod mixing;
mod slices;
mod transport;

use serde::Serialize;

/// What a form came to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Outcome {
    /// Its largest error, or how far it violates the law.
    Error(f64),
    /// It gives no number at all, but this.
    Fails(&'static str),
}

impl Outcome {
    /// From the largest error: not-a-number and infinity are failures.
    fn of(error: f64) -> Self {
        match error {
            e if e.is_nan() => Self::Fails("NaN"),
            e if e.is_infinite() => Self::Fails("overflow"),
            e => Self::Error(e),
        }
    }

    /// The error; infinite for a form that fails.
    pub fn error(self) -> f64 {
        match self {
            Self::Error(error) => error,
            Self::Fails(_) => f64::INFINITY,
        }
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Error(error) => f.pad(&format!("{error:.1e}")),
            Self::Fails(how) => f.pad(how),
        }
    }
}

/// A formula, and what is left of it where it is hard to compute.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HardCase {
    /// What is hard.
    pub name: &'static str,
    /// The textbook form.
    pub formula: &'static str,
    /// Where it stands, and the function of this library that computes it.
    pub source: &'static str,
    /// What both forms are computed at, and in which type.
    pub arguments: &'static str,
    /// What the errors are: relative, absolute with their unit, or the law that they violate.
    pub measure: &'static str,
    /// The textbook form.
    pub naive: Outcome,
    /// Ours.
    pub stable: Outcome,
    /// Largest error that ours may have.
    pub bar: f64,
    /// Where the bar comes from.
    pub why: &'static str,
    /// How many times the bar, 1 or more, the naive form is off at least: a case that it survives proves nothing.
    pub worse: f64,
}

impl HardCase {
    /// Whether our form stays below its bar, and the naive form is beyond it as far as is claimed.
    pub fn passes(&self) -> bool {
        self.stable.error() <= self.bar && self.naive.error() > self.worse * self.bar
    }
}

/// All cases, computed in about a second.
///
/// # Errors
/// Those of the functions at stake: none of them, unless it refuses what it should take.
pub fn hard_cases() -> crate::error::Result<Vec<HardCase>> {
    let mut all = angles::cases();
    all.extend(microfacets::cases());
    all.extend(fresnel::cases());
    all.extend(attenuation::cases());
    all.extend(layers::cases()?);
    all.extend(color::cases());
    all.extend(slices::cases()?);
    all.extend(transport::cases()?);
    all.extend(mixing::cases()?);
    Ok(all)
}

/// The largest error over all arguments; not a number, if one of them is none.
fn worst<T>(arguments: impl IntoIterator<Item = T>, error: impl Fn(T) -> f64) -> Outcome {
    Outcome::of(arguments.into_iter().map(error).fold(0.0, larger))
}

/// The larger of two errors; not a number, if one of them is none, which [`f64::max`] would hide.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// 10 to these powers.
fn decades(powers: std::ops::RangeInclusive<i32>) -> Vec<f64> {
    powers.map(|k| 10f64.powi(k)).collect()
}

/// All pairs.
fn pairs<A: Copy, B: Copy>(a: &[A], b: &[B]) -> Vec<(A, B)> {
    a.iter().flat_map(|a| b.iter().map(|b| (*a, *b))).collect()
}
