//! The window: events in, controls and pictures out.

mod actions;

use super::super::choices::Layout;
use super::super::keys;
use super::super::panels::files::{Command, Fields};
use super::super::panels::picture::{self, Drag};
use super::super::panels::{files, help, status};
use super::super::places::Places;
use super::super::start::Start;
use super::super::window::{Loss, SIDE, areas, caption, device, pixels, show, windows};
use super::desk::Desk;
use super::engine::Engine;
use super::panel;
use super::press::Press;
use super::screen::Screen;
use crate::error::Result;
use crate::scene::Bodies;
use actions::is_known;
use eframe::egui::layers::GraphicLayers;
use eframe::egui::{
    self, CentralPanel, Color32, Context, Frame, Panel, Pos2, Rect, ScrollArea, Sense, Ui, ViewportCommand,
};
use std::path::Path;
use std::time::Duration;

/// Opens the window of a print and returns when it is closed.
///
/// # Errors
/// Those of reading the image and the inks; no display, no adapter that can do what is needed, devices that are lost again and
/// again.
pub fn open(start: &Start, image: &Path) -> Result<()> {
    windows(
        Desk::new(start, image)?,
        |desk, text| desk.tell(text, true),
        |desk, loss, losses| {
            let (places, left) = (Places::new(start.places.clone()), loss.clone());
            let lose_after = start.lose_device_after.filter(|_| losses == 0);
            show(start, |creation| Window::new(creation, desk, places, left, lose_after))
        },
    )
}

struct Window {
    /// What is open.
    desk: Desk,
    press: Press,
    screen: Screen,
    fields: Fields,
    /// Name of the adapter.
    adapter: String,
    shows_help: bool,
    shows_panels: bool,
    /// The last frame's pictures: all of each, and what is seen of it.
    panes: Vec<[Rect; 2]>,
    /// Fine pictures so far, and what the last one took.
    drawn: (usize, Duration),
    /// Events so far: all but keys, and keys.
    events: [usize; 2],
    title: String,
    places: Places,
    loss: Loss<Desk>,
    device: eframe::wgpu::Device,
    /// See [`Start::lose_device_after`].
    lose_after: Option<usize>,
}

impl Window {
    fn new(
        creation: &eframe::CreationContext<'_>,
        desk: Desk,
        places: Places,
        loss: Loss<Desk>,
        lose_after: Option<usize>,
    ) -> Result<Self> {
        let state = device(creation)?;
        let engine = Engine::of_window(state)?;
        let info = state.adapter.get_info();
        let adapter = match engine {
            Engine::Cpu => format!("CPU ({} is software, too)", info.name),
            Engine::Gpu(_) => info.name,
        };
        loss.watch(state, &desk.waker);
        desk.waker.set(&creation.egui_ctx);
        Ok(Self {
            press: Press::new(engine, desk.waker.clone()),
            desk,
            screen: Screen::default(),
            fields: Fields { picture: "proof.png".into(), ..Fields::default() },
            adapter,
            shows_help: false,
            shows_panels: true,
            panes: Vec::new(),
            drawn: (0, Duration::ZERO),
            events: [0; 2],
            title: String::new(),
            places,
            loss,
            device: state.device.clone(),
            lose_after,
        })
    }

    /// Takes the pictures that have been made, and complaints.
    fn take(&mut self, context: &Context) {
        for outcome in self.press.take() {
            match outcome {
                Ok(proof) => {
                    self.screen.take(context, &proof);
                    if let Some(time) = proof.time {
                        self.drawn = (self.drawn.0 + 1, time);
                    }
                }
                Err(e) if !self.loss.is_known() => self.desk.tell(e.to_string(), true),
                Err(_) => {}
            }
        }
    }

