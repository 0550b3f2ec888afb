//! What a picture needs of a paint: the cells of its flakes that some sample of some pixel draws from.
//!
//! The rays are those of [`super::render()`] and the angles its own f32 numbers, so that a picture of a paint with only these
//! cells is that of the whole paint, to the bit.

use super::flake_layout::FlakeLayout;
use super::image::{Options, Patch, Stage};
use super::paint::{RenderCoat, RenderPaint};
use super::shade::Geometry;
use crate::btf::CellSet;
use crate::error::{Error, Result};
use crate::mix::{BlendOptions, Mix};
use crate::paint::{Flakes, Paint};
use crate::scene::Scene;
use rayon::prelude::*;

/// The cells of flakes so laid out, under such a coat, that a picture of the scene draws from: where an object wears the paint
/// numbered `worn`, or anywhere without that number. In a scene without objects all paints are worn alike, as number 0.
///
/// Lamps and surroundings draw from the levels of footprints. Surroundings show the mean of every slice, too, and that is the
/// coarsest level: it always belongs to the set.
///
/// # Errors
/// An illegal scene or option, a file of the scene that cannot be read.
pub fn needed_cells(
    scene: &Scene,
    options: &Options,
    layout: &FlakeLayout,
    coat: &RenderCoat,
    worn: Option<usize>,
) -> Result<CellSet> {
    let mut cells = drawn_cells(scene, options, layout, coat, worn)?;
    cells.insert_level(cells.levels() - 1);
    Ok(cells)
}

/// As [`needed_cells`], without those that show their mean only.
///
/// # Errors
/// Those of [`needed_cells`].
pub(crate) fn drawn_cells(
    scene: &Scene,
    options: &Options,
    layout: &FlakeLayout,
    coat: &RenderCoat,
    worn: Option<usize>,
) -> Result<CellSet> {
    scene.validate()?;
    options.validate()?;
    Ok(Stage::new(scene, options)?.drawn_cells(layout, coat, worn))
}

impl Stage<'_> {
    /// As [`drawn_cells`].
    fn drawn_cells(&self, layout: &FlakeLayout, coat: &RenderCoat, worn: Option<usize>) -> CellSet {
        if !self.options.flakes {
            return layout.no_cells();
        }
        let none = || layout.no_cells();
        let joined = |mut a: CellSet, b: CellSet| {
            a.extend(&b);
            a
        };
        (0..self.scene.size[1])
            .into_par_iter()
            .fold(none, |mut cells, y| {
                self.patches_of_row(y, |patch| {
                    if worn.is_none_or(|k| k == patch.paint) {
                        self.insert_cells(&mut cells, patch, layout, coat);
                    }
                });
                cells
            })
            .reduce(none, joined)
    }

    /// The cells that lamps and surroundings draw from on a patch.
    fn insert_cells(&self, cells: &mut CellSet, patch: &Patch, layout: &FlakeLayout, coat: &RenderCoat) {
        let detail = layout.detail(patch.footprint.surface.footprint);
        for [wi, wo] in self.flake_directions(patch) {
            if wi.z > 0.0 && wo.z > 0.0 {
                let g = Geometry::of(coat.inner(wi), coat.inner(wo));
                layout.insert_cells(cells, &detail, g.theta_h, g.theta_i);
            }
        }
    }

    /// # Errors
    /// A cell that the picture draws from and that was left out of the paint, which is worn as that number.
    pub(super) fn check_cells(&self, paint: &RenderPaint, worn: Option<usize>) -> Result<()> {
        let Some(flakes) = paint.flakes.as_ref().filter(|f| !f.is_whole()) else { return Ok(()) };
        let mut needed = self.drawn_cells(flakes.layout(), &paint.coat, worn);
        needed.insert_level(needed.levels() - 1);
        match needed.first_beyond(&flakes.cells()) {
            None => Ok(()),
            Some((level, slice)) => {
                let place = format!("paint: flakes: level {level}: slice {slice}");
                let legal = "statistics: this picture draws from it (the paint was made for another scene, size or number of rays)";
                Err(Error::invalid(place, "slice", "left out", legal))
            }
        }
    }
}

/// The cells of a paint that a picture of the scene draws from; none if it has no flakes. `worn`: see [`needed_cells`].
///
/// # Errors
/// Those of [`needed_cells`].
pub fn needed_of_paint(
    scene: &Scene,
    options: &Options,
    paint: &Paint,
    worn: Option<usize>,
) -> Result<Option<CellSet>> {
    let coat = RenderCoat::new(&paint.coat);
    let needs = |f: &Flakes| needed_cells(scene, options, &FlakeLayout::of(f), &coat, worn);
    paint.flakes.as_ref().map(needs).transpose()
}

/// The cells of a mix that a picture of its blend at these weights draws from, whichever object wears it; none if it has no
/// flakes.
///
/// # Errors
/// Those of [`needed_cells`]; weights that [`Mix::blend`] refuses.
pub fn needed_of_blend(
    scene: &Scene,
    options: &Options,
    mix: &Mix,
    weights: &[f64],
    blend: &BlendOptions,
) -> Result<Option<CellSet>> {
    let Some(flakes) = &mix.flakes else { return Ok(None) };
    let coat = RenderCoat::new(&mix.blended_coat(weights, blend)?);
    needed_cells(scene, options, &FlakeLayout::of_mix(flakes), &coat, None).map(Some)
}
