//! How a blend goes from one paint to another.

use crate::error::Error;
use crate::transport::Cost;
use std::fmt;
use std::str::FromStr;

/// What an arc does while the weights change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Path {
    /// `transport`: every box travels (Golla & Klein 2018, eqs 14, 15). Bright flakes dim where the other paint has none,
    /// so contrast is lost half way.
    Transport,
    /// `hybrid`: boxes nearer than a threshold travel; between farther ones the probability goes over, so that bright
    /// flakes become fewer instead of dimmer; then the gain of `contrast`, which is near 1.
    #[default]
    Hybrid,
    /// `contrast`: every box travels, then one gain a slice and channel brings the standard deviation to the blend of the
    /// paints', linear in cube roots.
    Contrast,
}

impl Path {
    /// Every path.
    pub const ALL: [Self; 3] = [Self::Transport, Self::Hybrid, Self::Contrast];

    /// Distance from which on probability goes over instead of a box travelling, Delta-E. Against paints simulated between
    /// the ends, over six changes of seven presets, Wasserstein-1 is 9.8, 9.1, 9.0, 8.8 Delta-E at 30, 50, 70, 100 (flakes
    /// that change their color should travel), `|ln q99.9|` 0.113, 0.114, 0.116, 0.116 (flakes that become fewer should
    /// not), and neighbouring slices go together the better the lower it is.
    pub const THRESHOLD: f64 = 70.0;

    /// The ground cost that suits the path: what `hybrid` exchanges costs the same however far apart it is.
    pub fn cost(self, threshold: f64) -> Cost {
        match self {
            Self::Hybrid => Cost::Capped(threshold),
            Self::Transport | Self::Contrast => Cost::Euclidean,
        }
    }

    /// Whether one gain a slice brings the standard deviation to the blend of the paints'.
    pub(super) fn keeps_contrast(self) -> bool {
        self != Self::Transport
    }

    fn name(self) -> &'static str {
        match self {
            Self::Transport => "transport",
            Self::Hybrid => "hybrid",
            Self::Contrast => "contrast",
        }
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Path {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|path| path.name() == text);
        found.ok_or_else(|| Error::invalid("path", "name", text, Self::ALL.map(Self::name).join(", ")))
    }
}
