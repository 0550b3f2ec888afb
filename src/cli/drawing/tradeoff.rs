//! Error against cost of the settings of a knob, both axes logarithmic.

use super::MARGIN;
use super::digits;
use super::svg::{FAINT, INK, Svg};
use crate::tradeoff::{Axis, Curve, Point};

/// Size of the picture, pixels.
const SIZE: [f64; 2] = [760.0, 340.0];
/// Room for the numbers of the vertical axis, above the diagram, and below it.
const LEFT: f64 = 76.0;
const TOP: f64 = 30.0;
const FOOT: f64 = 52.0;
/// Inks of Okabe and Ito (2008): the front, and what lies behind it.
const FRONT: &str = "#0072b2";
const BEHIND: &str = "#d55e00";
/// Decades below the largest error in which errors are told apart; smaller ones, and none at all, lie on the lower edge.
const DECADES: f64 = 9.0;

/// The diagrams of all curves as one SVG, two in a row, each under its name.
pub fn tradeoffs(curves: &[Curve]) -> String {
    const NAME: f64 = 26.0;
    let mut svg = Svg::default();
    for (k, curve) in curves.iter().enumerate() {
        let at = [SIZE[0] * (k % 2) as f64, (SIZE[1] + NAME) * (k / 2) as f64];
        svg.note([at[0] + MARGIN, at[1] + 18.0], "start", &format!("{}: {}", curve.stage, curve.knob));
        svg.moved([at[0], at[1] + NAME], |svg| draw(svg, curve));
    }
    svg.finish([2.0 * SIZE[0], (SIZE[1] + NAME) * curves.len().div_ceil(2) as f64])
}

/// The diagram of a curve as SVG.
pub fn tradeoff(curve: &Curve) -> String {
    let mut svg = Svg::default();
    draw(&mut svg, curve);
    svg.finish(SIZE)
}