    fn side(&mut self, ui: &mut Ui) {
        let Self { desk, places, fields, .. } = self;
        let command = ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            panel::show(ui, places, desk);
            let hint = "An image (.png, .jpg), an ink (.ink.json) or an emission (.csv); or drop files on the window";
            files::open(ui, places, fields, hint, None).or(files::picture(ui, places, fields))
        });
        match command.inner {
            Some(Command::Open(files)) => self.desk.open(files),
            Some(Command::SavePicture(path)) => self.save(ui.ctx(), path),
            _ => {}
        }
    }

    fn foot(&mut self, ui: &mut Ui) {
        let [width, height] = self.panes.first().map_or([0; 2], |[rect, _]| pixels(*rect, ui.ctx()));
        let time = 1e3 * self.drawn.1.as_secs_f64();
        let dots =
            self.desk.image.as_ref().map_or([0; 2], |image| image.size.map(|n| n * self.desk.state.cell));
        let picture =
            format!("{width} \u{00d7} {height}, {time:.0} ms; print {} \u{00d7} {} dots", dots[0], dots[1]);
        let work = [self.desk.work(), self.press.work().into_iter().collect()].concat();
        status::show(ui, &self.adapter, &picture, &work);
    }

    /// Pictures, and what the mouse does in them.
    fn middle(&mut self, ui: &mut Ui) {
        let rect = ui.max_rect();
        let layout = self.desk.state.layout;
        self.panes = areas(rect, layout, self.desk.state.divider);
        self.places.note("picture", rect);
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        self.hand(ui, &response);
        if let Some([pane, _]) = self.panes.first() {
            self.desk.state.fit(f64::from(pane.width() / pane.height().max(1.0)));
        }
        let sizes: Vec<[usize; 2]> = self.panes.iter().map(|[rect, _]| pixels(*rect, ui.ctx())).collect();
        match self.desk.order(&sizes) {
            Ok(Some(order)) => self.press.ask(order),
            Ok(None) => {}
            Err(e) => self.desk.tell(e.to_string(), true),
        }
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        for (k, [rect, clip]) in self.panes.iter().enumerate() {
            if let Some(texture) = self.screen.get(k) {
                ui.painter_at(*clip).image(texture, *rect, whole, Color32::WHITE);
            }
            if layout != Layout::Single {
                caption(ui, *clip, layout, k, panel::model_name(self.desk.state.models[k]));
            }
        }
        if layout == Layout::Split {
            picture::divider(ui, &mut self.places, rect, &mut self.desk.state.divider);
        }
    }

    /// What the mouse does in the picture under it; where a drag began counts, wherever it has led since.
    fn hand(&mut self, ui: &Ui, response: &egui::Response) {
        let pointer = ui.input(|i| i.pointer.latest_pos());
        let held = ui.input(|i| i.pointer.press_origin()).filter(|_| response.dragged()).or(pointer);
        let pane = held.and_then(|held| self.panes.iter().find(|[_, clip]| clip.contains(held)));
        let Some([rect, _]) = pane else { return };
        match picture::asked(ui, response) {
            Some(Drag::Lamp(points)) => self.desk.state.lamp.turn(points),
            Some(Drag::Pan(points)) => self.desk.state.orbit.pan(points / f64::from(rect.height())),
            Some(Drag::Turn(points)) => {
                if response.drag_started()
                    && let Ok(Some(request)) = self.desk.request(Default::default(), pixels(*rect, ui.ctx()))
                    && let Ok(bodies) = Bodies::new(&request.scene)
                {
                    picture::pivot(&mut self.desk.state.orbit, &request.scene, &bodies);
                }
                self.desk.state.orbit.orbit(points);
            }
            None => {}
        }
        if response.double_clicked() {
            self.desk.state.home();
        }
        picture::zoom(ui, response, *rect, &mut self.desk.state.orbit);
    }

    /// Says where controls stand and what the window shows, for who drives it from outside.
    fn report(&mut self) {
        let Self { places, desk, .. } = self;
        places.say("shape", desk.state.shape);
        places.say("layout", desk.state.layout.name());
        places.say("lamp is on", desk.state.lamp.is_on);
        places.say("is busy", desk.is_busy());
        places.say("is settled", self.press.is_settled());
        places.say("drawn", self.drawn.0);
        places.say("messages", desk.messages.len());
        places.say("events", self.events[0]);
        places.say("keys", self.events[1]);
    }
}

impl eframe::App for Window {
    fn logic(&mut self, context: &Context, _: &mut eframe::Frame) {
        self.desk.step();
        self.take(context);
        let title = self.desk.title();
        if title != self.title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if self.lose_after.take_if(|n| self.drawn.0 >= *n).is_some() {
            self.device.destroy();
        }
        if self.loss.is_found() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        // An empty frame needs no device.
        if self.loss.is_known() {
            return;
        }
        let context = ui.ctx().clone();
        self.places.begin_frame();
        let is_key = |event: &&egui::Event| matches!(event, egui::Event::Key { .. });
        let keys = context.input(|i| i.raw.events.iter().filter(is_key).count());
        self.events[0] += context.input(|i| i.raw.events.len()) - keys;
        self.events[1] += keys;
        let is_editing = context.egui_wants_keyboard_input();
        for action in context.input_mut(|input| keys::actions(input, is_editing)) {
            self.act(&context, action);
        }
        let dropped = context.input(|i| i.raw.dropped_files.clone());
        self.desk.open(dropped.iter().map(|file| file.path().to_owned()));
        if self.shows_panels {
            let flat = Frame::side_top_panel(ui.style());
            Panel::bottom("foot").frame(flat).show(ui, |ui| self.foot(ui));
            Panel::right("right").resizable(false).exact_size(SIDE).show(ui, |ui| self.side(ui));
        }
        CentralPanel::no_frame().show(ui, |ui| self.middle(ui));
        status::messages(&context, &mut self.places, &mut self.desk.messages);
        let (places, is_open) = (&mut self.places, &mut self.shows_help);
        help::show(&context, places, is_open, |binding| binding.does(is_known), help::PRINT_FILES);
        self.report();
        if self.places.has_news() {
            context.request_repaint();
        }
        if self.loss.is_found() {
            // Without a device egui panics, unless there is nothing to draw.
            context.graphics_mut(|layers| *layers = GraphicLayers::default());
            context.request_repaint();
        }
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        self.loss.leave(&mut self.desk);
    }
}
