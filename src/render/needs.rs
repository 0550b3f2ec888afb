//! What a picture needs of a paint: the cells of its flakes that some sample of some pixel draws from.
//!
//! The rays are those of [`super::render()`] and the angles its own f32 numbers, so that a picture of a paint with only these
//! cells is that of the whole paint, to the bit.

use super::flake_layout::FlakeLayout;
use super::image::{Options, Stage};
use super::paint::{RenderCoat, RenderPaint};
use super::shade::Geometry;
use crate::btf::CellSet;
use crate::error::{Error, Result};
use crate::mix::{BlendOptions, Mix};
use crate::paint::{Flakes, Paint};
use crate::scene::Scene;
use rayon::prelude::*;

/// The cells of flakes so laid out, under such a coat, that a picture of the scene draws from.
///
/// Lamps draw from the levels of their footprints. Surroundings show the mean of every slice, and that is the coarsest level:
/// it always belongs to the set.
///
/// # Errors
/// An illegal scene or option.
pub fn needed_cells(
    scene: &Scene,
    options: &Options,
    layout: &FlakeLayout,
    coat: &RenderCoat,
) -> Result<CellSet> {
    scene.validate()?;
    options.validate()?;
    let mut cells = layout.no_cells();
    cells.insert_level(cells.levels() - 1);
    if !options.flakes {
        return Ok(cells);
    }
    let stage = Stage::new(scene, options);
    let none = || layout.no_cells();
    let joined = |mut a: CellSet, b: CellSet| {
        a.extend(&b);
        a
    };
    let drawn = (0..scene.size[1])
        .into_par_iter()
        .fold(none, |mut cells, y| {
            stage.patches_of_row(y, |patch| {
                let detail = layout.detail(patch.footprint.surface.footprint);
                let wo = patch.seen_from;
                for wi in stage.lamps(patch).map(|lamp| lamp.local(&patch.to_surface)) {
                    if wi.z > 0.0 && wo.z > 0.0 {
                        let g = Geometry::of(coat.inner(wi), coat.inner(wo));
                        layout.insert_cells(&mut cells, &detail, g.theta_h, g.theta_i);
                    }
                }
            });
            cells
        })
        .reduce(none, joined);
    cells.extend(&drawn);
    Ok(cells)
}

/// # Errors
/// A cell that the picture draws from and that was left out of the paint.
pub(super) fn check_cells(scene: &Scene, options: &Options, paint: &RenderPaint) -> Result<()> {
    let Some(flakes) = paint.flakes.as_ref().filter(|f| !f.is_whole()) else { return Ok(()) };
    let needed = needed_cells(scene, options, flakes.layout(), &paint.coat)?;
    match needed.first_beyond(&flakes.cells()) {
        None => Ok(()),
        Some((level, slice)) => {
            let place = format!("paint: flakes: level {level}: slice {slice}");
            let legal = "statistics: this picture draws from it (the paint was made for another scene, size or number of rays)";
            Err(Error::invalid(place, "slice", "left out", legal))
        }
    }
}

/// The cells of a paint that a picture of the scene draws from; none if it has no flakes.
///
/// # Errors
/// An illegal scene or option.
pub fn needed_of_paint(scene: &Scene, options: &Options, paint: &Paint) -> Result<Option<CellSet>> {
    let needs = |f: &Flakes| needed_cells(scene, options, &FlakeLayout::of(f), &RenderCoat::new(&paint.coat));
    paint.flakes.as_ref().map(needs).transpose()
}

/// The cells of a mix that a picture of its blend at these weights draws from; none if it has no flakes.
///
/// # Errors
/// An illegal scene or option; weights that [`Mix::blend`] refuses.
pub fn needed_of_blend(
    scene: &Scene,
    options: &Options,
    mix: &Mix,
    weights: &[f64],
    blend: &BlendOptions,
) -> Result<Option<CellSet>> {
    let Some(flakes) = &mix.flakes else { return Ok(None) };
    let coat = RenderCoat::new(&mix.blended_coat(weights, blend)?);
    needed_cells(scene, options, &FlakeLayout::of_mix(flakes), &coat).map(Some)
}
