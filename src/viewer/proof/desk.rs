//! What is open and under way, without a window: files are opened and saved here, and complaints gather.

use super::super::job::Job;
use super::super::panels::status::{Message, tell};
use super::super::save::Saved;
use super::super::start::Start;
use super::super::waker::Waker;
use super::ink_set::{InkSet, PLACES};
use super::opened::{Image, Opened};
use super::request::{Dots, Inked, Order, Request};
use super::save::Save;
use super::state::State;
use crate::error::{Error, Result};
use crate::render::InkModel;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is open and under way.
#[derive(Default)]
pub struct Desk {
    /// What a user sets.
    pub state: State,
    /// What is printed; always there while the window is.
    pub image: Option<Arc<Image>>,
    /// The inks; always there while the window is.
    pub inks: Option<InkSet>,
    /// What is to be told, newest last.
    pub messages: Vec<Message>,
    /// What wakes the window.
    pub waker: Waker,
    opening: VecDeque<Job<Opened>>,
    saving: Option<Job<Saved>>,
}

impl Desk {
    /// Reads what the window starts with.
    ///
    /// # Errors
    /// Those of reading the image and the inks.
    pub fn new(start: &Start, image: &Path) -> Result<Self> {
        let image = Some(Arc::new(Image::read(image)?));
        Ok(Self { image, inks: Some(InkSet::read(start.inks.as_deref())?), ..Self::default() })
    }

    /// Begins to read files.
    pub fn open(&mut self, files: impl IntoIterator<Item = PathBuf>) {
        for file in files {
            let work = move |progress: &_| Opened::read(&file, progress);
            self.opening.push_back(Job::start(self.waker.function(), work));
        }
    }

    /// Begins to render pictures anew and to save them.
    pub fn save(&mut self, save: Save) {
        if self.saving.is_some() {
            let e = Error::invalid("save", "work under way", "another one", "one at a time");
            return self.tell(e.to_string(), true);
        }
        self.saving = Some(Job::start(self.waker.function(), move |progress| save.run(progress)));
    }

    /// Takes what threads have finished, in the order in which files were named.
    pub fn step(&mut self) {
        while let Some(result) = self.opening.front().and_then(Job::poll) {
            self.opening.pop_front();
            if let Err(e) = result.and_then(|opened| self.take(opened)) {
                self.tell(e.to_string(), true);
            }
        }
        if let Some(result) = self.saving.as_ref().and_then(Job::poll) {
            self.saving = None;
            match result {
                Ok(saved) => self.tell(saved.to_string(), false),
                Err(e) => self.tell(e.to_string(), true),
            }
        }
    }

    fn take(&mut self, opened: Opened) -> Result<()> {
        match opened {
            Opened::Image(image) => self.image = Some(image),
            Opened::Emission(name, spectrum) => self.state.set_emission(name, *spectrum),
            Opened::Ink(ink) => {
                let name = ink.name().to_owned();
                if let Some(inks) = &mut self.inks {
                    let place = inks.replace(*ink)?;
                    self.tell(format!("{name} is the {} ink now", PLACES[place]), false);
                }
            }
        }
        Ok(())
    }

    /// Says something once.
    pub fn tell(&mut self, text: String, is_error: bool) {
        tell(&mut self.messages, text, is_error);
    }

    /// What is open, for the title of the window.
    pub fn title(&self) -> String {
        let name = self.image.as_ref().and_then(|image| image.path.file_name());
        name.map_or_else(|| "carpaint".to_owned(), |name| format!("{} - carpaint", name.to_string_lossy()))
    }

    /// Whether files are read or written.
    pub fn is_busy(&self) -> bool {
        !self.opening.is_empty() || self.saving.is_some()
    }

    /// What is under way, and the share of it that is done.
    pub fn work(&self) -> Vec<(String, f32)> {
        self.opening.iter().map(Job::progress).chain(self.saving.as_ref().map(Job::progress)).collect()
    }

    /// What a picture of this size shows, in inks that reflect like this; none where nothing is open.
    ///
    /// # Errors
    /// A shape that there is not.
    pub fn request(&self, model: InkModel, size: [usize; 2]) -> Result<Option<Request>> {
        let (Some(image), Some(inks), state) = (&self.image, &self.inks, &self.state) else {
            return Ok(None);
        };
        let roughness = (!state.own_roughness).then_some(state.roughness);
        Ok(Some(Request {
            dots: Dots { image: image.clone(), method: state.method, cell: state.cell },
            inked: Inked { inks: inks.inks().clone(), roughness, look: state.look(model) },
            paper: state.paper(),
            scene: state.scene(size, image.proportions())?,
        }))
    }

    /// What the pictures of these sizes show, one a model that is shown; none where nothing is open or there is no room.
    ///
    /// # Errors
    /// As [`Desk::request`].
    pub fn order(&self, sizes: &[[usize; 2]]) -> Result<Option<Order>> {
        if sizes.iter().flatten().any(|side| *side == 0) {
            return Ok(None);
        }
        let models = self.state.shown_models().iter().zip(sizes);
        let requests = models.map(|(model, size)| self.request(*model, *size));
        let requests: Option<Vec<Request>> = requests.collect::<Result<_>>()?;
        Ok(requests.map(|requests| Order { requests, stops: self.state.stops() }))
    }
}

#[cfg(test)]
pub mod tests {
    use super::super::super::choices::Layout;
    use super::*;
    use crate::brdf::Ink;
    use crate::color::Wavelengths;

    /// A desk with a small image on it.
    pub fn desk() -> Desk {
        let pixels = (0..48).map(|k| [k as f32 / 47.0, 0.4, 1.0 - k as f32 / 47.0]).collect();
        let image = Image { path: "a.png".into(), size: [8, 6], pixels };
        let inks = Some(InkSet::read(None).unwrap());
        Desk { image: Some(Arc::new(image)), inks, ..Desk::default() }
    }

    #[test]
    fn an_order_has_a_picture_for_each_model_that_is_shown() {
        let mut desk = desk();
        let [one, two] = [[9, 7]; 2];
        assert_eq!(desk.order(&[one]).unwrap().unwrap().requests.len(), 1);
        desk.state.layout = Layout::Split;
        let requests = desk.order(&[one, two]).unwrap().unwrap().requests;
        assert_eq!(requests.len(), 2);
        assert_eq!(requests[0].scene, requests[1].scene, "the same scene");
        assert_eq!(requests[1].inked.look.model, InkModel::Schlick);
        assert!(desk.order(&[one, [0, 7]]).unwrap().is_none());
        assert!(Desk::default().order(&[one]).unwrap().is_none());
    }

    #[test]
    fn what_is_opened_takes_the_place_of_what_it_is_like() {
        let mut desk = desk();
        let before = desk.order(&[[4, 4]]).unwrap();
        let at = Wavelengths::new(vec![380.0, 480.0, 530.0, 580.0, 780.0]).unwrap();
        let green = Ink::new("green", 0.5, at, vec![0.0, 0.0, 1.0, 0.0, 0.0], vec![0.0; 5]).unwrap();
        desk.take(Opened::Ink(Box::new(green.clone()))).unwrap();
        assert_eq!(desk.inks.as_ref().unwrap().inks()[1], green);
        assert!(desk.messages[0].text.contains("green ink") && !desk.messages[0].is_error);
        assert_ne!(desk.order(&[[4, 4]]).unwrap(), before);
        desk.open(["no such file.csv".into()]);
        while desk.is_busy() {
            desk.step();
        }
        assert!(desk.messages[1].is_error && desk.messages[1].text.contains("no such file.csv"));
    }
}
