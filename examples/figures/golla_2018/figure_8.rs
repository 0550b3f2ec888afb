//! Fig. 8: beyond both paints in steps of 25 %: yellow-brown on the left, intensely blue on the right.

use super::look::{Look, chroma, steps_between};
use super::{BLUE, BROWN};
use crate::paints::{mix, steps};
use crate::{Figure, Finding, pictures};
use carpaint::error::Result;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "golla-2018-8",
    claim: "extrapolated in steps of 25 %, brown becomes yellow-brown and blue intensely blue, evenly",
    draw,
};

/// Share of blue, percent; the paints themselves are the fourth and the fifth.
const PERCENT: [i32; 8] = [-75, -50, -25, 0, 100, 125, 150, 175];

fn draw(name: &Path) -> Result<Finding> {
    let tiles = steps(&mix([BROWN, BLUE])?, &PERCENT)?;
    let looks = Look::of(&tiles, &pictures::capsules(name, &tiles, 1)?)?;
    let [(left, left_ratio), (right, right_ratio)] = [&looks[..4], &looks[4..]].map(steps_between);
    let colors: Vec<_> = looks.iter().map(Look::color).collect();
    // b grows from blue to yellow.
    let yellower = colors[..4].windows(2).all(|pair| pair[0].z > pair[1].z);
    let bluer = colors[4..].windows(2).all(|pair| chroma(pair[0]) < chroma(pair[1]));
    let b: Vec<f64> = colors[..4].iter().map(|color| color.z).collect();
    let blueness: Vec<f64> = colors[4..].iter().map(|color| chroma(*color)).collect();
    Ok(Finding {
        // No step looks like two.
        holds: left_ratio < 2.0 && right_ratio < 2.0 && yellower && bluer,
        says: format!(
            "steps of Delta-E 1976 {left:.1?} (largest over smallest {left_ratio:.2}) and {right:.1?} \
             ({right_ratio:.2}); b of the browns {b:.1?}, chroma of the blues {blueness:.1?}"
        ),
    })
}
