//! Lamp, surroundings, exposure.

use super::super::light::{Lamp, Surroundings};
use super::super::places::Places;
use super::super::state::State;
use super::controls::{self, Words};
use eframe::egui::Ui;

/// The lamp's and the surroundings' controls.
pub fn show(ui: &mut Ui, places: &mut Places, state: &mut State) {
    controls::heading(ui, "Lamp");
    let lamp = &mut state.lamp;
    controls::check(ui, places, "lamp", "One far lamp, under which flakes sparkle (L)", &mut lamp.is_on);
    ui.add_enabled_ui(lamp.is_on, |ui| {
        let words = |label, suffix, digits, hint| Words { label, suffix, digits, hint };
        let hint =
            "Direction of the lamp, 0 in front, growing to the right; Ctrl+drag in the picture moves it";
        let azimuth = words("azimuth", "\u{00b0}", 0, hint);
        controls::slider(ui, places, &azimuth, &mut lamp.azimuth_deg, -180.0..=180.0);
        let elevation = words("elevation", "\u{00b0}", 0, "Height of the lamp above the horizon");
        controls::slider(ui, places, &elevation, &mut lamp.elevation_deg, -90.0..=90.0);
        let hint = "Angular radius of the lamp's disc; the sun has 0.27\u{00b0}. Larger lamps blur the gloss";
        let radius = words("radius", "\u{00b0}", 2, hint);
        controls::log_slider(ui, places, &radius, &mut lamp.angular_radius_deg, Lamp::RADIUS_DEG);
        let power = words("power", " stops", 1, "Brightness of the lamp over its usual one");
        controls::slider(ui, places, &power, &mut lamp.stops, Lamp::STOPS);
    });
    if !state.others.is_empty() {
        let hint = "The other lamps of the scene that was opened";
        controls::check(ui, places, "lamps of the scene", hint, &mut state.others_shine);
    }
    controls::heading(ui, "Surroundings");
    let hint = "Light from everywhere (E); under it flakes show their mean";
    let name = |s: Surroundings| s.name().to_owned();
    let all = state.all_surroundings();
    controls::choice(ui, places, ("light from", hint), &mut state.surroundings, &all, name);
    if state.surroundings == Surroundings::Picture {
        let turn = Words {
            label: "turn",
            suffix: "\u{00b0}",
            digits: 0,
            hint: "Turns the picture about the object",
        };
        controls::slider(ui, places, &turn, &mut state.panorama.turn_deg, -180.0..=180.0);
        let hint = "Brightness of the picture of the surroundings";
        let stops = Words { label: "brightness", suffix: " stops", digits: 1, hint };
        controls::slider(ui, places, &stops, &mut state.panorama.stops, -6.0..=6.0);
    }
    let hint = "Stops by which the picture is brightened ([ and ])";
    let exposure = Words { label: "exposure", suffix: " stops", digits: 2, hint };
    controls::slider(ui, places, &exposure, &mut state.exposure_stops, State::EXPOSURE);
}
