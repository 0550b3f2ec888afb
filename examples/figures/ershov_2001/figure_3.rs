//! Fig. 3: a conventional solid paint, which has gloss and shade, beside a pearl.

use crate::mosaic::{beside, car, tile, write};
use crate::{Figure, Finding, smooth};
use carpaint::error::Result;
use carpaint::simulate::{Model, Reading, flop_index};
use std::f64::consts::PI;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-2001-3",
    claim: "a solid paint has gloss and shade as a pearl has, and no glitter: its body looks alike from everywhere",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let (solid, pearl) = (smooth::model("solid_red")?, smooth::model("pearl_200nm")?);
    let scene = car();
    let tiles = [tile(&scene, &smooth::paint(&solid)?)?, tile(&scene, &smooth::paint(&pearl)?)?];
    write(name, &beside(&tiles))?;

    let flops = [flop(&solid)?, flop(&pearl)?];
    let (wi, wo) = Reading::new(45.0, 0.0)?.directions();
    let glitter = solid.glitter(wi, wo).linear_rgb().max_element();
    let gloss = PI * solid.gloss(wi, wo);
    Ok(Finding {
        holds: flops[0] < 1.0 && flops[1] > 5.0 && glitter == 0.0 && gloss > 1.0,
        says: format!(
            "flop index {:.2} (solid), {:.1} (pearl); in the mirror direction of the solid's light: glitter {glitter}, gloss {gloss:.0} times a white diffuser",
            flops[0], flops[1]
        ),
    })
}

fn flop(model: &Model) -> Result<f64> {
    let [near, face, far] = [15.0, 45.0, 110.0].map(|angle| smooth::lab(model, 45.0, angle));
    Ok(flop_index([near?.x, face?.x, far?.x]).unwrap_or(f64::NAN))
}
