//! A paint in one picture: a cut through its layers, to scale, and its flop curve. And the curves of its errors, and a fit.

mod curves;
mod fit;
mod flop;
mod stack;
mod svg;
mod tradeoff;

pub use curves::curves;
pub use fit::fit_plot;
pub use tradeoff::{tradeoff, tradeoffs};

use crate::color::srgb_encode;
use crate::simulate::Model;
use glam::DVec3;
use svg::Svg;
pub use svg::escape;

/// Width of the whole picture, pixels.
const WIDTH: f64 = 1140.0;
/// Space around both halves.
const MARGIN: f64 = 28.0;
/// Where the flop curve begins.
const FLOP_X: f64 = 700.0;
/// Upper edge of both halves, below the title.
const TOP: f64 = 92.0;

/// Most letters of a title, some 14 pixels each at the widest.
const LONGEST_TITLE: usize = 75;

/// The picture as SVG.
pub fn svg(model: &Model) -> String {
    let mut svg = Svg::default();
    let title = &model.composition().title;
    svg.text([MARGIN, 38.0], 20.0, "start", &trimmed(title));
    let films = model.composition().films.len();
    let subtitle = format!("cut through {films} film{} and substrate", if films == 1 { "" } else { "s" });
    svg.note([MARGIN, 58.0], "start", &subtitle);
    let index = flop::index(model).map_or_else(String::new, |index| format!(", flop index {index:.1}"));
    svg.note([FLOP_X, 58.0], "start", &format!("flop: light at 45°, body without gloss{index}"));
    let stack = stack::draw(&mut svg, model, [MARGIN, TOP]);
    let flop = flop::draw(&mut svg, model, [FLOP_X, TOP], WIDTH - MARGIN - FLOP_X);
    svg.finish([WIDTH, stack.max(flop) + MARGIN])
}

/// A title no longer than the picture is wide.
fn trimmed(title: &str) -> String {
    if title.is_empty() {
        return "paint".to_owned();
    }
    if title.chars().count() <= LONGEST_TITLE {
        return title.to_owned();
    }
    title.chars().take(LONGEST_TITLE - 1).chain(['…']).collect()
}

/// A number with four digits, and none that say nothing.
fn digits(x: f64) -> String {
    let scale = 10f64.powf(3.0 - x.abs().max(f64::MIN_POSITIVE).log10().floor());
    // The last division rounds to the nearest number there is, which prints short.
    if x == 0.0 || !scale.is_finite() { x.to_string() } else { ((x * scale).round() / scale).to_string() }
}

/// A linear color as CSS writes it, clipped to what a screen shows.
fn css(rgb: DVec3) -> String {
    let [r, g, b] = rgb.to_array().map(|c| (255.0 * srgb_encode(c.clamp(0.0, 1.0))).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}
