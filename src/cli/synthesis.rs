//! How finely flakes are synthesized, asked alike by every command that does so.

use crate::btf::AngleGrid;
use crate::error::Result;
use crate::simulate::{DEFAULT_BINS, SynthesisOptions};

/// Grid and texture of synthesized flakes.
#[derive(clap::Args)]
pub struct SynthesisArguments {
    /// Angle bins per 90 degrees; theta_h + theta_i < 90 degrees gives bins (bins + 1) / 2 slices.
    #[arg(long, default_value_t = DEFAULT_BINS)]
    bins: usize,
    /// Another grid: the number of slices of each theta_i row, from 0 on, each from theta_h = 0 on.
    #[arg(long, value_delimiter = ',', value_name = "SLICES,...")]
    rows: Option<Vec<usize>>,
    /// Columns and rows of a flake slice, texels.
    #[arg(long, default_value_t = 128)]
    size: usize,
    /// Side of a texel, micrometers; `couple` needs paints with equal texels, bins and sizes [default: the mean flake is 1.5
    /// texels wide].
    #[arg(long, allow_negative_numbers = true)]
    texel_um: Option<f64>,
}

impl SynthesisArguments {
    /// What the library is asked for.
    pub fn options(&self, seed: u32) -> Result<SynthesisOptions> {
        let grid = match &self.rows {
            Some(rows) => AngleGrid::new(self.bins, rows.clone()).map_err(|e| e.within("--rows"))?,
            None => AngleGrid::triangle(self.bins).map_err(|e| e.within("--bins"))?,
        };
        Ok(SynthesisOptions {
            size: [self.size; 2],
            texel_mm: self.texel_um.map(|um| um * 1e-3),
            seed: u64::from(seed),
            ..SynthesisOptions::new(grid)
        })
    }
}