fn draw(svg: &mut Svg, curve: &Curve) {
    let axes = Axes::new(&curve.points);
    axes.draw(svg, curve.axis);
    let mut front: Vec<&Point> = curve.points.iter().filter(|point| point.is_on_front).collect();
    front.sort_by(|a, b| a.relative.total_cmp(&b.relative));
    let places: Vec<[f64; 2]> = front.iter().map(|point| axes.place(point)).collect();
    svg.polyline(&places, &format!(r#"stroke="{FRONT}" stroke-width="1.6" stroke-dasharray="5 3""#));
    let mut names = Names::new(curve.points.iter().map(|point| axes.place(point)));
    for point in &curve.points {
        let [x, y] = axes.place(point);
        let ink = if point.is_on_front { FRONT } else { BEHIND };
        if point.is_default {
            svg.circle([x, y], 9.0, &format!(r#"fill="none" stroke="{INK}" stroke-width="1.6""#));
        }
        let fill = if axes.holds(point) { ink } else { "#ffffff" };
        svg.circle([x, y], 4.5, &format!(r#"fill="{fill}" stroke="{ink}" stroke-width="1.6""#));
        names.draw(svg, [x, y], &point.setting);
    }
}

/// Where names stand: each where it hides neither a point nor another name, if there is such a place.
struct Names {
    /// Left, top, right and bottom of what is taken.
    taken: Vec<[f64; 4]>,
}

impl Names {
    /// Widths of letters, on average, and heights, of small text.
    const LETTER: [f64; 2] = [6.3, 12.0];
    /// From a point to the foot of its name: across, down, and which end of it is meant.
    const PLACES: [(f64, f64, &str); 8] = [
        (0.0, -13.0, "middle"),
        (0.0, 22.0, "middle"),
        (12.0, 4.0, "start"),
        (-12.0, 4.0, "end"),
        (8.0, -13.0, "start"),
        (-8.0, -13.0, "end"),
        (8.0, 22.0, "start"),
        (-8.0, 22.0, "end"),
    ];

    fn new(points: impl Iterator<Item = [f64; 2]>) -> Self {
        Self { taken: points.map(|[x, y]| [x - 6.0, y - 6.0, x + 6.0, y + 6.0]).collect() }
    }

    fn draw(&mut self, svg: &mut Svg, [x, y]: [f64; 2], name: &str) {
        let width = Self::LETTER[0] * name.chars().count() as f64;
        let frame = |(across, down, anchor): &(f64, f64, &str)| {
            let left = x + across
                - match *anchor {
                    "middle" => 0.5 * width,
                    "end" => width,
                    _ => 0.0,
                };
            [left, y + down - Self::LETTER[1], left + width, y + down]
        };
        let is_free = |frame: [f64; 4]| {
            let apart = |other: &[f64; 4]| {
                frame[0] > other[2] || frame[2] < other[0] || frame[1] > other[3] || frame[3] < other[1]
            };
            let inside = frame[0] > LEFT && frame[2] < SIZE[0] - MARGIN && frame[3] < SIZE[1] - FOOT;
            inside && self.taken.iter().all(apart)
        };
        let free = Self::PLACES.iter().find(|place| is_free(frame(place)));
        let place = free.unwrap_or(&Self::PLACES[if x < 0.5 * SIZE[0] { 4 } else { 5 }]);
        self.taken.push(frame(place));
        svg.note([x + place.0, y + place.1], place.2, name);
    }
}

/// Ends of both axes, decades.
struct Axes {
    cost: [f64; 2],
    error: [f64; 2],
}

impl Axes {
    fn new(points: &[Point]) -> Self {
        let largest = points.iter().map(|point| point.error).fold(0.0, f64::max);
        let top = if largest > 0.0 { largest.log10().floor() + 1.0 } else { 0.0 };
        let least = points.iter().map(|point| point.error).filter(|e| *e > 0.0).fold(largest, f64::min);
        let none_at_all = points.iter().any(|point| point.error <= 0.0);
        let least = if least > 0.0 { least.log10().floor() - f64::from(u8::from(none_at_all)) } else { -1.0 };
        let costs: Vec<f64> = points.iter().map(|point| point.relative.max(1e-9).log10()).collect();
        let low = costs.iter().copied().fold(f64::INFINITY, f64::min).floor();
        let high = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil();
        Self { cost: [low, high.max(low + 1.0)], error: [least.max(top - DECADES), top] }
    }

    /// Whether an error is one of the axis and not below its lower end.
    fn holds(&self, point: &Point) -> bool {
        point.error >= 10f64.powf(self.error[0])
    }

    fn place(&self, point: &Point) -> [f64; 2] {
        [self.across(point.relative.max(1e-9).log10()), self.up(point.error.max(f64::MIN_POSITIVE).log10())]
    }

    fn across(&self, decade: f64) -> f64 {
        let [low, high] = self.cost;
        LEFT + (SIZE[0] - MARGIN - LEFT) * (decade - low) / (high - low)
    }

    fn up(&self, decade: f64) -> f64 {
        let [low, high] = self.error;
        SIZE[1] - FOOT - (SIZE[1] - FOOT - TOP) * (decade.clamp(low, high) - low) / (high - low)
    }

    fn draw(&self, svg: &mut Svg, axis: Axis) {
        let cost = match axis {
            Axis::Time => "time",
            Axis::Bytes => "bytes",
        };
        let grid = r##"stroke="#dfe2e6" stroke-width="1""##;
        let (left, right) = (self.across(self.cost[0]), self.across(self.cost[1]));
        let (low, high) = (self.up(self.error[0]), self.up(self.error[1]));
        for decade in self.error[0] as i32..=self.error[1] as i32 {
            let y = self.up(f64::from(decade));
            svg.line([left, y], [right, y], grid);
            svg.note([left - 8.0, y + 4.0], "end", &power(decade));
        }
        for decade in self.cost[0] as i32..=self.cost[1] as i32 {
            let x = self.across(f64::from(decade));
            svg.line([x, low], [x, high], grid);
            svg.note([x, low + 18.0], "middle", &power(decade));
        }
        svg.rect([left, high], [right - left, low - high], &format!(r#"fill="none" stroke="{FAINT}""#));
        svg.note(
            [0.5 * (left + right), low + 38.0],
            "middle",
            &format!("{cost}, the default's 1; hollow: an error of 0, or below the scale"),
        );
    }
}

/// A power of ten, short.
fn power(decade: i32) -> String {
    if (-4..=4).contains(&decade) { digits(10f64.powi(decade)) } else { format!("1e{decade}") }
}
