//! The window: events in, panels and pictures out.

use super::demo::demo;
use super::document::{Document, Kind, stem};
use super::frame_times::FrameTimes;
use super::job::Job;
use super::keys::{self, Action};
use super::kitchen::Kitchen;
use super::measure::Spot;
use super::panels::files::{Command, Fields};
use super::panels::status::Message;
use super::panels::{self, composition, files, help, light, measure, mix, status, view};
use super::picture::{Pictures, Request, setup};
use super::places::Places;
use super::save::{self, Saved};
use super::shelf::{Ready, Shelf};
use super::stage;
use super::stage::Grip;
use super::state::{Layout, Object, Shown, State};
use super::weights;
use crate::color::srgb_encode;
use crate::error::{Error, Result};
use crate::scene::{Bodies, Scene};
use crate::simulate::Composition;
use eframe::egui::{
    self, Align2, CentralPanel, Color32, Context, Frame, Panel, Rect, ScrollArea, Sense, Ui, Vec2,
    ViewportCommand,
};
use glam::DVec2;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Width of the panels beside the picture, points.
const SIDE: f32 = 296.0;
/// Most messages at once; older ones go.
const MESSAGES: usize = 4;

/// How complaints begin that a device is lost.
const DEVICE_LOST: &str = "device lost";

/// What the window starts with.
#[derive(Debug, Clone, Default)]
pub struct Start {
    /// A mix, or paints; none: a demonstration is simulated.
    pub files: Vec<PathBuf>,
    /// Part of the name of the adapter to use.
    pub adapter: Option<String>,
    /// Where the places of controls are written, rectangles as JSON.
    pub places: Option<PathBuf>,
}

/// What the panel on the left is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tab {
    Mix,
    Composition,
    Files,
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// No display, no adapter that can do what is needed, a device that is lost.
pub fn open(start: Start) -> Result<()> {
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
    let loss = Loss::default();
    let noted = loss.clone();
    let create: eframe::AppCreator<'_> = Box::new(move |creation| {
        Window::new(&start, creation, noted)
            .map(|window| Box::new(window) as Box<dyn eframe::App>)
            .map_err(Into::into)
    });
    eframe::run_native("carpaint", options, create).map_err(failure)?;
    match loss.lock().ok().and_then(|mut loss| loss.take()) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

/// What took the device away, after which nothing can be shown, not even that.
type Loss = Arc<Mutex<Option<Error>>>;

/// What kept the window from opening, in our words.
fn failure(error: eframe::Error) -> Error {
    match error {
        eframe::Error::Wgpu(e) => {
            Error::gpu("view", "adapter", e, "a Vulkan, Metal, Direct3D 12 or OpenGL driver")
        }
        eframe::Error::AppCreation(e) => Error::gpu("view", "window", e, "one that opens"),
        e => Error::unsupported("view", "display", e, "an X11 or Wayland display"),
    }
}

struct Window {
    state: State,
    document: Option<Document>,
    shelf: Shelf,
    pictures: Pictures,
    kitchen: Kitchen,
    loading: Option<Job<Document>>,
    saving: Option<Job<Saved>>,
    fields: Fields,
    tab: Tab,
    messages: Vec<Message>,
    shows_help: bool,
    runs: bool,
    times: FrameTimes,
    /// What the last frame's panes showed, and where.
    panes: Vec<Pane>,
    spot: Option<Spot>,
    /// The objects of the scene, for what the mouse meets.
    bodies: Bodies,
    /// How the capsule of the demonstration is held.
    grip: Option<Grip>,
    /// Events so far: keys, and all others before them.
    events: [usize; 2],
    /// Whether every pane shows all of its picture as finely as it gets.
    is_settled: bool,
    places: Places,
    loss: Loss,
}

/// A part of the window that shows a picture.
struct Pane {
    index: usize,
    /// All of the picture, points.
    rect: Rect,
    /// What of it is seen.
    clip: Rect,
    shown: Shown,
}

