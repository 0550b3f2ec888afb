//! The controls beside a print.

use super::super::choices::Layout;
use super::super::light::Lamp;
use super::super::panels::controls::{self, Words};
use super::super::places::Places;
use super::super::state::State as PaintState;
use super::desk::Desk;
use super::ink_set::PLACES;
use super::state::{LampLight, State};
use crate::proof::Method;
use crate::render::{Bands, InkModel};
use crate::scene::Shape;
use eframe::egui::{Label, RichText, Ui};

/// All of them but those of files.
pub fn show(ui: &mut Ui, places: &mut Places, desk: &mut Desk) {
    light(ui, places, &mut desk.state);
    lamps(ui, places, &mut desk.state);
    material(ui, places, desk);
    print(ui, places, &mut desk.state);
    view(ui, places, &mut desk.state);
}

fn light(ui: &mut Ui, places: &mut Places, state: &mut State) {
    controls::heading(ui, "Light");
    let emission = state.emission.as_ref().map_or_else(String::new, |(name, _)| name.clone());
    let name = |light| match light {
        LampLight::D65 => "D65".to_owned(),
        LampLight::A => "A".to_owned(),
        LampLight::Measured => emission.clone(),
    };
    let hint = "Spectrum of the lamps; drop a measured emission (.csv: nanometres and power) on the window";
    let all = state.all_lights();
    controls::choice(ui, places, ("illuminant", hint), &mut state.light, &all, name);
    ui.horizontal(|ui| {
        let hint = "The eye takes the light's white for white, like a camera balanced for it";
        controls::check(ui, places, "adapted", hint, &mut state.adapted);
        let hint = "The exposure at which half a percent of the picture (of two, the left one) is white, until it is set by hand";
        controls::check(ui, places, "auto exposure", hint, &mut state.auto_exposure);
    });
    let hint = "Stops by which the picture is brightened ([ and ])";
    let words = Words { label: "exposure", suffix: " stops", digits: 2, hint };
    if controls::slider(ui, places, &words, &mut state.exposure_stops, PaintState::EXPOSURE) {
        state.auto_exposure = false;
    }
}

fn lamps(ui: &mut Ui, places: &mut Places, state: &mut State) {
    controls::heading(ui, "Lamps");
    let lamp = &mut state.lamp;
    ui.horizontal(|ui| {
        controls::check(ui, places, "lamp", "The lamp that a right drag moves (L)", &mut lamp.is_on);
        controls::check(
            ui,
            places,
            "lamp from the side",
            "A second lamp, half as bright",
            &mut state.side_lamp,
        );
    });
    ui.add_enabled_ui(lamp.is_on, |ui| {
        let words = |label, suffix, digits, hint| Words { label, suffix, digits, hint };
        let hint =
            "Direction of the lamp, 0 in front, growing to the right; a right drag in the picture moves it";
        controls::slider(
            ui,
            places,
            &words("azimuth", "\u{00b0}", 0, hint),
            &mut lamp.azimuth_deg,
            -180.0..=180.0,
        );
        let elevation = words("elevation", "\u{00b0}", 0, "Height of the lamp above the horizon");
        controls::slider(ui, places, &elevation, &mut lamp.elevation_deg, -90.0..=90.0);
        let power = words("power", " stops", 1, "Brightness of the lamp over its usual one");
        controls::slider(ui, places, &power, &mut lamp.stops, Lamp::STOPS);
    });
    let hint =
        "Light of a lamp opposite to each of the others, as a share of theirs: what shines through the paper";
    let words = Words { label: "back light", suffix: "", digits: 2, hint };
    controls::slider(ui, places, &words, &mut state.back_light, State::BACK_LIGHT);
}

fn material(ui: &mut Ui, places: &mut Places, desk: &mut Desk) {
    controls::heading(ui, "Inks");
    if let Some(inks) = &desk.inks {
        for (place, ink) in PLACES.iter().zip(inks.inks().iter()) {
            ui.horizontal(|ui| {
                let hint =
                    "Drop an ink (.ink.json) on the window: it takes the place of the one of its color";
                controls::label(ui, place, hint);
                let text = format!("{}, roughness {:.2}", ink.name(), ink.roughness());
                ui.add(Label::new(RichText::new(text).weak()).truncate());
            });
        }
    }
    let state = &mut desk.state;
    let hint = "Inks as rough as their files say, or all alike: how well flakes lie";
    controls::check(ui, places, "own roughness", hint, &mut state.own_roughness);
    ui.add_enabled_ui(!state.own_roughness, |ui| {
        let words = Words { label: "roughness", suffix: "", digits: 2, hint };
        controls::slider(ui, places, &words, &mut state.roughness, State::ROUGHNESS);
    });
    let hint = "Black paper beneath: a dim highlight, and light that it scatters";
    controls::check(ui, places, "black paper", hint, &mut state.has_paper);
    let hint = "How inks reflect: the goniochromatic model; Torrance and Sparrow's with Schlick's Fresnel term, or with the \
                exact one of titanium dioxide";
    let name = |model| model_name(model).to_owned();
    let [first, second] = &mut state.models;
    controls::choice(ui, places, ("model", hint), first, &InkModel::ALL, name);
    let name = |layout: Layout| layout.name().to_owned();
    let hint = "One model; two in one picture, with a divider to drag; or two pictures (V)";
    controls::choice(ui, places, ("layout", hint), &mut state.layout, &Layout::ALL, name);
    if state.layout != Layout::Single {
        let name = |model| model_name(model).to_owned();
        controls::choice(ui, places, ("beside", "The model on the right"), second, &InkModel::ALL, name);
    }
    let name = |bands| match bands {
        Bands::Wavelengths(count) => count.to_string(),
        Bands::Xyz => "xyz".to_owned(),
    };
    let hint = "At how many wavelengths light is added up; xyz: three numbers fitted to the inks, of the goniochromatic model \
                alone (others keep 41 wavelengths)";
    controls::choice(ui, places, ("wavelengths", hint), &mut state.bands, &State::BANDS, name);
}

fn print(ui: &mut Ui, places: &mut Places, state: &mut State) {
    controls::heading(ui, "Print");
    let name = |method| match method {
        Method::ErrorDiffusion => "error diffusion".to_owned(),
        Method::BlueNoise => "blue noise".to_owned(),
    };
    let all = [Method::ErrorDiffusion, Method::BlueNoise];
    controls::choice(ui, places, ("halftone", "How dots are placed"), &mut state.method, &all, name);
    let name = |cell: usize| format!("{cell} \u{00d7} {cell} dots");
    let hint = "Dots of a pixel of the image";
    controls::choice(ui, places, ("cell", hint), &mut state.cell, &State::CELLS, name);
}

fn view(ui: &mut Ui, places: &mut Places, state: &mut State) {
    let hint = "What is printed (O)";
    controls::choice(ui, places, ("shape", hint), &mut state.shape, &Shape::PRINTED, str::to_owned);
    if ui.button("reset eye").on_hover_text("The eye back to where it sees all of it (Home)").clicked() {
        state.home();
    }
}

/// A model for people.
pub fn model_name(model: InkModel) -> &'static str {
    match model {
        InkModel::Goniochromatic => "goniochromatic",
        InkModel::Schlick => "standard, Schlick",
        InkModel::Exact => "standard, exact TiO2",
    }
}
