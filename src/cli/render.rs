//! `carpaint render`.

use super::output;
use super::progress::Bar;
use crate::error::{Error, Result};
use crate::file::{PictureFormat, check_output};
use crate::paint::Paint;
use crate::render::{Options, RenderPaint, render, tick_count};
use crate::scene::{Scene, Shape};
use std::path::PathBuf;
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
    /// Scene file; left out, a capsule in a studio.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Painted object instead of the scene's: capsule, sphere or panel.
    #[arg(long)]
    shape: Option<String>,
    /// Size of one tile, pixels, e.g. 640x480.
    #[arg(long)]
    size: Option<String>,
    /// Exposure in stops instead of the scene's.
    #[arg(long, allow_negative_numbers = true)]
    exposure: Option<f64>,
    /// Rays a pixel.
    #[arg(long, default_value_t = Options::default().samples)]
    samples: usize,
    /// Seed of flakes and sampling.
    #[arg(long, default_value_t = Options::default().seed, allow_negative_numbers = true)]
    seed: u32,
    /// Leave the sparkle out and show the smooth part.
    #[arg(long)]
    no_flakes: bool,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        for path in &self.output {
            PictureFormat::of(path)?;
            check_output(path)?;
        }
        let scene = self.scene()?;
        let paints: Vec<RenderPaint> = self
            .paints
            .iter()
            .map(|path| RenderPaint::new(&Paint::read(path)?).map_err(|e| e.in_file(path)))
            .collect::<Result<_>>()?;
        let options =
            Options { samples: self.samples, seed: self.seed, flakes: !self.no_flakes, ..Options::default() };
        let start = Instant::now();
        let bar = Bar::new("render", tick_count(&scene));
        let picture = render(&scene, &paints, &options, &bar.tick())?;
        drop(bar);
        for path in &self.output {
            picture.write(path, scene.exposure_stops)?;
            output::wrote(path, start)?;
        }
        output::note!(
            "{} x {} pixels, {} rays each, clipped in 8 bits: {:.2} %",
            picture.size[0],
            picture.size[1],
            self.samples,
            100.0 * picture.clipped(scene.exposure_stops)
        );
        Ok(ExitCode::SUCCESS)
    }

    /// The scene that file and options describe.
    fn scene(&self) -> Result<Scene> {
        let mut scene = match &self.scene {
            Some(path) => Scene::read(path)?,
            None if self.paints.len() > 1 => Scene::strip(),
            None => Scene::default(),
        };
        if let Some(name) = &self.shape {
            scene.shape = Shape::named(name).map_err(|e| e.within("--shape"))?;
        }
        if let Some(size) = &self.size {
            scene.size = parse_size(size)?;
        }
        scene.exposure_stops = self.exposure.unwrap_or(scene.exposure_stops);
        scene.validate()?;
        Ok(scene)
    }
}

/// `WIDTHxHEIGHT`.
fn parse_size(text: &str) -> Result<[usize; 2]> {
    let sides = text.split_once('x').map(|(w, h)| (w.parse(), h.parse()));
    match sides {
        Some((Ok(width), Ok(height))) => Ok([width, height]),
        _ => Err(Error::invalid("--size", "picture size", text, "WIDTHxHEIGHT, e.g. 640x480")),
    }
}
