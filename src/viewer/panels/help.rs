//! What keys and mouse do.

use super::super::keys::{BINDINGS, MOUSE};
use super::super::places::Places;
use eframe::egui::{Align2, Context, Grid, RichText, Ui, Window};

/// What files are opened as, for the help.
const FILES: &[(&str, &str)] = &[
    (".paint.exr", "a mix, or paints to be coupled"),
    (".toml", "a composition, or a scene"),
    (".hdr .exr", "surroundings"),
    (".glb .gltf .obj", "a mesh"),
];

/// The help, over everything else.
pub fn show(context: &Context, places: &mut Places, is_open: &mut bool) {
    let window = Window::new("Keys and mouse")
        .open(is_open)
        .collapsible(false)
        .resizable(false)
        .vscroll(true)
        .default_height(620.0);
    let shown = window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        ui.horizontal_top(|ui| {
            rows(ui, "keys", BINDINGS.iter().map(|binding| (binding.shown, binding.what)));
            ui.add_space(14.0);
            ui.vertical(|ui| {
                ui.label(RichText::new("In the picture").strong());
                rows(ui, "mouse", MOUSE.iter().copied());
                ui.add_space(6.0);
                ui.label(RichText::new("Files dropped on the window are opened").strong());
                rows(ui, "files", FILES.iter().copied());
            });
        });
    });
    if let Some(shown) = shown {
        places.note("help", shown.response.rect);
    }
}

/// Pairs of what is done and what comes of it.
fn rows(ui: &mut Ui, name: &str, all: impl Iterator<Item = (&'static str, &'static str)>) {
    Grid::new(name).num_columns(2).spacing([18.0, 3.0]).striped(true).show(ui, |ui| {
        for (how, what) in all {
            ui.monospace(how);
            ui.label(what);
            ui.end_row();
        }
    });
}
