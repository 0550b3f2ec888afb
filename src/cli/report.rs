//! `carpaint report`.

use super::device::adapter_name;
use super::drawing::tradeoffs;
use super::hard_cases::print_hard_cases;
use super::page;
use super::{output, progress::begin};
use crate::brdf::Measured;
use crate::error::{Error, Result};
use crate::file::{check_output_folder, write_text};
use crate::report::peak_memory_mib;
use crate::simulate::Composition;
use crate::tradeoff::{Axis, Curve, Effort, Point, Subject, curves, stage_names};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Measure what every setting of every stage costs and how far it is from the truth, and write it as a page with diagrams.
///
/// Settings of a knob are timed in turns, their cost is a ratio to the default's; errors are against the best truth at hand. What is
/// written: DIR/report.html, which needs no network, report.json, curves.csv, and of the page the table of defaults (defaults.md) and the
/// diagrams (curves.svg).
#[derive(clap::Args)]
pub struct Arguments {
    /// The paint to measure on (TOML) [default: a silver metallic].
    #[arg(conflicts_with = "hard_cases")]
    composition: Option<PathBuf>,
    /// Folder to write into; made if missing.
    #[arg(short, long, required_unless_present = "hard_cases")]
    output: Option<PathBuf>,
    /// Fit lobes to this measurement, too, any that `fit` reads: simulated paints are easier than measured ones.
    #[arg(long, value_name = "FILE")]
    measured: Option<PathBuf>,
    /// Fewer turns, smaller problems: a minute or two.
    #[arg(long)]
    quick: bool,
    /// These stages alone.
    #[arg(long, value_name = "STAGE,...", value_delimiter = ',', value_parser = stage_names(), default_values = stage_names(), hide_default_value = true)]
    only: Vec<String>,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Instead: formulas whose textbook form loses its digits or fails, the error of that form and of the one that is computed with,
    /// against numbers of 77 digits, or against the law that holds; exit code 1 past a bar.
    #[arg(long, conflicts_with = "output")]
    hard_cases: bool,
    /// Print the hard cases as JSON.
    #[arg(long, requires = "hard_cases")]
    json: bool,
}

/// Paint to measure on unless another is named.
const SILVER: &str = include_str!("../../fixtures/compositions/silver_metallic.toml");

/// What was measured, on what.
#[derive(Serialize)]
pub struct Report {
    pub machine: Machine,
    pub paint: String,
    pub effort: Effort,
    pub seconds: f64,
    pub peak_mib: Option<f64>,
    pub curves: Vec<Curve>,
}

/// Where it was measured.
#[derive(Serialize)]
pub struct Machine {
    pub version: &'static str,
    pub system: String,
    pub processor: String,
    pub cores: usize,
    pub adapter: String,
}

impl Machine {
    fn new() -> Self {
        let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        Self {
            version: env!("CARGO_PKG_VERSION"),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: model.unwrap_or_else(|| "unknown".to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            adapter: adapter_name(),
        }
    }
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let Some(folder) = &self.output else { return print_hard_cases(self.json) };
        let start = Instant::now();
        check_output_folder(folder)?;
        let composition = match &self.composition {
            Some(path) => Composition::read(path)?,
            None => Composition::parse(SILVER)?,
        };
        let measured = self.measured.as_deref().map(Measured::read).transpose()?;
        let effort = Effort { quick: self.quick, seed: self.seed };
        let subject = Subject::new(&composition, measured, &effort, begin)?;
        let found = curves(&subject, &effort, &self.only, &begin("measuring", self.only.len()))?;
        let report = Report {
            machine: Machine::new(),
            paint: composition.title.clone(),
            effort,
            seconds: start.elapsed().as_secs_f64(),
            peak_mib: peak_memory_mib(),
            curves: found,
        };
        write(&report, folder, start)?;
        print_summary(&report.curves);
        Ok(ExitCode::SUCCESS)
    }
}

fn write(report: &Report, folder: &Path, start: Instant) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    let json = serde_json::to_string_pretty(report)
        .map_err(|e| Error::invalid("report", "not representable as JSON", e, "finite numbers"))?;
    let files = [
        ("report.json", json),
        ("curves.csv", csv(&report.curves)),
        ("defaults.md", page::defaults_table(report)),
        ("curves.svg", tradeoffs(&report.curves)),
        ("report.html", page::html(report)),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        write_text(&path, &text)?;
        output::wrote(&path, start)?;
    }
    Ok(())
}

/// A row a setting.
fn csv(curves: &[Curve]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text =
        "stage,knob,setting,default,front,axis,relative,ratio,seconds,lower_quartile_s,upper_quartile_s,turns,error,bytes,unit\n".to_owned();
    for curve in curves {
        for point in &curve.points {
            let cost = point.cost;
            let bytes = point.bytes.map_or_else(String::new, |bytes| bytes.to_string());
            text += &format!(
                "{},{},{},{},{},{},{},{},{},{},{},{},{},{bytes},{}\n",
                quoted(curve.stage),
                quoted(curve.knob),
                quoted(&point.setting),
                point.is_default,
                point.is_on_front,
                if curve.axis == Axis::Time { "time" } else { "bytes" },
                point.relative,
                cost.ratio,
                cost.seconds,
                cost.quartiles[0],
                cost.quartiles[1],
                cost.turns,
                point.error,
                quoted(curve.error)
            );
        }
    }
    text
}

/// The settings as a table for people.
fn print_summary(curves: &[Curve]) {
    for curve in curves {
        output::say!("{}: {}\n  error: {}", curve.stage, curve.knob, curve.error);
        let ratio = match curve.axis {
            Axis::Time => "ratio",
            Axis::Bytes => "bytes",
        };
        output::say!("  setting                       time  {ratio}       error");
        for point in &curve.points {
            let marks = match (point.is_default, point.is_on_front) {
                (true, true) => "default",
                (true, false) => "default, behind the front",
                (false, true) => "",
                (false, false) => "behind the front",
            };
            let milliseconds = 1e3 * point.cost.seconds;
            let Cell { setting, ratio, error } = Cell::of(point);
            output::say!("  {setting:<22} {milliseconds:>8.2} ms {ratio:>6} {error:>11}  {marks}");
        }
    }
}

/// A setting as tables show it.
pub struct Cell {
    pub setting: String,
    pub ratio: String,
    pub error: String,
}

impl Cell {
    pub fn of(point: &Point) -> Self {
        let error = if point.error.abs() < 1e-3 && point.error != 0.0 {
            format!("{:.1e}", point.error)
        } else {
            format!("{:.3}", point.error)
        };
        let ratio = match point.relative {
            ratio if ratio < 0.1 => format!("{ratio:.3}"),
            ratio => format!("{ratio:.2}"),
        };
        Self { setting: point.setting.clone(), ratio, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::Cost;

    #[test]
    fn rows_have_as_many_columns_as_the_head() {
        let cost = Cost { seconds: 0.5, quartiles: [0.4, 0.6], ratio: 1.0, turns: 3 };
        let point = Point {
            setting: "a \"quoted\" one".into(),
            cost,
            relative: 1.0,
            error: 0.0,
            bytes: None,
            is_default: true,
            is_on_front: true,
        };
        let curve =
            Curve { stage: "Fit", knob: "k", axis: Axis::Time, error: "e", why: "w", points: vec![point] };
        let text = csv(&[curve]);
        let columns = |line: &str| line.split(',').count();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines.len(), columns(lines[0])), (2, columns(lines[1])));
        assert!(lines[1].contains("\"a \"\"quoted\"\" one\""), "{}", lines[1]);
    }
}
