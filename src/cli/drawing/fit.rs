//! A measurement and its fit over the angle of the half vector, as figure 8 of Rump et al. 2008.

use super::svg::{INK, Svg};
use super::{MARGIN, TOP, WIDTH, trimmed};
use crate::fit::{Compared, FitReport};

/// Height of the diagram.
const HEIGHT: f64 = 420.0;
/// Room for the numbers of the vertical axis.
const AXIS: f64 = 56.0;
/// Most decades shown below the brightest sample: darker ones lie on the edge.
const DECADES: i32 = 6;
/// The decades whose numbers are written out; others as 1e-7.
const PLAIN: std::ops::RangeInclusive<i32> = -5..=5;

/// A kind of dot: its name, radius, style and value.
type Dots = (&'static str, f64, &'static str, fn(&Compared) -> f64);

/// Data below, large and pale, so that they show around the fit, and both are told apart without color, too. Inks of Okabe and
/// Ito (2008).
const DOTS: [Dots; 2] = [
    ("data", 2.4, r##"fill="#0072b2" fill-opacity="0.35""##, |p| p.measured),
    ("fit", 1.1, r##"fill="#d55e00" fill-opacity="0.9""##, |p| p.fitted),
];

/// The diagram of `points` as SVG.
pub fn fit_plot(title: &str, report: &FitReport, points: &[Compared]) -> String {
    let mut svg = Svg::default();
    svg.text([MARGIN, 38.0], 20.0, "start", &trimmed(title));
    let lobes = report.lobes.len();
    let gloss = if report.coat.gloss.is_some() { " and gloss" } else { "" };
    let terms = format!("diffuse, {lobes} lobe{}{gloss}", if lobes == 1 { "" } else { "s" });
    let errors =
        format!("mean |ln(data / fit)| {:.3}, with color table {:.3}", report.error, report.colored_error);
    svg.note([MARGIN, 60.0], "start", &format!("{terms}; outside of the gloss {errors}"));
    for (k, (name, radius, style, _)) in DOTS.into_iter().enumerate() {
        let x = WIDTH - MARGIN - 130.0 + 75.0 * k as f64;
        svg.circle([x, 56.0], 2.0 * radius, style);
        svg.note([x + 10.0, 60.0], "start", name);
    }
    let diagram = Diagram::over(points);
    diagram.draw_axes(&mut svg);
    for (_, radius, style, value) in DOTS {
        for p in points {
            let at = [diagram.across(p.theta_h.to_degrees()), diagram.up(value(p))];
            svg.circle(at, radius, style);
        }
    }
    svg.finish([WIDTH, TOP + HEIGHT + 48.0 + MARGIN])
}

/// The decades that the diagram shows.
struct Diagram {
    low: i32,
    high: i32,
}

impl Diagram {
    fn over(points: &[Compared]) -> Self {
        let values =
            || points.iter().flat_map(|p| [p.measured, p.fitted]).filter(|v| *v > 0.0).map(f64::log10);
        let high = values().fold(f64::NEG_INFINITY, f64::max).clamp(-30.0, 30.0).ceil() as i32;
        let low = values().fold(f64::INFINITY, f64::min).clamp(-30.0, 30.0).floor() as i32;
        Self { low: low.max(high - DECADES).min(high - 1), high }
    }

    fn draw_axes(&self, svg: &mut Svg) {
        let grid = r##"stroke="#dfe2e6" stroke-width="1""##;
        let (left, right, foot) = (self.across(0.0), self.across(90.0), TOP + HEIGHT);
        for decade in self.low..=self.high {
            let y = self.up(10f64.powi(decade));
            svg.line([left, y], [right, y], grid);
            let value = 10f64.powi(decade);
            let text = if PLAIN.contains(&decade) { format!("{value}") } else { format!("{value:e}") };
            svg.note([left - 8.0, y + 4.0], "end", &text);
        }
        for degrees in (0..=90).step_by(10).map(f64::from) {
            let x = self.across(degrees);
            svg.line([x, TOP], [x, foot + 5.0], grid);
            svg.note([x, foot + 20.0], "middle", &format!("{degrees}°"));
        }
        svg.rect([left, TOP], [right - left, HEIGHT], &format!(r#"fill="none" stroke="{INK}""#));
        svg.note([0.5 * (left + right), foot + 40.0], "middle", "angle between half vector and normal");
        svg.note([MARGIN, TOP - 10.0], "start", "BRDF, mean of the bands, 1/sr");
        svg.note([right, TOP - 10.0], "end", "on the lower edge: darker, or negative");
    }

    fn across(&self, degrees: f64) -> f64 {
        let left = MARGIN + AXIS;
        left + (WIDTH - MARGIN - left) * degrees / 90.0
    }

    /// What is below the scale, or zero, lies on its edge.
    fn up(&self, value: f64) -> f64 {
        let (low, high) = (f64::from(self.low), f64::from(self.high));
        let decade = value.max(f64::MIN_POSITIVE).log10().clamp(low, high);
        TOP + HEIGHT * (high - decade) / (high - low)
    }
}
