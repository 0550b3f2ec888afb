//! What is open and what is under way, without a window: files are opened and saved here, and complaints gather.

use super::beside::Beside;
use super::demo::demo;
use super::document::Document;
use super::job::{Job, Progress};
use super::kind::Kind;
use super::kitchen::Kitchen;
use super::panels::status::{Message, tell};
use super::save::{self, Saved};
use super::shelf::{Ready, Shelf};
use super::start::{Start, check_weights};
use super::state::{Shown, State};
use super::waker::Waker;
use super::worn::Worn;
use crate::error::{Error, Result};
use eframe::egui::DroppedFileHandle;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// What the panel on the left is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tab {
    /// The mix and its weights.
    #[default]
    Mix,
    /// Layers of paint.
    Composition,
    /// Opening and saving.
    Files,
}

/// What is open and under way.
#[derive(Default)]
pub struct Desk {
    /// What a user sets.
    pub state: State,
    /// The paints.
    pub document: Option<Document>,
    /// Paints ready to be looked at.
    pub shelf: Shelf,
    /// The composition being edited.
    pub kitchen: Kitchen,
    /// What the panel on the left is about.
    pub tab: Tab,
    /// What is to be told, newest last.
    pub messages: Vec<Message>,
    /// What wakes the window.
    pub waker: Waker,
    loading: Option<Job<Document>>,
    beside: VecDeque<Job<Beside>>,
    saving: Option<Job<Saved>>,
    /// Weights of the next document.
    weights: Option<Vec<f64>>,
}

impl Desk {
    /// Begins to read what the window starts with.
    pub fn new(start: &Start) -> Self {
        let mut desk = Self { weights: start.weights.clone(), ..Self::default() };
        let kinds = start.files.iter().map(|file| Kind::of(file));
        let has_paint = kinds.flatten().any(|kind| matches!(kind, Kind::Paint | Kind::Composition));
        if !has_paint {
            desk.loading = Some(Job::start(desk.waker.function(), demo));
        }
        desk.open(&start.files, false);
        if let Some(scene) = &start.scene {
            desk.open_beside(scene.clone(), Kind::Scene);
        }
        desk
    }

    /// Opens files: paints and mixes in place of what is open, or beside it if `adds`.
    pub fn open(&mut self, files: &[PathBuf], adds: bool) {
        let mut paints = Vec::new();
        for file in files {
            match Kind::of(file) {
                Ok(Kind::Paint) => paints.push(file.clone()),
                Ok(kind) => self.open_beside(file.clone(), kind),
                Err(e) => self.fail(&e),
            }
        }
        if !paints.is_empty() {
            let open = self.document.clone().filter(|_| adds);
            let work = move |progress: &_| Document::read(&paints, open.as_ref(), progress);
            self.loading = Some(Job::start(self.waker.function(), work));
        }
    }

    fn open_beside(&mut self, file: PathBuf, kind: Kind) {
        let work = move |progress: &_| Beside::read(&file, kind, progress);
        self.beside.push_back(Job::start(self.waker.function(), work));
    }

    /// Opens files that were dropped on the window.
    pub fn dropped(&mut self, files: &[DroppedFileHandle]) {
        let files: Vec<PathBuf> = files.iter().map(|file| file.path().to_owned()).collect();
        self.open(&files, false);
    }

    /// Takes what threads have finished, and starts what is due.
    pub fn step(&mut self) {
        if let Some(result) = self.loading.as_ref().and_then(Job::poll) {
            self.loading = None;
            let opened = result.and_then(|document| self.opened(document));
            self.note(opened);
        }
        // A scene wears the paints that were named with it.
        while self.loading.is_none()
            && let Some(result) = self.beside.front().and_then(Job::poll)
        {
            self.beside.pop_front();
            let taken = result.and_then(|beside| self.take(beside));
            self.note(taken);
        }
        let waker = self.waker.clone();
        match self.kitchen.step(|| waker.function()) {
            Some(Ok(ready)) => self.shelf.set_recipe(ready),
            Some(Err(e)) => self.fail(&e),
            None => {}
        }
        let read = self.shelf.step(|| waker.function());
        self.note(read);
        if let Some(result) = self.saving.as_ref().and_then(Job::poll) {
            self.saving = None;
            let told = result.map(|saved| self.tell(saved.to_string(), false));
            self.note(told);
        }
    }

