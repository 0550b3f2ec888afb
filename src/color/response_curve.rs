//! Response curves of cameras: from linear light to what a pixel says (Rump et al. 2008, sections 4.3 and 6).

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// What a camera's pixel says of linear light, a curve a channel.
///
/// As text: one knot a line, exposure and response, or exposure and the responses of red, green and blue; commas or spaces
/// between, `#` begins a comment. Between knots the curve is straight, beyond them level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Knots")]
pub struct ResponseCurve {
    /// Linear light, ascending, 0 or more.
    exposures: Vec<f64>,
    /// Red, green, blue: 0 to 1, never falling.
    responses: Vec<[f64; 3]>,
}

/// A curve before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Knots {
    exposures: Vec<f64>,
    responses: Vec<[f64; 3]>,
}

impl TryFrom<Knots> for ResponseCurve {
    type Error = Error;

    fn try_from(knots: Knots) -> Result<Self> {
        Self::from_knots(&knots.exposures, &knots.responses)
    }
}

impl ResponseCurve {
    /// Most knots.
    pub const MAX_KNOTS: usize = 1 << 16;

    /// A curve from its text, see [`ResponseCurve`].
    ///
    /// # Errors
    /// The line that is no knot; fewer than two knots or too many; exposures that do not ascend; responses outside 0 to 1 or
    /// falling.
    pub fn parse(text: &str) -> Result<Self> {
        let mut curve = Self { exposures: Vec::new(), responses: Vec::new() };
        for (number, line) in (1..).zip(text.lines()) {
            let knot = line.split('#').next().unwrap_or_default();
            if !knot.trim().is_empty() {
                curve.push_text(knot).map_err(|e| e.within(format!("line {number}")))?;
            }
        }
        curve.counted()
    }

    /// A curve through knots: linear light, and what red, green and blue say of it.
    ///
    /// # Errors
    /// As many of one as of the other, 2 to 65536; exposures that do not ascend; responses outside 0 to 1 or falling.
    pub fn from_knots(exposures: &[f64], responses: &[[f64; 3]]) -> Result<Self> {
        if exposures.len() != responses.len() {
            return Err(Error::invalid(
                "",
                "number of responses",
                responses.len(),
                exposures.len().to_string(),
            ));
        }
        let mut curve = Self { exposures: Vec::new(), responses: Vec::new() };
        for (k, (exposure, response)) in exposures.iter().zip(responses).enumerate() {
            curve.push(*exposure, *response).map_err(|e| e.within(format!("knot {k}")))?;
        }
        curve.counted()
    }

    /// The curve as text, which [`ResponseCurve::parse`] reads back to the bit.
    pub fn to_text(&self) -> String {
        let knots = self.exposures.iter().zip(&self.responses);
        let line = |(exposure, [r, g, b]): (&f64, &[f64; 3])| format!("{exposure} {r} {g} {b}\n");
        std::iter::once("# linear light, red, green, blue\n".to_owned()).chain(knots.map(line)).collect()
    }

    fn counted(self) -> Result<Self> {
        if !(2..=Self::MAX_KNOTS).contains(&self.exposures.len()) {
            return Err(Error::invalid("", "number of knots", self.exposures.len(), "2 to 65536"));
        }
        Ok(self)
    }

    fn push_text(&mut self, knot: &str) -> Result<()> {
        let words = knot.split([',', ' ', '\t', ';', '\r']).filter(|word| !word.is_empty());
        let numbers: Vec<f64> = words
            .map(|word| word.parse().map_err(|_| Error::invalid("", "number", word, "a decimal number")))
            .collect::<Result<_>>()?;
        let (exposure, response) = match numbers[..] {
            [exposure, all] => (exposure, [all; 3]),
            [exposure, r, g, b] => (exposure, [r, g, b]),
            _ => return Err(Error::invalid("", "numbers", numbers.len(), "2 or 4")),
        };
        self.push(exposure, response)
    }

