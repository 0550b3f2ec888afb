//! Rows of a label and a control, alike in all panels.

use super::super::places::Note;
use eframe::egui::{ComboBox, Label, Response, RichText, Slider, SliderClamping, Ui};
use std::ops::RangeInclusive;

/// Width of the labels, points.
const LABEL: f32 = 78.0;
/// Width of a slider's rail, points.
const RAIL: f32 = 100.0;

/// A slider's words: what it is called, its unit, digits, and what it means.
pub struct Words<'a> {
    /// Left of it.
    pub label: &'a str,
    /// Behind the number.
    pub suffix: &'a str,
    /// Digits after the point.
    pub digits: usize,
    /// Shown when the pointer rests.
    pub hint: &'a str,
}

/// A label of the common width.
pub fn label(ui: &mut Ui, text: &str, hint: &str) {
    let height = ui.spacing().interact_size.y;
    ui.allocate_ui_with_layout(
        [LABEL, height].into(),
        eframe::egui::Layout::left_to_right(eframe::egui::Align::Center),
        |ui| {
            ui.set_min_width(LABEL);
            ui.add(Label::new(text).truncate()).on_hover_text(hint);
        },
    );
}

/// A labelled slider; whether the value changed.
pub fn slider(
    ui: &mut Ui,
    places: &mut impl Note,
    words: &Words<'_>,
    value: &mut f64,
    range: RangeInclusive<f64>,
) -> bool {
    slider_with(ui, places, words, value, range, |slider| slider)
}

/// A labelled slider over powers.
pub fn log_slider(
    ui: &mut Ui,
    places: &mut impl Note,
    words: &Words<'_>,
    value: &mut f64,
    range: RangeInclusive<f64>,
) -> bool {
    slider_with(ui, places, words, value, range, |slider| slider.logarithmic(true))
}

fn slider_with(
    ui: &mut Ui,
    places: &mut impl Note,
    words: &Words<'_>,
    value: &mut f64,
    range: RangeInclusive<f64>,
    change: impl FnOnce(Slider<'_>) -> Slider<'_>,
) -> bool {
    ui.horizontal(|ui| {
        label(ui, words.label, words.hint);
        ui.spacing_mut().slider_width = RAIL;
        let slider = Slider::new(value, range)
            .suffix(words.suffix)
            .fixed_decimals(words.digits)
            .smart_aim(false)
            // What is not touched is not rounded to the digits shown either.
            .clamping(SliderClamping::Edits)
            .trailing_fill(true);
        let response = ui.add(change(slider)).on_hover_text(words.hint);
        places.note(words.label, response.rect);
        response.changed()
    })
    .inner
}

/// A labelled choice; whether another one was made.
pub fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    places: &mut impl Note,
    (text, hint): (&str, &str),
    value: &mut T,
    all: &[T],
    name: impl Fn(T) -> String,
) -> bool {
    let before = *value;
    ui.horizontal(|ui| {
        label(ui, text, hint);
        let shown = name(*value);
        let combo = ComboBox::from_id_salt(text).selected_text(shown).width(RAIL + 66.0).truncate();
        let response = combo.show_ui(ui, |ui| {
            for one in all {
                ui.selectable_value(value, *one, name(*one));
            }
        });
        places.note(text, response.response.rect);
        response.response.on_hover_text(hint);
    });
    *value != before
}

/// A check box that is noted.
pub fn check(ui: &mut Ui, places: &mut impl Note, text: &str, hint: &str, value: &mut bool) -> Response {
    let response = ui.checkbox(value, text).on_hover_text(hint);
    places.note(text, response.rect);
    response
}

/// A heading over a group of controls.
pub fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(3.0);
    ui.label(RichText::new(text).strong());
}
