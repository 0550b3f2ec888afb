//! Fig. 4: the same pearls over another substrate.

use crate::mosaic::{beside, car, exposed, tile, write};
use crate::{Figure, Finding, smooth};
use carpaint::color::delta_e_2000;
use carpaint::error::Result;
use carpaint::simulate::Reading;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-2001-4",
    claim: "shade depends on the color of the substrate, glitter does not",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let (white, black) = (smooth::model("pearl_on_white")?, smooth::model("pearl_on_black")?);
    let scene = car();
    let tiles = [tile(&scene, &smooth::paint(&white)?)?, tile(&scene, &smooth::paint(&black)?)?];
    write(name, &exposed(beside(&tiles), -1.0))?;

    let apart = |angle: f64| -> Result<f64> {
        Ok(delta_e_2000(smooth::lab(&white, 45.0, angle)?, smooth::lab(&black, 45.0, angle)?))
    };
    let (wi, wo) = Reading::new(45.0, 15.0)?.directions();
    let glitter = [&white, &black].map(|model| model.glitter(wi, wo).linear_rgb());
    let (near, far) = (apart(15.0)?, apart(110.0)?);
    let moved = (glitter[0] - glitter[1]).abs().max_element() / glitter[1].max_element();
    Ok(Finding {
        holds: far > 10.0 && far > 2.0 * near && moved < 1e-12,
        says: format!(
            "white against black: Delta-E 2000 {near:.1} at 15 degrees, {far:.1} at 110; the glitter differs by {moved:.0e} of itself"
        ),
    })
}
