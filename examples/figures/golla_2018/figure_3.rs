//! Fig. 3: the flakes' lightness alone goes from blue to brown.

use super::look::{Look, hue_between};
use super::{BLUE, BROWN};
use crate::paints::{mix, simulated};
use crate::{Figure, Finding, pictures};
use carpaint::error::Result;
use carpaint::mix::{BlendOptions, Channels, Mix};
use carpaint::paint::Paint;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-3",
    claim: "where the flakes' lightness alone is interpolated, sparkle grows to brown's and the color stays blue",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let tiles = tiles(&mix([BLUE, BROWN])?)?;
    let looks = Look::of(&tiles, &pictures::capsules(name, &tiles, 1)?)?;
    let sparkle: Vec<f64> = looks.iter().map(Look::sparkle).collect();
    let hue: Vec<f64> = looks.iter().map(|look| hue_between(look.color(), looks[0].color())).collect();
    let match_of_brown = sparkle[2] / sparkle[3];
    Ok(Finding {
        // A contrast is seen to differ from about a tenth on, a hue from about ten degrees.
        holds: sparkle[0] < sparkle[1]
            && sparkle[1] < sparkle[2]
            && (match_of_brown - 1.0).abs() < 0.1
            && hue[2] < 10.0,
        says: format!(
            "sparkle (standard deviation of luminance) {sparkle:.4?}, the third {match_of_brown:.2} of brown's; \
             mean hue {hue:.1?} degrees from blue's"
        ),
    })
}

/// Blue, halfway, with brown's lightness; brown.
fn tiles(mix: &Mix) -> Result<[Paint; 4]> {
    let blend = |share| blended(mix, 0, Channels::Lightness, share);
    Ok([simulated(BLUE)?.as_ref().clone(), blend(0.5)?, blend(1.0)?, simulated(BROWN)?.as_ref().clone()])
}

/// A share of the second paint in some channels, the others those of `source`.
pub fn blended(mix: &Mix, source: usize, channels: Channels, share: f64) -> Result<Paint> {
    mix.blend_with(&[1.0 - share, share], &BlendOptions { channels, source, ..BlendOptions::default() })
}
