//! `carpaint view`.

use crate::error::Result;
use crate::viewer::{Start, open};
use std::path::PathBuf;
use std::process::ExitCode;

/// Look at paints and mixes in a window: turn, zoom to single flakes, move the lamp, blend. An image is shown as a print.
///
/// Without a file three paints are simulated and coupled on the spot. F1 in the window shows what keys and mouse do.
#[derive(clap::Args)]
pub struct Arguments {
    /// A mix, or paints, which are then coupled (NAME.paint.exr); or a composition (.toml). Scenes (.toml), surroundings (.hdr, .exr)
    /// and meshes (.glb, .gltf, .obj) beside them. Or an image by itself (.png, .jpg), printed as `carpaint proof` shows it.
    files: Vec<PathBuf>,
    /// Scene file (TOML): its objects wear the paints, number 0 the first one, the number after the last the blend; where all wear the
    /// same number, they wear the blend.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// One weight a paint at first, separated by commas, summing to 1, from -1 to 2; by default equal ones.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    weights: Option<Vec<f64>>,
    /// The inks for red, green and blue of a print (.ink.json) instead of three of coated mica that come with the program.
    #[arg(long, num_args = 3, value_names = ["RED", "GREEN", "BLUE"])]
    inks: Option<Vec<PathBuf>>,
    /// Part of the name of the adapter to draw with, in any case; by default the best one.
    #[arg(long)]
    adapter: Option<String>,
    /// Write where controls stand into a file (JSON), for tests that drive the window.
    #[arg(long, hide = true)]
    places: Option<PathBuf>,
    /// Take the device away after so many pictures, twice, for tests.
    #[arg(long, hide = true)]
    lose_device_after: Option<usize>,
    /// Take the device away after so many pictures, when the window can do nothing about it, for tests.
    #[arg(long, hide = true)]
    lose_device_late_after: Option<usize>,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let Self { files, scene, weights, inks, adapter, places, lose_device_after, lose_device_late_after } =
            self;
        open(Start {
            files,
            scene,
            weights,
            inks,
            adapter,
            places,
            lose_device_after,
            lose_device_late_after,
        })?;
        Ok(ExitCode::SUCCESS)
    }
}
