//! How many lobes a measurement asks for.

use serde::Serialize;

/// A number of lobes that was tried.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Choice {
    /// Metallic lobes.
    pub lobes: usize,
    /// Eq. 7 over the samples fitted, gloss apart.
    pub error: f64,
    /// The information criterion; the least is taken.
    pub criterion: f64,
}

/// Schwarz's criterion (BIC) of a fit of `lobes` lobes and a diffuse term with the mean absolute residual `error`.
///
/// To lower eq. 7 is to seek the likeliest lobes under residuals of Laplace's distribution, whose likelihood at its own best width
/// is `(2 e error)^-N`; each parameter is charged `ln N`. Cells of a table that miss the model together count as if they
/// were independent: on measured tables it is a judge of description, not of truth, and mostly takes all lobes it may.
pub(super) fn criterion(error: f64, lobes: usize, samples: usize) -> f64 {
    let n = samples.max(1) as f64;
    // The width of the residuals is a parameter, too.
    let parameters = (2 + 3 * lobes) as f64;
    2.0 * n * (1.0 + (2.0 * error.max(f64::MIN_POSITIVE)).ln()) + parameters * n.ln()
}
