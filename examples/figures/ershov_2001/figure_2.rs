//! Fig. 2: the attributes gloss, glitter and shade; here each alone, and the three together.

use crate::mosaic::{below, beside, car, tile, write};
use crate::{Figure, Finding, smooth};
use carpaint::brdf::ClearCoat;
use carpaint::color::luminance;
use carpaint::error::Result;
use carpaint::paint::Paint;
use carpaint::simulate::Reading;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-2001-2",
    claim: "glitter is what is seen of the body near the mirror direction, shade what is seen far from it; gloss is on top",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let model = smooth::model("pearl_200nm")?;
    let whole = smooth::paint(&model)?;
    let matt = ClearCoat { mirror: 0.0, ..model.coat() };
    let gloss = Paint { diffuse: 0.0, lobes: Vec::new(), ..whole.clone() };
    let glitter = smooth::fitted(matt, |wi, wo| model.glitter(wi, wo).linear_rgb())?;
    let shade = smooth::fitted(matt, |wi, wo| model.rest(wi, wo).linear_rgb())?;
    let scene = car();
    let rows = [[&gloss, &glitter], [&shade, &whole]];
    let rows = rows.map(|row| Ok(beside(&[tile(&scene, row[0])?, tile(&scene, row[1])?])));
    write(name, &below(&rows.into_iter().collect::<Result<Vec<_>>>()?))?;

    let share = |aspecular: f64| -> Result<f64> {
        let (wi, wo) = Reading::new(45.0, aspecular)?.directions();
        Ok(luminance(model.glitter(wi, wo).linear_rgb()) / luminance(model.brdf_rgb(wi, wo)))
    };
    let (near, far) = (share(15.0)?, share(110.0)?);
    Ok(Finding {
        holds: near > 0.9 && far < 0.1,
        says: format!(
            "glitter is {:.1} % of the body's luminance at 15 degrees and {:.1} % at 110, light at 45 degrees (gloss | glitter / shade | all)",
            100.0 * near,
            100.0 * far
        ),
    })
}
