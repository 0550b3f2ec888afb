//! What makes the window look again, from any thread, whichever window it is by then.

use eframe::egui::Context;
use std::sync::{Arc, Mutex};

/// Wakes the window of now.
#[derive(Clone, Default)]
pub struct Waker(Arc<Mutex<Option<Context>>>);

impl Waker {
    /// From now on wakes this window.
    pub fn set(&self, context: &Context) {
        if let Ok(mut now) = self.0.lock() {
            *now = Some(context.clone());
        }
    }

    /// Wakes it, if there is one.
    pub fn wake(&self) {
        if let Ok(now) = self.0.lock()
            && let Some(context) = &*now
        {
            context.request_repaint();
        }
    }

    /// The same as a function.
    pub fn function(&self) -> impl Fn() + Send + Sync + 'static {
        let waker = self.clone();
        move || waker.wake()
    }
}
