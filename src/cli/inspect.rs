//! `carpaint inspect`.

use super::fit_ink::is_ink;
use super::output;
use crate::brdf::{Ink, TabulatedBrdf, ink, read_measured};
use crate::btf::FlakeBtf;
use crate::error::{Error, Result};
use crate::file::ContainerReader;
use crate::mix::{self, Mix};
use crate::paint::{self, Paint};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Say what is in a file: a paint, a mix, a flake BTF, an ink or a measured table.
#[derive(clap::Args)]
pub struct Arguments {
    /// The file.
    file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let is_exr = self.file.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        let summary = if is_exr {
            summarize(&self.file)?
        } else if is_ink(&self.file) {
            inked(&Ink::read(&self.file)?)
        } else {
            table(&read_measured(&self.file)?)
        };
        if self.json {
            output::json(&summary)?;
        } else {
            print_tree(&summary, 0);
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn summarize(path: &Path) -> Result<Value> {
    match ContainerReader::open(path)?.kind() {
        paint::KIND => Paint::read(path).map(|p| paint(&p)),
        mix::KIND => Mix::read(path).map(|m| mixed(&m)),
        crate::btf::KIND => FlakeBtf::read(path).map(|b| flake_btf(&b)),
        other => {
            let legal = format!("{}, {} or {}", paint::KIND, mix::KIND, crate::btf::KIND);
            Err(Error::invalid("attribute carpaint", "kind of file", other, legal).in_file(path))
        }
    }
}

fn paint(p: &Paint) -> Value {
    let flakes = p.flakes.as_ref().map(|f| {
        let levels: Vec<_> = f
            .levels
            .iter()
            .map(|l| {
                let clusters: usize = l.slices.iter().map(|s| s.clusters.len()).sum();
                json!({ "pitch_mm": l.pitch_mm, "clusters": clusters })
            })
            .collect();
        json!({ "bins": f.grid.bins(), "slices": f.grid.len(), "slice_size": f.size, "texel_mm": f.texel_mm,
            "missing": f.missing, "inverse_cdf_steps": f.inverse_cdf_steps, "levels": levels })
    });
    json!({ "kind": paint::KIND, "coat": p.coat, "diffuse": p.diffuse, "lobes": p.lobes,
        "color_table": p.colors.size(), "color_table_measured": share(p.colors.measured()),
        "flakes": flakes, "provenance": p.provenance })
}

fn mixed(m: &Mix) -> Value {
    let paints: Vec<_> = m
        .constituents
        .iter()
        .map(|c| json!({ "name": c.name, "coat": c.coat, "diffuse": c.diffuse, "lobes": c.lobes }))
        .collect();
    let flakes = m.flakes.as_ref().map(|f| {
        let slices = || f.levels.iter().flat_map(|l| &l.slices);
        json!({ "bins": f.grid.bins(), "slices": f.grid.len(), "slice_size": f.size, "texel_mm": f.texel_mm,
            "levels": f.levels.len(), "arcs": slices().map(|s| s.probabilities.len()).sum::<usize>(),
            "largest_gap": slices().map(|s| s.gap).fold(0.0, f64::max) })
    });
    json!({ "kind": mix::KIND, "paints": paints, "flakes": flakes })
}

fn flake_btf(b: &FlakeBtf) -> Value {
    let values = || b.slices.iter().flat_map(|s| s.fluctuation.as_flattened());
    json!({ "kind": crate::btf::KIND, "bins": b.grid.bins(), "slices": b.grid.len(), "slice_size": b.size,
        "texel_mm": b.texel_mm, "coat": b.coat,
        "fluctuation_range": [values().copied().fold(f32::INFINITY, f32::min), values().copied().fold(f32::NEG_INFINITY, f32::max)],
        "smooth_resolution": b.smooth.resolution(), "provenance": b.provenance })
}

fn inked(ink: &Ink) -> Value {
    let range = |values: &[f64]| {
        [
            values.iter().copied().fold(f64::INFINITY, f64::min),
            values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    let nm = ink.wavelengths().nm();
    json!({ "kind": ink::KIND, "name": ink.name(), "alpha": ink.roughness(), "wavelengths": nm.len(),
        "wavelengths_nm": range(nm), "rho": range(ink.reflectance()), "c": range(ink.growth()),
        "provenance": ink.provenance() })
}

fn table(t: &TabulatedBrdf) -> Value {
    let values = || t.values().as_flattened();
    json!({ "kind": "measured table", "resolution": t.resolution(),
        "range": [values().iter().copied().fold(f32::INFINITY, f32::min), values().iter().copied().fold(f32::NEG_INFINITY, f32::max)],
        "negative_share": values().iter().filter(|v| **v < 0.0).count() as f64 / values().len() as f64 })
}

fn share(marks: &[bool]) -> f64 {
    marks.iter().filter(|m| **m).count() as f64 / marks.len().max(1) as f64
}

/// Keys and values, indented; lists of plain values on one line.
fn print_tree(value: &Value, depth: usize) {
    let Value::Object(map) = value else {
        output::say!("{:1$}{value}", "", 2 * depth);
        return;
    };
    for (key, value) in map {
        match value {
            Value::Object(_) => {
                output::say!("{:1$}{key}", "", 2 * depth);
                print_tree(value, depth + 1);
            }
            Value::Array(items) if items.iter().any(Value::is_object) => {
                output::say!("{:1$}{key}", "", 2 * depth);
                for item in items {
                    output::say!("{:1$}{item}", "", 2 * depth + 2);
                }
            }
            Value::String(text) if text.contains('\n') => {
                output::say!("{:1$}{key}", "", 2 * depth);
                for line in text.lines() {
                    output::say!("{:1$}{line}", "", 2 * depth + 2);
                }
            }
            Value::String(text) => output::say!("{:1$}{key}  {text}", "", 2 * depth),
            _ => output::say!("{:1$}{key}  {value}", "", 2 * depth),
        }
    }
}