impl Window {
    fn new(start: &Start, creation: &eframe::CreationContext<'_>, loss: Loss) -> Result<Self> {
        let context = &creation.egui_ctx;
        let Some(device) = &creation.wgpu_render_state else {
            return Err(Error::gpu("view", "device", "none", "one that draws the window"));
        };
        context.set_theme(egui::Theme::Dark);
        context.all_styles_mut(|style| style.spacing.item_spacing = Vec2::new(6.0, 4.0));
        let mut window = Self {
            state: State::default(),
            document: None,
            shelf: Shelf::default(),
            pictures: Pictures::new(device)?,
            kitchen: Kitchen::default(),
            loading: None,
            saving: None,
            fields: Fields::default(),
            tab: Tab::Mix,
            messages: Vec::new(),
            shows_help: false,
            runs: false,
            times: FrameTimes::default(),
            panes: Vec::new(),
            spot: None,
            bodies: Bodies::default(),
            grip: None,
            events: [0; 2],
            is_settled: false,
            places: Places::new(start.places.clone()),
            loss,
        };
        if start.files.is_empty() {
            window.loading = Some(Job::start(waker(context), demo));
        } else {
            window.open(context, start.files.clone(), false);
        }
        Ok(window)
    }

    /// Opens files, in place of what is open or beside it.
    fn open(&mut self, context: &Context, files: Vec<PathBuf>, adds: bool) {
        if let [file] = &files[..]
            && let Some(outcome) = self.open_beside(file)
        {
            if let Err(e) = outcome {
                self.fail(&e);
            }
            return;
        }
        let open = self.document.clone().filter(|_| adds);
        self.loading =
            Some(Job::start(waker(context), move |progress| Document::read(&files, open.as_ref(), progress)));
    }

    /// Opens a file that holds no paint: a composition, surroundings, a mesh. None: it is none of these.
    fn open_beside(&mut self, file: &Path) -> Option<Result<()>> {
        let file = file.to_owned();
        Some(match Kind::of(&file) {
            Kind::Paint => return None,
            Kind::Composition => Composition::read(&file).map(|composition| {
                self.kitchen.open(composition, &stem(&file));
                self.tab = Tab::Composition;
                self.state.shown[0] = Shown::Recipe;
            }),
            Kind::Surroundings => self.state.set_panorama(file),
            Kind::Mesh => self.state.set_mesh(file),
        })
    }

    fn fail(&mut self, error: &Error) {
        self.tell(error.to_string(), true);
    }

    /// Says something once.
    fn tell(&mut self, text: String, is_error: bool) {
        let message = Message { text, is_error };
        if !self.messages.contains(&message) {
            self.messages.push(message);
        }
        let surplus = self.messages.len().saturating_sub(MESSAGES);
        self.messages.drain(..surplus);
    }

    /// Takes what threads have finished.
    fn collect(&mut self, context: &Context) {
        match self.loading.as_ref().and_then(Job::poll) {
            Some(Ok(document)) => {
                self.loading = None;
                context.send_viewport_cmd(ViewportCommand::Title(format!("{} - carpaint", document.title())));
                self.state.opened(document.paints.len());
                self.shelf.opened(&document);
                self.document = Some(document);
            }
            Some(Err(e)) => {
                self.loading = None;
                self.fail(&e);
            }
            None => {}
        }
        match self.kitchen.step(|| waker(context)) {
            Some(Ok(ready)) => self.shelf.set_recipe(ready),
            Some(Err(e)) => self.fail(&e),
            None => {}
        }
        if let Some(rest) = self.kitchen.is_resting() {
            context.request_repaint_after(rest);
        }
        if let Some(result) = self.saving.as_ref().and_then(Job::poll) {
            self.saving = None;
            match result {
                Ok(saved) => self.tell(saved.to_string(), false),
                Err(e) => self.fail(&e),
            }
        }
    }

