//! Curves and points in a diagram.

use carpaint::error::{Error, Result};
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

/// Inks of Okabe and Ito (2008), told apart by everybody.
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
pub const SKY: RGBColor = RGBColor(86, 180, 233);
pub const BLACK: RGBColor = RGBColor(34, 37, 42);

/// How points are shown.
#[derive(Clone, Copy)]
pub enum Mark {
    Line,
    /// Dots of that radius, pixels.
    Dots(i32),
}

/// A curve.
pub struct Curve {
    pub name: String,
    pub ink: RGBColor,
    pub mark: Mark,
    pub points: Vec<(f64, f64)>,
}

/// A diagram; `x` and `y` are what the axes say.
pub struct Plot<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
    pub across: Range<f64>,
    pub up: Range<f64>,
    pub curves: &'a [Curve],
}

const SIZE: (u32, u32) = (900, 560);

impl Plot<'_> {
    /// Writes `NAME.svg`, the vertical axis logarithmic.
    pub fn write(&self, name: &Path) -> Result<()> {
        self.put(name, RangedCoordf64::from(self.across.clone()))
    }

    /// Writes `NAME.svg`, both axes logarithmic.
    pub fn write_log_log(&self, name: &Path) -> Result<()> {
        self.put(name, self.across.clone().log_scale())
    }

    fn put<X>(&self, name: &Path, across: impl AsRangedCoord<CoordDescType = X, Value = f64>) -> Result<()>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let path = name.with_added_extension("svg");
        self.paint(&path, across).map_err(|e| Error::io(&path, std::io::Error::other(e.to_string())))
    }

    fn paint<X>(
        &self,
        path: &Path,
        across: impl AsRangedCoord<CoordDescType = X, Value = f64>,
    ) -> std::result::Result<(), Box<dyn std::error::Error>>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let area = SVGBackend::new(path, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .caption(self.title, ("sans-serif", 20))
            .margin(16)
            .x_label_area_size(48)
            .y_label_area_size(70)
            .build_cartesian_2d(across, self.up.clone().log_scale())?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .axis_desc_style(("sans-serif", 16))
            .label_style(("sans-serif", 14))
            .light_line_style(RGBColor(238, 240, 242))
            .draw()?;
        for curve in self.curves {
            let ink = curve.ink;
            let points = curve.points.iter().copied();
            match curve.mark {
                Mark::Line => chart
                    .draw_series(LineSeries::new(points, ink.stroke_width(2)))?
                    .label(&curve.name)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], ink.stroke_width(2))),
                Mark::Dots(radius) => chart
                    .draw_series(points.map(|p| Circle::new(p, radius, ink.filled())))?
                    .label(&curve.name)
                    .legend(move |(x, y)| Circle::new((x + 10, y), radius.max(3), ink.filled())),
            };
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(160, 165, 170))
            .label_font(("sans-serif", 15))
            .draw()?;
        area.present()?;
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
