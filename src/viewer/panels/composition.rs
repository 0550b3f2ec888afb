//! Layers, flakes and pigments of a composition (Ershov et al. 2001, section 8).

use super::super::kitchen::{self, Kitchen, PRESETS, Stage};
use super::super::places::{Note, Places};
use super::controls::{self, Words};
use crate::color::{Spectrum, reflectance_of_rgb};
use crate::simulate::Composition;
use crate::simulate::composition::{Film, FlakeKind, Pigment};
use eframe::egui::{CollapsingHeader, Color32, ComboBox, RichText, TextEdit, Ui};
use glam::DVec3;
use std::ops::RangeInclusive;

/// What the panel asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// The composition is to be looked at.
    Look,
    /// It is to be saved.
    Save,
}

/// The composition's controls.
pub fn show(ui: &mut Ui, places: &mut Places, kitchen: &mut Kitchen) -> Option<Asked> {
    let mut asked = None;
    controls::heading(ui, "Composition");
    if presets(ui, places, kitchen) {
        asked = Some(Asked::Look);
    }
    let Some(composition) = &mut kitchen.composition else {
        ui.label("Choose one to begin with, or open a composition file (.toml).");
        return asked;
    };
    let before = composition.clone();
    ground(ui, places, composition);
    let mut gone = None;
    for (k, film) in composition.films.iter_mut().enumerate().rev() {
        let name = format!("film {}", k + 1);
        let header = CollapsingHeader::new(RichText::new(&name).strong()).default_open(true);
        header.show(ui, |ui| {
            let mut film_places = Scope { places: &mut *places, prefix: name.clone() };
            if edit_film(ui, &mut film_places, film) {
                gone = Some(k);
            }
        });
    }
    if let Some(k) = gone.filter(|_| composition.films.len() > 1) {
        composition.films.remove(k);
    }
    let can_add = composition.films.len() < Composition::MAX_FILMS;
    if ui.add_enabled(can_add, eframe::egui::Button::new("add a film on top")).clicked() {
        composition.films.push(kitchen::new_film());
    }
    let words =
        Words { label: "roughness", suffix: "\u{00b0}", digits: 2, hint: "Width of the gloss; 0: a mirror" };
    controls::slider(ui, places, &words, &mut composition.surface.roughness_deg, 0.0..=10.0);
    if *composition != before {
        kitchen.edited();
        asked = Some(Asked::Look);
    }
    outcome(ui, kitchen);
    ui.add(TextEdit::singleline(&mut kitchen.file).desired_width(f32::INFINITY))
        .on_hover_text("File to save to (.toml)");
    let save = ui.button("save composition");
    places.note("save composition", save.rect);
    if save.clicked() {
        asked = Some(Asked::Save);
    }
    asked
}

/// Notes places under the name of what they belong to.
struct Scope<'a> {
    places: &'a mut Places,
    prefix: String,
}

impl Scope<'_> {
    /// A labelled slider.
    fn slider(
        &mut self,
        ui: &mut Ui,
        words: &Words<'_>,
        value: &mut f64,
        range: RangeInclusive<f64>,
    ) -> bool {
        let mut own = self.places.within(&self.prefix);
        controls::slider(ui, &mut own, words, value, range)
    }

    /// A labelled slider over powers.
    fn log_slider(
        &mut self,
        ui: &mut Ui,
        words: &Words<'_>,
        value: &mut f64,
        range: RangeInclusive<f64>,
    ) -> bool {
        let mut own = self.places.within(&self.prefix);
        controls::log_slider(ui, &mut own, words, value, range)
    }
}

/// A choice of compositions; whether one was taken.
fn presets(ui: &mut Ui, places: &mut Places, kitchen: &mut Kitchen) -> bool {
    let title = kitchen.composition.as_ref().map_or("choose", |c| c.title.as_str()).to_owned();
    let mut taken = false;
    let response = ComboBox::from_id_salt("preset").selected_text(title).width(200.0).show_ui(ui, |ui| {
        for (name, text) in PRESETS {
            let response = ui.selectable_label(false, name);
            places.note(format!("preset {name}"), response.rect);
            if response.clicked()
                && let Ok(composition) = Composition::parse(text)
            {
                kitchen.open(composition, &name.replace(' ', "_"));
                taken = true;
            }
        }
    });
    places.note("preset", response.response.rect);
    response.response.on_hover_text("A composition to begin with");
    taken
}

