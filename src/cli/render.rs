//! `carpaint render`.

use super::device::Device;
use super::output;
use super::progress::Bar;
use super::scene::SceneArguments;
use crate::color::ResponseCurve;
use crate::error::{Error, Result};
use crate::file::{PictureFormat, check_output_apart, read_text};
use crate::paint::Paint;
use crate::render::{Options, Random, RenderPaint, ToneMap, needed_of_paint, tick_count};
use crate::scene::Scene;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Render a picture of one or more paints, side by side.
#[derive(clap::Args)]
pub struct Arguments {
    /// Paint files (NAME.paint.exr), left to right.
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
}

/// A paint with what the picture needs of it.
fn ready(path: &Path, scene: &Scene, options: &Options) -> Result<RenderPaint> {
    let mut paint = Paint::read(path)?;
    if let (Some(cells), Some(flakes)) = (needed_of_paint(scene, options, &paint)?, &mut paint.flakes) {
        flakes.keep(&cells);
    }
    RenderPaint::new(&paint).map_err(|e| e.in_file(path))
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        for path in &self.output {
            PictureFormat::of(path)?;
            check_output_apart(path, &self.paints)?;
        }
        let tone_map = tone_map(&self.tone_map)?;
        let mut scene = self.scene.scene(self.paints.len())?;
        scene.exposure_stops = self.exposure.unwrap_or(scene.exposure_stops);
        scene.validate()?;
        let flakes = !self.no_flakes;
        let options = Options { seed: self.seed, flakes, random: self.random, ..self.scene.options() };
        let paints: Vec<RenderPaint> =
            self.paints.iter().map(|path| ready(path, &scene, &options)).collect::<Result<_>>()?;
        let renderer = self.device.open()?;
        let start = Instant::now();
        let bar = Bar::new("render", tick_count(&scene));
        let picture = renderer.render(&scene, &paints, &options, &bar.tick())?;
        drop(bar);
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