    /// When there will be something to do, though nothing happens.
    pub fn rest(&self) -> Option<Duration> {
        [self.kitchen.is_resting(), self.shelf.rest()].into_iter().flatten().min()
    }

    fn opened(&mut self, document: Document) -> Result<()> {
        let n = document.paints.len();
        self.shelf.opened(&document);
        self.document = Some(document);
        self.state.opened(n)?;
        if let Some(weights) = self.weights.take() {
            check_weights(&weights, Some(n))?;
            self.state.extrapolates |= weights.iter().any(|w| !(0.0..=1.0).contains(w));
            self.state.weights = weights;
        }
        Ok(())
    }

    fn take(&mut self, beside: Beside) -> Result<()> {
        match beside {
            Beside::Composition(composition, name) => {
                self.kitchen.open(*composition, &name);
                self.tab = Tab::Composition;
                self.state.shown[0] = Shown::Recipe;
            }
            Beside::Surroundings(path) => self.state.set_panorama(path),
            Beside::Mesh(path) => self.state.set_mesh(path),
            Beside::Scene(staged) => {
                let camera = staged.check_camera();
                self.state.set_scene(*staged)?;
                camera?;
            }
        }
        Ok(())
    }

    /// Says what is wrong, if something is.
    pub fn note(&mut self, outcome: Result<()>) {
        if let Err(e) = outcome {
            self.fail(&e);
        }
    }

    /// Says what is wrong.
    pub fn fail(&mut self, error: &Error) {
        self.tell(error.to_string(), true);
    }

    /// Says something once.
    pub fn tell(&mut self, text: String, is_error: bool) {
        tell(&mut self.messages, text, is_error);
    }

    /// What is open, for the title of the window.
    pub fn title(&self) -> String {
        match &self.document {
            Some(document) => format!("{} - carpaint", document.title()),
            None => "carpaint".to_owned(),
        }
    }

    /// Whether paints are on their way.
    pub fn makes_paints(&self) -> bool {
        self.loading.is_some() || self.kitchen.progress().is_some()
    }

    /// Whether files are read or written, or values of a blend are on their way.
    pub fn is_busy(&self) -> bool {
        let has_files = self.loading.is_some() || !self.beside.is_empty() || self.saving.is_some();
        has_files || self.shelf.is_reading()
    }

    /// What is under way, and the share of it that is done.
    pub fn work(&self) -> Vec<(String, f32)> {
        let beside = self.beside.iter().map(Job::progress);
        let [loading, kitchen] = [self.loading.as_ref().map(Job::progress), self.kitchen.progress()];
        let saving = self.saving.as_ref().map(Job::progress);
        loading.into_iter().chain(beside).chain(saving).chain(kitchen).collect()
    }

    /// What the objects of a picture wear that shows this paint, in the order in which they name it.
    ///
    /// # Errors
    /// A paint that there is not.
    pub fn worn(&mut self, shown: Shown) -> Result<Vec<Worn>> {
        let all = self.state.worn(shown)?;
        all.into_iter().map(|one| self.shelf.worn(one, self.document.as_ref(), &self.state)).collect()
    }

    /// A paint on show, if it can be had.
    pub fn one(&mut self, shown: Shown) -> Option<Worn> {
        self.shelf.worn(shown, self.document.as_ref(), &self.state).ok()
    }

    /// The paints as they are, without those that cannot be had.
    pub fn paints(&mut self) -> Vec<Option<Arc<Ready>>> {
        let Some(document) = &self.document else { return Vec::new() };
        (0..document.paints.len()).map(|k| self.shelf.paint(k, document).ok()).collect()
    }

