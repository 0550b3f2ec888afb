//! `carpaint simulate`.

use super::brdf_output::{self, BrdfFormat};
use super::budget::{BudgetArguments, picked};
use super::goniometer::{self, GoniometerArguments};
use super::readings::{EnergyTable, Readings};
use super::{drawing, model::ModelArguments, output, progress::Bar, synthesis::SynthesisArguments};
use crate::error::{Error, Result};
use crate::file::{check_output, place, write_text};
use crate::report::peak_memory_mib;
use crate::simulate::{
    Composition, Goniospectrometer, Model, ModelKind, ModelOptions, Reading, Synthesis, SynthesisOptions,
};
use crate::tradeoff::{Budget, pick_model};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Simulate a paint from its composition: flake BTF, BRDF, instrument readings, a drawing.
///
/// Any of -o, --brdf, --at, --spectra, --energy and --svg, together or alone. To couple two paints later, simulate both with the same
/// --texel-um, --bins and --size: left to itself, the texel follows the flakes, and differs from paint to paint.
#[derive(clap::Args)]
#[command(mut_arg("error", |a| a.conflicts_with_all(["model", "tolerance"])))]
#[command(mut_arg("time", |a| a.conflicts_with_all(["model", "tolerance"])))]
pub struct Arguments {
    /// The paint's recipe (TOML; see fixtures/compositions).
    composition: PathBuf,
    /// The flake BTF to write, NAME.btf.exr: explicit flakes, and the smooth BRDF they fluctuate about.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Write the mean BRDF, gloss left out: spectra (.csv), a table (.mbsdf) or a fitted paint (.paint.exr); repeatable.
    #[arg(long, value_name = "OUT")]
    brdf: Vec<PathBuf>,
    /// Print L*a*b*, spectra (with --json) and flop index as a multi-angle instrument reads them (ASTM E2194, E2539):
    /// incidence and aspecular angles in degrees, as in "45:15,25,45,75,110;15:15"; aspecular angles count from the mirror
    /// direction towards the light.
    #[arg(long, value_name = "INCIDENCE:ANGLES;...", allow_hyphen_values = true)]
    at: Option<String>,
    /// Write the in-plane spectra that a goniometer with a spectrometer measures (.csv: theta_i, theta_o, reflectance factors).
    #[arg(long, value_name = "OUT.csv")]
    spectra: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Goniometer (with --spectra)")]
    goniometer: GoniometerArguments,
    /// Print where light goes that comes in at an angle, degrees: reflected, to the substrate, absorbed; full model.
    #[arg(long, value_name = "INCIDENCE", num_args = 0..=1, require_equals = true, default_missing_value = "45")]
    energy: Option<f64>,
    /// Draw the stack of layers and the flop curve (SVG).
    #[arg(long, value_name = "OUT.svg")]
    svg: Option<PathBuf>,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    budget: BudgetArguments,
    #[command(flatten, next_help_heading = "Flakes (with --output)")]
    synthesis: SynthesisArguments,
    /// Show flakes shifted by their depth; the azimuth of the view is a convention, whose cost is reported.
    #[arg(long, requires = "output", help_heading = "Flakes (with --output)")]
    parallax: bool,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true)]
    seed: u32,
    /// Print the tables behind the summary.
    #[arg(long)]
    verbose: bool,
    /// Print the summary as JSON.
    #[arg(long)]
    json: bool,
}

