//! Fig. 6: sparkles, from so near that flakes are seen as they are, from 0.3 m, and from 10 m.

use crate::mosaic::{beside, tile_with, write};
use crate::panel::{EYE, contrast, luminances, options, panel};
use crate::{Figure, Finding, paints};
use carpaint::error::Result;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-2001-6",
    claim: "sparkles become noticeable when the painted surface is close, and are gone from far away",
    draw,
};

/// Contrast below which nothing is seen (Weber's law).
const SEEN: f64 = 0.02;

fn draw(name: &Path) -> Result<Finding> {
    let paint = paints::simulated("brown_metallic")?;
    let (near, far) = (0.3, 100.0);
    let pixels_mm = [0.012, near * 1000.0 * EYE, far * 1000.0 * EYE];
    let tiles = pixels_mm.map(|pixel_mm| tile_with(&panel(pixel_mm, 240), &paint, &options()));
    let tiles = tiles.into_iter().collect::<Result<Vec<_>>>()?;
    let [close, seen, gone] = [0, 1, 2].map(|k| contrast(&luminances(&tiles[k])));
    write(name, &beside(&tiles))?;
    Ok(Finding {
        holds: seen > 10.0 * SEEN && gone < SEEN,
        says: format!(
            "standard deviation over mean, pixels of an eye's one arcminute: {seen:.2} at {near} m, {gone:.3} at {far} m ({close:.2} in pixels of 12 um); seen is {SEEN}"
        ),
    })
}
