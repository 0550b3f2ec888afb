//! Fig. 5: blue whose flakes have lost their color.

use super::BLUE;
use super::look::Look;
use crate::paints::simulated;
use crate::{Figure, Finding, pictures};
use carpaint::error::Result;
use carpaint::mix::whitened;
use carpaint::paint::Paint;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-5",
    claim: "without color in its flakes blue has white sparkles, and looks smoother",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let blue = simulated(BLUE)?.as_ref().clone();
    let white = Paint { flakes: blue.flakes.as_ref().map(whitened), ..blue.clone() };
    let tiles = [blue, white];
    let looks = Look::of(&tiles, &pictures::capsules(name, &tiles, 1)?)?;
    let [tint, grain] = [Look::tint, Look::grain].map(|of| [of(&looks[0]), of(&looks[1])]);
    let from_afar = looks[0].difference(&looks[1]);
    Ok(Finding {
        // A color beside another is seen to differ from Delta-E 2.3 on (Mahy et al. 1994).
        holds: tint[1] < 0.1 * tint[0] && from_afar < 2.3 && grain[1] < grain[0],
        says: format!(
            "colored share of what flakes add {tint:.3?}; from afar {from_afar:.2} Delta-E 1976 apart; grain \
             (standard deviation of color, Delta-E 1976) {grain:.2?}"
        ),
    })
}
