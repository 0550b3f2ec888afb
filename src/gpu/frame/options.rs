//! How frames are drawn.

use crate::error::{Error, Result};
use crate::render::Random;

/// How frames are drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameOptions {
    /// Seed of the flakes.
    pub seed: u32,
    /// Where the flakes' random numbers come from.
    pub random: Random,
    /// Whether flakes sparkle; their mean belongs to the smooth part and stays.
    pub flakes: bool,
    /// Exposure, stops, -64 to 64; that of the scene does not count.
    pub exposure_stops: f64,
    /// Directions a pixel in which the base looks for the surroundings as in [`crate::render::Options`], 1 to 4096; none:
    /// prefiltered maps, in real time.
    pub directions: Option<usize>,
    /// Whether flakes are drawn from colors along u that were drawn beforehand, 254 a slice, instead of from their boxes: several
    /// times as fast on software adapters. Mean and contrast stay, where in its box a color lies is the same for all flakes
    /// of a step, what is rarer than 3e-5 shares a step, colors keep eight bits; lamps count with their middle, at the contrast
    /// that their disc leaves.
    pub rows: bool,
    /// Whether flakes sparkle under the surroundings too, if they sparkle: 28 to 52 looks at them a pixel.
    pub around: bool,
    /// The rectangle of pixels that is drawn, its left top corner and its size; what lies around it stays. None: all.
    pub part: Option<[[u32; 2]; 2]>,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            random: Random::Hash,
            flakes: true,
            exposure_stops: 0.0,
            directions: None,
            rows: false,
            around: true,
            part: None,
        }
    }
}

impl FrameOptions {
    pub(super) fn validate(&self, size: [u32; 2]) -> Result<()> {
        if !(-64.0..=64.0).contains(&self.exposure_stops) {
            return Err(Error::invalid("frame", "exposure_stops", self.exposure_stops, "-64 to 64"));
        }
        if let Some(n) = self.directions
            && !(1..=4096).contains(&n)
        {
            return Err(Error::invalid("frame", "directions", n, "1 to 4096"));
        }
        if let Random::Texture(side) = self.random
            && !(1..=1 << 16).contains(&side)
        {
            return Err(Error::invalid("frame", "random texture", side, "1 to 65536"));
        }
        if let Some([first, part]) = self.part {
            let ends = |k: usize| first[k].checked_add(part[k]).is_some_and(|end| end <= size[k]);
            if !(ends(0) && ends(1)) {
                let legal = format!("a rectangle inside {} x {}", size[0], size[1]);
                return Err(Error::invalid("frame", "part", format!("{part:?} at {first:?}"), legal));
            }
        }
        Ok(())
    }
}
