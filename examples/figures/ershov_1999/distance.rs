//! Section 5.2: how sparkles and texture fade with the viewing distance, eqs 1 and 2; the panel from four distances.

use crate::mosaic::{beside, exposed, write};
use crate::panel::{EYE, INCIDENCE_DEG, SUN_DEG, contrast, luminances, mean, options, panel};
use crate::plots::{self, BLACK, BLUE, Curve, GREEN, Mark, Plot, Span, VERMILION};
use crate::{Figure, Finding, paints, smooth};
use carpaint::color::{Spectrum, luminance};
use carpaint::error::Result;
use carpaint::render::{FlakeTruth, Options, Picture, RenderPaint, render, render_truth};
use carpaint::simulate::sparkle::visibility::{footprint, sparkle_luminance};
use carpaint::simulate::sparkle::{Masking, SparkleModel, SparkleView};
use carpaint::simulate::{Model, Reading};
use plotters::chart::SeriesLabelPosition;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "ershov-1999-distance",
    claim: "texture fades as one over the distance, a single sparkle as one over its square, both as the formulas say",
    draw,
};

const PRESET: &str = "silver_metallic";
/// Pixels along a panel: enough that the rarest sparkles, three in a thousand pixels, are some hundreds.
const SIDE: usize = 384;
const METERS: [f64; 9] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// Of which a picture is shown.
const SHOWN: [usize; 4] = [0, 2, 4, 6];
/// Columns and rows of it.
const SHOWN_SIDE: usize = 220;
/// More sparkles a pixel than this, and they are no single ones.
const SINGLE: f64 = 0.2;

/// A pixel is lit that is brighter by this than those without a sparkle, over the mean.
const STANDS_OUT: f64 = 0.5;

/// The lowest contrast shown.
const LEAST: f64 = 1e-3;

/// What is seen from one distance.
struct Seen {
    /// Standard deviation over mean, of rendered sparkles, of flakes rendered from statistics, and by eq. 2.
    contrast: [f64; 3],
    /// Luminance of a lit pixel over that of the paint, rendered and by eq. 1; where sparkles are alone.
    sparkle: Option<[f64; 2]>,
}

fn draw(name: &Path) -> Result<Finding> {
    let model = smooth::model(PRESET)?;
    let sparkles = SparkleModel::new(model.optics());
    let ready = [RenderPaint::new(&smooth::paint(&model)?)?, RenderPaint::new(&*paints::simulated(PRESET)?)?];
    let (mut seen, mut shown) = (Vec::new(), Vec::new());
    for (k, meters) in METERS.into_iter().enumerate() {
        let pictures = pictures(&ready, &sparkles, meters)?;
        seen.push(look(&model, &pictures, meters)?);
        if SHOWN.contains(&k) {
            shown.push(corner(&pictures[0]));
        }
    }
    write(&name.with_added_extension("panels"), &exposed(beside(&shown), -0.5))?;

    // What lies below the diagram is nothing: statistics of a slice say nothing of pixels wider than it.
    let along = |k: usize| {
        let all = METERS.into_iter().zip(&seen).map(move |(m, s)| (m, s.contrast[k]));
        all.filter(|p| p.1 > LEAST).collect()
    };
    let single =
        |k: usize| METERS.into_iter().zip(&seen).filter_map(move |(m, s)| Some((m, s.sparkle?[k]))).collect();
    let curve = |name: &str, ink, mark, points| Curve { name: name.into(), ink, mark, points };
    let curves = vec![
        curve("a sparkle over the paint, eq. 1", BLACK, Mark::Line, single(1)),
        curve("the same, rendered", VERMILION, Mark::Dots(5), single(0)),
        curve("contrast of the texture, eq. 2", BLUE, Mark::Line, along(2)),
        curve("the same, rendered", BLUE, Mark::Dots(5), along(0)),
        curve("the same, flakes with lobes, from statistics of 1.5 mm", GREEN, Mark::Dots(5), along(1)),
    ];
    let plot = Plot {
        title: "Silver metallic in the sun, seen by an eye of one arcminute".into(),
        axes: ["distance, m", "contrast (standard deviation / mean; sparkle / mean)"],
        across: Span::Logarithmic(0.2..80.0),
        up: Span::Logarithmic(LEAST..3e3),
        legend: SeriesLabelPosition::UpperRight,
        curves,
    };
    plots::write(name, std::slice::from_ref(&plot), 1)?;
    let drawn = &plot.curves;

    let [sparkle, texture] = [&drawn[1], &drawn[3]].map(|c| exponent(&c.points));
    let off = |drawn: &Curve, law: &Curve| {
        let ratios = drawn.points.iter().zip(&law.points).map(|(a, b)| (a.1 / b.1 - 1.0).abs());
        100.0 * ratios.fold(0.0, f64::max)
    };
    let (sparkle_off, texture_off) = (off(&drawn[1], &drawn[0]), off(&drawn[3], &drawn[2]));
    Ok(Finding {
        holds: (sparkle + 2.0).abs() < 0.1
            && (texture + 1.0).abs() < 0.05
            && sparkle_off.max(texture_off) < 20.0,
        says: format!(
            "exponents over the distance: sparkle {sparkle:.2} (-2), texture {texture:.2} (-1); within {sparkle_off:.0} and {texture_off:.0} % of eqs 1 and 2"
        ),
    })
}

