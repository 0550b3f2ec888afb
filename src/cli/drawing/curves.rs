//! Errors against clusters, steps and levels, both axes logarithmic.

use super::svg::{INK, Svg};
use super::{MARGIN, TOP, WIDTH, trimmed};
use crate::report::{CurveAxis, CurvePoint, Curves};

/// Height of a panel, and the space between two.
const HEIGHT: f64 = 300.0;
const GAP: f64 = 26.0;
/// Room for the numbers of the vertical axis.
const AXIS: f64 = 38.0;
/// Space left and right of the points of a panel.
const INSET: f64 = 18.0;
/// Decades shown: below is what chance leaves of an error of zero, above what no statistics that are of use show.
const DECADES: (i32, i32) = (-3, 1);

/// An error: its name, ink, mark and value.
type Curve = (&'static str, &'static str, Mark, fn(&CurvePoint) -> f64);

/// Told apart without color, too.
#[derive(Clone, Copy)]
enum Mark {
    Circle,
    Square,
    Diamond,
}

/// Inks of Okabe and Ito (2008).
const CURVES: [Curve; 3] = [
    ("Wasserstein-1 above its floor, Delta-E, +- noise", "#0072b2", Mark::Circle, |p| p.wasserstein),
    ("standard deviation, |ln ratio|", "#d55e00", Mark::Square, |p| p.deviation),
    ("99.9 % quantile, |ln ratio|", "#009e73", Mark::Diamond, |p| p.quantile),
];

/// The curves of a composition of this title as SVG.
pub fn curves(title: &str, curves: &Curves) -> String {
    let mut svg = Svg::default();
    svg.text([MARGIN, 38.0], 20.0, "start", &trimmed(title));
    let mut x = MARGIN + 6.0;
    for (name, ink, mark, _) in CURVES {
        draw_mark(&mut svg, mark, [x, 58.0], ink, true);
        svg.note([x + 10.0, 62.0], "start", name);
        x += 320.0;
    }
    svg.note([WIDTH - MARGIN, 62.0], "end", "hollow: outside of the scale");
    let left = MARGIN + AXIS;
    let width = (WIDTH - MARGIN - left - 2.0 * GAP) / 3.0;
    for (k, (axis, points)) in curves.along().into_iter().enumerate() {
        let panel = Panel { x: left + k as f64 * (width + GAP), width, axis, points };
        panel.draw(&mut svg, k == 0);
    }
    svg.finish([WIDTH, TOP + HEIGHT + 54.0 + MARGIN])
}

/// One curve's diagram.
struct Panel<'a> {
    x: f64,
    width: f64,
    axis: CurveAxis,
    points: &'a [CurvePoint],
}

impl Panel<'_> {
    fn draw(&self, svg: &mut Svg, numbered: bool) {
        self.draw_axes(svg, numbered);
        for point in self.points {
            let (x, w, noise) = (self.across(point), point.wasserstein, point.wasserstein_noise);
            let style = format!(r#"stroke="{}" stroke-width="1""#, CURVES[0].1);
            svg.line([x, up(w - noise)], [x, up(w + noise)], &style);
        }
        for (_, ink, mark, value) in CURVES {
            let places: Vec<[f64; 2]> =
                self.points.iter().map(|point| [self.across(point), up(value(point))]).collect();
            svg.polyline(&places, &format!(r#"stroke="{ink}" stroke-width="1.8" stroke-linejoin="round""#));
            for (place, point) in places.iter().zip(self.points) {
                draw_mark(svg, mark, *place, ink, inside(value(point)));
            }
        }
    }

    fn draw_axes(&self, svg: &mut Svg, numbered: bool) {
        let grid = r##"stroke="#dfe2e6" stroke-width="1""##;
        for decade in DECADES.0..=DECADES.1 {
            let y = up(10f64.powi(decade));
            svg.line([self.x, y], [self.x + self.width, y], grid);
            if numbered {
                svg.note([self.x - 6.0, y + 4.0], "end", &format!("{}", 10f64.powi(decade)));
            }
        }
        let foot = TOP + HEIGHT;
        for point in self.points {
            let x = self.across(point);
            svg.line([x, TOP], [x, foot + 5.0], grid);
            svg.note([x, foot + 18.0], "middle", &self.axis.label(&point.setting));
            svg.note([x, foot + 34.0], "middle", &format!("{:.1}", point.bytes / 1024.0));
        }
        svg.rect([self.x, TOP], [self.width, HEIGHT], &format!(r#"fill="none" stroke="{INK}""#));
        let name = match self.axis {
            CurveAxis::Clusters => "clusters a slice; KiB",
            CurveAxis::Steps => "steps of the inverse CDF, 50 clusters; KiB",
            CurveAxis::Level => "level of detail, 50 clusters; KiB",
        };
        svg.note([self.x + 0.5 * self.width, foot + 54.0], "middle", name);
    }

    /// Where a point lies; the points fill the panel's width.
    fn across(&self, point: &CurvePoint) -> f64 {
        let octaves = |point: &CurvePoint| self.axis.octaves(&point.setting);
        let all = || self.points.iter().map(octaves);
        let (first, last) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let share = if last > first { (octaves(point) - first) / (last - first) } else { 0.5 };
        self.x + INSET + share * (self.width - 2.0 * INSET)
    }
}

/// The height of an error; what is outside of the scale, or not a number, lies on its edge.
fn up(value: f64) -> f64 {
    let [low, high] = [DECADES.0, DECADES.1].map(f64::from);
    let decade = value.max(f64::MIN_POSITIVE).log10().clamp(low, high);
    TOP + HEIGHT * (high - decade) / (high - low)
}

fn inside(value: f64) -> bool {
    (10f64.powi(DECADES.0)..=10f64.powi(DECADES.1)).contains(&value)
}

fn draw_mark(svg: &mut Svg, mark: Mark, [x, y]: [f64; 2], ink: &str, filled: bool) {
    let fill = if filled { ink } else { "#ffffff" };
    let style = format!(r#"fill="{fill}" stroke="{ink}" stroke-width="1.4""#);
    match mark {
        Mark::Circle => svg.circle([x, y], 4.0, &style),
        Mark::Square => svg.rect([x - 3.5, y - 3.5], [7.0, 7.0], &style),
        Mark::Diamond => {
            svg.shape(&format!(
                r#"path d="M{:.2} {y:.2}L{x:.2} {:.2}L{:.2} {y:.2}L{x:.2} {:.2}Z" {style}"#,
                x - 5.0,
                y - 5.0,
                x + 5.0,
                y + 5.0
            ));
        }
    }
}
