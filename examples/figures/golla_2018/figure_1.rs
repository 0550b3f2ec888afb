//! Fig. 1: two paints, and the way from brown to blue in steps of 25 %.

use super::look::{Look, steps_between};
use super::{BLUE, BROWN};
use crate::paints::{mix, steps};
use crate::{Figure, Finding, pictures};
use carpaint::error::Result;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-1",
    claim: "interpolated from brown to blue in steps of 25 %, color and sparkle change evenly",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let tiles = steps(&mix([BROWN, BLUE])?, &[0, 25, 50, 75, 100])?;
    let looks = Look::of(&tiles, &pictures::capsules(name, &tiles, 1)?)?;
    let (apart, ratio) = steps_between(&looks);
    let sparkle: Vec<f64> = looks.iter().map(Look::sparkle).collect();
    let is_between = sparkle.windows(2).all(|pair| pair[0] > pair[1]);
    Ok(Finding {
        // No step looks like two.
        holds: ratio < 2.0 && (is_between || sparkle.is_sorted()),
        says: format!(
            "steps of Delta-E 1976 {apart:.1?}, largest over smallest {ratio:.2}; sparkle (standard deviation \
             of luminance) {sparkle:.3?}"
        ),
    })
}
