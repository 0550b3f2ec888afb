//! What keys and panels ask for.

use super::super::keys::Action;
use super::super::light::Lamp;
use super::super::orbit::Orbit;
use super::super::panels::files::Command;
use super::super::save;
use super::super::state::{Layout, Shown, State};
use super::super::weights;
use super::panes::pixels;
use super::{Tab, Window};
use crate::error::Result;
use eframe::egui::Context;
use glam::DVec2;
use std::path::PathBuf;

/// Does what a key asks for, if it is of what every window looks with: lamp, layout, eye, and exposure in stops.
pub fn look(action: Action, lamp: &mut Lamp, layout: &mut Layout, eye: &mut Orbit, exposure: &mut f64) {
    match action {
        Action::Lamp => lamp.is_on = !lamp.is_on,
        Action::Layout => *layout = layout.next(),
        Action::Zoom(factor) => eye.zoom(factor, DVec2::ZERO),
        Action::Orbit(right, down) => eye.orbit(DVec2::new(right, down)),
        Action::Expose(stops) => {
            let (low, high) = (*State::EXPOSURE.start(), *State::EXPOSURE.end());
            *exposure = (*exposure + stops).clamp(low, high);
        }
        _ => {}
    }
}

impl Window {
    /// Does what a key asks for.
    pub(super) fn act(&mut self, context: &Context, action: Action) {
        self.shell.act(context, action, &mut self.desk.messages);
        let state = &mut self.desk.state;
        look(action, &mut state.lamp, &mut state.layout, &mut state.orbit, &mut state.exposure_stops);
        let n = state.weights.len();
        match action {
            Action::Open => self.desk.tab = Tab::Files,
            Action::SavePicture => {
                self.command(context, Command::SavePicture(self.shell.fields.picture.trim().into()))
            }
            Action::SavePaint => {
                self.command(context, Command::SavePaint(self.shell.fields.paint.trim().into()))
            }
            Action::Surroundings => state.next_surroundings(),
            Action::Object => state.next_object(),
            Action::LastObject => state.last_object(),
            Action::Flakes => state.flakes = !state.flakes,
            Action::Channels => state.next_channels(),
            Action::Extrapolate => state.set_extrapolates(!state.extrapolates),
            Action::Keep if n > 1 => state.keep(),
            Action::Home => state.home(),
            Action::Run => self.runs = !self.runs,
            Action::Equal => state.weights = weights::equal(n),
            Action::Only(k) if k < n => state.weights = weights::only(k, n),
            // Done above, or of more paints than there are.
            _ => {}
        }
    }

    /// Does what a panel asks for.
    pub(super) fn command(&mut self, context: &Context, command: Command) {
        let outcome = match command {
            Command::Open(files) => {
                self.desk.open(&files, false);
                Ok(())
            }
            Command::Add(file) => {
                self.desk.open(&[file], true);
                Ok(())
            }
            Command::SavePicture(path) => self.save_picture(context, path),
            Command::SavePaint(path) => self.desk.save_paint(path),
            Command::SaveComposition => self.desk.save_composition(),
        };
        self.desk.note(outcome);
    }

    /// The pictures now seen, rendered with care, side by side where they are two.
    fn save_picture(&mut self, context: &Context, path: PathBuf) -> Result<()> {
        let size = self.panes.first().map(|pane| pixels(pane.rect, context)).unwrap_or([640, 480]);
        let shown: Vec<Shown> = self.panes.iter().map(|pane| pane.shown).collect();
        let all = [0, size[0]];
        let requests = shown.into_iter().map(|s| self.request(s, size, all)).collect::<Result<Vec<_>>>()?;
        let split = (self.desk.state.layout == Layout::Split).then_some(f64::from(self.desk.state.divider));
        self.desk.save_picture(save::Order { requests, split, path, samples: self.shell.fields.samples })
    }
}
