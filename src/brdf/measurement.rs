//! What a file of measurements holds, and what of it could not be used.

use super::SampleSet;
use crate::error::{Error, Result};
use serde::Serialize;

/// The usable samples of a file, and what its reader met on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// The usable samples.
    pub samples: SampleSet,
    /// What was there, and what of it was left out.
    pub counts: Counts,
    /// How far the file is from reciprocity (see [`super::reciprocity`]); None where it holds no pair of directions both ways.
    pub reciprocity: Option<f64>,
}

/// Numbers of cells, nodes or rows of a file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// All there are.
    pub found: usize,
    /// Left out: light or eye at or below the horizon.
    pub below_horizon: usize,
    /// Left out: marked as invalid, or no finite number.
    pub invalid: usize,
    /// Left out: good ones beyond the limit of the reader, evenly spread.
    pub thinned: usize,
    /// Used, though a band is negative.
    pub negative: usize,
    /// Used, though every band is 0.
    pub zero: usize,
}

impl Measurement {
    /// A departure from reciprocity worth a warning. Good instruments keep to a few percent; the two car paints published with
    /// NVIDIA's MDL SDK are 7 to 21 % off, and fit.
    const RECIPROCITY_LIMIT: f64 = 0.1;

    /// The samples of a file; negative and zero values are counted here.
    ///
    /// # Errors
    /// No usable sample.
    pub(super) fn new(samples: SampleSet, left_out: Counts, reciprocity: Option<f64>) -> Result<Self> {
        let Counts { found, below_horizon, invalid, .. } = left_out;
        if samples.is_empty() {
            let found = format!("{found} in all, {below_horizon} below the horizon, {invalid} invalid");
            return Err(Error::invalid("", "usable samples", found, "1 or more"));
        }
        let count =
            |is: &dyn Fn(&[f64]) -> bool| (0..samples.len()).filter(|k| is(samples.values(*k))).count();
        let negative = count(&|values| values.iter().any(|v| *v < 0.0));
        let zero = count(&|values| values.iter().all(|v| *v == 0.0));
        Ok(Self { samples, counts: Counts { negative, zero, ..left_out }, reciprocity })
    }

    /// What the user should know, a sentence each; none if all is well.
    pub fn warnings(&self) -> Vec<String> {
        self.counts.warnings(self.samples.len(), self.reciprocity)
    }
}

impl Counts {
    /// The same of any `used` samples.
    pub(super) fn warnings(self, used: usize, reciprocity: Option<f64>) -> Vec<String> {
        let Self { found, below_horizon, invalid, thinned, negative, zero } = self;
        let lines = [
            (below_horizon, found, "lie below the horizon: left out"),
            (invalid, found, "are marked as invalid or are no numbers: left out"),
            (thinned, found, "are good but more than are needed: left out, evenly"),
            (negative, used, "have a negative band: used as they are"),
            (zero, used, "are 0 in every band: used as they are"),
        ];
        let counted =
            lines.iter().filter(|(n, ..)| *n > 0).map(|(n, of, what)| format!("{n} of {of} samples {what}"));
        let apart = reciprocity.filter(|median| *median > Measurement::RECIPROCITY_LIMIT).map(|median| {
            format!(
                "not reciprocal: with light and eye exchanged values differ by {:.0} % (median)",
                100.0 * median
            )
        });
        counted.chain(apart).collect()
    }
}
