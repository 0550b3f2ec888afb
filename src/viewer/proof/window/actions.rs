//! What keys and panels ask for.

use super::super::super::choices::Layout;
use super::super::super::keys::Action;
use super::super::super::window::{look, pixels};
use super::super::save::Save;
use super::Window;
use eframe::egui::Context;
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
        self.shell.act(context, action, &mut self.desk.messages);
        let state = &mut self.desk.state;
        look(action, &mut state.lamp, &mut state.layout, &mut state.orbit, &mut state.exposure_stops);
        match action {
            Action::SavePicture => self.save(context, self.shell.fields.picture.trim().into()),
            Action::Object => state.next_shape(false),
            Action::LastObject => state.next_shape(true),
            Action::Home => state.home(),
            Action::Expose(_) => state.auto_exposure = false,
            _ => {}
        }
    }

    /// Saves what the window shows, as it shows it.
    pub(super) fn save(&mut self, context: &Context, path: PathBuf) {
        let size = self.panes.first().map_or([640, 480], |[rect, _]| pixels(*rect, context));
        match self.desk.order(&[size; 2]) {
            Ok(Some(order)) => {
                let (requests, state) = (order.requests, &self.desk.state);
                let split = (state.layout == Layout::Split).then_some(state.divider.into());
                let (stops, samples) = (state.exposure_stops, self.shell.fields.samples);
                self.desk.save(Save { requests, stops, split, path, samples });
            }
            Ok(None) => {}
            Err(e) => self.desk.tell(e.to_string(), true),
        }
    }
}
