//! What every window has around its pictures: fields, help, messages, keys, a title, and what comes of a device that is lost.

use super::super::keys::{self, Action, Binding};
use super::super::panels::files::Fields;
use super::super::panels::help;
use super::super::panels::status::{self, Message};
use super::super::places::Places;
use super::super::start::Start;
use super::super::waker::Waker;
use super::{Loss, device};
use crate::error::Result;
use eframe::CreationContext;
use eframe::egui::layers::GraphicLayers;
use eframe::egui::{Context, Event, ViewportCommand};

/// What every window has; `D` is what is open in it.
pub struct Shell<D> {
    /// Where controls stand.
    pub places: Places,
    /// What the fields of files hold.
    pub fields: Fields,
    /// Whether there is anything around the pictures.
    pub shows_panels: bool,
    /// What a lost device leaves.
    pub loss: Loss<D>,
    shows_help: bool,
    /// Events so far: all but keys, and keys.
    events: [usize; 2],
    /// What the window is called.
    title: String,
}

impl<D: Default + Send + 'static> Shell<D> {
    /// That of a window that is being made: from now on it is woken, when its device is lost, too.
    ///
    /// # Errors
    /// As [`device`].
    pub fn new(
        creation: &CreationContext<'_>,
        start: &Start,
        waker: &Waker,
        loss: &Loss<D>,
        fields: Fields,
    ) -> Result<Self> {
        loss.watch(device(creation)?, waker);
        waker.set(&creation.egui_ctx);
        Ok(Self {
            places: Places::new(start.places.clone()),
            fields,
            shows_panels: true,
            loss: loss.clone(),
            shows_help: false,
            events: [0; 2],
            title: String::new(),
        })
    }

    /// Before a frame: what the window is called; one that has lost its device is closed.
    pub fn step(&mut self, context: &Context, title: String) {
        if title != self.title {
            context.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if self.loss.is_found() {
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Begins a frame: what keys ask for; none if the device is gone. An empty frame needs no device.
    pub fn begin(&mut self, context: &Context) -> Option<Vec<Action>> {
        if self.loss.is_known() {
            return None;
        }
        self.places.begin_frame();
        let is_key = |event: &&Event| matches!(event, Event::Key { .. });
        let keys = context.input(|i| i.raw.events.iter().filter(is_key).count());
        self.events[0] += context.input(|i| i.raw.events.len()) - keys;
        self.events[1] += keys;
        let is_editing = context.egui_wants_keyboard_input();
        Some(context.input_mut(|input| keys::actions(input, is_editing)))
    }

    /// Does what a key asks for, if it is of what every window has.
    pub fn act(&mut self, context: &Context, action: Action, messages: &mut Vec<Message>) {
        match action {
            Action::Help => self.shows_help = !self.shows_help,
            Action::Panels => self.shows_panels = !self.shows_panels,
            Action::Dismiss => {
                self.shows_help = false;
                messages.clear();
            }
            Action::Quit => context.send_viewport_cmd(ViewportCommand::Close),
            Action::Open => {
                self.shows_panels = true;
                self.fields.wants_focus = true;
            }
            _ => {}
        }
    }

    /// Ends a frame: messages and help over everything else, for which see [`help::show`], and what was said of the window.
    pub fn end(
        &mut self,
        context: &Context,
        messages: &mut Vec<Message>,
        holds: impl Fn(&Binding) -> bool,
        files: &[(&'static str, &'static str)],
    ) {
        status::messages(context, &mut self.places, messages);
        help::show(context, &mut self.places, &mut self.shows_help, holds, files);
        let [events, keys] = self.events;
        self.places.say("messages", messages.len());
        self.places.say("events", events);
        self.places.say("keys", keys);
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
