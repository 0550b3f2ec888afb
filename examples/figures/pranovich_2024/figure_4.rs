//! Fig. 4: measured reflectance, averaged over the spectrum, and the fit (top); how far they are apart (middle); the parameters
//! (bottom).

use super::inks::{MeasuredInk, measured};
use crate::plots::{self, BLACK, BLUE, Curve, GREEN, Mark, ORANGE, PURPLE, Plot, SKY, Span, VERMILION};
use crate::{Figure, Finding};
use carpaint::brdf::LobeGeometry;
use carpaint::error::Result;
use glam::DVec3;
use plotters::chart::SeriesLabelPosition;
use plotters::style::RGBColor;
use std::f64::consts::PI;
use std::path::Path;

/// One for each incidence.
const INCIDENCES: [RGBColor; 7] = [BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE];
const RED_GREEN_BLUE: [RGBColor; 3] = [VERMILION, GREEN, BLUE];

pub const FIGURE: Figure = Figure {
    name: "pranovich-2024-4",
    claim: "mirrored light grows exponentially with the angle, and an ink has one roughness, alike within 3 % over the incidences",
    draw,
};

fn draw(name: &Path) -> Result<Finding> {
    let inks = measured()?;
    let mut panels: Vec<Plot> = inks.iter().map(reflectance).collect();
    panels.extend(inks.iter().map(difference));
    panels.push(spectra(&*inks, "reflectance rho", |of| of.ink.reflectance()));
    panels.push(spectra(&*inks, "growth c", |of| of.ink.growth()));
    panels.push(roughness(&*inks));
    plots::write(name, &panels, 3)?;
    let each = |number: &dyn Fn(&MeasuredInk) -> f64| inks.iter().map(number).collect::<Vec<f64>>();
    let spread = each(&|of| 100.0 * of.report.alpha_spread);
    let [exponential, line] = [f64::ln as fn(f64) -> f64, |y| y]
        .map(|scale| each(&|of| 100.0 * straightness(&mirrored(of), scale)));
    Ok(Finding {
        holds: spread.iter().all(|s| *s < 3.0) && exponential.iter().zip(&line).all(|(e, l)| e < l),
        says: format!(
            "red, green, blue: alpha {:.3?} (the paper: 0.19), its spread {spread:.1?} %; error of all readings \
             {:.1?} %; mirrored light is off an exponential of 1 - cos by {exponential:.1?} %, off a straight line by \
             {line:.1?} %",
            each(&|of| of.report.alpha),
            each(&|of| 100.0 * of.report.error),
        ),
    })
}

fn mean(spectrum: &[f64]) -> f64 {
    spectrum.iter().sum::<f64>() / spectrum.len() as f64
}

/// Exit angle, degrees, and reflectance factors, averaged over the spectrum, as measured and as fitted.
fn scan(of: &MeasuredInk, incidence: f64) -> Vec<(f64, [f64; 2])> {
    let rows = of.measured.spectra().iter().filter(|row| row.reading.incidence_deg == incidence);
    let factors = rows.map(|row| {
        let (wi, wo): (DVec3, DVec3) = row.reading.directions();
        let fitted = of.ink.brdf(&LobeGeometry::of(wi, wo));
        (row.reading.theta_o_deg(), [&row.mean, &fitted].map(|f| PI * mean(f)))
    });
    factors.collect()
}

/// A value of the measured and the fitted reflectance factor.
type Value = fn([f64; 2]) -> f64;

/// A curve of each incidence of each of these kinds: whether dotted, and of what.
fn scans(of: &MeasuredInk, title: &str, kinds: &[(bool, Value)]) -> Plot {
    let mut curves = Vec::new();
    for (incidence, ink) in of.measured.incidences().into_iter().zip(INCIDENCES) {
        for (k, (is_dotted, value)) in kinds.iter().enumerate() {
            let name = if k == 0 { format!("{incidence} deg") } else { String::new() };
            let points = scan(of, incidence).into_iter().map(|(exit, pair)| (exit, value(pair)));
            let every = if *is_dotted { 4 } else { 1 };
            let mark = if *is_dotted { Mark::Dots(2) } else { Mark::Line };
            curves.push(Curve { name, ink, mark, points: points.step_by(every).collect() });
        }
    }
    let title = format!("{} ink: {title}", of.color);
    plot(title, ["exit angle, degrees", "reflectance factor"], 0.0, curves)
}

