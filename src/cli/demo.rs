//! `carpaint demo`.

use super::{output, progress::Bar};
use crate::error::{Error, Result};
use crate::file::{check_output_folder, write_text};
use crate::mix::{CoupleOptions, Mix, couple};
use crate::paint::Paint;
use crate::render::{Options, RenderPaint, ToneMap, render, tick_count};
use crate::report::{Chain, ChainOptions, Check, Stage, picture_checks, run_chain, transport_checks};
use crate::scene::Scene;
use crate::simulate::Composition;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Simulate a brown and a blue paint, fit and couple them, and render the strip of interpolated and extrapolated paints.
///
/// Needs no input. Prints what every stage cost and how large its error is, and writes pictures, paints and a report into
/// a folder.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the results; made if missing.
    #[arg(short, long, default_value = "demo")]
    output: PathBuf,
    /// Height of the strip, pixels.
    #[arg(long, default_value_t = 480)]
    height: usize,
    /// Angle bins per 90 degrees.
    #[arg(long, default_value_t = 24)]
    bins: usize,
    /// Columns and rows of a flake slice, texels.
    #[arg(long, default_value_t = 128)]
    size: usize,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

/// The paints of Golla & Klein's Figs 1 and 8, as compositions.
const PAINTS: [(&str, &str); 2] = [
    ("brown", include_str!("../../fixtures/compositions/brown_metallic.toml")),
    ("blue", include_str!("../../fixtures/compositions/blue_metallic.toml")),
];
/// Weight of the second paint, percent: the paints, three blends between, two extrapolations beyond each.
const STRIP: [i32; 9] = [-50, -25, 0, 25, 50, 75, 100, 125, 150];
/// One texel for both paints, so that their slices can be coupled: between what suits the fine blue flakes and the coarse
/// brown ones.
const TEXEL_MM: f64 = 0.012;

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        let scene = self.scene()?;
        check_output_folder(&self.output)?;
        std::fs::create_dir_all(&self.output).map_err(|e| Error::io(&self.output, e))?;
        let options =
            ChainOptions { bins: self.bins, size: self.size, texel_mm: Some(TEXEL_MM), seed: self.seed };
        let mut stages = Vec::new();
        let mut paints = Vec::new();
        let mut models = Vec::new();
        for (name, text) in PAINTS {
            let composition = Composition::parse(text).map_err(|e| e.within(name))?;
            let Chain { paint, model, stages: done, .. } =
                run_chain(name, &composition, &options, |what, n| Bar::new(what, n).into_tick())?;
            print_stages(&done);
            stages.extend(done);
            paint.write(&self.output.join(format!("{name}.paint.exr")))?;
            paints.push((name.to_owned(), paint));
            models.push(model);
        }
        let mix = self.couple(&paints, &mut stages)?;
        let blends = blend(&mix, &paints, &mut stages)?;
        let rendered = self.render(&scene, &blends)?;
        let mut checks = Vec::new();
        for ((name, paint), model) in paints.iter().zip(&models) {
            let named = picture_checks(paint, model)?.into_iter();
            checks.extend(named.map(|c| Check { what: format!("{name}: {}", c.what), ..c }));
        }
        finish(rendered.with(checks), &mut stages);
        let report = serde_json::to_string_pretty(&stages)
            .map_err(|e| Error::invalid("report", "not representable as JSON", e, "finite numbers"))?;
        write_text(&self.output.join("report.json"), &report)?;
        output::say!(
            "strip.png, left to right: {} % blue (0 % is brown)",
            STRIP.map(|p| p.to_string()).join(", ")
        );
        for file in
            ["strip.png", "strip.exr", "brown.paint.exr", "blue.paint.exr", "mix.paint.exr", "report.json"]
        {
            output::wrote(&self.output.join(file), start)?;
        }
        Ok(if stages.iter().all(Stage::passes) { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }

    fn couple(&self, paints: &[(String, Paint)], stages: &mut Vec<Stage>) -> Result<Mix> {
        let named: Vec<_> = paints.iter().map(|(name, paint)| (name.clone(), paint)).collect();
        let rows = paints[0].1.flakes.as_ref().map_or(0, |f| f.levels.len() * f.grid.len());
        let tick = Bar::new("coupling", rows).into_tick();
        let (stage, (mix, report)) =
            Stage::run("couple", || couple(&named, &CoupleOptions::default(), &tick))?;
        let checks = match (&paints[0].1.flakes, &paints[1].1.flakes) {
            (Some(a), Some(b)) => transport_checks(&report, a, b)?,
            _ => Vec::new(),
        };
        mix.write(&self.output.join("mix.paint.exr"))?;
        finish(stage.with(checks), stages);
        Ok(mix)
    }

    /// The strip's scene, in tiles of the asked height.
    fn scene(&self) -> Result<Scene> {
        let mut scene = Scene::strip();
        let full = scene.size[1];
        scene.size = scene.size.map(|n| n.saturating_mul(self.height).div_ceil(full));
        scene.validate().map_err(|e| e.within("--height"))?;
        Ok(scene)
    }

    fn render(&self, scene: &Scene, paints: &[Paint]) -> Result<Stage> {
        let tick = Bar::new("rendering", tick_count(scene)).into_tick();
        let (stage, picture) = Stage::run("render strip", || {
            let ready = paints.iter().map(RenderPaint::new).collect::<Result<Vec<_>>>()?;
            render(scene, &ready, &Options { seed: self.seed, ..Options::default() }, &tick)
        })?;
        drop(tick);
        picture.write(&self.output.join("strip.png"), scene.exposure_stops, &ToneMap::Srgb)?;
        picture.write(&self.output.join("strip.exr"), scene.exposure_stops, &ToneMap::Srgb)?;
        Ok(stage)
    }
}

/// The strip's paints.
fn blend(mix: &Mix, ends: &[(String, Paint)], stages: &mut Vec<Stage>) -> Result<Vec<Paint>> {
    let weights = STRIP.map(|percent| f64::from(percent) / 100.0);
    let (stage, paints) = Stage::run("blend 9 paints", || {
        weights.iter().map(|w| mix.blend(&[1.0 - w, *w])).collect::<Result<Vec<_>>>()
    })?;
    let mut checks = Vec::new();
    for (k, (name, end)) in ends.iter().enumerate() {
        let differences = mix.blend(&[1.0 - k as f64, k as f64])?.differences(end);
        // The lattices in space and in angle are the mix's own; offsets are small differences of means, in f32.
        let expected = ["pitch", "knot spacing", "knot compression", "offset"];
        let inexact = differences.into_iter().filter(|d| !expected.iter().any(|what| d.0.contains(what)));
        let largest = inexact.map(|d| d.1).fold(0.0, f64::max);
        checks.push(Check::new(
            format!("{name} at weight 1: boxes, probabilities, lobes, colors"),
            largest,
            1e-15,
        ));
    }
    finish(stage.with(checks), stages);
    Ok(paints)
}

fn finish(stage: Stage, stages: &mut Vec<Stage>) {
    output::print(format_args!("{stage}"));
    stages.push(stage);
}

fn print_stages(stages: &[Stage]) {
    for stage in stages {
        output::print(format_args!("{stage}"));
    }
}
