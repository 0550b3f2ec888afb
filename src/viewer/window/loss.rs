//! A device that is lost: nothing can be drawn any more, not even that, so the window is closed and opened anew on another one.

use super::super::desk::Desk;
use super::super::waker::Waker;
use eframe::wgpu::Device;
use std::sync::{Arc, Mutex};

/// What a window that lost its device leaves to the next one.
#[derive(Clone, Default)]
pub struct Loss(Arc<Mutex<Left>>);

#[derive(Default)]
struct Left {
    /// Why the device is gone.
    why: Option<String>,
    desk: Option<Desk>,
}

impl Loss {
    /// Takes note when a device is lost, and wakes its window. After this nobody else can: a device tells only one.
    pub fn watch(&self, device: &Device, waker: &Waker) {
        let (loss, waker) = (self.clone(), waker.clone());
        device.set_device_lost_callback(move |reason, why| {
            if let Ok(mut left) = loss.0.lock() {
                left.why = Some(format!("{reason:?} {why}").trim_end().to_owned());
            }
            waker.wake();
        });
    }

    /// Whether the device is gone.
    pub fn is_known(&self) -> bool {
        self.0.lock().is_ok_and(|left| left.why.is_some())
    }

    /// Leaves what is open, if the device is gone.
    pub fn leave(&self, desk: &mut Desk) {
        if let Ok(mut left) = self.0.lock()
            && left.why.is_some()
        {
            left.desk = Some(std::mem::take(desk));
        }
    }

    /// Why the device is gone, and what was open; none: it is not.
    pub fn take(&self) -> Option<(String, Desk)> {
        let mut left = self.0.lock().ok()?;
        let why = left.why.take()?;
        Some((why, left.desk.take().unwrap_or_default()))
    }
}
