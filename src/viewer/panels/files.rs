//! Opening and saving.

use super::super::places::Places;
use super::controls;
use eframe::egui::{Button, TextEdit, Ui};
use std::path::PathBuf;

/// What the fields hold.
#[derive(Debug, Clone)]
pub struct Fields {
    /// File to open.
    pub open: String,
    /// Picture to save.
    pub picture: String,
    /// Rays a pixel of a saved picture.
    pub samples: usize,
    /// Paint to save.
    pub paint: String,
    /// The field to open a file takes the keyboard.
    pub wants_focus: bool,
}

impl Default for Fields {
    fn default() -> Self {
        Self {
            open: String::new(),
            picture: "picture.png".into(),
            samples: 16,
            paint: "blend.paint.exr".into(),
            wants_focus: false,
        }
    }
}

/// What a panel asks of the window.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Opens files in place of what is open.
    Open(Vec<PathBuf>),
    /// Couples a paint to those that are open.
    Add(PathBuf),
    /// Renders the picture and saves it.
    SavePicture(PathBuf),
    /// Saves the blended paint.
    SavePaint(PathBuf),
    /// Saves the composition.
    SaveComposition,
}

/// The fields; what was asked for.
pub fn show(ui: &mut Ui, places: &mut Places, fields: &mut Fields, can_add: bool) -> Option<Command> {
    let hint = "A mix or a paint (.paint.exr), a composition or a scene (.toml), surroundings (.hdr, .exr), a mesh (.glb, .gltf, \
                .obj); or drop files on the window";
    let opened = open(ui, places, fields, hint, Some(can_add));
    opened.or(picture(ui, places, fields)).or(paint(ui, places, fields))
}

/// The field for a file to open; `can_add`: whether one can be coupled to those that are open, none where there are no paints.
pub fn open(
    ui: &mut Ui,
    places: &mut Places,
    fields: &mut Fields,
    hint: &str,
    can_add: Option<bool>,
) -> Option<Command> {
    let mut command = None;
    controls::heading(ui, "Open");
    let field = ui
        .add(TextEdit::singleline(&mut fields.open).hint_text("path of a file").desired_width(f32::INFINITY));
    places.note("open field", field.rect);
    if std::mem::take(&mut fields.wants_focus) {
        field.request_focus();
    }
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(eframe::egui::Key::Enter));
    field.on_hover_text(hint);
    let path = || PathBuf::from(fields.open.trim());
    let has_path = !fields.open.trim().is_empty();
    ui.horizontal(|ui| {
        let open = ui.add_enabled(has_path, Button::new("open")).on_hover_text("In place of what is open");
        if has_path && (open.clicked() || entered) {
            command = Some(Command::Open(vec![path()]));
        }
        let Some(can_add) = can_add else { return };
        let add = ui.add_enabled(has_path && can_add, Button::new("add"));
        if add.on_hover_text("Couple this paint to those that are open").clicked() {
            command = Some(Command::Add(path()));
        }
    });
    command
}

/// The field for a picture to save.
pub fn picture(ui: &mut Ui, places: &mut Places, fields: &mut Fields) -> Option<Command> {
    let mut command = None;
    controls::heading(ui, "Save picture");
    ui.add(TextEdit::singleline(&mut fields.picture).desired_width(f32::INFINITY))
        .on_hover_text(".png: 8 bit, sRGB, at the exposure; .exr: linear, f32, exposure not applied");
    ui.horizontal(|ui| {
        let hint = "Rays a pixel: the saved picture is rendered anew, behind the window";
        controls::label(ui, "rays a pixel", hint);
        ui.add(eframe::egui::DragValue::new(&mut fields.samples).range(1..=1024)).on_hover_text(hint);
        let save = ui.button("save").on_hover_text("Ctrl+S");
        places.note("save picture", save.rect);
        if save.clicked() {
            command = Some(Command::SavePicture(fields.picture.trim().into()));
        }
    });
    command
}

/// The field for a paint to save.
fn paint(ui: &mut Ui, places: &mut Places, fields: &mut Fields) -> Option<Command> {
    let mut command = None;
    controls::heading(ui, "Save blended paint");
    ui.add(TextEdit::singleline(&mut fields.paint).desired_width(f32::INFINITY))
        .on_hover_text("The paint at the weights, as `carpaint blend` writes it (.paint.exr)");
    let save = ui.button("save paint").on_hover_text("Ctrl+B");
    places.note("save paint", save.rect);
    if save.clicked() {
        command = Some(Command::SavePaint(fields.paint.trim().into()));
    }
    command
}
