//! Curves and points in panels, as SVG.

use carpaint::error::{Error, Result};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use std::path::Path;

/// Colors that all eyes tell apart (Okabe & Ito 2008), but for the yellow one, which is too bright for a line.
pub const COLORS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 158, 115),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(204, 121, 167),
];
/// Of the same, those for red, green and blue.
pub const RED_GREEN_BLUE: [RGBColor; 3] = [COLORS[5], COLORS[3], COLORS[4]];

const PANEL: (u32, u32) = (420, 320);

/// A diagram.
pub struct Panel {
    pub title: String,
    /// What the axes show, with unit.
    pub axes: [&'static str; 2],
    /// Share of the height that is left free above the curves, for the legend.
    pub headroom: f64,
    pub curves: Vec<Curve>,
}

/// What a diagram shows.
pub struct Curve {
    /// In the legend; none where it is empty.
    pub label: String,
    pub color: RGBColor,
    /// Points instead of a line.
    pub is_dotted: bool,
    pub points: Vec<(f64, f64)>,
}

/// Writes panels in rows of `columns` as `NAME.svg`.
pub fn write(name: &Path, panels: &[Panel], columns: usize) -> Result<()> {
    let rows = panels.len().div_ceil(columns);
    let path = name.with_added_extension("svg");
    let drawn = || {
        let area =
            SVGBackend::new(&path, (PANEL.0 * columns as u32, PANEL.1 * rows as u32)).into_drawing_area();
        area.fill(&WHITE)?;
        for (place, panel) in area.split_evenly((rows, columns)).iter().zip(panels) {
            panel.draw(place)?;
        }
        area.present()
    };
    drawn().map_err(|e| Error::io(&path, std::io::Error::other(e.to_string())))
}

type Place<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawn<'a> = std::result::Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

impl Panel {
    fn draw<'a>(&self, place: &Place<'a>) -> Drawn<'a> {
        let (x, mut y) = (self.range(|p| p.0, false), self.range(|p| p.1, true));
        y.end += self.headroom * (y.end - y.start);
        let mut chart = ChartBuilder::on(place)
            .caption(&self.title, ("sans-serif", 17))
            .margin(8)
            .margin_right(20)
            .x_label_area_size(38)
            .y_label_area_size(56)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .x_labels(7)
            .y_labels(6)
            .label_style(("sans-serif", 13).into_font())
            .draw()?;
        for curve in &self.curves {
            let color = curve.color;
            let series = if curve.is_dotted {
                chart.draw_series(curve.points.iter().map(|p| Circle::new(*p, 2, color.filled())))?
            } else {
                chart.draw_series(LineSeries::new(curve.points.iter().copied(), color.stroke_width(2)))?
            };
            if !curve.label.is_empty() {
                series
                    .label(&curve.label)
                    .legend(move |(x, y)| Rectangle::new([(x, y - 1), (x + 14, y + 1)], color.filled()));
            }
        }
        if self.curves.iter().any(|curve| !curve.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperLeft)
                .background_style(WHITE.mix(0.8))
                .label_font(
                    ("sans-serif", 13).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center)),
                )
                .draw()?;
        }
        Ok(())
    }

    /// What an axis holds; from 0 where all is above it.
    fn range(&self, of: impl Fn(&(f64, f64)) -> f64, is_from_zero: bool) -> Range<f64> {
        let all = self.curves.iter().flat_map(|curve| curve.points.iter().map(&of));
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (v.min(l), v.max(h)));
        let margin = if is_from_zero { 0.05 * (high - low) } else { 0.0 };
        (if is_from_zero && low >= 0.0 { 0.0 } else { low - margin })..high + margin
    }
}
