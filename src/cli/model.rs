//! Which model of a composition, asked alike by every command that does so.

use crate::simulate::{ModelKind, ModelOptions};

/// The model of the smooth part.
#[derive(clap::Args)]
pub struct ModelArguments {
    /// The model of the smooth part.
    #[arg(long, value_enum, default_value = "auto")]
    model: Kind,
    /// Error target of the full model: of the BRDF relative to its value, or to a thousandth of its peak.
    #[arg(long, default_value_t = 1e-2, allow_negative_numbers = true)]
    tolerance: f64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Kind {
    /// The published fast model, corrected: one film without pigments.
    Fast,
    /// The fast model with the terms it drops put back.
    FastCorrected,
    /// The full solution: doubling and adding.
    Full,
    /// The cheapest of these that meets the error target.
    Auto,
}

impl ModelArguments {
    /// What the library is asked for.
    pub fn options(&self) -> ModelOptions {
        let kind = match self.model {
            Kind::Fast => ModelKind::Fast,
            Kind::FastCorrected => ModelKind::FastCorrected,
            Kind::Full => ModelKind::Full,
            Kind::Auto => ModelKind::Auto,
        };
        ModelOptions { kind, error: self.tolerance }
    }
}
