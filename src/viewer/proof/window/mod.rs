//! The window: events in, controls and pictures out.

mod actions;

use super::super::choices::Layout;
use super::super::keys::Binding;
use super::super::panels::files::{Command, Fields};
use super::super::panels::picture::{self, Drag};
use super::super::panels::{files, help, status};
use super::super::start::Start;
use super::super::window::{Loss, SIDE, Shell, areas, caption, device, pixels, show, windows};
use super::desk::Desk;
use super::engine::Engine;
use super::panel;
use super::press::Press;
use super::screen::Screen;
use crate::error::Result;
use crate::scene::Bodies;
use actions::is_known;
use eframe::egui::{
    CentralPanel, Color32, Context, Frame, Panel, Pos2, Rect, Response, ScrollArea, Sense, Ui,
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
        |desk, loss, losses| show(start, |creation| Window::new(creation, start, desk, loss, losses)),
    )
}

struct Window {
    /// What is open.
    desk: Desk,
    shell: Shell<Desk>,
    press: Press,
    screen: Screen,
    /// Name of the adapter.
    adapter: String,
    /// The last frame's pictures: all of each, and what is seen of it.
    panes: Vec<[Rect; 2]>,
    /// Fine pictures so far, and what the last one took.
    drawn: (usize, Duration),
    device: eframe::wgpu::Device,
    /// See [`Start::lose_device_after`].
    lose_after: Option<usize>,
}

impl Window {
    fn new(
        creation: &eframe::CreationContext<'_>,
        start: &Start,
        desk: Desk,
        loss: &Loss<Desk>,
        losses: usize,
    ) -> Result<Self> {
        let state = device(creation)?;
        let engine = Engine::of_window(state)?;
        let info = state.adapter.get_info();
        let adapter = match engine {
            Engine::Cpu => format!("CPU ({} is software, too)", info.name),
            Engine::Gpu(_) => info.name,
        };
        let fields = Fields { picture: "proof.png".into(), ..Fields::default() };
        let shell = Shell::new(creation, start, &desk.waker, loss, fields)?;
        Ok(Self {
            press: Press::new(engine, desk.waker.clone()),
            desk,
            shell,
            screen: Screen::default(),
            adapter,
            panes: Vec::new(),
            drawn: (0, Duration::ZERO),
            device: state.device.clone(),
            lose_after: start.lose_device_after.filter(|_| losses == 0),
        })
    }

    /// Takes the pictures that have been made, and complaints.
    fn take(&mut self, context: &Context) {
        for outcome in self.press.take() {
            match outcome {
                Ok(proof) => {
                    self.screen.take(context, &proof);
                    self.desk.state.exposed(proof.stops);
                    if let Some(time) = proof.time {
                        self.drawn = (self.drawn.0 + 1, time);
                    }
                }
                Err(e) if !self.shell.loss.is_known() => self.desk.tell(e.to_string(), true),
                Err(_) => {}
            }
        }
    }

    fn side(&mut self, ui: &mut Ui) {
        let Self { desk, shell: Shell { places, fields, .. }, .. } = self;
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
        self.shell.places.note("picture", rect);
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
            picture::divider(ui, &mut self.shell.places, rect, &mut self.desk.state.divider);
        }
    }

    /// What the mouse does in the picture under it; where a drag began counts, wherever it has led since.
    fn hand(&mut self, ui: &Ui, response: &Response) {
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
        let Self { shell: Shell { places, .. }, desk, .. } = self;
        places.say("shape", desk.state.shape);
        places.say("layout", desk.state.layout.name());
        places.say("lamp is on", desk.state.lamp.is_on);
        places.say("is busy", desk.is_busy());
        places.say("is settled", self.press.is_settled());
        places.say("drawn", self.drawn.0);
    }
}

impl eframe::App for Window {
    fn logic(&mut self, context: &Context, _: &mut eframe::Frame) {
        self.desk.step();
        self.take(context);
        if self.lose_after.take_if(|n| self.drawn.0 >= *n).is_some() {
            self.device.destroy();
        }
        self.shell.step(context, self.desk.title());
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        let Some(actions) = self.shell.begin(&context) else { return };
        for action in actions {
            self.act(&context, action);
        }
        let dropped = context.input(|i| i.raw.dropped_files.clone());
        self.desk.open(dropped.iter().map(|file| file.path().to_owned()));
        if self.shell.shows_panels {
            let flat = Frame::side_top_panel(ui.style());
            Panel::bottom("foot").frame(flat).show(ui, |ui| self.foot(ui));
            Panel::right("right").resizable(false).exact_size(SIDE).show(ui, |ui| self.side(ui));
        }
        CentralPanel::no_frame().show(ui, |ui| self.middle(ui));
        self.report();
        let holds = |binding: &Binding| binding.does(is_known);
        self.shell.end(&context, &mut self.desk.messages, holds, help::PRINT_FILES);
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        self.shell.loss.leave(&mut self.desk);
    }
}