    /// From now on blends are made by the CPU: why the GPU does not take the mix.
    pub fn blend_here(&mut self, why: &Error) {
        self.shelf.blend_here();
        self.tell(format!("blends are made by the CPU, which takes longer: {why}"), true);
    }

    /// Renders pictures and saves them, behind the window.
    ///
    /// # Errors
    /// Something else is being saved.
    pub fn save_picture(&mut self, order: save::Order) -> Result<()> {
        self.save(move |progress| order.run(progress))
    }

    /// Saves the blend, behind the window.
    ///
    /// # Errors
    /// Nothing is open; something else is being saved.
    pub fn save_paint(&mut self, path: PathBuf) -> Result<()> {
        let Some(document) = self.document.clone() else {
            return Err(Error::invalid("save paint", "paint", "none", "an open one"));
        };
        let (weights, options) = (self.state.weights.clone(), self.state.blend);
        self.save(move |progress| {
            let _tick = progress.begin("saving the paint", 1);
            let paint = match &document.mix {
                Some(mix) => mix.blend_with(&weights, &options)?,
                None => (*document.paints[0].paint).clone(),
            };
            save::paint(&paint, &path)
        })
    }

    fn save(&mut self, work: impl FnOnce(&Progress) -> Result<Saved> + Send + 'static) -> Result<()> {
        if self.saving.is_some() {
            return Err(Error::invalid("save", "work", "another file", "one at a time"));
        }
        self.saving = Some(Job::start(self.waker.function(), work));
        Ok(())
    }

    /// Saves the composition.
    ///
    /// # Errors
    /// As [`Kitchen::save`].
    pub fn save_composition(&mut self) -> Result<()> {
        let text = self.kitchen.save()?;
        self.tell(text, false);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::state::Object;
    use super::*;
    use crate::brdf::{ClearCoat, ColorTable};
    use crate::paint::Paint;
    use eframe::egui::{DroppedFile, RawInput};
    use std::path::Path;

    /// A file that a hand let go of over the window.
    #[derive(Debug)]
    struct Dropped(PathBuf);

    impl DroppedFile for Dropped {
        fn path(&self) -> &Path {
            &self.0
        }

        fn bytes(&self) -> std::result::Result<Vec<u8>, String> {
            std::fs::read(&self.0).map_err(|e| e.to_string())
        }
    }

    /// Drops files as the window gets them, and waits until they are read.
    fn drop_on(desk: &mut Desk, files: &[PathBuf]) {
        let mut input = RawInput::default();
        for file in files {
            input.dropped_files.push(Arc::new(Dropped(file.clone())));
        }
        desk.dropped(&input.dropped_files);
        while desk.loading.is_some() || !desk.beside.is_empty() {
            desk.step();
            std::thread::yield_now();
        }
    }

    fn paint(diffuse: f64) -> Paint {
        let (coat, lobes, colors) = (ClearCoat::NONE, Vec::new(), ColorTable::white());
        Paint { coat, diffuse, lobes, colors, flakes: None, provenance: serde_json::Value::Null }
    }

    fn fixture(name: &str) -> PathBuf {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fixtures").join(name)
    }

    #[test]
    fn dropped_files_are_opened_as_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        paint(0.1).write(&at("a.paint.exr")).unwrap();
        paint(0.3).write(&at("b.paint.exr")).unwrap();
        let mut desk = Desk::default();
        drop_on(&mut desk, &[at("a.paint.exr"), at("b.paint.exr")]);
        let document = desk.document.clone().unwrap();
        assert_eq!(
            (document.title().as_str(), desk.state.weights.as_slice()),
            ("a \u{00b7} b", &[0.5, 0.5][..])
        );
        document.mix.unwrap().write(&at("m.paint.exr")).unwrap();
        drop_on(&mut desk, &[at("a.paint.exr")]);
        assert_eq!((desk.title().as_str(), desk.state.weights.len()), ("a - carpaint", 1));
        drop_on(&mut desk, &[at("m.paint.exr")]);
        assert!(desk.document.as_ref().unwrap().mix.is_some());
        drop_on(&mut desk, &[fixture("scenes/studio.exr")]);
        assert_eq!(desk.state.surroundings.name(), "picture");
        drop_on(&mut desk, &[fixture("scenes/ring.obj")]);
        assert_eq!(desk.state.object, Object::Mesh);
        drop_on(&mut desk, &[fixture("scenes/mesh.toml")]);
        assert_eq!((desk.state.object, desk.state.surroundings.name()), (Object::Scene, "scene"));
        drop_on(&mut desk, &[fixture("compositions/solid_red.toml")]);
        assert_eq!((desk.tab, desk.state.shown[0]), (Tab::Composition, Shown::Recipe));
        assert_eq!(desk.messages, []);
    }

