//! Fig. 6: interpolations in steps of 25 %; the flip-flop weakens towards gray.

use crate::paints::{mix, steps};
use crate::{Figure, Finding, pictures};
use carpaint::color::lab_from_rgb;
use carpaint::error::Result;
use carpaint::fit::SmoothFit;
use carpaint::math::half_difference::spherical;
use carpaint::paint::Paint;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-6",
    claim: "the change of hue of the flip-flop paint weakens steadily towards gray",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let (brown, blue, gray) = ("brown_metallic", "blue_metallic", "silver_metallic");
    let mut tiles = Vec::new();
    for pair in [[brown, blue], [blue, gray], ["green_blue_flip_flop", gray]] {
        tiles.extend(steps(&mix(pair)?, &[0, 25, 50, 75, 100])?);
    }
    pictures::capsules(name, &tiles, 3)?;
    let apart: Vec<f64> =
        tiles[10..].iter().map(|paint| chroma(paint, 15.0).distance(chroma(paint, 110.0))).collect();
    Ok(Finding {
        holds: apart.windows(2).all(|pair| pair[1] < pair[0]),
        says: format!("between 15 and 110 degrees a, b move by {apart:.1?}, light at 45 degrees"),
    })
}

/// a, b of the smooth part at an aspecular angle, degrees, light at 45 degrees.
fn chroma(paint: &Paint, aspecular: f64) -> DVec2 {
    let wo = spherical((aspecular - 45.0).to_radians(), 0.0);
    let lab = lab_from_rgb(PI * SmoothFit::from(paint).eval(spherical(FRAC_PI_4, 0.0), wo));
    DVec2::new(lab.y, lab.z)
}
