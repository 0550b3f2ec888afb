//! What of the flakes a blend lets go (Golla & Klein 2018, section 4.4).

use crate::cluster::{SliceStatistics, mean_of_boxes};
use crate::error::Error;
use crate::paint::Flakes;
use glam::DVec3;
use std::fmt;
use std::str::FromStr;

/// Which quantities go from paint to paint; the others stay those of one paint, the source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Channels {
    /// `all`.
    #[default]
    All,
    /// `lightness`: only that of the flakes; a and b of every draw from a box, the mean of every slice and the smooth part
    /// stay (Fig. 3).
    Lightness,
    /// `all-but-lightness`: only the flakes' lightness stays (Fig. 4).
    AllButLightness,
    /// `white-flakes`: all, and the boxes of the flakes lose their a and b (Fig. 5); the mean of every slice is what it would
    /// be with them, so that the paint keeps its color from afar.
    WhiteFlakes,
}

impl Channels {
    /// Every choice.
    pub const ALL: [Self; 4] = [Self::All, Self::Lightness, Self::AllButLightness, Self::WhiteFlakes];

    fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Lightness => "lightness",
            Self::AllButLightness => "all-but-lightness",
            Self::WhiteFlakes => "white-flakes",
        }
    }
}

impl fmt::Display for Channels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Channels {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let found = Self::ALL.into_iter().find(|channels| channels.name() == text);
        found.ok_or_else(|| Error::invalid("channels", "name", text, Self::ALL.map(Self::name).join(", ")))
    }
}

/// Flakes whose boxes have no a and b (Fig. 5); the mean of every slice stays.
pub fn whitened(flakes: &Flakes) -> Flakes {
    let mut white = flakes.clone();
    for slice in white.levels.iter_mut().flat_map(|level| &mut level.slices) {
        let mean = slice.mean_rgb();
        for corner in slice.clusters.iter_mut().flat_map(|c| [&mut c.min, &mut c.max]) {
            *corner = [corner[0], 0.0, 0.0];
        }
        slice.offset = offset(slice, mean);
    }
    white
}

/// What brings the mean of a slice to `mean`.
fn offset(slice: &SliceStatistics, mean: DVec3) -> [f32; 3] {
    let gain = DVec3::from(slice.gain.map(f64::from));
    (mean - gain * mean_of_boxes(&slice.clusters)).as_vec3().to_array()
}
