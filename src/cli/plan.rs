//! `carpaint plan`.

use super::output;
use super::scene::SceneArguments;
use crate::btf::CellSet;
use crate::error::{Error, Result};
use crate::paint::{Flakes, Paint};
use crate::render::needed_of_paint;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;

/// What a picture of a scene needs of a paint's flakes: angle pairs and levels of detail, their number and memory.
#[derive(clap::Args)]
#[command(mut_arg("scene", |a| a.long(None).index(1).required(true)))]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Paint (.paint.exr).
    #[arg(index = 2)]
    paint: PathBuf,
    /// Number of the paint, from 0, in a scene whose objects wear several; without it all objects count.
    #[arg(long)]
    worn: Option<usize>,
    /// Print the plan as JSON.
    #[arg(long)]
    json: bool,
}

/// What is needed out of what there is.
#[derive(Serialize)]
pub struct Plan {
    /// Cells (angle pairs at levels) needed.
    pub cells: usize,
    /// Cells of the paint.
    pub total: usize,
    /// Share needed.
    pub share: f64,
    /// Bytes of their clusters, and of all.
    pub bytes: [usize; 2],
    /// Cells needed that were left out, as the paint was made for another scene.
    pub left_out: usize,
    /// Needed slices of each level, finest first; the coarsest, the mean, is always needed whole.
    pub slices_of_level: Vec<usize>,
    /// Slices of a level.
    pub slices: usize,
}

impl Plan {
    /// The plan for these flakes.
    pub fn new(flakes: &Flakes, cells: &CellSet) -> Self {
        let all = CellSet::all(flakes.grid.len(), flakes.levels.len());
        Self {
            cells: cells.len(),
            total: all.len(),
            share: cells.len() as f64 / all.len() as f64,
            bytes: [flakes.cluster_bytes(cells), flakes.cluster_bytes(&all)],
            left_out: cells.iter().filter(|(l, k)| flakes.levels[*l].slices[*k].is_left_out()).count(),
            slices_of_level: (0..cells.levels()).map(|l| cells.len_of_level(l)).collect(),
            slices: flakes.grid.len(),
        }
    }

    /// One line for people.
    pub fn summary(&self) -> String {
        let [needed, all] = self.bytes.map(|b| output::size(b as u64));
        let share = 100.0 * self.share;
        let missing =
            if self.left_out > 0 { format!("; {} are not there", self.left_out) } else { String::new() };
        format!("{} of {} cells ({share:.1} %), clusters {needed} of {all}{missing}", self.cells, self.total)
    }
}

impl Arguments {
    pub fn run(self) -> Result<ExitCode> {
        let paint = Paint::read(&self.paint)?;
        let scene = self.scene.scene(1)?;
        let cells = needed_of_paint(&scene, &self.scene.options(), &paint, self.worn)?;
        let (Some(flakes), Some(cells)) = (&paint.flakes, cells) else {
            return Err(Error::invalid(
                self.paint.display().to_string(),
                "flakes",
                "none",
                "a paint with flakes",
            ));
        };
        let plan = Plan::new(flakes, &cells);
        if self.json {
            output::json(&plan)?;
            return Ok(ExitCode::SUCCESS);
        }
        output::say!("needed: {}", plan.summary());
        for (level, n) in plan.slices_of_level.iter().enumerate() {
            let whole = if level + 1 == cells.levels() { " (the mean, for surroundings)" } else { "" };
            output::say!("level {level}: {n} of {} slices{whole}", plan.slices);
        }
        Ok(ExitCode::SUCCESS)
    }
}
