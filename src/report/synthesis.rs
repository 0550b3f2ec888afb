//! Synthesized slices against their expectation.

use super::Check;
use crate::btf::FlakeBtf;

/// Slice means against the analytic expectation (Ershov et al. 2001, eq. 36, convolved with the flakes' lobe), in the standard
/// errors that the synthesis derives from its own flakes.
pub fn checks(btf: &FlakeBtf) -> Vec<Check> {
    let score = |key: &str| btf.provenance["check"][key].as_f64().unwrap_or(f64::NAN);
    vec![
        // Slices share their flakes: of some 200 only a few dozen scores are independent, and an rms of 2 is rare.
        // A brightness off by a tenth gives 5 and more.
        Check::new("slice means, rms in standard errors", score("rms_z"), 2.5),
        // The largest of some hundred normal scores is near 3.
        Check::new("slice means, largest in standard errors", score("max_abs_z"), 5.0),
    ]
}