/// What is asked for, checked before any work.
struct Tasks {
    brdf: Vec<(BrdfFormat, PathBuf)>,
    readings: Vec<Reading>,
    goniometer: Goniospectrometer,
    synthesis: SynthesisOptions,
    model: ModelOptions,
    budget: Option<Budget>,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        let tasks = self.tasks()?;
        let composition = Composition::read(&self.composition)?;
        let warnings = composition.warnings()?;
        warnings.iter().for_each(|warning| output::note!("note: {warning}"));
        let options = match tasks.budget {
            Some(budget) => picked("simulate", pick_model(&composition, budget)?),
            None => tasks.model,
        };
        let model = Model::new(&composition, options).map_err(|e| e.in_file(&self.composition))?;
        let mut summary = Map::new();
        summary.insert("model".into(), json!(model.kind()));
        summary.insert("warnings".into(), json!(warnings));
        let missed = model.missed_error();
        if let Some(error) = missed {
            output::note!(
                "note: the solution of light scattered more than once is expected to be off by {:.2} %: flakes narrower \
                 or spheres larger than its nodes resolve",
                100.0 * error
            );
        }
        summary.insert("missed_error".into(), json!(missed));
        summary.insert("model_seconds".into(), json!(start.elapsed().as_secs_f64()));
        if let Some(path) = &self.output {
            let btf = self.write_btf(&model, &tasks.synthesis, path)?;
            self.print(|| print_btf(&btf, self.verbose));
            summary.extend(btf);
        }
        if !tasks.readings.is_empty() {
            let readings = Readings::new(&model, &tasks.readings);
            self.print(|| readings.print());
            summary.insert("at".into(), json!(readings));
        }
        if let Some(degrees) = self.energy {
            let energy = EnergyTable::new(&model.energy(degrees.to_radians())?, degrees);
            self.print(|| energy.print());
            summary.insert("energy".into(), json!(energy));
        }
        for (format, path) in &tasks.brdf {
            format.write(&model, self.seed, path)?;
        }
        if let Some(path) = &self.spectra {
            goniometer::write(&model, &tasks.goniometer, path)?;
        }
        if let Some(path) = &self.svg {
            write_text(path, &drawing::svg(&model))?;
        }
        let files =
            [("brdf", &self.brdf[..]), ("spectra", self.spectra.as_slice()), ("svg", self.svg.as_slice())];
        for (key, files) in files {
            for path in files {
                self.print(|| output::say!("{}: {key}, model {}", path.display(), brdf_output::name(&model)));
            }
            if !files.is_empty() {
                summary.insert(key.into(), json!(files));
            }
        }
        if self.json {
            summary.insert("seconds".into(), json!(start.elapsed().as_secs_f64()));
            summary.insert("peak_mib".into(), json!(peak_memory_mib()));
            output::json(&summary)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn tasks(&self) -> Result<Tasks> {
        let brdf = self.brdf.iter().map(|path| Ok((BrdfFormat::of(path)?, path.clone())));
        let brdf = brdf.collect::<Result<Vec<_>>>()?;
        let readings = match &self.at {
            Some(text) => Reading::parse_list(text).map_err(|e| e.within("--at"))?,
            None => Vec::new(),
        };
        if let Some(degrees) = self.energy.filter(|degrees| !(0.0..90.0).contains(degrees)) {
            return Err(Error::invalid("--energy", "incidence, degrees", degrees, "0 to below 90"));
        }
        let mut model = self.model.options();
        match (self.energy, model.kind) {
            (Some(_), ModelKind::Fast) => {
                let legal = "auto, fast-corrected or full: the fast model keeps no account of all light";
                return Err(Error::invalid("--energy", "--model", "fast", legal));
            }
            (Some(_), ModelKind::Auto) => model.kind = ModelKind::Full,
            _ => {}
        }
        let mut files: Vec<&Path> = self.brdf.iter().map(PathBuf::as_path).collect();
        files.extend(self.output.as_deref());
        files.extend(self.spectra.as_deref());
        files.extend(self.svg.as_deref());
        if files.is_empty() && readings.is_empty() && self.energy.is_none() {
            let legal = "one or more of --output, --brdf, --at, --spectra, --energy, --svg";
            return Err(Error::invalid("simulate", "outputs", "none", legal));
        }
        self.require_distinct(&files)?;
        files.iter().try_for_each(|path| check_output(path))?;
        if let Some(path) = &self.output {
            output::require_suffix("--output", path, ".btf.exr")?;
        }
        if let Some(path) = &self.spectra {
            output::require_suffix("--spectra", path, ".csv")?;
        }
        if let Some(path) = &self.svg {
            output::require_suffix("--svg", path, ".svg")?;
        }
        let goniometer = self.goniometer.options(self.seed)?;
        let synthesis = SynthesisOptions { parallax: self.parallax, ..self.synthesis.options(self.seed)? };
        Ok(Tasks { brdf, readings, goniometer, synthesis, model, budget: self.budget.budget()? })
    }

    /// Refuses two outputs in one file, and one in the file of the recipe.
    fn require_distinct(&self, files: &[&Path]) -> Result<()> {
        let recipe = place(&self.composition);
        let places: Vec<PathBuf> = files.iter().map(|path| place(path)).collect();
        for (k, path) in files.iter().enumerate() {
            let what = if places[k] == recipe {
                "output in place of the recipe"
            } else if places[..k].contains(&places[k]) {
                "output named twice"
            } else {
                continue;
            };
            return Err(Error::invalid("simulate", what, path.display(), "a file for each"));
        }
        Ok(())
    }

    /// Synthesizes the flakes slice by slice into their file, and says what came of it.
    fn write_btf(
        &self,
        model: &Model,
        options: &SynthesisOptions,
        path: &Path,
    ) -> Result<Map<String, Value>> {
        let start = Instant::now();
        let synthesis = Synthesis::new(model, options)?;
        let bar = Bar::new("flakes", options.grid.len());
        let provenance = synthesis.write(path, &bar.tick())?;
        drop(bar);
        let bytes = std::fs::metadata(path).map_err(|e| Error::io(path, e))?.len();
        let mut btf = Map::new();
        for (key, value) in [
            ("output", json!(path)),
            ("slices", json!(options.grid.len())),
            ("size", json!(options.size)),
            ("texel_um", json!(synthesis.texel_mm() * 1e3)),
            ("flakes", provenance["flakes"].clone()),
            ("check", provenance["check"].clone()),
            ("bytes", json!(bytes)),
            ("btf_seconds", json!(start.elapsed().as_secs_f64())),
        ] {
            btf.insert(key.into(), value);
        }
        Ok(btf)
    }

    /// Prints for people, unless a program reads.
    fn print(&self, print: impl FnOnce()) {
        if !self.json {
            print();
        }
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn print_btf(btf: &Map<String, Value>, verbose: bool) {
    let [columns, rows] = [0, 1].map(|k| number(&btf["size"][k]));
    output::say!(
        "{}: {} slices of {columns} x {rows} texels of {:.2} um, {:.1} MB, {:.2} s",
        btf["output"].as_str().unwrap_or_default(),
        btf["slices"],
        number(&btf["texel_um"]),
        number(&btf["bytes"]) * 1e-6,
        number(&btf["btf_seconds"]),
    );
    output::say!("flakes of each kind: {}", btf["flakes"]);
    let check = &btf["check"];
    if check["rms_z"].is_null() {
        output::say!("slice means against the model: not tested");
    } else {
        output::say!(
            "slice means against the model: rms z {:.2}, largest {:.2}, over {} slices",
            number(&check["rms_z"]),
            number(&check["max_abs_z"]),
            check["slices"],
        );
    }
    if !check["parallax"].is_null() {
        let rms = number(&check["parallax"]["rms_over_std"]);
        output::say!(
            "parallax: views from opposite azimuths differ by {rms:.3} standard deviations of a slice"
        );
    }
    if verbose {
        print_tables(check);
    }
}

/// The tables behind the summary: one slice for all phi_d, one azimuth for all views.
fn print_tables(check: &Value) {
    let rows = |table: &str| check[table]["rows"].as_array().cloned().unwrap_or_default();
    // Without light there is no error.
    let error = |row: &Value, key: &str| {
        if number(&row["share"]) > 0.0 { format!("{:.4}", number(&row[key])) } else { "-".into() }
    };
    output::say!("theta_h  share of light  error of one slice for all phi_d  with the cosines taken out");
    for row in rows("phi_d") {
        output::say!(
            "{:7.2}  {:14.2e}  {:>31}  {:>26}",
            number(&row["theta_h_deg"]),
            number(&row["share"]),
            error(&row, "plain"),
            error(&row, "without_cosines")
        );
    }
    let parallax = rows("parallax");
    if !parallax.is_empty() {
        output::say!("theta_i  images apart, texels  difference of opposite views, std");
    }
    for row in parallax {
        output::say!(
            "{:7.2}  {:20.3}  {:32.4}",
            number(&row["theta_i_deg"]),
            number(&row["texels"]),
            number(&row["rms_over_std"])
        );
    }
}
