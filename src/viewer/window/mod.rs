//! The window: events in, panels and pictures out.

mod actions;
mod loss;
mod panes;
mod shell;

use super::desk::{Desk, Tab};
use super::frame_times::FrameTimes;
use super::measure::Spot;
use super::panels::files::{Command, Fields};
use super::panels::{composition, files, help, light, measure, mix, status, view};
use super::picture::{Pictures, setup};
use super::shelf::Ready;
use super::stage::Grip;
use super::start::Start;
use super::state::Shown;
use crate::color::srgb_encode;
use crate::error::{Error, Result};
use crate::scene::Bodies;
pub use actions::look;
use eframe::egui::{self, CentralPanel, Color32, Context, Frame, Panel, ScrollArea, Ui, Vec2};
use eframe::egui_wgpu::RenderState;
pub use loss::{Loss, windows};
use panes::Pane;
pub use panes::{areas, caption, pixels};
pub use shell::Shell;
use std::time::Duration;

/// Width of the panels beside the picture, points.
pub const SIDE: f32 = 296.0;

/// Opens the window and returns when it is closed. A window that loses its device is closed and opened anew on another one, with
/// all that was open.
///
/// # Errors
/// What [`Start::check`] finds; no display, no adapter that can do what is needed, devices that are lost again and again.
pub fn open(start: &Start) -> Result<()> {
    start.check()?;
    windows(
        Desk::new(start),
        |desk, text| desk.tell(text, true),
        |desk, loss, losses| show(start, |creation| Window::new(creation, start, desk, loss, losses)),
    )
}

/// Shows a window until it is closed.
///
/// # Errors
/// Those of `create`; no display, no adapter that can do what is needed.
pub fn show<A: eframe::App + 'static>(
    start: &Start,
    create: impl FnOnce(&eframe::CreationContext<'_>) -> Result<A>,
) -> Result<()> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("carpaint")
            .with_app_id("carpaint")
            .with_inner_size([1280.0, 800.0])
            .with_drag_and_drop(true),
        wgpu_options: eframe::egui_wgpu::WgpuConfiguration {
            wgpu_setup: setup(start.adapter.clone()).into(),
            ..Default::default()
        },
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(|creation| {
        let context = &creation.egui_ctx;
        context.set_theme(egui::Theme::Dark);
        context.all_styles_mut(|style| style.spacing.item_spacing = Vec2::new(6.0, 4.0));
        Ok(Box::new(create(creation)?) as Box<dyn eframe::App>)
    });
    eframe::run_native("carpaint", options, create).map_err(failure)
}

/// The device that draws a window.
///
/// # Errors
/// There is none.
pub fn device<'a>(creation: &'a eframe::CreationContext<'_>) -> Result<&'a RenderState> {
    let none = || Error::gpu("view", "device", "none", "one that draws the window");
    creation.wgpu_render_state.as_ref().ok_or_else(none)
}

/// What kept the window from opening, in our words.
fn failure(error: eframe::Error) -> Error {
    match error {
        eframe::Error::Wgpu(e) => {
            Error::gpu("view", "adapter", e, "a Vulkan, Metal, Direct3D 12 or OpenGL driver")
        }
        eframe::Error::AppCreation(e) => Error::gpu("view", "window", e, "one that opens"),
        e => no_display(&e.to_string()),
    }
}

/// No window system, as the driver of windows complains.
fn no_display(complaint: &str) -> Error {
    let is_unset = |name| std::env::var_os(name).is_none_or(|value| value.is_empty());
    let has_none = cfg!(all(unix, not(target_os = "macos")))
        && ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().all(is_unset);
    let found = match has_none {
        true => "none (neither DISPLAY nor WAYLAND_DISPLAY is set)",
        false => without_place(complaint),
    };
    let legal = "a screen that windows open on, X11 or Wayland; carpaint render draws pictures without one";
    Error::invalid("view", "display", found, legal)
}

/// A complaint without the place in the source that it names in front: `os error at FILE:LINE: what is wrong`.
fn without_place(complaint: &str) -> &str {
    let (_, behind) = complaint.split_once("os error at ").unwrap_or(("", complaint));
    behind.split_once(".rs:").and_then(|(_, line)| line.split_once(": ")).map_or(behind, |(_, what)| what)
}

