//! Lightness over the aspecular angle, light at 45 degrees, with the colors themselves.

use super::css;
use super::svg::{FAINT, INK, Svg};
use crate::color::lab_from_rgb;
use crate::simulate::{Model, Reading, flop_index};
use glam::DVec3;
use std::f64::consts::PI;

const INCIDENCE_DEG: f64 = 45.0;
/// Aspecular angles shown: views from 80 degrees on the mirror side to 80 on the light's.
const RANGE_DEG: (i32, i32) = (-35, 125);
/// The five angles of ASTM E2194 and DIN 6175-2.
const INSTRUMENT_DEG: [f64; 5] = [15.0, 25.0, 45.0, 75.0, 110.0];
/// Height of the diagram, and of the strip of colors under it.
const HEIGHT: f64 = 250.0;
const STRIP: f64 = 34.0;
/// Room for the numbers of the vertical axis.
const AXIS: f64 = 40.0;

/// Draws the diagram with its upper left corner at `at`; returns its lower edge.
pub fn draw(svg: &mut Svg, model: &Model, [x, y]: [f64; 2], width: f64) -> f64 {
    let (first, last) = RANGE_DEG;
    let curve: Vec<(f64, DVec3)> = (first..=last)
        .filter_map(|deg| Some((f64::from(deg), reflectance(model, f64::from(deg))?)))
        .collect();
    let lightness = |rgb: DVec3| lab_from_rgb(rgb).x;
    let highest = curve.iter().map(|(_, rgb)| lightness(*rgb)).fold(0.0, f64::max);
    let top = (highest / 20.0).ceil().max(1.0) * 20.0;
    let (left, wide) = (x + AXIS, width - AXIS);
    let across = |deg: f64| left + wide * (deg - f64::from(first)) / f64::from(last - first);
    let up = |l: f64| y + HEIGHT * (1.0 - l / top);

    draw_axes(svg, &across, &up, top, [left, left + wide], y + HEIGHT + STRIP);
    let step = wide / f64::from(last - first);
    for (deg, rgb) in &curve {
        // Half a pixel more: no seams between the strips.
        let at = [(across(*deg) - 0.5 * step).max(left), y + HEIGHT];
        let end = (across(*deg) + 0.5 * step + 0.5).min(left + wide);
        svg.rect(at, [end - at[0], STRIP], &format!(r#"fill="{}" shape-rendering="crispEdges""#, css(*rgb)));
    }
    svg.rect([left, y], [wide, HEIGHT + STRIP], &format!(r#"fill="none" stroke="{INK}""#));
    let points: Vec<[f64; 2]> = curve.iter().map(|(deg, rgb)| [across(*deg), up(lightness(*rgb))]).collect();
    svg.clipped([left, y], [wide, HEIGHT], |svg| {
        svg.polyline(&points, &format!(r#"stroke="{INK}" stroke-width="1.8" stroke-linejoin="round""#));
    });
    let read: Vec<(f64, DVec3)> =
        INSTRUMENT_DEG.iter().filter_map(|deg| Some((*deg, reflectance(model, *deg)?))).collect();
    for (deg, rgb) in &read {
        let at = [across(*deg), up(lightness(*rgb))];
        svg.circle(at, 6.5, &format!(r#"fill="{}" stroke="{INK}" stroke-width="1.4""#, css(*rgb)));
    }
    draw_labels(svg, &read, &across, &up, left + wide);
    let foot = y + HEIGHT + STRIP + 34.0;
    svg.note(
        [left + 0.5 * wide, foot],
        "middle",
        "aspecular angle, degrees from the mirror towards the light",
    );
    foot
}

/// The numbers at the readings, above and below in turn so that neighbors keep clear of each other; the last ends inside the
/// frame.
fn draw_labels(
    svg: &mut Svg,
    read: &[(f64, DVec3)],
    across: &impl Fn(f64) -> f64,
    up: &impl Fn(f64) -> f64,
    right: f64,
) {
    for (k, (deg, rgb)) in read.iter().enumerate() {
        let lightness = lab_from_rgb(*rgb).x;
        let (x, y) = (across(*deg), up(lightness));
        // Above a falling curve there is room to the right, below it to the left; not on the strip of colors.
        let below = k % 2 == 1 && y + 24.0 < up(0.0);
        let (x, y) = if below { (x - 4.0, y + 20.0) } else { (x + 4.0, y - 11.0) };
        let anchor = if below || x + 40.0 > right { "end" } else { "start" };
        svg.text([x, y], 12.0, anchor, &format!("{lightness:.1}"));
    }
}

/// The flop index of what is drawn.
pub fn index(model: &Model) -> Option<f64> {
    let lightness = |deg: f64| Some(lab_from_rgb(reflectance(model, deg)?).x);
    flop_index([lightness(15.0)?, lightness(45.0)?, lightness(110.0)?])
}

/// Lines and numbers of both axes; `foot` is the lower edge of the strip.
fn draw_axes(
    svg: &mut Svg,
    across: &impl Fn(f64) -> f64,
    up: &impl Fn(f64) -> f64,
    top: f64,
    [left, right]: [f64; 2],
    foot: f64,
) {
    let grid = r##"stroke="#dfe2e6" stroke-width="1""##;
    for k in 0..=(top / 20.0) as usize {
        let l = 20.0 * k as f64;
        svg.line([left, up(l)], [right, up(l)], grid);
        svg.note([left - 6.0, up(l) + 4.0], "end", &format!("{l}"));
    }
    svg.text([left - AXIS + 4.0, up(top) - 8.0], 12.0, "start", "L*");
    let mirror = format!(r#"stroke="{FAINT}" stroke-width="1" stroke-dasharray="4 4""#);
    svg.line([across(0.0), up(top)], [across(0.0), up(0.0)], &mirror);
    svg.note([across(0.0) + 5.0, up(top) + 14.0], "start", "mirror");
    for deg in [0.0, 15.0, 25.0, 45.0, 75.0, 110.0] {
        svg.line([across(deg), foot], [across(deg), foot + 5.0], &format!(r#"stroke="{INK}""#));
        svg.note([across(deg), foot + 18.0], "middle", &format!("{deg}"));
    }
}

/// pi f, linear Rec.709; none for a direction below the horizon.
fn reflectance(model: &Model, aspecular_deg: f64) -> Option<DVec3> {
    let (wi, wo) = Reading::new(INCIDENCE_DEG, aspecular_deg).ok()?.directions();
    Some(PI * model.brdf_rgb(wi, wo))
}