fn reflectance(of: &MeasuredInk) -> Plot {
    scans(
        of,
        "measured (dots), fitted (70 deg: not)",
        &[(false, |[_, fitted]| fitted), (true, |[read, _]| read)],
    )
}

fn difference(of: &MeasuredInk) -> Plot {
    scans(of, "absolute difference", &[(false, |[read, fitted]| (read - fitted).abs())])
}

fn spectra(inks: &[MeasuredInk], title: &'static str, values: fn(&MeasuredInk) -> &[f64]) -> Plot {
    let curve = |(of, ink): (&MeasuredInk, RGBColor)| {
        let points = of.ink.wavelengths().nm().iter().copied().zip(values(of).iter().copied()).collect();
        Curve { name: of.color.to_owned(), ink, mark: Mark::Line, points }
    };
    let curves = inks.iter().zip(RED_GREEN_BLUE).map(curve).collect();
    plot(title.to_owned(), ["wavelength, nm", title], 0.3, curves)
}

fn roughness(inks: &[MeasuredInk]) -> Plot {
    let curve = |(of, ink): (&MeasuredInk, RGBColor)| {
        let points = of.report.incidences.iter().map(|fit| (fit.incidence_deg, fit.alpha)).collect();
        Curve { name: of.color.to_owned(), ink, mark: Mark::Line, points }
    };
    let curves = inks.iter().zip(RED_GREEN_BLUE).map(curve).collect();
    let title = "roughness alpha of each incidence".to_owned();
    plot(title, ["incidence, degrees", "alpha"], 0.3, curves)
}

/// Lines over all that they span, the legend where they are low.
fn plot(title: String, axes: [&'static str; 2], free: f64, curves: Vec<Curve>) -> Plot {
    let (across, up) = (Span::Data(0.0), Span::Data(free));
    Plot { title, axes, across, up, legend: SeriesLabelPosition::UpperLeft, curves }
}

/// 1 - cos of the incidences that are fitted, and reflectance factors where light is mirrored, averaged over the spectrum.
fn mirrored(of: &MeasuredInk) -> Vec<(f64, f64)> {
    let rows = of.measured.spectra().iter();
    let rows = rows.filter(|row| row.reading.aspecular_deg.abs() < 1e-9 && row.reading.incidence_deg < 70.0);
    rows.map(|row| (1.0 - row.reading.incidence_deg.to_radians().cos(), PI * mean(&row.mean))).collect()
}

/// Root mean square distance of points from a straight line, on a scale of the ordinate, as a share of the ordinate.
fn straightness(points: &[(f64, f64)], scale: fn(f64) -> f64) -> f64 {
    // On a scale of logarithms all weigh alike, else by the inverse square: shares in both.
    let weight = |y: f64| (scale(y * (1.0 + 1e-6)) - scale(y)).powi(-2);
    let [mut s, mut sx, mut sy, mut sxx, mut sxy] = [0.0; 5];
    for (x, y) in points.iter().copied() {
        let (w, y) = (weight(y), scale(y));
        (s, sx, sy, sxx, sxy) = (s + w, sx + w * x, sy + w * y, sxx + w * x * x, sxy + w * x * y);
    }
    let slope = (s * sxy - sx * sy) / (s * sxx - sx * sx);
    let start = (sy - slope * sx) / s;
    let off = |(x, y): &(f64, f64)| (start + slope * x - scale(*y)).powi(2) * weight(*y) * 1e-12;
    (points.iter().map(off).sum::<f64>() / points.len() as f64).sqrt()
}
