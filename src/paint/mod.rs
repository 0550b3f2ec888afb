//! The paint: what is rendered.
//!
//! `f = (1 - F(wi)) (1 - F(wo)) [ chi(theta_h, theta_i) (a/pi + sum CT) + Xi(x, theta_h, theta_i) ] + gloss`
//! (Golla & Klein 2018, eq. 7, under a clear coat). Smooth part and color table carry the mean, glitter included; Xi is
//! the signed rest, given by its statistics.

mod cells;
pub(crate) mod difference;
#[cfg(feature = "files")]
mod file;
mod knots;
#[cfg(feature = "files")]
pub(crate) mod rows;

#[cfg(feature = "files")]
pub use file::KIND;
#[cfg(feature = "files")]
pub(crate) use file::{FlakesMeta, color_table_part, read_color_table};

pub use difference::Differences;
pub use knots::Knots;

use crate::brdf::{ClearCoat, ColorTable, Lobe};
use crate::btf::{AngleGrid, FlakeBtf, level_count};
use crate::cluster::SliceStatistics;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A paint.
#[derive(Debug, Clone, PartialEq)]
pub struct Paint {
    /// The clear coat.
    pub coat: ClearCoat,
    /// Diffuse intensity a (an albedo when chi is 1), usually 0-1, within +-1e6 (extrapolated paints may have less than none).
    pub diffuse: f64,
    /// Cook-Torrance lobes of the brightness, 0 to 4.
    pub lobes: Vec<Lobe>,
    /// The color table chi.
    pub colors: ColorTable,
    /// The flakes, if any.
    pub flakes: Option<Flakes>,
    /// Where it came from: free-form JSON (tool version, seed, sources, fit errors).
    pub provenance: Value,
}

/// Statistics of a flake BTF.
#[derive(Debug, Clone, PartialEq)]
pub struct Flakes {
    /// Which angle pairs have a slice; angles under the coat (outer ones where it does not refract).
    pub grid: AngleGrid,
    /// What an angle pair without a slice gives.
    pub missing: MissingSlice,
    /// Columns and rows of the source slices, texels, 1 to 4096.
    pub size: [usize; 2],
    /// Side of a texel of the finest level, millimetres, 1e-6 to 1e4.
    pub texel_mm: f64,
    /// Levels of detail, finest first, down to one texel: [`level_count`] of the size.
    pub levels: Vec<FlakeLevel>,
    /// Steps of the inverse CDF table written for engines, 1 to 65535.
    pub inverse_cdf_steps: usize,
    /// How random numbers follow the half vector: flakes light up and go out. None: they depend on the place alone.
    pub knots: Option<Knots>,
}

/// One level of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct FlakeLevel {
    /// Pitch of the lattice on which independent random numbers are drawn, millimetres: the square root of the
    /// integral range of the source texture, so that averages of draws have the source's variance. 1e-6 to 1e8.
    pub pitch_mm: f64,
    /// Statistics of every slice, in grid order.
    pub slices: Vec<SliceStatistics>,
}

/// What an angle pair without a slice returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MissingSlice {
    /// Nothing: flakes fade out, as in AxF-style paints.
    #[default]
    Zero,
    /// The nearest slice of the same theta_i row, or of the last row.
    Nearest,
}

impl Paint {
    /// Most lobes.
    pub const MAX_LOBES: usize = 4;
    /// Largest absolute value of the diffuse intensity.
    pub const MAX_DIFFUSE: f64 = 1e6;

    /// # Errors
    /// A field outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        check_smooth(&self.coat, self.diffuse, &self.lobes)?;
        self.flakes.as_ref().map_or(Ok(()), Flakes::validate)
    }
}

/// Checks the smooth part of a paint, of a mix or alone.
pub(crate) fn check_smooth(coat: &ClearCoat, diffuse: f64, lobes: &[Lobe]) -> Result<()> {
    coat.validate()?;
    if !(-Paint::MAX_DIFFUSE..=Paint::MAX_DIFFUSE).contains(&diffuse) {
        return Err(Error::invalid("paint", "diffuse", diffuse, "-1e6 to 1e6"));
    }
    if lobes.len() > Paint::MAX_LOBES {
        return Err(Error::invalid("paint", "lobes", lobes.len(), "0 to 4"));
    }
    for (k, lobe) in lobes.iter().enumerate() {
        lobe.validate().map_err(|e| e.within(format!("lobe {k}")))?;
    }
    Ok(())
}

/// What flakes are laid out by, for paints and mixes: everything but the statistics.
pub(crate) struct Layout<'a> {
    pub grid: &'a AngleGrid,
    pub missing: MissingSlice,
    pub size: [usize; 2],
    pub texel_mm: f64,
    pub inverse_cdf_steps: usize,
    pub knots: Option<Knots>,
    /// Pitch and number of slices of each level.
    pub levels: Vec<(f64, usize)>,
}

impl Layout<'_> {
    /// Legal pitches, millimetres: up to a largest slice of the largest texels.
    const PITCH_MM: std::ops::RangeInclusive<f64> = 1e-6..=1e8;

    pub(crate) fn validate(&self) -> Result<()> {
        FlakeBtf::check_texels(self.size, self.texel_mm).map_err(|e| e.within("flakes"))?;
        if !(1..=65_535).contains(&self.inverse_cdf_steps) {
            return Err(Error::invalid("flakes", "inverse_cdf_steps", self.inverse_cdf_steps, "1 to 65535"));
        }
        self.knots.as_ref().map_or(Ok(()), Knots::validate)?;
        let expected = level_count(self.size);
        if self.levels.len() != expected {
            let legal = format!("{expected} for slices of {} x {}", self.size[0], self.size[1]);
            return Err(Error::invalid("flakes", "levels", self.levels.len(), legal));
        }
        for (l, (pitch_mm, slices)) in self.levels.iter().enumerate() {
            let place = || format!("flakes: level {l}");
            if !Self::PITCH_MM.contains(pitch_mm) {
                return Err(Error::invalid(place(), "pitch_mm", pitch_mm, "1e-6 to 1e8"));
            }
            if *slices != self.grid.len() {
                let legal = format!("{} (the grid)", self.grid.len());
                return Err(Error::invalid(place(), "slices", slices, legal));
            }
        }
        Ok(())
    }
}

impl Flakes {
    pub(crate) fn layout(&self) -> Layout<'_> {
        Layout {
            grid: &self.grid,
            missing: self.missing,
            size: self.size,
            texel_mm: self.texel_mm,
            inverse_cdf_steps: self.inverse_cdf_steps,
            knots: self.knots,
            levels: self.levels.iter().map(|l| (l.pitch_mm, l.slices.len())).collect(),
        }
    }

    /// # Errors
    /// A field outside its legal range, named.
    pub fn validate(&self) -> Result<()> {
        self.layout().validate()?;
        for (l, level) in self.levels.iter().enumerate() {
            for (k, slice) in level.slices.iter().enumerate() {
                slice.validate().map_err(|e| e.within(format!("flakes: level {l}: slice {k}")))?;
            }
        }
        Ok(())
    }
}
