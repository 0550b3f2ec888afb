//! Weights, path and channels of the mix.

use super::super::document::Document;
use super::super::places::Places;
use super::super::state::State;
use super::super::weights;
use super::controls::{self, Words};
use super::pad;
use crate::mix::{Channels, LobePath, Path};
use eframe::egui::{Color32, Sense, Ui};

/// The mix of a document; `colors` are its paints' in the face.
pub fn show(ui: &mut Ui, places: &mut Places, state: &mut State, document: &Document, colors: &[Color32]) {
    let n = document.paints.len();
    if document.mix.is_none() {
        controls::heading(ui, "Paint");
        ui.label(&document.paints[0].name);
        ui.add_space(4.0);
        ui.label("One paint has nothing to mix with. Open or drop several, or a mix.");
        return;
    }
    controls::heading(ui, "Weights");
    sliders(ui, places, state, document, colors);
    ui.horizontal(|ui| {
        let equal = ui.button("equal").on_hover_text("The same weight for every paint (0)");
        places.note("equal", equal.rect);
        if equal.clicked() {
            state.weights = weights::equal(n);
        }
        let keep = ui.button("keep").on_hover_text("Keep this blend, to stand beside others (K)");
        places.note("keep", keep.rect);
        if keep.clicked() {
            state.keep();
        }
        let mut extrapolates = state.extrapolates;
        let hint = "Let weights go from -100 to 200 %: beyond a paint, away from the others (X)";
        if controls::check(ui, places, "extrapolate", hint, &mut extrapolates).changed() {
            state.set_extrapolates(extrapolates);
        }
    });
    if n >= 3 {
        pad::show(ui, places, state, document, colors);
    }
    controls::heading(ui, "Blend");
    options(ui, places, state, document);
}

fn sliders(ui: &mut Ui, places: &mut Places, state: &mut State, document: &Document, colors: &[Color32]) {
    let (low, high) = state.weight_range();
    for (k, named) in document.paints.iter().enumerate() {
        ui.horizontal(|ui| {
            let (swatch, _) = ui.allocate_exact_size([10.0, 14.0].into(), Sense::hover());
            ui.painter().rect_filled(swatch, 2.0, colors.get(k).copied().unwrap_or(Color32::GRAY));
            let mut percent = 100.0 * state.weights[k];
            let words = Words {
                label: &named.name,
                suffix: " %",
                digits: 1,
                hint: "Weight of this paint; the others keep their proportions and share the rest",
            };
            if controls::slider(ui, places, &words, &mut percent, 100.0 * low..=100.0 * high) {
                state.set_weight(k, percent / 100.0);
            }
        });
    }
}

fn options(ui: &mut Ui, places: &mut Places, state: &mut State, document: &Document) {
    let usual = document.mix.as_ref().map_or(Path::default(), |mix| mix.path);
    let mut path = state.blend.path.unwrap_or(usual);
    let hint = "transport: every box travels, as published; hybrid: bright flakes become fewer instead of dimmer; contrast: \
                every box travels, and contrast is kept";
    if controls::choice(ui, places, ("path", hint), &mut path, &Path::ALL, |p| p.to_string()) {
        state.blend.path = Some(path);
    }
    let hint = "What of the flakes goes from paint to paint (C); the rest stays that of the source";
    controls::choice(
        ui,
        places,
        ("channels", hint),
        &mut state.blend.channels,
        &Channels::ALL,
        channels_name,
    );
    let names = |k: usize| document.paints[k].name.clone();
    let all: Vec<usize> = (0..document.paints.len()).collect();
    ui.add_enabled_ui(state.blend.channels != Channels::All, |ui| {
        let hint = "The paint that keeps what does not go";
        controls::choice(ui, places, ("source", hint), &mut state.blend.source, &all, names);
    });
    let hint = "Which lobes of the smooth part belong together: those of equal number, or of like roughness";
    controls::choice(ui, places, ("lobes", hint), &mut state.blend.lobes, &LobePath::ALL, |l| l.to_string());
}

fn channels_name(channels: Channels) -> String {
    match channels {
        Channels::All => "all",
        Channels::Lightness => "lightness only",
        Channels::AllButLightness => "all but lightness",
        Channels::WhiteFlakes => "white flakes",
    }
    .to_owned()
}
