//! Fig. 4: all but the flakes' lightness goes from brown to blue; the order is the caption's (the text counts from the right).

use super::figure_3::blended;
use super::look::{Look, hue_between};
use super::{BLUE, BROWN};
use crate::paints::{mix, simulated};
use crate::{Figure, Finding, pictures};
use carpaint::color::delta_e_76;
use carpaint::error::Result;
use carpaint::mix::Channels;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-4",
    claim: "where all but the flakes' lightness is interpolated, brown turns violet and blue and keeps its sparkle",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let mix = mix([BROWN, BLUE])?;
    let blend = |share| blended(&mix, 0, Channels::AllButLightness, share);
    let [brown, blue] = [simulated(BROWN)?.as_ref().clone(), simulated(BLUE)?.as_ref().clone()];
    // The other way to the same end, Fig. 3.
    let lightness_alone = blended(&mix, 1, Channels::Lightness, 0.0)?;
    let mut tiles = vec![brown, blend(0.5)?, blend(1.0)?, blue];
    let mut drawn = pictures::capsules(name, &tiles, 1)?;
    drawn.extend(pictures::each(
        &pictures::capsule(),
        std::slice::from_ref(&lightness_alone),
        &pictures::OPTIONS,
    )?);
    tiles.push(lightness_alone);
    let looks = Look::of(&tiles, &drawn)?;
    let sparkle: Vec<f64> = looks.iter().map(|look| look.sparkle() / looks[0].sparkle()).collect();
    let colors: Vec<_> = looks.iter().map(Look::color).collect();
    let [all, halfway, rest] = [0, 1, 2].map(|k| delta_e_76(colors[k], colors[3]));
    // Lightness is a concave measure: the more sparkle of the same light, the darker its mean. Hue tells.
    let hue = hue_between(colors[2], colors[3]);
    let from_figure_3 = looks[2].difference(&looks[4]);
    Ok(Finding {
        // A contrast is seen to differ from about a tenth on, a hue from about ten degrees, a color beside
        // another from Delta-E 2.3 on (Mahy et al. 1994).
        holds: sparkle[1..3].iter().all(|s| (s - 1.0).abs() < 0.1)
            && (0.25..0.75).contains(&(halfway / all))
            && hue < 10.0
            && from_figure_3 < 2.3
            && (sparkle[4] / sparkle[2] - 1.0).abs() < 0.1,
        says: format!(
            "sparkle over brown's {:.2?} (blue's {:.2}); mean color {all:.1}, {halfway:.1}, {rest:.1} Delta-E 1976 \
             from blue, the third of blue's hue within {hue:.1} degrees; it is {from_figure_3:.1} from that of Fig. 3, whose sparkle is {:.2}",
            &sparkle[1..3],
            sparkle[3],
            sparkle[4]
        ),
    })
}
