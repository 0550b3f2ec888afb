//! Paints ready to be looked at. Pictures of a blend are made by the GPU; its values, which instruments and the pointer ask for,
//! are made behind the window when the hand rests.

use super::document::Document;
use super::job::Job;
use super::measure::Instrument;
use super::state::{Shown, State};
use super::worn::{BLENDS, Blend, Worn};
use crate::error::{Error, Result};
use crate::paint::Paint;
use crate::render::RenderPaint;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Weights must stay as they are for so long before a blend is made on the CPU.
const REST: Duration = Duration::from_millis(150);

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

/// A blend on its way to the CPU.
#[derive(Default)]
struct Wanted {
    /// The blend that is asked for, and since when.
    now: Option<(Blend, Instant)>,
    /// The last one made.
    made: Option<(Blend, Arc<Ready>)>,
    job: Option<(Blend, Job<Arc<Ready>>)>,
}

impl Wanted {
    /// The last one made, if it is the one asked for.
    fn current(&self) -> Option<&Arc<Ready>> {
        let ((now, _), (made, ready)) = (self.now.as_ref()?, self.made.as_ref()?);
        (now == made).then_some(ready)
    }

    fn ask(&mut self, blend: &Blend) {
        if self.now.as_ref().is_none_or(|(now, _)| now != blend) {
            self.now = Some((blend.clone(), Instant::now()));
        }
    }

    /// Starts what is due and takes what is done.
    fn step<W: Fn() + Send + Sync + 'static>(&mut self, wake: impl Fn() -> W) -> Result<()> {
        if let Some(result) = self.job.as_ref().and_then(|(_, job)| job.poll())
            && let Some((blend, _)) = self.job.take()
        {
            self.made = Some((blend, result?));
        }
        if let Some((now, since)) = &self.now
            && self.job.is_none()
            && self.current().is_none()
            && since.elapsed() >= REST
        {
            let blend = now.clone();
            let job = Job::start(wake(), move |progress| {
                let _tick = progress.begin("reading the blend", 1);
                blend.ready()
            });
            self.job = Some((now.clone(), job));
        }
        Ok(())
    }
}

/// The paints of one document, its blends, and that of the composition panel.
#[derive(Default)]
pub struct Shelf {
    paints: Vec<Option<Arc<Ready>>>,
    blends: [Wanted; BLENDS],
    recipe: Option<Arc<Ready>>,
    /// The GPU does not take the mix: its blends are made here, at once.
    blends_here: bool,
}

impl Shelf {
    /// Another document: what was made of the last one goes.
    pub fn opened(&mut self, document: &Document) {
        self.paints = vec![None; document.paints.len()];
        self.blends = Default::default();
        self.blends_here = false;
    }

    /// Another paint of the composition panel.
    pub fn set_recipe(&mut self, ready: Arc<Ready>) {
        self.recipe = Some(ready);
    }

    /// Whether the composition panel has made a paint.
    pub fn has_recipe(&self) -> bool {
        self.recipe.is_some()
    }

    /// From now on blends of this document are made here: the GPU does not take its mix.
    pub fn blend_here(&mut self) {
        self.blends_here = true;
    }

    /// What is shown, for a picture. Nothing is blended, unless the GPU cannot do it.
    ///
    /// # Errors
    /// A paint that there is not; without the GPU those of blending.
    pub fn worn(&mut self, shown: Shown, document: Option<&Document>, state: &State) -> Result<Worn> {
        let none = |what: &str| Error::invalid("view", what, "none yet", "an open one");
        if shown == Shown::Recipe {
            return self.recipe.clone().map(Worn::Paint).ok_or_else(|| none("composition"));
        }
        let document = document.ok_or_else(|| none("paint"))?;
        match (blend(shown, document, state), shown) {
            (Some(blend), _) if self.blends_here => {
                let wanted = &mut self.blends[blend.slot];
                wanted.ask(&blend);
                if let Some(ready) = wanted.current() {
                    return Ok(Worn::Paint(ready.clone()));
                }
                let ready = blend.ready()?;
                wanted.made = Some((blend, ready.clone()));
                Ok(Worn::Paint(ready))
            }
            (Some(blend), _) => Ok(Worn::Blend(blend)),
            (None, Shown::Paint(k)) => self.paint(k, document).map(Worn::Paint),
            (None, _) => self.paint(0, document).map(Worn::Paint),
        }
    }

    /// What is worn, with its values, if they are there; a blend is asked for until they are.
    pub fn ready(&mut self, worn: &Worn) -> Option<Arc<Ready>> {
        match worn {
            Worn::Paint(ready) => Some(ready.clone()),
            Worn::Blend(blend) => {
                self.blends[blend.slot].ask(blend);
                self.blends[blend.slot].current().cloned()
            }
        }
    }

    /// The same, or what was known last of a blend whose values are on their way.
    pub fn last(&mut self, worn: &Worn) -> Option<Arc<Ready>> {
        let ready = self.ready(worn);
        match worn {
            Worn::Blend(blend) if ready.is_none() => {
                self.blends[blend.slot].made.as_ref().map(|(_, ready)| ready.clone())
            }
            _ => ready,
        }
    }

