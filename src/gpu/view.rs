//! Which of a mix's flakes a frame draws from.

use crate::btf::CellSet;
use crate::error::Result;
use crate::render::{FlakeLayout, Options, RenderCoat, drawn_cells};
use crate::scene::Scene;

/// A scene that frames are drawn of, and the cells that they draw from.
#[derive(Debug)]
pub(super) struct View {
    scene: Scene,
    worn: Option<usize>,
    /// Index of refraction of a coat that refracts: others do not bend angles.
    refraction: Option<f32>,
    /// Found when the view is there for the second time: while a camera moves, all cells are realized sooner than those are found.
    cells: Option<CellSet>,
}

impl View {
    fn new(scene: &Scene, worn: Option<usize>, coat: &RenderCoat) -> Self {
        Self { scene: scene.clone(), worn, refraction: refraction(coat), cells: None }
    }

    fn is(&self, scene: &Scene, worn: Option<usize>, coat: &RenderCoat) -> bool {
        self.worn == worn && self.refraction == refraction(coat) && self.scene == *scene
    }

    /// The view that follows `last`, and its cells, finest level first; none: all. Means of slices come from no cell.
    ///
    /// # Errors
    /// Those of [`crate::render::needed_cells`].
    pub fn after(
        last: Option<Self>,
        scene: &Scene,
        worn: Option<usize>,
        coat: &RenderCoat,
        layout: &FlakeLayout,
    ) -> Result<Self> {
        match last.filter(|view| view.is(scene, worn, coat)) {
            Some(view) if view.cells.is_some() => Ok(view),
            Some(view) => {
                let options = Options { samples: 1, ..Options::default() };
                let cells = drawn_cells(scene, &options, layout, coat, worn)?;
                Ok(Self { cells: Some(cells), ..view })
            }
            None => Ok(Self::new(scene, worn, coat)),
        }
    }

    /// The cells, once they are found; none: all.
    pub fn cells(&self) -> Option<&CellSet> {
        self.cells.as_ref()
    }
}

fn refraction(coat: &RenderCoat) -> Option<f32> {
    coat.refracts.then_some(coat.ior)
}