fn ground(ui: &mut Ui, places: &mut impl Note, composition: &mut Composition) {
    let albedo = &mut composition.substrate.albedo;
    ui.horizontal(|ui| {
        let hint = "Color of the ground coat under the films";
        controls::label(ui, "ground coat", hint);
        let mut color = albedo.linear_rgb().clamp(DVec3::ZERO, DVec3::ONE).as_vec3().to_array();
        let response = ui.color_edit_button_rgb(&mut color).on_hover_text(hint);
        let within = DVec3::from(color.map(f64::from)).clamp(DVec3::splat(0.005), DVec3::splat(0.98));
        if response.changed()
            && let Ok(spectrum) = reflectance_of_rgb(within)
        {
            *albedo = spectrum;
        }
    });
    let words = Words {
        label: "albedo",
        suffix: "",
        digits: 3,
        hint: "Mean albedo of the ground coat, its hue kept",
    };
    spectrum(ui, places, &words, albedo, 0.0..=1.0);
}

/// A slider for the mean of a spectrum, its shape kept.
fn spectrum(
    ui: &mut Ui,
    places: &mut impl Note,
    words: &Words<'_>,
    value: &mut Spectrum,
    range: RangeInclusive<f64>,
) {
    let mut mean = kitchen::mean(value);
    let most = *range.end();
    if controls::slider(ui, places, words, &mut mean, range) {
        kitchen::set_mean(value, mean, most);
    }
}

/// The controls of a film; whether it is to go.
fn edit_film(ui: &mut Ui, scope: &mut Scope<'_>, film: &mut Film) -> bool {
    let words = |label, suffix, digits, hint| Words { label, suffix, digits, hint };
    let thickness = words("thickness", " \u{00b5}m", 1, "Thickness of the film; 12 to 20 are usual");
    scope.slider(ui, &thickness, &mut film.thickness_um, 1.0..=80.0);
    let index = words("index", "", 2, "Index of refraction of the binder; 1.5 is usual");
    scope.slider(ui, &index, &mut film.index, 1.0..=2.2);
    let absorption = words("absorption", " /mm", 1, "Mean absorption of the binder, its hue kept");
    let mut own = scope.places.within(&scope.prefix);
    spectrum(ui, &mut own, &absorption, &mut film.absorption_per_mm, 0.0..=300.0);
    tint(ui, film);
    parts(ui, scope, "flakes", &mut film.flakes, edit_flakes);
    parts(ui, scope, "pigment", &mut film.pigments, edit_pigment);
    let mut is_gone = false;
    ui.horizontal(|ui| {
        let room = |n: usize| n < Composition::MAX_KINDS;
        if ui.add_enabled(room(film.flakes.len()), eframe::egui::Button::new("+ flakes")).clicked() {
            film.flakes.push(kitchen::new_flakes());
        }
        if ui.add_enabled(room(film.pigments.len()), eframe::egui::Button::new("+ pigment")).clicked() {
            film.pigments.push(kitchen::new_pigment());
        }
        is_gone = ui.button("remove film").clicked();
    });
    is_gone
}

