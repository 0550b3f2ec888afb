//! Fig. 8: data and fitted model over the angle of the half vector; a measured car paint where CARPAINT_REFERENCE has one.

use super::{brdf, glossy, reference};
use crate::plots::{self, Curve, Mark, Plot, SKY, Span, VERMILION};
use crate::{Figure, Finding};
use carpaint::brdf::{TabulatedBrdf, read_measured};
use carpaint::error::Result;
use carpaint::fit::{Compared, FitOptions, compare, fit_smooth};
use plotters::chart::SeriesLabelPosition;
use std::path::Path;

pub const FIGURE: Figure = Figure {
    name: "rump-2008-8",
    claim: "diffuse, three lobes and gloss follow the data over the half vector, to within a factor of 1.5 on average",
    draw,
};

/// Points shown.
const POINTS: usize = 3000;

fn draw(name: &Path) -> Result<Finding> {
    let (title, table, filled) = match reference("mbsdf/carpaint_green.mbsdf") {
        Some(path) => ("Green car paint, measured", read_measured(&path)?, true),
        None => {
            let model = glossy()?;
            let table = TabulatedBrdf::from_fn(45, 90, |wi, wo| brdf(&model, wi, wo))?;
            ("Green-blue flip-flop, simulated", table, false)
        }
    };
    let options = FitOptions { filled, ..FitOptions::default() };
    let (fit, report) = fit_smooth(&table, &options, &|| ())?;
    let points = compare(&table, &fit, &options, POINTS);
    let along = |value: fn(&Compared) -> f64| {
        points.iter().map(|p| (p.theta_h.to_degrees(), value(p))).filter(|p| p.1 > 1e-4).collect()
    };
    let curves = vec![
        Curve { name: "data".into(), ink: SKY, mark: Mark::Dots(3), points: along(|p| p.measured) },
        Curve { name: "model".into(), ink: VERMILION, mark: Mark::Dots(1), points: along(|p| p.fitted) },
    ];
    let plot = Plot {
        title: title.into(),
        axes: ["angle between half vector and normal, degrees", "mean of the bands, 1/sr"],
        across: Span::Linear(0.0..90.0),
        up: Span::Logarithmic(1e-4..1e2),
        legend: SeriesLabelPosition::UpperRight,
        curves,
    };
    plots::write(name, &[plot], 1)?;
    let gloss = report.gloss_error.unwrap_or(0.0);
    let factor = 1.5f64.ln();
    Ok(Finding {
        holds: [report.error, report.colored_error, gloss].iter().all(|error| *error < factor),
        says: format!(
            "{title}: eq. 7 is {:.3} outside the gloss, {:.3} with the color table, {gloss:.2} in the gloss ({factor:.2} is a factor of 1.5)",
            report.error, report.colored_error
        ),
    })
}
