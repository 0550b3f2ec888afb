//! Where controls stand, for whoever drives the window from outside (tests): a file with their rectangles.

use eframe::egui::Rect;
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// Takes notes of where controls stand.
pub trait Note {
    /// Notes where a control stands.
    fn note(&mut self, name: &str, rect: Rect);
}

/// [`Places`] under names that begin alike.
pub struct Within<'a> {
    places: &'a mut Places,
    prefix: &'a str,
}

impl Note for Within<'_> {
    fn note(&mut self, name: &str, rect: Rect) {
        self.places.note(format!("{} {name}", self.prefix), rect);
    }
}

impl Note for Places {
    fn note(&mut self, name: &str, rect: Rect) {
        Self::note(self, name, rect);
    }
}

/// Rectangles of named controls, in points of the window, and numbers worth knowing with them.
#[derive(Debug, Default)]
pub struct Places {
    file: Option<PathBuf>,
    now: Map<String, Value>,
    written: Map<String, Value>,
}

impl Places {
    /// Written to `file`, if one is named.
    pub fn new(file: Option<PathBuf>) -> Self {
        Self { file, ..Self::default() }
    }

    /// Notes where a control stands.
    pub fn note(&mut self, name: impl Into<String>, rect: Rect) {
        if self.file.is_some() {
            let place = [rect.left(), rect.top(), rect.right(), rect.bottom()];
            self.now.insert(name.into(), json!(place));
        }
    }

    /// The same, under names that begin with `prefix`.
    pub fn within<'a>(&'a mut self, prefix: &'a str) -> Within<'a> {
        Within { places: self, prefix }
    }

    /// Notes a value.
    pub fn say(&mut self, name: &str, value: impl Into<Value>) {
        if self.file.is_some() {
            self.now.insert(name.to_owned(), value.into());
        }
    }

    /// Begins a frame, when that before it is on the screen: writes what that one changed. A file that cannot be written says
    /// nothing; nothing depends on it.
    pub fn begin_frame(&mut self) {
        if let Some(file) = &self.file
            && self.now != self.written
        {
            let _ = crate::file::write_text(file, &Value::Object(self.now.clone()).to_string());
            self.written.clone_from(&self.now);
        }
        self.now.clear();
    }

    /// Whether something is to be written when the next frame begins.
    pub fn has_news(&self) -> bool {
        self.file.is_some() && self.now != self.written
    }
}
