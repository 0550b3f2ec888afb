//! `carpaint view`.

use crate::error::Result;
use crate::viewer::{Start, open};
use std::path::PathBuf;
use std::process::ExitCode;

/// Look at paints and mixes in a window: turn, zoom to single flakes, move the lamp, blend.
///
/// Without a file three paints are simulated and coupled on the spot. F1 in the window shows what keys and mouse do.
#[derive(clap::Args)]
pub struct Arguments {
    /// A mix, or paints, which are then coupled (NAME.paint.exr); or a composition (.toml).
    files: Vec<PathBuf>,
    /// Part of the name of the adapter to draw with, in any case; by default the best one.
    #[arg(long)]
    adapter: Option<String>,
    /// Write where controls stand into a file (JSON), for tests that drive the window.
    #[arg(long, hide = true)]
    places: Option<PathBuf>,
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        open(Start { files: self.files, adapter: self.adapter, places: self.places })?;
        Ok(ExitCode::SUCCESS)
    }
}