    fn act(&mut self, context: &Context, action: Action) {
        let state = &mut self.state;
        let n = state.weights.len();
        match action {
            Action::Help => self.shows_help = !self.shows_help,
            Action::Dismiss => {
                self.shows_help = false;
                self.messages.clear();
            }
            Action::Quit => context.send_viewport_cmd(ViewportCommand::Close),
            Action::Open => {
                self.tab = Tab::Files;
                self.fields.wants_focus = true;
            }
            Action::SavePicture => {
                self.command(context, Command::SavePicture(self.fields.picture.trim().into()))
            }
            Action::SavePaint => self.command(context, Command::SavePaint(self.fields.paint.trim().into())),
            Action::Lamp => state.lamp.is_on = !state.lamp.is_on,
            Action::Surroundings => state.next_surroundings(),
            Action::Object => state.next_object(),
            Action::Flakes => state.flakes = !state.flakes,
            Action::Layout => state.layout = state.layout.next(),
            Action::Channels => state.next_channels(),
            Action::Extrapolate => state.set_extrapolates(!state.extrapolates),
            Action::Home => state.home(),
            Action::Run => self.runs = !self.runs,
            Action::Zoom(factor) => state.orbit.zoom(factor, DVec2::ZERO),
            Action::Orbit(right, down) => state.orbit.orbit(DVec2::new(right, down)),
            Action::Expose(stops) => {
                let (low, high) = (*State::EXPOSURE.start(), *State::EXPOSURE.end());
                state.exposure_stops = (state.exposure_stops + stops).clamp(low, high);
            }
            Action::Equal => state.weights = weights::equal(n),
            Action::Only(k) if k < n => state.weights = weights::only(k, n),
            Action::Only(_) => {}
        }
    }

    fn command(&mut self, context: &Context, command: Command) {
        let outcome = match command {
            Command::Open(files) => {
                self.open(context, files, false);
                Ok(())
            }
            Command::Add(file) => {
                self.open(context, vec![file], true);
                Ok(())
            }
            Command::SavePicture(path) => self.save_picture(context, path),
            Command::SavePaint(path) => self.save_paint(&path),
            Command::SaveComposition => self.kitchen.save().map(|text| self.tell(text, false)),
        };
        if let Err(e) = outcome {
            self.fail(&e);
        }
    }

    /// The pictures now seen, rendered with care, side by side where they are two.
    fn save_picture(&mut self, context: &Context, path: PathBuf) -> Result<()> {
        if self.saving.is_some() {
            return Err(Error::invalid("save picture", "work", "another picture", "one at a time"));
        }
        let size = self.panes.first().map(|pane| pixels(pane.rect, context)).unwrap_or([640, 480]);
        let shown: Vec<Shown> = self.panes.iter().map(|pane| pane.shown).collect();
        let all = [0, size[0]];
        let requests = shown.into_iter().map(|s| self.request(s, size, all)).collect::<Result<Vec<_>>>()?;
        let split = (self.state.layout == Layout::Split).then_some(f64::from(self.state.divider));
        let order = save::Order { requests, split, path, samples: self.fields.samples };
        self.saving = Some(Job::start(waker(context), move |progress| order.run(progress)));
        Ok(())
    }

    fn save_paint(&mut self, path: &Path) -> Result<()> {
        let Some(document) = &self.document else {
            return Err(Error::invalid("save paint", "paint", "none", "an open one"));
        };
        let paint = match &document.mix {
            Some(mix) => mix.blend_with(&self.state.weights, &self.state.blend)?,
            None => (*document.paints[0].paint).clone(),
        };
        let saved = save::paint(&paint, path)?;
        self.tell(saved.to_string(), false);
        Ok(())
    }

    fn request(&mut self, shown: Shown, size: [usize; 2], columns: [usize; 2]) -> Result<Request> {
        let scene = self.state.scene(size);
        let mut get = |shown| self.shelf.get(shown, self.document.as_ref(), &self.state);
        let paints = self.state.worn(shown).into_iter().map(&mut get).collect::<Result<_>>()?;
        Ok(Request { scene, paints, flakes: self.state.flakes, seed: self.state.seed, columns })
    }

