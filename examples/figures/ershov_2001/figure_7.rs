//! Fig. 7: two layers with pearls of different density and coating; a body, and a close look at its flakes.

use crate::mosaic::{beside, car, exposed, tile, write};
use crate::panel::{SUN_DEG, options, panel};
use crate::smooth::{chroma, hue, turn};
use crate::{Figure, Finding, paints};
use carpaint::color::{BANDS, Spectrum, lab_from_rgb, luminance};
use carpaint::error::Result;
use carpaint::render::{FlakeTruth, RenderPaint, RenderSlices, render_truth};
use carpaint::simulate::Reading;
use carpaint::simulate::sparkle::view::KindSparkles;
use carpaint::simulate::sparkle::{Masking, SparkleView};
use glam::DVec3;
use std::f64::consts::PI;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-2001-7",
    claim: "two layers of pearls with different coatings make one glitter of two hues",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let preset = "two_flake_layers";
    let chain = paints::chain(preset)?;
    let (paint, model) = (&chain.paint, &chain.model);
    let car = car();
    // The raw slices: statistics know no sizes of flakes.
    let slices = RenderSlices::new(&chain.btf);
    let ready = [RenderPaint::new(paint)?];
    let near = panel(0.5 * chain.btf.texel_mm, car.size[1]);
    let close = render_truth(&near, &ready, &[FlakeTruth::Slices(&slices)], &options(), &|| ())?;
    write(name, &beside(&[tile(&car, paint)?, exposed(close, -1.0)]))?;

    let (wi, wo) = Reading::new(45.0, 15.0)?.directions();
    let view = SparkleView::new(model.optics(), wi, wo, SUN_DEG.to_radians(), Masking::Dimmed);
    // The topmost film comes first.
    let [top, bottom] = [0, 1].map(|k| light(&view.kinds()[k]));
    let [a, b] = [top, bottom].map(|rgb| lab_from_rgb(PI * rgb));
    let share = luminance(top) / luminance(top + bottom);
    let apart = turn(hue(a), hue(b));
    Ok(Finding {
        holds: apart > 30.0 && (0.1..0.9).contains(&share),
        says: format!(
            "at 15 degrees the hues of the layers' light are {apart:.0} degrees apart (chroma {:.0} above, {:.0} below); the upper layer's is {:.0} % of the luminance, from {:.0} % of the sparkles",
            chroma(a),
            chroma(b),
            100.0 * share,
            100.0 * view.kinds()[0].density / view.mean_count(1.0)
        ),
    })
}

/// The mean light of a kind of flakes, 1/sr.
fn light(kind: &KindSparkles) -> DVec3 {
    // Mean of exp(-thickness z) over depths z of 0 to 1.
    let dimmed = |x: f64| if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
    let mean = |k: usize| kind.density * kind.brightness[k] * dimmed(kind.thickness[k]);
    Spectrum(std::array::from_fn::<_, BANDS, _>(mean)).linear_rgb()
}
