//! `carpaint render`.

use super::budget::{BudgetArguments, picked};
use super::device::Device;
use super::flake_source::FlakeSource;
use super::output;
use super::progress::Bar;
use super::scene::SceneArguments;
use crate::color::ResponseCurve;
use crate::error::{Error, Result};
use crate::file::{PictureFormat, check_output_apart, read_text};
use crate::paint::Paint;
use crate::render::{Options, Picture, Random, RenderPaint, ToneMap, needed_of_paint, tick_count, trace};
use crate::scene::Scene;
use crate::tradeoff::{Budget, pick_samples};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Render a picture of one or more paints: side by side, or worn by the objects of a scene that lists them.
#[derive(clap::Args)]
#[command(mut_arg("error", |a| a.conflicts_with_all(["samples", "path_trace", "flakes"])))]
#[command(mut_arg("time", |a| a.conflicts_with_all(["samples", "path_trace", "flakes"])))]
pub struct Arguments {
    /// Paint files (NAME.paint.exr), left to right, or numbered from 0 as objects of the scene wear them.
    #[arg(required = true)]
    paints: Vec<PathBuf>,
    /// Picture to write: .png (8 bit, sRGB) or .exr (linear, f32, exposure not applied); may be given more than once.
    #[arg(short, long, required = true)]
    output: Vec<PathBuf>,
    #[command(flatten)]
    scene: SceneArguments,
    /// Exposure in stops instead of the scene's.
    #[arg(long, allow_negative_numbers = true)]
    exposure: Option<f64>,
    /// How light becomes eight bits: `srgb`, or `camera:CURVE`, a text file of knots, a line each: linear light (after exposure)
    /// and response, or the responses of red, green and blue.
    #[arg(long, default_value = "srgb")]
    tone_map: String,
    /// Seed of flakes and sampling.
    #[arg(long, default_value_t = Options::default().seed, allow_negative_numbers = true)]
    seed: u32,
    /// Where the flakes' random numbers come from: `hash`, without repetition, or `texture:SIDE`, a tile of SIDE x SIDE cells.
    #[arg(long, value_parser = random, default_value = "hash")]
    random: Random,
    /// Where to render; `auto` takes a GPU if there is one that is not software.
    #[arg(long, value_enum, default_value_t)]
    device: Device,
    /// Leave the sparkle out and show the smooth part.
    #[arg(long)]
    no_flakes: bool,
    /// What makes the flakes: `statistical`, the paint's own statistics; `btf:FILE`, the raw slices that they were made from;
    /// `analytic:COMPOSITION`, Ershov's sparkles, drawn for every pixel, dimmed by flakes above them (`analytic-hidden`: hidden
    /// or not). The last two take one paint, and the CPU.
    #[arg(long, default_value = "statistical", conflicts_with = "no_flakes")]
    flakes: FlakeSource,
    /// Path-trace on the CPU, with light between objects, flakes under all light, and up to so many reflections.
    #[arg(long, value_name = "REFLECTIONS", num_args = 0..=1, default_missing_value = "4", conflicts_with = "flakes")]
    path_trace: Option<usize>,
    #[command(flatten)]
    budget: BudgetArguments,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        for path in &self.output {
            PictureFormat::of(path)?;
            check_output_apart(path, &self.paints)?;
        }
        let tone_map = tone_map(&self.tone_map)?;
        let budget = self.budget.budget()?;
        let mut scene = self.scene.scene(self.paints.len())?;
        self.output.iter().try_for_each(|path| check_output_apart(path, &scene.files()))?;
        scene.exposure_stops = self.exposure.unwrap_or(scene.exposure_stops);
        scene.validate()?;
        scene.check_paints(self.paints.len())?;
        let flakes = !self.no_flakes;
        let mut options = Options { seed: self.seed, flakes, random: self.random, ..self.scene.options() };
        let paints = self.paints.iter().enumerate();
        let paints: Vec<RenderPaint> =
            paints.map(|(worn, path)| self.ready(path, &scene, &options, worn)).collect::<Result<_>>()?;
        let start = Instant::now();
        let picture = self.picture(&scene, &paints, &mut options, budget)?;
        for path in &self.output {
            picture.write(path, scene.exposure_stops, &tone_map)?;
            output::wrote(path, start)?;
        }
        output::note!(
            "{} x {} pixels, {} rays each, clipped in 8 bits: {:.2} %",
            picture.size[0],
            picture.size[1],
            options.samples,
            100.0 * picture.clipped(scene.exposure_stops)
        );
        Ok(ExitCode::SUCCESS)
    }

    /// A paint, worn as that number, with what the picture needs of it.
    fn ready(&self, path: &Path, scene: &Scene, options: &Options, worn: usize) -> Result<RenderPaint> {
        let mut paint = Paint::read(path)?;
        let worn = (!scene.objects.is_empty()).then_some(worn);
        // Paths meet flakes under all angles, and settings are tried on smaller pictures.
        if self.path_trace.is_none()
            && !self.budget.is_given()
            && let Some(cells) = needed_of_paint(scene, options, &paint, worn)?
            && let Some(flakes) = &mut paint.flakes
        {
            flakes.keep(&cells);
        }
        RenderPaint::new(&paint).map_err(|e| e.in_file(path))
    }

    /// The picture; a budget sets the rays of the options.
    fn picture(
        &self,
        scene: &Scene,
        paints: &[RenderPaint],
        options: &mut Options,
        budget: Option<Budget>,
    ) -> Result<Picture> {
        let bar = |what| Bar::new(what, tick_count(scene)).into_tick();
        if let Some(bounces) = self.path_trace {
            let traced = trace(scene, paints, options, bounces, &bar("path tracing"))?;
            let percent = 100.0 * traced.standard_error;
            output::note!("path traced on the CPU, standard error of a pixel {percent:.2} %");
            return Ok(traced.picture);
        }
        if self.flakes == FlakeSource::Statistical {
            let renderer = self.device.open()?;
            if let Some(budget) = budget {
                let render =
                    |scene: &Scene, options: &Options| renderer.render(scene, paints, options, &|| ());
                options.samples = picked("render", pick_samples(scene, options, budget, render)?);
            }
            return renderer.render(scene, paints, options, &bar("render"));
        }
        self.flakes.render(scene, paints, options, &bar("render"))
    }
}

/// Largest file of a response curve, bytes.
const MAX_CURVE_BYTES: u64 = 1 << 22;

/// `srgb` or `camera:CURVE`.
fn tone_map(text: &str) -> Result<ToneMap> {
    match text.strip_prefix("camera:").map(Path::new) {
        Some(path) => {
            let curve = ResponseCurve::parse(&read_text(path, MAX_CURVE_BYTES)?);
            Ok(ToneMap::Camera(curve.map_err(|e| e.in_file(path))?))
        }
        None if text == "srgb" => Ok(ToneMap::Srgb),
        None => Err(Error::invalid("--tone-map", "name", text, "srgb or camera:CURVE")),
    }
}

/// `hash` or `texture:SIDE`.
fn random(text: &str) -> std::result::Result<Random, String> {
    match text.strip_prefix("texture:").map(str::parse) {
        Some(Ok(side)) => Ok(Random::Texture(side)),
        None if text == "hash" => Ok(Random::Hash),
        _ => Err("hash or texture:SIDE".to_owned()),
    }
}