    #[test]
    fn radiance_files_are_surroundings_too() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("gray.HDR");
        // Two pixels of (0.5, 0.5, 0.5): mantissas of 128 over 256, exponent 0.
        let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
        bytes.extend([128, 128, 128, 128].repeat(2));
        std::fs::write(&file, bytes).unwrap();
        let mut desk = Desk::default();
        drop_on(&mut desk, std::slice::from_ref(&file));
        assert_eq!((desk.state.panorama.path.as_path(), desk.messages.as_slice()), (file.as_path(), &[][..]));
    }

    #[test]
    fn what_is_wrong_with_a_dropped_file_is_told_and_all_stays() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let file = folder.path().join(name);
            std::fs::write(&file, bytes).unwrap();
            file
        };
        paint(0.1).write(&folder.path().join("a.paint.exr")).unwrap();
        let whole = std::fs::read(folder.path().join("a.paint.exr")).unwrap();
        let mut desk = Desk::default();
        drop_on(&mut desk, &[folder.path().join("a.paint.exr")]);
        let before = desk.state.clone();
        for file in [
            write("bad.paint.exr", b"no such thing"),
            write("cut.paint.exr", &whole[..whole.len() - 9]),
            write("bad.hdr", b"no such thing"),
            write("bad.glb", b"no such thing"),
            write("bad.obj", b"f 1 2 3\n"),
            write("neither.toml", b"key = 1\n"),
            write("composition.toml", b"[substrate]\nalbedo = 2\n"),
            write("scene.toml", b"[camera]\nzoom = 2\n"),
            folder.path().join("none.paint.exr"),
        ] {
            drop_on(&mut desk, std::slice::from_ref(&file));
            let [message] = &desk.messages[..] else { panic!("one message of {}", file.display()) };
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            assert!(message.is_error && message.text.contains(&name), "{name}: {}", message.text);
            desk.messages.clear();
        }
        assert_eq!((desk.state, desk.document.unwrap().title().as_str()), (before, "a"));
    }

    #[test]
    fn a_scene_waits_for_the_paints_that_it_wears() {
        let folder = tempfile::tempdir().unwrap();
        let files = ["a", "b", "c"].map(|name| folder.path().join(format!("{name}.paint.exr")));
        files.iter().for_each(|file| paint(0.2).write(file).unwrap());
        let mut desk = Desk::default();
        let demo = fixture("scenes/demo.toml");
        drop_on(&mut desk, &[&[demo.clone()][..], &files].concat());
        assert_eq!((desk.state.object, desk.messages.len()), (Object::Scene, 0));
        assert_eq!(desk.worn(Shown::Blend).unwrap().len(), 4);
        drop_on(&mut desk, &files[..1]);
        assert_eq!((desk.state.object, desk.messages.len()), (Object::Capsule, 1), "it wears four");
        drop_on(&mut desk, &[demo]);
        assert_eq!(desk.state.object, Object::Capsule);
    }
}
