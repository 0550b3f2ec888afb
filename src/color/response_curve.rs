//! Response curves of cameras: from linear light to what a pixel says (Rump et al. 2008, sections 4.3 and 6).

use crate::error::{Error, Result};

/// What a camera's pixel says of linear light, a curve a channel.
///
/// As text: one knot a line, exposure and response, or exposure and the responses of red, green and blue; commas or spaces
/// between, `#` begins a comment. Between knots the curve is straight, beyond them level.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseCurve {
    /// Linear light, ascending, 0 or more.
    exposures: Vec<f64>,
    /// Red, green, blue: 0 to 1, never falling.
    responses: Vec<[f64; 3]>,
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
                curve.push(knot).map_err(|e| e.within(format!("line {number}")))?;
            }
        }
        let legal = 2..=Self::MAX_KNOTS;
        if !legal.contains(&curve.exposures.len()) {
            return Err(Error::invalid("", "number of knots", curve.exposures.len(), "2 to 65536"));
        }
        Ok(curve)
    }

    fn push(&mut self, knot: &str) -> Result<()> {
        let words = knot.split([',', ' ', '\t', ';', '\r']).filter(|word| !word.is_empty());
        let numbers: Vec<f64> = words
            .map(|word| word.parse().map_err(|_| Error::invalid("", "number", word, "a decimal number")))
            .collect::<Result<_>>()?;
        let (exposure, response) = match numbers[..] {
            [exposure, all] => (exposure, [all; 3]),
            [exposure, r, g, b] => (exposure, [r, g, b]),
            _ => return Err(Error::invalid("", "numbers", numbers.len(), "2 or 4")),
        };
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