    /// Starts what is due and takes what is done behind the window. `wake` is called when there will be more.
    ///
    /// # Errors
    /// Those of blending.
    pub fn step<W: Fn() + Send + Sync + 'static>(&mut self, wake: impl Fn() -> W) -> Result<()> {
        self.blends.iter_mut().try_for_each(|wanted| wanted.step(&wake))
    }

    /// How long the hand must rest until a blend is read.
    pub fn rest(&self) -> Option<Duration> {
        let waits = |w: &&Wanted| w.job.is_none() && w.current().is_none();
        let since = self.blends.iter().filter(waits).filter_map(|w| w.now.as_ref());
        since.map(|(_, since)| REST.saturating_sub(since.elapsed())).min()
    }

    /// Whether values of a blend are on their way.
    pub fn is_reading(&self) -> bool {
        self.blends.iter().any(|wanted| wanted.now.is_some() && wanted.current().is_none())
    }

    /// The paint number `k` of the document.
    ///
    /// # Errors
    /// As [`Ready::new`]; no such paint.
    pub fn paint(&mut self, k: usize, document: &Document) -> Result<Arc<Ready>> {
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
}

/// The blend that is shown; none: another paint, or there is nothing to blend.
fn blend(shown: Shown, document: &Document, state: &State) -> Option<Blend> {
    let mix = document.mix.clone()?;
    let (weights, options) = (state.weights.clone(), state.blend);
    match shown {
        Shown::Blend => Some(Blend { mix, slot: 0, weights, options }),
        Shown::Kept => {
            let (weights, options) = state.kept.clone().unwrap_or((weights, options));
            Some(Blend { mix, slot: 1, weights, options })
        }
        Shown::Paint(_) | Shown::Recipe => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::document::NamedPaint;
    use super::super::job::Progress;
    use super::*;
    use crate::brdf::{ClearCoat, ColorTable};

    fn document() -> Document {
        let plain = |name: &str, diffuse: f64| NamedPaint {
            name: name.to_owned(),
            paint: Arc::new(Paint {
                coat: ClearCoat::NONE,
                diffuse,
                lobes: Vec::new(),
                colors: ColorTable::white(),
                flakes: None,
                provenance: serde_json::Value::Null,
            }),
        };
        Document::new(vec![plain("a", 0.2), plain("b", 0.6)], &Progress::silent()).unwrap()
    }

    fn state(weight: f64) -> State {
        State { weights: vec![weight, 1.0 - weight], ..State::default() }
    }

    #[test]
    fn a_blend_goes_to_the_gpu_as_weights_and_its_values_follow_when_it_rests() {
        let document = document();
        let mut shelf = Shelf::default();
        shelf.opened(&document);
        let mut worn = |weight: f64| shelf.worn(Shown::Blend, Some(&document), &state(weight)).unwrap();
        let (first, second) = (worn(0.5), worn(0.25));
        assert!(matches!(&first, Worn::Blend(blend) if blend.weights == [0.5, 0.5]), "{first:?}");
        assert!(first == worn(0.5) && first != second);
        assert!(shelf.ready(&second).is_none() && shelf.is_reading(), "nobody waits for a blend");
        shelf.step(|| || ()).unwrap();
        assert!(shelf.blends[0].job.is_none(), "not while the hand moves");
        while shelf.ready(&second).is_none() {
            shelf.step(|| || ()).unwrap();
            std::thread::yield_now();
        }
        // f32 of the renderer.
        assert!((shelf.ready(&second).unwrap().paint.diffuse - 0.5).abs() < 1e-6);
        assert!(shelf.ready(&first).is_none() && shelf.last(&first).is_some(), "the last values stay");
    }

    #[test]
    fn a_mix_that_the_gpu_refuses_is_blended_here() {
        let document = document();
        let mut shelf = Shelf::default();
        shelf.opened(&document);
        shelf.blend_here();
        let Worn::Paint(ready) = shelf.worn(Shown::Blend, Some(&document), &state(0.75)).unwrap() else {
            panic!("a paint")
        };
        assert!((ready.paint.diffuse - 0.3).abs() < 1e-6);
        let again = shelf.worn(Shown::Blend, Some(&document), &state(0.75)).unwrap();
        assert!(again == Worn::Paint(ready), "once");
        shelf.opened(&document);
        let worn = shelf.worn(Shown::Blend, Some(&document), &state(0.75)).unwrap();
        assert!(matches!(worn, Worn::Blend(_)), "another document is tried anew");
    }

    #[test]
    fn kept_weights_stay_beside_those_that_move() {
        let document = document();
        let mut shelf = Shelf::default();
        shelf.opened(&document);
        let kept = State { kept: Some((vec![1.0, 0.0], state(0.5).blend)), ..state(0.5) };
        let Worn::Blend(blend) = shelf.worn(Shown::Kept, Some(&document), &kept).unwrap() else {
            panic!("a blend")
        };
        assert_eq!((blend.slot, blend.weights), (1, vec![1.0, 0.0]));
    }
}