struct Window {
    /// What is open.
    desk: Desk,
    shell: Shell<Desk>,
    pictures: Pictures,
    runs: bool,
    times: FrameTimes,
    /// Pictures drawn so far, coarse ones too.
    drawn: usize,
    /// What the last frame's panes showed, and where.
    panes: Vec<Pane>,
    spot: Option<Spot>,
    /// The objects of the scene, for what the mouse meets.
    bodies: Bodies,
    /// How the capsule of the demonstration is held.
    grip: Option<Grip>,
    /// Whether every pane shows all of its picture as finely as it gets.
    is_settled: bool,
    /// How long none of the others needs to be drawn.
    rest: Duration,
    /// Devices lost before this window.
    losses: usize,
    /// See [`Start::lose_device_after`].
    lose_after: Option<usize>,
    /// See [`Start::lose_device_late_after`].
    lose_late_after: Option<usize>,
}

impl Window {
    fn new(
        creation: &eframe::CreationContext<'_>,
        start: &Start,
        desk: Desk,
        loss: &Loss<Desk>,
        losses: usize,
    ) -> Result<Self> {
        let pictures = Pictures::new(device(creation)?, desk.waker.clone())?;
        let shell = Shell::new(creation, start, &desk.waker, loss, Fields::default())?;
        Ok(Self {
            desk,
            shell,
            pictures,
            runs: false,
            times: FrameTimes::default(),
            drawn: 0,
            panes: Vec::new(),
            spot: None,
            bodies: Bodies::default(),
            grip: None,
            is_settled: false,
            rest: Duration::ZERO,
            losses,
            lose_after: start.lose_device_after,
            lose_late_after: start.lose_device_late_after,
        })
    }

    fn left(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            for (tab, name) in [(Tab::Mix, "Mix"), (Tab::Composition, "Composition"), (Tab::Files, "Files")] {
                let response = ui.selectable_value(&mut self.desk.tab, tab, name);
                self.shell.places.note(format!("tab {name}"), response.rect);
            }
        });
        let colors: Vec<Color32> = self.desk.paints().iter().map(|ready| swatch(ready.as_deref())).collect();
        let Self { desk, shell: Shell { places, fields, .. }, .. } = self;
        let command = ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            match (desk.tab, &desk.document) {
                (Tab::Mix, Some(document)) => {
                    mix::show(ui, places, &mut desk.state, document, &colors);
                    None
                }
                (Tab::Mix, None) => {
                    ui.add_space(8.0);
                    ui.label("Nothing is open yet.");
                    None
                }
                (Tab::Composition, _) => match composition::show(ui, places, &mut desk.kitchen) {
                    Some(composition::Asked::Look) => {
                        desk.state.shown[0] = Shown::Recipe;
                        None
                    }
                    Some(composition::Asked::Save) => Some(Command::SaveComposition),
                    None => None,
                },
                (Tab::Files, document) => files::show(ui, places, fields, document.is_some()),
            }
        });
        if let Some(command) = command.inner {
            self.command(ui.ctx(), command);
        }
    }

    fn right(&mut self, ui: &mut Ui) {
        let shown = [Some(self.desk.state.shown[0]), self.desk.state.second()];
        let worn = shown.map(|shown| shown.and_then(|shown| self.desk.one(shown)));
        let shelf = &mut self.desk.shelf;
        let read = worn.each_ref().map(|worn| worn.as_ref().and_then(|worn| shelf.last(worn)));
        let is_old = worn.iter().flatten().any(|worn| shelf.ready(worn).is_none());
        let Self { shell: Shell { places, .. }, desk, spot, times, runs, .. } = self;
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            view::show(ui, places, &mut desk.state, desk.document.as_ref(), desk.shelf.has_recipe());
            light::show(ui, places, &mut desk.state);
            if let [Some(first), second] = &read {
                measure::instrument(ui, &first.instrument, second.as_ref().map(|s| &s.instrument), is_old);
            }
            measure::spot(ui, spot.as_ref());
            measure::frame_times(ui, times, runs);
        });
    }

    fn foot(&mut self, ui: &mut Ui) {
        let work = [self.desk.work(), self.pictures.work()].concat();
        let picture = match self.panes.first().map(|pane| (pane.rect, pane.shown)) {
            Some((rect, shown)) => {
                let [width, height] = pixels(rect, ui.ctx());
                let pixel_um = 1e3 * self.desk.state.orbit.field_mm() / height.max(1) as f64;
                let texel = self.desk.one(shown).and_then(|worn| worn.texel_mm());
                let texel = texel.map_or_else(String::new, |mm| format!(", texel {:.3} \u{00b5}m", 1e3 * mm));
                format!("{width} \u{00d7} {height}, pixel {pixel_um:.3} \u{00b5}m{texel}")
            }
            None => "no picture".to_owned(),
        };
        status::show(ui, self.pictures.adapter(), &picture, &work);
    }

    /// Takes the device away if that is asked for: the first one while a frame is made, the second one between two.
    fn lose_device(&mut self, losses: usize) {
        if self.losses == losses && self.lose_after.take_if(|n| self.drawn >= *n).is_some() {
            self.pictures.device().destroy();
        }
    }

    /// Says where controls stand and what the window shows, for who drives it from outside.
    fn report(&mut self, context: &Context) {
        let movable = self.movable_place(context);
        let Self { shell: Shell { places, .. }, desk, .. } = self;
        places.say("lamp is on", desk.state.lamp.is_on);
        places.say("weights", desk.state.weights.clone());
        places.say("object", desk.state.object.name());
        places.say("is busy", desk.is_busy() || !self.pictures.work().is_empty());
        places.say("is settled", self.is_settled);
        places.say("drawn", self.drawn);
        places.say("losses", self.losses);
        places.say("stage", format!("{:?}", desk.kitchen.stage));
        places.say("movable", movable);
    }
}

