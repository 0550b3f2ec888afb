//! Curves and points in diagrams, as SVG.

use carpaint::error::{Error, Result};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

/// Inks of Okabe and Ito (2008), told apart by everybody, but for the yellow one, which is too bright for a line.
pub const BLACK: RGBColor = RGBColor(34, 37, 42);
pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub const SKY: RGBColor = RGBColor(86, 180, 233);
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub const PURPLE: RGBColor = RGBColor(204, 121, 167);

/// How points are shown.
#[derive(Clone, Copy)]
pub enum Mark {
    Line,
    /// Dots of that radius, pixels.
    Dots(i32),
}

/// A curve.
pub struct Curve {
    /// In the legend; none where it is empty.
    pub name: String,
    pub ink: RGBColor,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

/// What an axis spans.
pub enum Span {
    /// What the points do, and a margin; the vertical one from 0 where all are above it, with so much of its height left free for
    /// the legend.
    Data(f64),
    Linear(Range<f64>),
    Logarithmic(Range<f64>),
}

/// A diagram.
pub struct Plot {
    pub title: String,
    /// What the axes say, with unit.
    pub axes: [&'static str; 2],
    pub across: Span,
    pub up: Span,
    /// Where the legend stands.
    pub legend: SeriesLabelPosition,
    pub curves: Vec<Curve>,
}

/// Of a diagram alone, and of one in a row.
const SIZES: [(u32, u32); 2] = [(900, 560), (420, 320)];

type Place<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

/// Writes diagrams in rows of `columns` as `NAME.svg`.
pub fn write(name: &Path, plots: &[Plot], columns: usize) -> Result<()> {
    let rows = plots.len().div_ceil(columns);
    let (width, height) = SIZES[usize::from(plots.len() > 1)];
    let path = name.with_added_extension("svg");
    let drawn = || -> Drawn {
        let area = SVGBackend::new(&path, (width * columns as u32, height * rows as u32)).into_drawing_area();
        area.fill(&WHITE)?;
        for (place, plot) in area.split_evenly((rows, columns)).iter().zip(plots) {
            plot.draw(place)?;
        }
        Ok(area.present()?)
    };
    drawn().map_err(|e| Error::io(&path, std::io::Error::other(e.to_string())))
}

impl Plot {
    fn draw(&self, place: &Place<'_>) -> Drawn {
        let linear = |span: &Span, of: fn(&(f64, f64)) -> f64, is_up: bool| match span {
            Span::Data(free) => RangedCoordf64::from(self.range(of, is_up, *free)),
            Span::Linear(range) | Span::Logarithmic(range) => RangedCoordf64::from(range.clone()),
        };
        let (x, y) = (linear(&self.across, |p| p.0, false), linear(&self.up, |p| p.1, true));
        match (&self.across, &self.up) {
            (Span::Logarithmic(across), Span::Logarithmic(up)) => {
                self.draw_on(place, across.clone().log_scale(), up.clone().log_scale())
            }
            (Span::Logarithmic(across), _) => self.draw_on(place, across.clone().log_scale(), y),
            (_, Span::Logarithmic(up)) => self.draw_on(place, x, up.clone().log_scale()),
            _ => self.draw_on(place, x, y),
        }
    }

    /// What the points span.
    fn range(&self, of: impl Fn(&(f64, f64)) -> f64, is_up: bool, free: f64) -> Range<f64> {
        let all = self.curves.iter().flat_map(|curve| curve.points.iter().map(&of));
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (v.min(l), v.max(h)));
        let margin = if is_up { 0.05 * (high - low) } else { 0.0 };
        let low = if is_up && low >= 0.0 { 0.0 } else { low - margin };
        low..high + margin + free * (high - low)
    }

    fn draw_on<X, Y>(
        &self,
        place: &Place<'_>,
        across: impl AsRangedCoord<CoordDescType = X, Value = f64>,
        up: impl AsRangedCoord<CoordDescType = Y, Value = f64>,
    ) -> Drawn
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        // Letters grow with the diagram, if less than it.
        let letters = 13 + place.dim_in_pixel().0 / 450;
        let mut chart = ChartBuilder::on(place)
            .caption(&self.title, ("sans-serif", letters + 4))
            .margin(10)
            .margin_right(20)
            .x_label_area_size(3 * letters)
            .y_label_area_size(9 * letters / 2)
            .build_cartesian_2d(across, up)?;
        chart
            .configure_mesh()
            .x_desc(self.axes[0])
            .y_desc(self.axes[1])
            .x_labels(7)
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .label_style(("sans-serif", letters))
            .light_line_style(RGBColor(238, 240, 242))
            .draw()?;
        for curve in &self.curves {
            let (ink, points) = (curve.ink, curve.points.iter().copied());
            let series = match curve.mark {
                Mark::Line => chart.draw_series(LineSeries::new(points, ink.stroke_width(2)))?,
                Mark::Dots(radius) => {
                    chart.draw_series(points.map(|p| Circle::new(p, radius, ink.filled())))?
                }
            };
            if !curve.name.is_empty() {
                series.label(&curve.name);
                match curve.mark {
                    Mark::Line => series
                        .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], ink.stroke_width(2))),
                    Mark::Dots(radius) => {
                        series.legend(move |(x, y)| Circle::new((x + 9, y), radius, ink.filled()))
                    }
                };
            }
        }
        chart
            .configure_series_labels()
            .position(self.legend.clone())
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(160, 165, 170))
            .label_font(("sans-serif", letters))
            .draw()?;
        Ok(())
    }
}

/// A number without digits that say nothing.
fn short(value: &f64) -> String {
    if *value != 0.0 && !(1e-3..1e4).contains(&value.abs()) {
        return format!("{value:.0e}");
    }
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