/// The panel from a distance: with Ershov's sparkles, and with flakes from statistics.
fn pictures(ready: &[RenderPaint; 2], sparkles: &SparkleModel, meters: f64) -> Result<[Picture; 2]> {
    let scene = panel(1000.0 * meters * EYE, SIDE);
    // One sample: a pixel is what one draw is of.
    let options = Options { samples: 1, ..options() };
    let truth = [FlakeTruth::Sparkles(sparkles)];
    let drawn = render_truth(&scene, &ready[..1], &truth, &options, &|| ())?;
    Ok([drawn, render(&scene, &ready[1..], &options, &|| ())?])
}

fn look(model: &Model, pictures: &[Picture; 2], meters: f64) -> Result<Seen> {
    let (wi, wo) = Reading::new(INCIDENCE_DEG, INCIDENCE_DEG)?.directions();
    let view = SparkleView::new(model.optics(), wi, wo, SUN_DEG.to_radians(), Masking::Dimmed);
    let area = footprint(1e6 * meters, EYE, wo.z);
    let y = |spectrum: Spectrum| luminance(spectrum.linear_rgb());
    let paint = luminance(model.brdf_rgb(wi, wo));
    let deviation = y(Spectrum(view.variance(area).0.map(f64::sqrt)));
    let values = pictures.each_ref().map(luminances);
    let sparkle = (view.mean_count(area) < SINGLE).then(|| {
        // No flake shines in most pixels; the lit stand out from them. The sun is 1 across its rays.
        let mut sorted = values[0].clone();
        sorted.sort_by(f64::total_cmp);
        let unlit = sorted[sorted.len() / 2];
        let lit: Vec<f64> =
            sorted.iter().map(|v| (v - unlit) / (paint * wi.z)).filter(|v| *v > STANDS_OUT).collect();
        [mean(&lit), y(sparkle_luminance(&view, area)) / paint]
    });
    let [drawn, statistics] = values.map(|values| contrast(&values));
    Ok(Seen { contrast: [drawn, statistics, deviation / paint], sparkle })
}

/// The part of a picture that is shown.
fn corner(picture: &Picture) -> Picture {
    let rows = picture.pixels.chunks(picture.size[0]).take(SHOWN_SIDE);
    Picture { size: [SHOWN_SIDE; 2], pixels: rows.flat_map(|row| row[..SHOWN_SIDE].to_vec()).collect() }
}

/// Exponent of the power law through points, by least squares of logarithms.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| [p.0.ln(), p.1.ln()]).collect();
    let [x, y] = [0, 1].map(|k| logs.iter().map(|p| p[k]).sum::<f64>() / logs.len() as f64);
    let (sum, squares) =
        logs.iter().fold((0.0, 0.0), |(s, q), p| (s + (p[0] - x) * (p[1] - y), q + (p[0] - x).powi(2)));
    sum / squares
}
