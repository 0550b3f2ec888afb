//! Fig. 1: the whole technique on a body: gloss, sparkle and flip-flop together.

use super::FLIP_FLOP;
use crate::mosaic::{car, exposed, tile, tile_with, write};
use crate::panel::{contrast, luminances, options, panel};
use crate::{Figure, Finding, paints};
use carpaint::color::lab_from_rgb;
use carpaint::error::Result;
use carpaint::fit::SmoothFit;
use carpaint::render::{FlakeTruth, Options, RenderPaint, RenderSlices, render_truth};
use carpaint::report::picture_checks;
use carpaint::scene::Scene;
use carpaint::simulate::Reading;
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-1",
    claim: "the light of the body, its sparkle and its change of color are those of the paint that was measured",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let chain = paints::chain(FLIP_FLOP)?;
    let scene = Scene { size: [640, 352], ..car() };
    write(name, &exposed(tile(&scene, &chain.paint)?, 0.3))?;

    let body = picture_checks(&chain.paint, &chain.model)?[0].value;
    let near = panel(1.5 * chain.btf.texel_mm, 256);
    let slices = RenderSlices::new(&chain.btf);
    let ready = [RenderPaint::new(&chain.paint)?];
    let fine = Options { samples: 16, ..options() };
    let truth = render_truth(&near, &ready, &[FlakeTruth::Slices(&slices)], &fine, &|| ())?;
    let drawn = tile_with(&near, &chain.paint, &options())?;
    let [drawn, measured] = [drawn, truth].map(|picture| contrast(&luminances(&picture)));
    let fit = SmoothFit::from(&chain.paint);
    let shown = travel(|wi, wo| fit.eval(wi, wo))?;
    let simulated = travel(|wi, wo| chain.model.brdf_rgb(wi, wo))?;
    Ok(Finding {
        holds: body < 1.0 && (drawn / measured - 1.0).abs() < 0.15 && (shown / simulated - 1.0).abs() < 0.1,
        says: format!(
            "body: mean Delta-E 2000 {body:.2}; sparkle: contrast {drawn:.2} against {measured:.2} of the raw slices; a, b move by {shown:.1} between steep and grazing light, the paint's by {simulated:.1}"
        ),
    })
}

/// How far a, b move next to the mirror direction from light at 15 to light at 75 degrees.
fn travel(brdf: impl Fn(DVec3, DVec3) -> DVec3) -> Result<f64> {
    let ends = [15.0, 75.0].map(|incidence| -> Result<DVec3> {
        let (wi, wo) = Reading::new(incidence, 15.0)?.directions();
        Ok(lab_from_rgb(PI * brdf(wi, wo)))
    });
    let [steep, grazing] = ends;
    let moved = grazing? - steep?;
    Ok(moved.y.hypot(moved.z))
}