/// The controls of what a film holds of one kind, each under its name and number, with a button that takes it away.
fn parts<T>(
    ui: &mut Ui,
    scope: &mut Scope<'_>,
    name: &str,
    all: &mut Vec<T>,
    edit: impl Fn(&mut Ui, &mut Scope<'_>, &mut T),
) {
    let mut gone = None;
    for (k, part) in all.iter_mut().enumerate() {
        let name = format!("{name} {}", k + 1);
        ui.separator();
        ui.horizontal(|ui| {
            ui.label(RichText::new(&name).italics());
            if ui.small_button("remove").clicked() {
                gone = Some(k);
            }
        });
        let prefix = format!("{} {name}", scope.prefix);
        edit(ui, &mut Scope { places: &mut *scope.places, prefix }, part);
    }
    if let Some(k) = gone {
        all.remove(k);
    }
}

/// The hue that the binder leaves of white light.
fn tint(ui: &mut Ui, film: &mut Film) {
    let absorption = film.absorption_per_mm.clone();
    let mean = kitchen::mean(&absorption);
    if mean == 0.0 {
        return;
    }
    ui.horizontal(|ui| {
        let hint = "Color of white light after the mean free path: the hue of the binder";
        controls::label(ui, "tint", hint);
        let passed = Spectrum(absorption.0.map(|a| (-a / mean).exp()));
        let mut color = passed.linear_rgb().clamp(DVec3::ZERO, DVec3::ONE).as_vec3().to_array();
        let response = ui.color_edit_button_rgb(&mut color).on_hover_text(hint);
        if response.changed()
            && let Ok(tinted) = kitchen::tinted(&absorption, color)
        {
            film.absorption_per_mm = tinted;
        }
    });
}

fn edit_flakes(ui: &mut Ui, scope: &mut Scope<'_>, kind: &mut FlakeKind) {
    let words = |label, suffix, digits, hint| Words { label, suffix, digits, hint };
    let hint = "Flake area over paint area; 0.3 to 2 are usual";
    scope.slider(ui, &words("area", "", 2, hint), &mut kind.area_density, 0.0..=4.0);
    let hint = "Mean diameter; 10 to 30 are usual";
    scope.log_slider(ui, &words("diameter", " \u{00b5}m", 1, hint), &mut kind.diameter_um, 2.0..=100.0);
    let hint = "Standard deviation of the diameter over its mean";
    scope.slider(ui, &words("spread", "", 2, hint), &mut kind.diameter_spread, 0.0..=1.0);
    if let Some(sigma) = &mut kind.sigma_deg {
        let hint = "Width of the tilts; 4 to 12 are usual";
        scope.log_slider(ui, &words("tilt", "\u{00b0}", 1, hint), sigma, 0.5..=60.0);
    }
    if let Some(mirror) = &mut kind.mirror {
        let hint = "Mean reflectance of a flake, its hue kept";
        let most = 1.0 - kitchen::mean(&mirror.transmittance);
        let mut own = scope.places.within(&scope.prefix);
        spectrum(ui, &mut own, &words("reflectance", "", 2, hint), &mut mirror.reflectance, 0.0..=most);
    }
    for (k, layer) in kind.stack.iter_mut().flatten().enumerate() {
        let material = layer.material.as_deref().unwrap_or("layer");
        let label = format!("{} {material}", k + 1);
        let hint = "Thickness of this layer of a flake";
        let words = Words { label: &label, suffix: " nm", digits: 0, hint };
        scope.slider(ui, &words, &mut layer.thickness_nm, 0.0..=800.0);
    }
}

fn edit_pigment(ui: &mut Ui, scope: &mut Scope<'_>, pigment: &mut Pigment) {
    let words = |label, suffix, digits, hint| Words { label, suffix, digits, hint };
    if let Some(mie) = &mut pigment.mie {
        let material = mie.material.as_deref().unwrap_or("spheres");
        ui.label(material);
        let hint = "Share of the film's volume";
        let mut percent = 100.0 * mie.volume_fraction;
        if scope.slider(ui, &words("volume", " %", 2, hint), &mut percent, 0.0..=20.0) {
            mie.volume_fraction = percent / 100.0;
        }
        let hint = "Radius of the spheres";
        scope.log_slider(ui, &words("radius", " \u{00b5}m", 3, hint), &mut mie.radius_um, 0.005..=5.0);
    }
    let coefficients = match (&mut pigment.rayleigh, &mut pigment.henyey_greenstein) {
        (Some(law), _) => Some((&mut law.scattering_per_mm, &mut law.extinction_per_mm)),
        (_, Some(law)) => Some((&mut law.scattering_per_mm, &mut law.extinction_per_mm)),
        _ => None,
    };
    if let Some((scattering, extinction)) = coefficients {
        let hint = "Mean extinction of the pigment; scattering keeps its share of it";
        let mut mean = kitchen::mean(extinction);
        let before = mean;
        if scope.slider(ui, &words("extinction", " /mm", 1, hint), &mut mean, 0.1..=500.0) && before > 0.0 {
            let factor = mean / before;
            *extinction = Spectrum(extinction.0.map(|v| v * factor));
            *scattering = Spectrum(scattering.0.map(|v| v * factor));
        }
    }
}

/// What came of it, and how fast.
fn outcome(ui: &mut Ui, kitchen: &Kitchen) {
    if let Some(problem) = &kitchen.problem {
        ui.colored_label(Color32::from_rgb(230, 110, 100), problem);
    }
    for warning in &kitchen.warnings {
        ui.colored_label(Color32::from_rgb(220, 180, 90), warning);
    }
    let seconds = |time: Option<std::time::Duration>| {
        time.map_or("\u{2013}".to_owned(), |t| format!("{:.2} s", t.as_secs_f64()))
    };
    let shown = match kitchen.stage {
        Stage::Nothing => "nothing yet",
        Stage::Fast => "the fast model's mean, without flakes",
        Stage::Full => "the full model, with flakes",
    };
    ui.label(format!("shown: {shown}"));
    ui.label(format!(
        "from edit to picture: fast {}, full {}",
        seconds(kitchen.times[0]),
        seconds(kitchen.times[1])
    ))
    .on_hover_text("Ershov et al. 2001 report 0.14 s");
}
