//! What keys and mouse do.

use super::super::keys::{BINDINGS, MOUSE};
use super::super::places::Places;
use eframe::egui::{Align2, Context, Grid, RichText, Window};

/// The help, over everything else.
pub fn show(context: &Context, places: &mut Places, is_open: &mut bool) {
    let window = Window::new("Keys and mouse").open(is_open).collapsible(false).resizable(false);
    let shown = window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        Grid::new("keys").num_columns(2).spacing([18.0, 3.0]).striped(true).show(ui, |ui| {
            for binding in BINDINGS {
                ui.monospace(binding.shown);
                ui.label(binding.what);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.label(RichText::new("In the picture").strong());
        Grid::new("mouse").num_columns(2).spacing([18.0, 3.0]).striped(true).show(ui, |ui| {
            for (how, what) in MOUSE {
                ui.monospace(*how);
                ui.label(*what);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.label(
            "Files dropped on the window are opened: a mix or paints (.paint.exr), a composition or a scene (.toml), \
             surroundings (.hdr, .exr), a mesh (.glb, .gltf, .obj).",
        );
    });
    if let Some(shown) = shown {
        places.note("help", shown.response.rect);
    }
}