    fn push(&mut self, exposure: f64, response: [f64; 3]) -> Result<()> {
        let least = self.exposures.last().map_or(0.0, |last| last.next_up());
        if !(exposure >= least && exposure.is_finite()) {
            return Err(Error::invalid("", "exposure", exposure, format!("{least} or more, ascending")));
        }
        let before = self.responses.last().copied().unwrap_or_default();
        for (response, before) in response.iter().zip(before) {
            if !(before..=1.0).contains(response) {
                return Err(Error::invalid(
                    "",
                    "response",
                    response,
                    format!("{before} to 1, never falling"),
                ));
            }
        }
        self.exposures.push(exposure);
        self.responses.push(response);
        Ok(())
    }

    /// What the pixel says of linear light in channel 0 to 2.
    pub fn response(&self, exposure: f64, channel: usize) -> f64 {
        let above = self.exposures.partition_point(|e| *e <= exposure).clamp(1, self.exposures.len() - 1);
        let ([low, high], [from, to]) = (
            [above - 1, above].map(|k| self.exposures[k]),
            [above - 1, above].map(|k| self.responses[k][channel]),
        );
        from + ((exposure - low) / (high - low)).clamp(0.0, 1.0) * (to - from)
    }

    /// The least linear light of which channel 0 to 2 says `response`, and that it says most of where the curve ends below.
    pub fn exposure(&self, response: f64, channel: usize) -> f64 {
        let above = self.responses.partition_point(|r| r[channel] < response);
        if above == 0 {
            return self.exposures[0];
        }
        let last = self.exposures.len() - 1;
        let above = above.min(last);
        let [from, to] = [above - 1, above].map(|k| self.responses[k][channel]);
        let share = if to > from { ((response - from) / (to - from)).min(1.0) } else { 0.0 };
        self.exposures[above - 1] + share * (self.exposures[above] - self.exposures[above - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_straight_between_knots_and_level_beyond() {
        let curve = ResponseCurve::parse("# a camera\n0.1, 0.0\n\n1 0.5 0.6 0.7 # knee\r\n3\t1\n").unwrap();
        let at = |x: f64| [0, 1, 2].map(|c| curve.response(x, c));
        assert_eq!(at(0.0), [0.0; 3]);
        assert_eq!(at(1.0), [0.5, 0.6, 0.7]);
        assert_eq!(at(2.0), [0.75, 0.8, 0.85]);
        assert_eq!(at(1e30), [1.0; 3]);
        assert_eq!(curve.response(f64::NEG_INFINITY, 0), 0.0);
    }

    #[test]
    fn light_and_response_are_each_others_inverse() {
        let curve =
            ResponseCurve::from_knots(&[0.0, 1.0, 2.0, 3.0], &[[0.0; 3], [0.5; 3], [1.0; 3], [1.0; 3]])
                .unwrap();
        for response in [0.0, 0.1, 0.5, 0.8, 1.0] {
            // A rounding of the division.
            assert!((curve.response(curve.exposure(response, 1), 1) - response).abs() < 1e-15);
        }
        assert_eq!(
            (curve.exposure(1.0, 0), curve.exposure(2.0, 0), curve.exposure(-1.0, 0)),
            (2.0, 2.0, 0.0)
        );
        let dull = ResponseCurve::parse("1 0.2\n2 0.2\n3 0.9").unwrap();
        assert_eq!((dull.exposure(0.2, 0), dull.exposure(1.0, 0)), (1.0, 3.0));
        assert_eq!(ResponseCurve::parse(&dull.to_text()).unwrap(), dull);
        let text = serde_json::to_string(&dull).unwrap();
        assert_eq!(serde_json::from_str::<ResponseCurve>(&text).unwrap(), dull);
        let falling = text.replace("0.9", "0.1");
        assert!(serde_json::from_str::<ResponseCurve>(&falling).unwrap_err().to_string().contains("knot 2"));
    }

    #[test]
    fn bad_knots_are_named() {
        let message = |text: &str| ResponseCurve::parse(text).unwrap_err().to_string();
        assert!(message("0 0\n1 x").contains("line 2") && message("0 0\n1 x").contains('x'));
        assert!(message("0 0\n0 1").contains("exposure: found 0"));
        assert!(message("0 0.5\n1 0.4").contains("response: found 0.4"));
        assert!(message("0 0\n1 1.1").contains("response: found 1.1"));
        assert!(message("0 0\nnan 1").contains("exposure: found NaN"));
        assert!(message("0 0\n1 1 1").contains("numbers: found 3"));
        assert!(message("0 0").contains("number of knots: found 1"));
    }
}
