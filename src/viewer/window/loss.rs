//! A device that is lost: nothing can be drawn any more, not even that, so the window is closed and opened anew on another one.

use super::super::waker::Waker;
use crate::error::{Error, Result};
use eframe::egui_wgpu::RenderState;
use eframe::wgpu::{self, Buffer, BufferSize, BufferUsages, Device, Queue};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Arc, Mutex};

/// How often a window is opened anew when its device is lost.
const MOST: usize = 3;

/// What a window that lost its device leaves to the next one.
pub struct Loss<D>(Arc<Mutex<Left<D>>>);

struct Left<D> {
    /// The device of the window.
    probe: Option<Probe>,
    /// Why the device is gone.
    why: Option<String>,
    desk: Option<D>,
}

impl<D> Clone for Loss<D> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<D> Default for Loss<D> {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(Left { probe: None, why: None, desk: None })))
    }
}

/// Opens windows with what is open, one in place of another that loses its device; `run` shows one until it is closed, and takes the
/// number of devices lost so far.
///
/// # Errors
/// Those of `run`; devices that are lost again and again.
pub fn windows<D: Default + Send + 'static>(
    mut desk: D,
    tell: impl Fn(&mut D, String),
    run: impl Fn(D, &Loss<D>, usize) -> Result<()>,
) -> Result<()> {
    let loss = Loss::default();
    for losses in 0.. {
        loss.catch(|| run(desk, &loss, losses))?;
        let Some((why, left)) = loss.take() else { return Ok(()) };
        if losses == MOST {
            return Err(Error::gpu("view", "device", format!("lost: {why}"), "one that stays"));
        }
        desk = left;
        tell(&mut desk, format!("the device was lost ({why}): this is another one"));
    }
    Ok(())
}

/// By what a device shows that it is there.
#[derive(Clone)]
struct Probe {
    device: Device,
    queue: Queue,
    buffer: Buffer,
}

impl Probe {
    /// As few as can be written.
    const BYTES: BufferSize = match BufferSize::new(wgpu::COPY_BUFFER_ALIGNMENT) {
        Some(bytes) => bytes,
        None => BufferSize::MIN,
    };

    fn new(state: &RenderState) -> Self {
        let buffer = state.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("probe"),
            size: Self::BYTES.get(),
            usage: BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { device: state.device.clone(), queue: state.queue.clone(), buffer }
    }

    /// Whether the device still takes what egui is going to write. Its loss is told then, at the latest.
    fn is_there(&self) -> bool {
        let is_there = self.queue.write_buffer_with(&self.buffer, 0, Self::BYTES).is_some();
        if !is_there {
            // One that was taken away tells it to those who wait.
            let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        }
        is_there
    }
}

impl<D: Default + Send + 'static> Loss<D> {
    /// Takes note when the device of a window is lost, and wakes it. After this nobody else can: a device tells only one.
    pub fn watch(&self, state: &RenderState, waker: &Waker) {
        if let Ok(mut left) = self.0.lock() {
            left.probe = Some(Probe::new(state));
        }
        let (loss, waker) = (self.clone(), waker.clone());
        state.device.set_device_lost_callback(move |reason, why| {
            loss.note(format!("{reason:?} {why}").trim_end().to_owned());
            waker.wake();
        });
    }

    fn note(&self, why: String) {
        if let Ok(mut left) = self.0.lock() {
            left.why.get_or_insert(why);
        }
    }

    /// Whether the device is gone, as far as was told.
    pub fn is_known(&self) -> bool {
        self.0.lock().is_ok_and(|left| left.why.is_some())
    }

    /// Whether the device is gone; it is asked.
    pub fn is_found(&self) -> bool {
        let probe = self.0.lock().ok().and_then(|left| left.probe.clone());
        if !self.is_known() && probe.is_some_and(|probe| !probe.is_there()) {
            self.note("Unknown".to_owned());
        }
        self.is_known()
    }

    /// Leaves what is open, if the device is gone. It is not asked any more.
    pub fn leave(&self, desk: &mut D) {
        if let Ok(mut left) = self.0.lock() {
            // The device holds on to this, and the probe to the device.
            let probe = left.probe.take();
            if left.why.is_some() {
                left.desk = Some(std::mem::take(desk));
            }
            drop(left);
            drop(probe);
        }
    }

    /// Why the device is gone, and what was open; none: it is not.
    pub fn take(&self) -> Option<(String, D)> {
        let mut left = self.0.lock().ok()?;
        let why = left.why.take()?;
        Some((why, left.desk.take().unwrap_or_default()))
    }

    /// Runs a window. Where a device is lost on the way of a frame to the screen, after the window has looked for the last time,
    /// egui panics: that is an error here, of which nothing else is said. The window cannot be opened anew: a process has one
    /// event loop, and the panic has left that.
    ///
    /// # Errors
    /// Those of `window`; a device lost at that moment.
    pub fn catch(&self, window: impl FnOnce() -> Result<()>) -> Result<()> {
        let before = Arc::new(panic::take_hook());
        let (passed_on, loss, thread) = (before.clone(), self.clone(), std::thread::current().id());
        panic::set_hook(Box::new(move |panic| {
            if std::thread::current().id() != thread || !loss.explains(panic) {
                passed_on(panic);
            }
        }));
        let caught = panic::catch_unwind(AssertUnwindSafe(window));
        panic::set_hook(Box::new(move |panic| before(panic)));
        match caught {
            Ok(outcome) => outcome,
            Err(cause) => match self.take() {
                Some((why, _)) => {
                    let found = format!("lost while a frame was on its way to the screen: {why}");
                    Err(Error::gpu("view", "device", found, "one that stays"))
                }
                None => panic::resume_unwind(cause),
            },
        }
    }

    /// Whether a panic is egui's over a device that is gone. None of others is asked: the driver's own may come while it is locked.
    fn explains(&self, panic: &PanicHookInfo<'_>) -> bool {
        panic.location().is_some_and(|place| place.file().contains("egui-wgpu")) && self.is_found()
    }
}