impl eframe::App for Window {
    fn logic(&mut self, context: &Context, _: &mut eframe::Frame) {
        self.desk.step();
        self.pictures.forget_others(self.desk.document.as_ref().and_then(|document| document.mix.as_ref()));
        if let Some(rest) = self.desk.rest() {
            context.request_repaint_after(rest);
        }
        self.lose_device(1);
        self.shell.step(context, self.desk.title());
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        let Some(actions) = self.shell.begin(&context) else { return };
        for action in actions {
            self.act(&context, action);
        }
        let dropped = context.input(|i| i.raw.dropped_files.clone());
        self.desk.dropped(&dropped);
        if self.shell.shows_panels {
            let flat = Frame::side_top_panel(ui.style());
            Panel::bottom("foot").frame(flat).show(ui, |ui| self.foot(ui));
            Panel::left("left").resizable(false).exact_size(SIDE).show(ui, |ui| self.left(ui));
            Panel::right("right").resizable(false).exact_size(SIDE).show(ui, |ui| self.right(ui));
        }
        CentralPanel::no_frame().show(ui, |ui| self.middle(ui));
        self.report(&context);
        self.lose_device(0);
        self.shell.end(&context, &mut self.desk.messages, |_| true, help::PAINT_FILES);
        if self.runs {
            context.request_repaint();
        } else if !self.is_settled {
            context.request_repaint_after(self.rest);
        }
        if self.lose_late_after.is_some_and(|n| self.drawn >= n) {
            self.pictures.device().destroy();
        }
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        self.shell.loss.leave(&mut self.desk);
    }
}

/// Color of a paint in the face.
fn swatch(ready: Option<&Ready>) -> Color32 {
    let encode = |c: f64| (255.0 * srgb_encode(c)).round() as u8;
    ready.map_or(Color32::GRAY, |ready| {
        let [r, g, b] = ready.instrument.face().map(encode);
        Color32::from_rgb(r, g, b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complaints_lose_the_place_in_the_source() {
        let complaint = "winit EventLoopError: os error at /a/b: c/x11/mod.rs:12: no such thing: none";
        assert_eq!(without_place(complaint), "no such thing: none");
        assert_eq!(without_place("no such thing: none"), "no such thing: none");
    }
}
