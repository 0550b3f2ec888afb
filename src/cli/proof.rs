//! `carpaint proof`.

use super::device::Device;
use super::halftone::HalftoneArguments;
use super::output;
use super::progress::Bar;
use crate::brdf::Ink;
use crate::color::{Illuminant, Spectrum, Wavelengths, read_emission, srgb_encode};
use crate::error::{Error, Result};
use crate::file::{PictureFormat, check_output_apart, read_print_image};
use crate::proof::{Coverage, Halftone};
use crate::render::{
    self, Bands, InkModel, Options, Paper, Picture, Print, PrintInks, ToneMap, lit_from_behind, own_inks,
    tick_count,
};
use crate::scene::{Scene, Shape};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Show an image as a print in goniochromatic inks would look: halftoned, on a sheet, under a lamp (Pranovich et al. 2024).
///
/// Inks lie side by side, dot off dot, on black paper; the light of each wavelength is added up, so that illuminants count. Colors that
/// sRGB does not have keep hue and luminance in .png; .exr keeps them as they are.
#[derive(clap::Args)]
#[command(mut_arg("method", |a| a.conflicts_with("halftoned")), mut_arg("cell", |a| a.conflicts_with("halftoned")))]
#[command(mut_arg("ink_limit", |a| a.conflicts_with("halftoned")), mut_arg("seed", |a| a.conflicts_with("halftoned")))]
pub struct Arguments {
    /// The image to be printed (.png, .jpg, .exr; without alpha, no CMYK).
    image: PathBuf,
    /// Picture to write: .png (8 bit, sRGB) or .exr (linear, f32, exposure not applied); may be given more than once.
    #[arg(short, long, required = true)]
    output: Vec<PathBuf>,
    /// The inks for red, green and blue (.ink.json) instead of three of coated mica that come with the program.
    #[arg(long, num_args = 3, value_names = ["RED", "GREEN", "BLUE"])]
    inks: Option<Vec<PathBuf>>,
    /// The image is a halftone: each pixel red, green or blue of 255 or black, a dot each.
    #[arg(long)]
    halftoned: bool,
    #[command(flatten, next_help_heading = "Halftone")]
    halftone: HalftoneArguments,
    #[command(flatten, next_help_heading = "Light and material")]
    look: Look,
    /// Scene file (TOML); its lamps and objects count, all of which wear the print.
    #[arg(long, help_heading = "Scene")]
    scene: Option<PathBuf>,
    /// What is printed: a sheet or a panel in the proportions of the image, or the front half of a sphere or a capsule, all around.
    #[arg(long, help_heading = "Scene", default_value = "sheet", conflicts_with = "scene")]
    shape: String,
    /// Size of the picture, pixels, e.g. 640x480.
    #[arg(long, help_heading = "Scene")]
    size: Option<String>,
    /// Rays a pixel.
    #[arg(long, help_heading = "Scene", default_value_t = Options::default().samples)]
    samples: usize,
    /// Exposure in stops instead of the scene's, or of the one at which half a percent of the picture is white.
    #[arg(long, help_heading = "Scene", allow_negative_numbers = true)]
    exposure: Option<f64>,
    /// Where to render; `auto` takes a GPU if there is one that is not software.
    #[arg(long, help_heading = "Scene", value_enum, default_value_t)]
    device: Device,
    /// Print the summary as JSON.
    #[arg(long)]
    json: bool,
}

/// Lamps, inks and paper.
#[derive(clap::Args)]
pub struct Look {
    /// Light of the lamps: D65, A, or a measured emission (.csv: nanometres and power).
    #[arg(long, default_value = "D65")]
    illuminant: String,
    /// The eye takes the light's white for white, like a camera balanced for it.
    #[arg(long)]
    adapted: bool,
    /// How inks reflect.
    #[arg(long, value_enum, default_value_t)]
    model: ModelName,
    /// Roughness alpha of all inks instead of their own: how well flakes lie.
    #[arg(long, allow_negative_numbers = true)]
    roughness: Option<f64>,
    /// Wavelengths between 380 and 780 nm (21 take half the time and are within 0.6 Delta-E 2000 of 41), or `xyz`: three numbers fitted
    /// to the inks, a seventh of the time, within 4.
    #[arg(long, value_parser = bands, default_value = "41")]
    wavelengths: Bands,
    /// What lies beneath: black, none, or numbers HIGHLIGHT,SHININESS,ALBEDO (a dim highlight's share of light and its Phong
    /// exponent, and how much light is scattered on below).
    #[arg(long, value_parser = paper, default_value = "black", allow_hyphen_values = true)]
    paper: Paper,
    /// A lamp opposite to each of the scene's, of this share of its light: what shines through the paper.
    #[arg(long, num_args = 0..=1, default_missing_value = "0.05", default_value = "0", allow_negative_numbers = true)]
    back_light: f64,
}

/// How inks reflect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum ModelName {
    /// The goniochromatic model.
    #[default]
    Goniochromatic,
    /// Torrance and Sparrow's, rho as the reflectance at normal incidence.
    Schlick,
    /// Torrance and Sparrow's, rho times the exact reflectance of titanium dioxide.
    Exact,
}

fn bands(text: &str) -> std::result::Result<Bands, String> {
    match text {
        "xyz" => Ok(Bands::Xyz),
        _ => {
            let count = text.parse().ok().filter(|count| (2..=Wavelengths::MAX).contains(count));
            count.map(Bands::Wavelengths).ok_or_else(|| "2 to 4096, or xyz".to_owned())
        }
    }
}