    /// Colors of the paints in the face, for swatches.
    fn swatches(&mut self) -> Vec<Color32> {
        let Some(document) = &self.document else { return Vec::new() };
        let encode = |c: f64| (255.0 * srgb_encode(c)).round() as u8;
        (0..document.paints.len())
            .map(|k| match self.shelf.get(Shown::Paint(k), Some(document), &self.state) {
                Ok(ready) => {
                    let [r, g, b] = ready.instrument.face().map(encode);
                    Color32::from_rgb(r, g, b)
                }
                Err(_) => Color32::GRAY,
            })
            .collect()
    }

    /// The paint of a pane, if it can be had.
    fn ready(&mut self, shown: Shown) -> Option<Arc<Ready>> {
        self.shelf.get(shown, self.document.as_ref(), &self.state).ok()
    }

    fn left(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            for (tab, name) in [(Tab::Mix, "Mix"), (Tab::Composition, "Composition"), (Tab::Files, "Files")] {
                let response = ui.selectable_value(&mut self.tab, tab, name);
                self.places.note(format!("tab {name}"), response.rect);
            }
        });
        let colors = self.swatches();
        let command = ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            match (self.tab, &self.document) {
                (Tab::Mix, Some(document)) => {
                    mix::show(ui, &mut self.places, &mut self.state, document, &colors);
                    None
                }
                (Tab::Mix, None) => {
                    ui.add_space(8.0);
                    ui.label("Nothing is open yet.");
                    None
                }
                (Tab::Composition, _) => match composition::show(ui, &mut self.places, &mut self.kitchen) {
                    Some(composition::Asked::Look) => {
                        self.state.shown[0] = Shown::Recipe;
                        None
                    }
                    Some(composition::Asked::Save) => Some(Command::SaveComposition),
                    None => None,
                },
                (Tab::Files, document) => {
                    files::show(ui, &mut self.places, &mut self.fields, document.is_some())
                }
            }
        });
        if let Some(command) = command.inner {
            self.command(ui.ctx(), command);
        }
    }

    fn right(&mut self, ui: &mut Ui) {
        let [first, second] = [Some(self.state.shown[0]), self.state.second()]
            .map(|shown| shown.and_then(|shown| self.ready(shown)));
        let Self { places, state, document, shelf, spot, times, runs, .. } = self;
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            view::show(ui, places, state, document.as_ref(), shelf.has_recipe());
            light::show(ui, places, state);
            if let Some(first) = &first {
                measure::instrument(ui, &first.instrument, second.as_ref().map(|s| &s.instrument));
            }
            measure::spot(ui, spot.as_ref());
            measure::frame_times(ui, times, runs);
        });
    }

    fn foot(&mut self, ui: &mut Ui) {
        let mut work: Vec<(String, f32)> = Vec::new();
        work.extend(self.loading.as_ref().map(Job::progress));
        work.extend(self.saving.as_ref().map(Job::progress));
        work.extend(self.kitchen.progress());
        let picture = match self.panes.first() {
            Some(pane) => {
                let [width, height] = pixels(pane.rect, ui.ctx());
                let pixel_um = 1e3 * self.state.orbit.field_mm() / height.max(1) as f64;
                let texel = self.ready(pane_shown(&self.panes)).and_then(|ready| ready.texel_mm);
                let texel = texel.map_or_else(String::new, |mm| format!(", texel {:.3} \u{00b5}m", 1e3 * mm));
                format!("{width} \u{00d7} {height}, pixel {pixel_um:.3} \u{00b5}m{texel}")
            }
            None => "no picture".to_owned(),
        };
        status::show(ui, self.pictures.adapter(), &picture, &work);
    }

    /// Where pictures go in the middle of the window.
    fn lay_out(&self, rect: Rect) -> Vec<Pane> {
        let [first, second] = self.state.shown;
        let whole = |index, rect, shown| Pane { index, rect, clip: rect, shown };
        match self.state.layout {
            Layout::Single => vec![whole(0, rect, first)],
            Layout::Split => {
                let (left, right) = rect.split_left_right_at_fraction(self.state.divider);
                vec![
                    Pane { index: 0, rect, clip: left, shown: first },
                    Pane { index: 1, rect, clip: right, shown: second },
                ]
            }
            Layout::SideBySide => {
                let (left, right) = rect.split_left_right_at_fraction(0.5);
                let gap = Vec2::new(1.0, 0.0);
                vec![
                    whole(0, Rect::from_min_max(left.min, left.max - gap), first),
                    whole(1, Rect::from_min_max(right.min + gap, right.max), second),
                ]
            }
        }
    }

    fn middle(&mut self, ui: &mut Ui) {
        let rect = ui.max_rect();
        self.panes = self.lay_out(rect);
        self.places.note("picture", rect);
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        self.spot = None;
        self.is_settled = true;
        let document = self.document.as_ref();
        let names: Vec<String> =
            self.panes.iter().map(|pane| view::shown_name(pane.shown, document)).collect();
        let pointer = ui.input(|i| i.pointer.latest_pos());
        let is_split = self.state.layout == Layout::Split;
        // Where a drag began counts, wherever it has led since.
        let held = ui.input(|i| i.pointer.press_origin()).filter(|_| response.dragged()).or(pointer);
        for (k, name) in names.iter().enumerate() {
            let Pane { index, rect, clip, shown } = self.panes[k];
            let size = pixels(rect, ui.ctx());
            // Of a window that is closed to a slit there is nothing to draw.
            if size.contains(&0) || clip.width() < 1.0 {
                continue;
            }
            let scene = self.state.scene(size);
            match self.bodies.changed(&scene) {
                Ok(bodies) => self.bodies = bodies,
                Err(e) => self.fail(&e),
            }
            let has_pointer = pointer.is_some_and(|p| clip.contains(p)) && response.contains_pointer();
            if held.is_some_and(|p| clip.contains(p)) {
                let world = (&scene, &self.bodies);
                panels::picture::drag(ui, &response, rect, &mut self.state, world, &mut self.grip);
            }
            if self.ready(shown).is_none() {
                self.wait(ui, clip);
                continue;
            }
            let drawn = self.draw(index, shown, size, columns(rect, clip, size[0]));
            if let Err(e) = &drawn {
                self.fail(e);
                self.note_loss(ui.ctx(), e);
            }
            if let Some(layers) = self.pictures.layers(index) {
                panels::picture::layers(&ui.painter_at(clip), rect, layers);
            }
            if self.panes.len() > 1 {
                let (at, anchor) = match (is_split, k) {
                    (true, 1) => (clip.right_top() + Vec2::new(-12.0, 12.0), Align2::RIGHT_TOP),
                    _ => (clip.left_top() + Vec2::new(12.0, 12.0), Align2::LEFT_TOP),
                };
                panels::picture::caption(&ui.painter_at(clip), at, anchor, name);
            }
            if let (true, Some(pointer), Ok(request)) = (has_pointer, pointer, &drawn) {
                let at = (pointer - rect.min) * ui.ctx().pixels_per_point();
                let paints: Vec<_> = request.paints.iter().map(|ready| &ready.paint).collect();
                let pixel = [f64::from(at.x), f64::from(at.y)];
                self.spot = Spot::at(&request.scene, &self.bodies, &paints, pixel);
            }
        }
        if is_split {
            panels::picture::divider(ui, &mut self.places, rect, &mut self.state.divider);
        }
        let height = pixels(rect, ui.ctx())[1].max(1);
        measure::scale_bar(ui, rect, self.state.orbit.field_mm() / height as f64);
    }

    /// Where the middle of the movable capsule is seen, points; null without the demonstration.
    fn movable_place(&self, context: &Context) -> serde_json::Value {
        let Some(pane) = self.panes.first().filter(|_| self.state.object == Object::Demonstration) else {
            return serde_json::Value::Null;
        };
        let scene = self.state.scene(pixels(pane.rect, context));
        let Some([x, y]) = stage::seen_at(&scene, self.state.movable) else { return serde_json::Value::Null };
        let scale = f64::from(context.pixels_per_point());
        let origin = pane.rect.min;
        serde_json::json!([f64::from(origin.x) + x / scale, f64::from(origin.y) + y / scale])
    }

    /// Says in a pane that there is no paint for it yet.
    fn wait(&self, ui: &Ui, clip: Rect) {
        let is_busy = self.loading.is_some() || self.kitchen.progress().is_some();
        let text = if is_busy { "making paints ready" } else { "open a mix, a paint or a composition" };
        let font = egui::FontId::proportional(18.0);
        ui.painter_at(clip).text(clip.center(), Align2::CENTER_CENTER, text, font, Color32::GRAY);
    }

    /// A device that is lost is the end of the window.
    fn note_loss(&self, context: &Context, error: &Error) {
        let Error::Gpu(fault) = error else { return };
        if fault.found.contains(DEVICE_LOST)
            && let Ok(mut loss) = self.loss.lock()
        {
            *loss = Some(Error::Gpu(fault.clone()));
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Draws a pane anew if it shows something else; what it shows.
    fn draw(&mut self, pane: usize, shown: Shown, size: [usize; 2], columns: [usize; 2]) -> Result<Request> {
        let request = self.request(shown, size, columns)?;
        let drawn = self.pictures.draw(pane, &request, self.runs)?;
        if let Some(time) = drawn.time {
            self.times.push(time);
            if shown == Shown::Recipe {
                self.kitchen.seen();
            }
        }
        self.is_settled &= !drawn.is_partial;
        Ok(request)
    }
}

impl eframe::App for Window {
    fn logic(&mut self, context: &Context, _: &mut eframe::Frame) {
        self.collect(context);
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
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
        let dropped: Vec<PathBuf> =
            context.input(|i| i.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        if !dropped.is_empty() {
            self.command(&context, Command::Open(dropped));
        }
        let flat = Frame::side_top_panel(ui.style());
        Panel::bottom("foot").frame(flat).show(ui, |ui| self.foot(ui));
        Panel::left("left").resizable(false).exact_size(SIDE).show(ui, |ui| self.left(ui));
        Panel::right("right").resizable(false).exact_size(SIDE).show(ui, |ui| self.right(ui));
        CentralPanel::no_frame().show(ui, |ui| self.middle(ui));
        status::messages(&context, &mut self.places, &mut self.messages);
        help::show(&context, &mut self.places, &mut self.shows_help);
        self.places.say("lamp is on", self.state.lamp.is_on);
        self.places.say("weights", self.state.weights.clone());
        self.places.say("is busy", self.loading.is_some() || self.saving.is_some());
        self.places.say("is settled", self.is_settled);
        self.places.say("messages", self.messages.len());
        self.places.say("stage", format!("{:?}", self.kitchen.stage));
        self.places.say("events", self.events[0]);
        self.places.say("keys", self.events[1]);
        self.places.say("movable", self.movable_place(&context));
        if self.runs || !self.is_settled || self.places.has_news() {
            context.request_repaint();
        }
    }
}

/// What makes the window look again, from any thread.
fn waker(context: &Context) -> impl Fn() + Send + Sync + 'static {
    let context = context.clone();
    move || context.request_repaint()
}

/// Size of a rectangle, pixels, as large as a scene may be.
fn pixels(rect: Rect, context: &Context) -> [usize; 2] {
    let size = rect.size() * context.pixels_per_point();
    [size.x, size.y].map(|side| (side.round().max(0.0) as usize).min(Scene::MAX_SIDE / 4))
}

/// The columns of a picture in `rect`, `width` pixels wide, that are seen in `clip`.
fn columns(rect: Rect, clip: Rect, width: usize) -> [usize; 2] {
    let at = |x: f32| (x - rect.left()) / rect.width().max(1e-6) * width as f32;
    let first = at(clip.left()).floor().max(0.0) as usize;
    [first.min(width), (at(clip.right()).ceil().max(0.0) as usize).min(width)]
}

/// What the first pane shows.
fn pane_shown(panes: &[Pane]) -> Shown {
    panes.first().map_or(Shown::Blend, |pane| pane.shown)
}
