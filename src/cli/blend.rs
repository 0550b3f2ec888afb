//! `carpaint blend`.

use super::output;
use super::scene::SceneArguments;
use crate::error::{Error, Result};
use crate::file::{Container, check_output_apart};
use crate::mix::{self, BlendOptions, Channels, LobePath, Mix, Path, distance_weights, whitened};
use crate::paint::{self, Paint};
use crate::render::needed_of_blend;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// The paint that coupled paints give at these weights; weights outside [0, 1] extrapolate.
///
/// A single paint can be given with `--channels white-flakes`: its flakes lose their color.
#[derive(clap::Args)]
#[group(skip)]
#[command(mut_arg("shape", |a| a.requires("scene")), mut_arg("size", |a| a.requires("scene")))]
pub struct Arguments {
    /// The mix (.paint.exr, from `couple`).
    mix: PathBuf,
    /// One weight a paint, separated by commas, summing to 1.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, conflicts_with = "distances")]
    weights: Option<Vec<f64>>,
    /// Instead of weights the distances to the paints, one each: weights go with their inverse squares.
    #[arg(long, value_delimiter = ',')]
    distances: Option<Vec<f64>>,
    /// transport, hybrid or contrast; by default that of the mix.
    #[arg(long, value_name = "NAME")]
    path: Option<Path>,
    /// What goes: all, lightness (of the flakes only), all-but-lightness, white-flakes.
    #[arg(long, value_name = "NAME", default_value_t)]
    channels: Channels,
    /// Number, from 1, of the paint that keeps what does not go.
    #[arg(long, value_name = "N", default_value_t = 1)]
    source: usize,
    /// index or matched: which lobes of the smooth part belong together.
    #[arg(long, value_name = "NAME", default_value_t)]
    lobes: LobePath,
    /// The paint to write (.paint.exr).
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten, next_help_heading = "Only what a picture of a scene needs")]
    scene: SceneArguments,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let start = Instant::now();
        check_output_apart(&self.output, std::slice::from_ref(&self.mix))?;
        let container = Container::read(&self.mix)?;
        if container.meta.get("kind").is_some_and(|kind| kind == paint::KIND) {
            self.whiten(container).map_err(|e| e.in_file(&self.mix))?;
        } else {
            self.blend(container).map_err(|e| e.in_file(&self.mix))?;
        }
        output::wrote(&self.output, start)?;
        Ok(ExitCode::SUCCESS)
    }

    fn blend(&self, container: Container) -> Result<()> {
        let mut mix = Mix::from_container(container)?;
        let weights = self.weights()?;
        if !(1..=mix.constituents.len()).contains(&self.source) {
            let legal = format!("1 to {}", mix.constituents.len());
            return Err(Error::invalid("--source", "paint", self.source, legal));
        }
        let options = BlendOptions {
            path: self.path,
            channels: self.channels,
            source: self.source - 1,
            lobes: self.lobes,
        };
        if let Some(scene) = self.scene.named()? {
            let cells = needed_of_blend(&scene, &self.scene.options(), &mix, &weights, &options)?;
            if let (Some(flakes), Some(cells)) = (&mut mix.flakes, cells) {
                output::note!("for the scene {} of {} cells", cells.len(), cells.total());
                flakes.keep(&cells);
            }
        }
        mix.blend_with(&weights, &options)?.write(&self.output)?;
        if self.distances.is_some() {
            let shown: Vec<String> = weights.iter().map(|w| format!("{w:.4}")).collect();
            output::say!("weights {}", shown.join(", "));
        }
        if weights.iter().any(|w| !(0.0..=1.0).contains(w)) {
            let mass = 100.0 * mix.inverted_mass(&weights)?;
            output::say!("extrapolated: boxes of {mass:.1} % of the flakes are kept from turning inside out");
        }
        Ok(())
    }

    fn weights(&self) -> Result<Vec<f64>> {
        match (&self.weights, &self.distances) {
            (Some(weights), _) => Ok(weights.clone()),
            (None, Some(distances)) => distance_weights(distances).map_err(|e| e.within("--distances")),
            (None, None) => Err(Error::invalid("blend", "weights", "none", "--weights or --distances")),
        }
    }

    fn whiten(&self, container: Container) -> Result<()> {
        let single =
            self.channels == Channels::WhiteFlakes && self.weights.is_none() && self.distances.is_none();
        if !single {
            let legal =
                format!("{}; of a single paint only --channels white-flakes, without weights", mix::KIND);
            return Err(Error::invalid("", "kind of file", paint::KIND, legal));
        }
        let mut paint = Paint::from_container(container)?;
        paint.flakes = paint.flakes.as_ref().map(whitened);
        paint.write(&self.output)
    }
}
