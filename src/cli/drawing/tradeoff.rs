//! Error against cost of the settings of a knob, both axes logarithmic.

use super::MARGIN;
use super::digits;
use super::svg::{FAINT, INK, Svg};
use crate::tradeoff::{Curve, Point};

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

/// The diagram of a curve as SVG.
pub fn tradeoff(curve: &Curve) -> String {
    let mut svg = Svg::default();
    let axes = Axes::new(&curve.points);
    axes.draw(&mut svg);
    let mut front: Vec<&Point> = curve.points.iter().filter(|point| point.is_on_front).collect();
    front.sort_by(|a, b| a.cost.ratio.total_cmp(&b.cost.ratio));
    let places: Vec<[f64; 2]> = front.iter().map(|point| axes.place(point)).collect();
    svg.polyline(&places, &format!(r#"stroke="{FRONT}" stroke-width="1.6" stroke-dasharray="5 3""#));
    for (k, point) in curve.points.iter().enumerate() {
        let [x, y] = axes.place(point);
        let ink = if point.is_on_front { FRONT } else { BEHIND };
        if point.is_default {
            svg.circle([x, y], 9.0, &format!(r#"fill="none" stroke="{INK}" stroke-width="1.6""#));
        }
        let fill = if axes.holds(point) { ink } else { "#ffffff" };
        svg.circle([x, y], 4.5, &format!(r#"fill="{fill}" stroke="{ink}" stroke-width="1.6""#));
        // Neighbors that lie close have their names above and below, where there is room.
        let below = k % 2 == 1 && y < SIZE[1] - FOOT - 30.0;
        svg.note([x, if below { y + 22.0 } else { y - 13.0 }], "middle", &point.setting);
    }
    svg.finish(SIZE)
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
        let costs: Vec<f64> = points.iter().map(|point| point.cost.ratio.max(1e-9).log10()).collect();
        let low = costs.iter().copied().fold(f64::INFINITY, f64::min).floor();
        let high = costs.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil();
        Self { cost: [low, high.max(low + 1.0)], error: [least.max(top - DECADES), top] }
    }

    /// Whether an error is one of the axis and not below its lower end.
    fn holds(&self, point: &Point) -> bool {
        point.error >= 10f64.powf(self.error[0])
    }

    fn place(&self, point: &Point) -> [f64; 2] {
        [self.across(point.cost.ratio.max(1e-9).log10()), self.up(point.error.max(f64::MIN_POSITIVE).log10())]
    }

    fn across(&self, decade: f64) -> f64 {
        let [low, high] = self.cost;
        LEFT + (SIZE[0] - MARGIN - LEFT) * (decade - low) / (high - low)
    }

    fn up(&self, decade: f64) -> f64 {
        let [low, high] = self.error;
        SIZE[1] - FOOT - (SIZE[1] - FOOT - TOP) * (decade.clamp(low, high) - low) / (high - low)
    }

    fn draw(&self, svg: &mut Svg) {
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
            "time, the default's 1; hollow: an error of 0, or below the scale",
        );
    }
}

/// A power of ten, short.
fn power(decade: i32) -> String {
    if (-4..=4).contains(&decade) { digits(10f64.powi(decade)) } else { format!("1e{decade}") }
}
