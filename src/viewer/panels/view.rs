//! Object, eye, and which paints share the picture.

use super::super::document::Document;
use super::super::places::Places;
use super::super::state::{Layout, Object, Shown, State};
use super::controls;
use eframe::egui::Ui;

/// The object's and the view's controls; `has_recipe`: there is a paint of the composition panel to look at.
pub fn show(
    ui: &mut Ui,
    places: &mut Places,
    state: &mut State,
    document: Option<&Document>,
    has_recipe: bool,
) {
    controls::heading(ui, "View");
    let mut object = state.object;
    let all = state.all_objects();
    let name = |o: Object| o.name().replace('-', " ");
    if controls::choice(ui, places, ("object", "The painted object (O)"), &mut object, &all, name) {
        state.set_object(object);
    }
    ui.horizontal(|ui| {
        controls::check(ui, places, "flakes", "Sparkle, or the smooth part alone (F)", &mut state.flakes);
        if ui
            .button("reset eye")
            .on_hover_text("The eye back to where it sees all of the object (Home)")
            .clicked()
        {
            state.home();
        }
    });
    let name = |l: Layout| l.name().to_owned();
    let hint = "One paint; two in one picture, with a divider to drag; or two pictures (V)";
    controls::choice(ui, places, ("layout", hint), &mut state.layout, &Layout::ALL, name);
    let mut all = Vec::new();
    if let Some(document) = document {
        all.push(Shown::Blend);
        if document.mix.is_some() {
            all.extend(state.kept.is_some().then_some(Shown::Kept));
            all.extend((0..document.paints.len()).map(Shown::Paint));
        }
    }
    if has_recipe {
        all.push(Shown::Recipe);
    }
    let name = |shown: Shown| shown_name(shown, document);
    let [first, second] = &mut state.shown;
    controls::choice(ui, places, ("paint", "The paint, the left one of two"), first, &all, name);
    if state.layout != Layout::Single {
        controls::choice(ui, places, ("second", "The right one of two paints"), second, &all, name);
    }
}

/// A shown paint for people.
pub fn shown_name(shown: Shown, document: Option<&Document>) -> String {
    let name = |k: usize| document.and_then(|d| d.paints.get(k)).map_or("none", |p| &p.name).to_owned();
    match shown {
        Shown::Blend if document.is_some_and(|d| d.mix.is_some()) => "blend".to_owned(),
        Shown::Blend => name(0),
        Shown::Kept => "kept blend".to_owned(),
        Shown::Paint(k) => name(k),
        Shown::Recipe => "composition".to_owned(),
    }
}
