//! What keys and mouse do.

use super::super::keys::{BINDINGS, Binding, MOUSE};
use super::super::places::Places;
use eframe::egui::{Align2, Context, Grid, RichText, Ui, Window};

/// What files are opened as by the window of paints.
pub const PAINT_FILES: &[(&str, &str)] = &[
    (".paint.exr", "a mix, or paints to be coupled"),
    (".toml", "a composition, or a scene"),
    (".hdr .exr", "surroundings"),
    (".glb .gltf .obj", "a mesh"),
];

/// What they are opened as by the window of a print.
pub const PRINT_FILES: &[(&str, &str)] = &[
    (".png .jpg", "another image"),
    (".ink.json", "an ink, in place of the one of its color"),
    (".csv", "the emission of a lamp"),
];

/// Height of the help where there is room, points; else it scrolls.
const HEIGHT: f32 = 620.0;
/// Width of a window in which keys and mouse find room side by side, points.
const WIDE: f32 = 880.0;

/// The help, over everything else: keys of which something holds, and what files are opened as.
pub fn show(
    context: &Context,
    places: &mut Places,
    is_open: &mut bool,
    holds: impl Fn(&Binding) -> bool,
    files: &[(&'static str, &'static str)],
) {
    let is_wide = context.content_rect().width() >= WIDE;
    // A default height, once lowered for want of room, would stay so.
    let window = Window::new("Keys and mouse")
        .open(is_open)
        .collapsible(false)
        .resizable(false)
        .vscroll(true)
        .min_height(HEIGHT);
    let contents = |ui: &mut Ui| {
        rows(ui, "keys", BINDINGS.iter().filter(|b| holds(b)).map(|b| (b.shown, b.what)));
        ui.add_space(14.0);
        ui.vertical(|ui| {
            ui.label(RichText::new("In the picture").strong());
            rows(ui, "mouse", MOUSE.iter().copied());
            ui.add_space(6.0);
            ui.label(RichText::new("Files dropped on the window are opened").strong());
            rows(ui, "files", files.iter().copied());
        });
    };
    let shown = window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| match is_wide {
        true => ui.horizontal_top(contents).inner,
        false => ui.vertical(contents).inner,
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
