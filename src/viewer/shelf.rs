//! Paints ready to be rendered, made when they are first looked at and kept until they change.

use super::document::Document;
use super::measure::Instrument;
use super::state::{Shown, State};
use crate::error::{Error, Result};
use crate::mix::{BlendOptions, Mix};
use crate::paint::Paint;
use crate::render::RenderPaint;
use std::sync::Arc;

/// A paint ready to be rendered, and what an instrument reads of it. Two are the same if they are one allocation.
#[derive(Debug)]
pub struct Ready {
    /// For the renderers.
    pub paint: RenderPaint,
    /// Side of a texel of its flakes, millimetres.
    pub texel_mm: Option<f64>,
    /// L*a*b* and flop index.
    pub instrument: Instrument,
}

impl Ready {
    /// Makes a paint ready.
    ///
    /// # Errors
    /// As [`RenderPaint::new`].
    pub fn new(paint: &Paint) -> Result<Arc<Self>> {
        let texel_mm = paint.flakes.as_ref().map(|flakes| flakes.texel_mm);
        let paint = RenderPaint::new(paint)?;
        let instrument = Instrument::read(&paint);
        Ok(Arc::new(Self { paint, texel_mm, instrument }))
    }
}

/// Weights, what goes, and what came of it.
type Blended = (Vec<f64>, BlendOptions, Arc<Ready>);

/// The paints of one document, and that of the composition panel.
#[derive(Debug, Default)]
pub struct Shelf {
    paints: Vec<Option<Arc<Ready>>>,
    blend: Option<Blended>,
    recipe: Option<Arc<Ready>>,
}

impl Shelf {
    /// Another document: what was made of the last one goes.
    pub fn opened(&mut self, document: &Document) {
        self.paints = vec![None; document.paints.len()];
        self.blend = None;
    }

    /// Another paint of the composition panel.
    pub fn set_recipe(&mut self, ready: Arc<Ready>) {
        self.recipe = Some(ready);
    }

    /// Whether the composition panel has made a paint.
    pub fn has_recipe(&self) -> bool {
        self.recipe.is_some()
    }

    /// The paint that is shown.
    ///
    /// # Errors
    /// Those of blending; a paint that there is not.
    pub fn get(&mut self, shown: Shown, document: Option<&Document>, state: &State) -> Result<Arc<Ready>> {
        let none = |what: &str| Error::invalid("view", what, "none yet", "an open one");
        if shown == Shown::Recipe {
            return self.recipe.clone().ok_or_else(|| none("composition"));
        }
        let document = document.ok_or_else(|| none("paint"))?;
        match (shown, &document.mix) {
            (Shown::Paint(k), _) => self.paint(k, document),
            (_, Some(mix)) => self.blend(mix, state),
            (_, None) => self.paint(0, document),
        }
    }

    fn paint(&mut self, k: usize, document: &Document) -> Result<Arc<Ready>> {
        let (Some(slot), Some(named)) = (self.paints.get_mut(k), document.paints.get(k)) else {
            let legal = format!("0 to {}", document.paints.len().saturating_sub(1));
            return Err(Error::invalid("view", "paint", k, legal));
        };
        if let Some(ready) = slot {
            return Ok(ready.clone());
        }
        let ready = Ready::new(&named.paint).map_err(|e| e.within(&named.name))?;
        Ok(slot.insert(ready).clone())
    }

    fn blend(&mut self, mix: &Mix, state: &State) -> Result<Arc<Ready>> {
        if let Some((weights, options, ready)) = &self.blend
            && *weights == state.weights
            && *options == state.blend
        {
            return Ok(ready.clone());
        }
        let ready = Ready::new(&mix.blend_with(&state.weights, &state.blend)?)?;
        self.blend = Some((state.weights.clone(), state.blend, ready.clone()));
        Ok(ready)
    }
}
