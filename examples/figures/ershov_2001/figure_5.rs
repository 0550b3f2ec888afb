//! Fig. 5: coatings of 200 and of 43 nm, and a metallic of the first one's mean color ("metal.bmp" of the paper's disc).

use crate::mosaic::{below, beside, car, tile, write};
use crate::smooth::{chroma, hue, turn};
use crate::{Figure, Finding, smooth};
use carpaint::error::Result;
use carpaint::scene::Object;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-2001-5",
    claim: "the hue of the glitter depends on the thickness of the coating, and turns with the angle for pearls of 200 nm, not for metal of their color",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let models = ["pearl_200nm", "pearl_43nm", "metallic_like_pearl"].map(smooth::model);
    let models = models.into_iter().collect::<Result<Vec<_>>>()?;
    let paints = models.iter().map(smooth::paint).collect::<Result<Vec<_>>>()?;
    // From two sides, as Figs 2 and 5a are.
    let rows = [-24.0, 40.0].map(|turn_deg| {
        let mut scene = car();
        scene.objects = vec![Object { turn_deg, ..scene.objects[0].clone() }];
        Ok(beside(&paints.iter().map(|paint| tile(&scene, paint)).collect::<Result<Vec<_>>>()?))
    });
    write(name, &below(&rows.into_iter().collect::<Result<Vec<_>>>()?))?;

    // Next to the mirror direction of steep and of grazing light.
    let ends = |k: usize| Ok::<_, carpaint::Error>([15.0, 75.0].map(|i| smooth::lab(&models[k], i, 15.0)));
    let mut travel = Vec::new();
    let mut steep = Vec::new();
    for k in 0..3 {
        let [a, b] = ends(k)?;
        let (a, b) = (a?, b?);
        travel.push(turn(hue(a), hue(b)));
        steep.push(a);
    }
    let apart = turn(hue(steep[0]), hue(steep[1]));
    Ok(Finding {
        holds: apart > 30.0 && travel[0] > 30.0 && travel[2] < 3.0,
        says: format!(
            "hues of 200 and 43 nm are {apart:.0} degrees apart (chroma {:.0} and {:.0}); from light at 15 to light at 75 degrees they turn by {:.0} and {:.0}, the metal's by {:.1}",
            chroma(steep[0]),
            chroma(steep[1]),
            travel[0],
            travel[1],
            travel[2]
        ),
    })
}
