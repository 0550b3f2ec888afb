//! From a flake BTF to the flake statistics of a paint.

use super::cells::Cells;
use super::lifetime::knots;
use super::{FitOptions, FitReport, Lifetime, SmoothFit, fit_smooth};
use crate::btf::{FlakeSlice, FlakeSource};
use crate::cluster::{BoxRule, cluster_levels};
use crate::color::luminance;
use crate::error::Result;
use crate::paint::{FlakeLevel, Flakes, Knots, MissingSlice, Paint};
use glam::DVec3;

/// How slices are reduced to statistics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlakeOptions {
    /// Clusters a slice, 1 to 1024; Golla & Klein suggest 50.
    pub clusters: usize,
    /// How boxes are laid around clusters.
    pub boxes: BoxRule,
    /// Steps of the inverse CDF table written for engines, 1 to 65535; Golla & Klein use 500.
    pub inverse_cdf_steps: usize,
    /// What an angle pair without a slice gives.
    pub missing: MissingSlice,
    /// What becomes of flakes as the half vector turns.
    pub lifetime: Lifetime,
}

impl Default for FlakeOptions {
    fn default() -> Self {
        Self {
            clusters: 50,
            boxes: BoxRule::MomentMatched,
            inverse_cdf_steps: 500,
            missing: MissingSlice::Zero,
            lifetime: Lifetime::Solve,
        }
    }
}

/// Who carries the mean of a slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SliceMean {
    /// Xi = fluctuation + (expectation - what the fit explains): the slice carries the residual of the fit.
    Residual,
    /// Xi of zero mean: for flakes given to another paint, whose color must stay. The fluctuation is scaled, channel by channel,
    /// by that paint's color over the BTF's own: flakes then make up the same share of its light, and light stays light
    /// between them. Unscaled, bright flakes on a dark paint would leave black holes.
    Zero,
}

/// Fits smooth part and flakes of a BTF. `tick` is called once a start of the optimizer and once a slice.
///
/// # Errors
/// Those of [`fit_smooth`] and [`fit_flakes`].
pub fn fit_btf(
    btf: &dyn FlakeSource,
    options: &FitOptions,
    statistics: &FlakeOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<(Paint, FitReport)> {
    // A simulated table has no cells filled in by repetition; it repeats itself where it is constant.
    let options = FitOptions { filled: false, ..options.clone() };
    let (smooth, report) = fit_smooth(btf.smooth(), &options, tick)?;
    let flakes = fit_flakes(btf, &smooth, SliceMean::Residual, statistics, tick)?;
    Ok((smooth.into_paint(Some(flakes), btf.provenance().clone(), &report), report))
}

/// Flake statistics of a BTF, as they lie under the coat of `smooth`, at every level of detail. `tick` is called once a
/// slice.
///
/// A finite texture has a mean of its own, off its expectation by the chance of where flakes fell; it is taken out, so that
/// the mean of a slice is exactly what `mean` says, and nothing is counted twice.
///
/// # Errors
/// Cluster numbers or a spacing of knots out of range; a coat through which no slice is seen; those of the source.
pub fn fit_flakes(
    btf: &dyn FlakeSource,
    smooth: &SmoothFit,
    mean: SliceMean,
    options: &FlakeOptions,
    tick: &(dyn Fn() + Sync),
) -> Result<Flakes> {
    let cells = Cells::new(btf, &smooth.coat)?;
    let slice = |k: usize| cell_residual(&cells, smooth, mean, k);
    let levels =
        cluster_levels(cells.grid().len(), slice, btf.size(), options.clusters, options.boxes, tick)?;
    // Texels double from level to level, a little less where a side is odd.
    let mut size = btf.size();
    let texels = size[0] * size[1];
    let knots = match options.lifetime {
        Lifetime::Solve => knots(&cells, &levels[0].slices)?,
        Lifetime::Fixed(spacing) => Some(Knots::usual(spacing)),
        Lifetime::Endless => None,
    };
    let levels = levels
        .into_iter()
        .map(|level| {
            let coarsening = texels as f64 / (size[0] * size[1]) as f64;
            size = size.map(|n| n.div_ceil(2));
            let pitch_mm = level.pitch_texels * btf.texel_mm() * coarsening.sqrt();
            FlakeLevel { pitch_mm, slices: level.slices }
        })
        .collect();
    let flakes = Flakes {
        grid: cells.grid().clone(),
        missing: options.missing,
        size: btf.size(),
        texel_mm: btf.texel_mm(),
        levels,
        inverse_cdf_steps: options.inverse_cdf_steps,
        knots,
    };
    flakes.layout().validate()?;
    Ok(flakes)
}

/// Texels of Xi of cell `k` of the paint (of slice `k`, unless the coat refracts), under the coat, linear Rec.709, 1/sr.
///
/// # Errors
/// Those of the source; a coat through which no slice is seen.
pub fn residual(
    btf: &dyn FlakeSource,
    smooth: &SmoothFit,
    mean: SliceMean,
    k: usize,
) -> Result<Vec<[f32; 3]>> {
    cell_residual(&Cells::new(btf, &smooth.coat)?, smooth, mean, k)
}

fn cell_residual(cells: &Cells, smooth: &SmoothFit, mean: SliceMean, k: usize) -> Result<Vec<[f32; 3]>> {
    let ((inner_i, inner_o), (wi, wo)) = (cells.inner(k), cells.outer(k));
    let transmittance = smooth.coat.transmittance(wi.z, wo.z);
    let slice = cells.slice(k)?;
    let FlakeSlice { fluctuation, expectation } = &*slice;
    let base = smooth.base(inner_i, inner_o);
    let expectation = DVec3::from(*expectation);
    let sum: DVec3 = fluctuation.iter().map(|t| DVec3::from(t.map(f64::from))).sum();
    let chance = sum / fluctuation.len() as f64;
    let (scale, wanted) = match mean {
        SliceMean::Residual => (DVec3::splat(1.0 / transmittance), expectation / transmittance - base),
        // Against the texture's own mean, so that scaled light stays light. Measured colors can be negative, simulated ones
        // out of gamut: flakes take no light from where there is none, and a channel nearly absent from them does not
        // count more than a hundredth of their luminance.
        SliceMean::Zero => {
            let own = expectation + chance;
            let least = (0.01 * luminance(own)).max(1e-9);
            (base.max(DVec3::ZERO) / own.max(DVec3::splat(least)), DVec3::ZERO)
        }
    };
    let texel =
        |t: &[f32; 3]| ((DVec3::from(t.map(f64::from)) - chance) * scale + wanted).as_vec3().to_array();
    Ok(fluctuation.iter().map(texel).collect())
}