fn paper(text: &str) -> std::result::Result<Paper, String> {
    let legal = || "black, none or HIGHLIGHT,SHININESS,ALBEDO".to_owned();
    let paper = match text {
        "black" => Paper::BLACK,
        "none" => Paper::NONE,
        _ => {
            let numbers: Vec<f32> = text.split(',').map_while(|n| n.trim().parse().ok()).collect();
            let [highlight, shininess, albedo] = numbers[..] else { return Err(legal()) };
            Paper { highlight, shininess, albedo }
        }
    };
    paper.validate().map_err(|e| e.to_string())?;
    Ok(paper)
}

impl Look {
    /// Light of the lamps.
    fn light(&self) -> Result<Spectrum> {
        let path = Path::new(&self.illuminant);
        if let Ok(standard) = Illuminant::named(&self.illuminant) {
            return Ok(standard.spectrum());
        }
        if !path.exists() {
            let legal = "D65, A or a file of a measured emission";
            return Err(Error::invalid("--illuminant", "light", format!("{:?}", self.illuminant), legal));
        }
        read_emission(path)
    }

    /// The inks under that light.
    fn inks(&self, inks: Vec<Ink>) -> Result<PrintInks> {
        let rough = |ink: Ink| match self.roughness {
            Some(alpha) => ink.with_roughness(alpha).map_err(|e| e.within("--roughness")),
            None => Ok(ink),
        };
        let inks = inks.into_iter().map(rough).collect::<Result<Vec<_>>>()?;
        let model = match self.model {
            ModelName::Goniochromatic => InkModel::Goniochromatic,
            ModelName::Schlick => InkModel::Schlick,
            ModelName::Exact => InkModel::Exact,
        };
        if self.wavelengths == Bands::Xyz && model != InkModel::Goniochromatic {
            let legal = "goniochromatic with --wavelengths xyz";
            return Err(Error::invalid("proof", "--model", format!("{:?}", self.model), legal));
        }
        let (light, adapted, bands) = (self.light()?, self.adapted, self.wavelengths);
        render::Look { light, adapted, model, bands }.inks(&inks)
    }
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        let inputs: Vec<PathBuf> =
            std::iter::once(&self.image).chain(self.inks.iter().flatten()).cloned().collect();
        self.check_outputs(&inputs)?;
        let inks = self.look.inks(self.ink_set()?)?;
        let print = self.print()?;
        let scene = self.scene(print.size())?;
        self.check_outputs(&scene.files())?;
        let coverage = Coverage::new(print);
        let options = Options { samples: self.samples, ..Options::default() };
        let print = Print { inks: &inks, coverage: &coverage, paper: self.look.paper };
        let renderer = self.device.open()?;
        let bar = Bar::new("proof", tick_count(&scene));
        let picture = renderer.render_print(&scene, &print, &options, &bar.tick())?;
        drop(bar);
        let stops = match (self.exposure, &self.scene) {
            (None, None) => picture.exposure(Picture::WHITE_SHARE),
            _ => scene.exposure_stops,
        };
        for path in &self.output {
            picture.write(path, stops, &ToneMap::InGamut)?;
            output::wrote(path, start)?;
        }
        self.report(&coverage, &picture, stops)?;
        Ok(ExitCode::SUCCESS)
    }

    fn check_outputs(&self, inputs: &[PathBuf]) -> Result<()> {
        self.output.iter().try_for_each(|path| {
            PictureFormat::of(path)?;
            check_output_apart(path, inputs)
        })
    }

    fn ink_set(&self) -> Result<Vec<Ink>> {
        match &self.inks {
            Some(paths) => paths.iter().map(|path| Ink::read(path)).collect(),
            None => own_inks(),
        }
    }

    /// The dots.
    fn print(&self) -> Result<Halftone> {
        if self.halftoned {
            let (size, pixels) = read_print_image(&self.image)?;
            let code = |c: f32| (255.0 * srgb_encode(f64::from(c))).round() as u8;
            let pixels: Vec<[u8; 3]> = pixels.iter().map(|p| p.map(code)).collect();
            return Halftone::from_rgb(size, &pixels).map_err(|e| e.in_file(&self.image));
        }
        Ok(self.halftone.print(&self.image)?.1)
    }

    /// The scene, lamps behind included.
    fn scene(&self, [columns, rows]: [usize; 2]) -> Result<Scene> {
        let mut scene = match &self.scene {
            Some(path) => Scene::read(path)?,
            None => {
                let shape = Shape::printed(&self.shape, columns as f64 / rows as f64);
                Scene::proof(shape.map_err(|e| e.within("--shape"))?)
            }
        };
        if let Some(size) = &self.size {
            scene.size = super::scene::parse_size(size)?;
        }
        scene.exposure_stops = self.exposure.unwrap_or(scene.exposure_stops);
        crate::check::range("--back-light", "share", self.look.back_light, 0.0..=1.0)?;
        if self.look.back_light > 0.0 {
            scene = lit_from_behind(scene, self.look.back_light);
        }
        scene.validate()?;
        Ok(scene)
    }

    fn report(&self, coverage: &Coverage, picture: &Picture, stops: f64) -> Result<()> {
        let tone = coverage.dots().mean_tone();
        let outside = picture.clipped(stops);
        if self.json {
            return output::json(&json!({
                "output": self.output, "dots": coverage.size(0), "mean_tone": tone, "exposure_stops": stops, "outside_srgb": outside,
            }));
        }
        let [columns, rows] = coverage.size(0);
        let [red, green, blue] = tone.map(|t| 100.0 * t);
        output::say!("{columns} x {rows} dots: {red:.2} % red, {green:.2} % green, {blue:.2} % blue");
        output::say!(
            "exposure {stops:.2} stops; {:.2} % of the pixels are no sRGB: hue and luminance kept",
            100.0 * outside
        );
        Ok(())
    }
}
