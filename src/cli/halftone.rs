//! `carpaint halftone`.

use super::output;
use crate::error::Result;
use crate::file;
use crate::proof::{Halftone, InkLimit, Method, Separation, ToneErrors};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Side of the blocks whose tones are compared, pixels of the image.
const BLOCK: usize = 16;
/// Names of the primaries.
const PRIMARIES: [&str; 3] = ["red", "green", "blue"];

/// Turn an image into dots of three inks, red, green and blue, side by side on blank paper, and say which tones they reach.
///
/// Coverage is proportional to linear light: white is a third of each ink.
#[derive(clap::Args)]
pub struct Arguments {
    /// Image (.png, .jpg, .exr; without alpha, no CMYK).
    image: PathBuf,
    /// Dots: an RGB picture of 0 and 255 (.png).
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    halftone: HalftoneArguments,
    /// Print the summary as JSON.
    #[arg(long)]
    json: bool,
}

/// How an image becomes dots.
#[derive(clap::Args)]
pub struct HalftoneArguments {
    /// How dots are placed.
    #[arg(long, value_enum, default_value = "error-diffusion")]
    method: MethodName,
    /// Dots along a side of a pixel, 1 to 32.
    #[arg(long, default_value_t = 1)]
    cell: usize,
    /// What happens where an image asks for more ink than there is paper.
    #[arg(long, value_enum, default_value = "scale")]
    ink_limit: InkLimitName,
    /// Seed of what is random in the placement.
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

impl HalftoneArguments {
    /// Wished tones of an image file, and its dots.
    pub fn print(&self, image: &Path) -> Result<(Separation, Halftone)> {
        let (size, pixels) = file::read_print_image(image)?;
        let separation =
            Separation::new(size, &pixels, self.ink_limit.into()).map_err(|e| e.in_file(image))?;
        let print = Method::from(self.method).halftone(&separation, self.cell, self.seed)?;
        Ok((separation, print))
    }
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum MethodName {
    /// Floyd-Steinberg for all inks at once: the tones of an image to a dot.
    ErrorDiffusion,
    /// A threshold a dot (void and cluster): the same grain everywhere.
    BlueNoise,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum InkLimitName {
    /// The whole image times one factor: tones keep their proportions.
    Scale,
    /// Each pixel by itself: bright ones keep their hue only.
    Clip,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        output::require_suffix("--output", &self.output, ".png")?;
        file::check_output_apart(&self.output, std::slice::from_ref(&self.image))?;
        let (separation, print) = self.halftone.print(&self.image)?;
        let errors = ToneErrors::of(&separation, &print, BLOCK)?;
        file::write_png(&self.output, print.size(), &print.rgb())?;
        if self.json {
            let (factor, size) = (separation.factor(), print.size());
            output::json(
                &json!({ "size": size, "dots": size[0] * size[1], "factor": factor, "tones": errors }),
            )?;
        } else {
            summary(&errors, print.size(), separation.factor());
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }
}

fn summary(errors: &ToneErrors, size: [usize; 2], factor: f64) {
    output::say!("{} x {} = {} dots, image times {factor:.4}", size[0], size[1], size[0] * size[1]);
    output::say!("ink      wished   reached  largest difference in {BLOCK} x {BLOCK} pixels");
    for (k, ink) in PRIMARIES.iter().enumerate() {
        let (wished, reached) = (errors.wished[k], errors.reached[k]);
        output::say!("{ink:<6}  {wished:.5}   {reached:.5}  {:.5}", errors.largest_of_blocks[k]);
    }
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::ErrorDiffusion => Self::ErrorDiffusion,
            MethodName::BlueNoise => Self::BlueNoise,
        }
    }
}

impl From<InkLimitName> for InkLimit {
    fn from(name: InkLimitName) -> Self {
        match name {
            InkLimitName::Scale => Self::Scale,
            InkLimitName::Clip => Self::Clip,
        }
    }
}
