//! What keys and panels ask for.

use super::super::super::choices::Layout;
use super::super::super::keys::Action;
use super::super::super::state::State as PaintState;
use super::super::super::window::pixels;
use super::super::save::Save;
use super::Window;
use eframe::egui::{Context, ViewportCommand};
use glam::DVec2;
use std::path::PathBuf;

/// Whether a key does something in this window.
pub fn is_known(action: Action) -> bool {
    !matches!(
        action,
        Action::SavePaint
            | Action::Surroundings
            | Action::Flakes
            | Action::Channels
            | Action::Extrapolate
            | Action::Keep
            | Action::Run
            | Action::Equal
            | Action::Only(_)
    )
}

impl Window {
    /// Does what a key asks for.
    pub(super) fn act(&mut self, context: &Context, action: Action) {
        let state = &mut self.desk.state;
        match action {
            Action::Help => self.shows_help = !self.shows_help,
            Action::Panels => self.shows_panels = !self.shows_panels,
            Action::Dismiss => {
                self.shows_help = false;
                self.desk.messages.clear();
            }
            Action::Quit => context.send_viewport_cmd(ViewportCommand::Close),
            Action::Open => {
                self.shows_panels = true;
                self.fields.wants_focus = true;
            }
            Action::SavePicture => self.save(context, self.fields.picture.trim().into()),
            Action::Lamp => state.lamp.is_on = !state.lamp.is_on,
            Action::Object => state.next_shape(false),
            Action::LastObject => state.next_shape(true),
            Action::Layout => state.layout = state.layout.next(),
            Action::Home => state.home(),
            Action::Zoom(factor) => state.orbit.zoom(factor, DVec2::ZERO),
            Action::Orbit(right, down) => state.orbit.orbit(DVec2::new(right, down)),
            Action::Expose(stops) => {
                let (low, high) = (*PaintState::EXPOSURE.start(), *PaintState::EXPOSURE.end());
                state.exposure_stops = (state.exposure_stops + stops).clamp(low, high);
            }
            _ => {}
        }
    }

    /// Saves what the window shows, as it shows it.
    pub(super) fn save(&mut self, context: &Context, path: PathBuf) {
        let size = self.panes.first().map_or([640, 480], |[rect, _]| pixels(*rect, context));
        match self.desk.order(&[size; 2]) {
            Ok(Some(order)) => {
                let split =
                    (self.desk.state.layout == Layout::Split).then_some(self.desk.state.divider.into());
                self.desk.save(Save { order, split, path, samples: self.fields.samples });
            }
            Ok(None) => {}
            Err(e) => self.desk.tell(e.to_string(), true),
        }
    }
}
