//! Progress bars on standard error, for anything longer than a second.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `total` units of work that shows what it is about; it disappears when dropped. Not drawn without a terminal.
pub struct Bar(ProgressBar);

impl Bar {
    pub fn new(what: &str, total: usize) -> Self {
        let bar = ProgressBar::new(total as u64);
        if let Ok(style) = ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Self(bar)
    }

    /// A bar that its own ticks keep: gone when the last of them is dropped.
    pub fn into_tick(self) -> impl Fn() + Sync + use<> {
        move || self.0.inc(1)
    }

    /// One unit of work is done; the function that library calls take as `tick`.
    pub fn tick(&self) -> impl Fn() + Sync + '_ {
        || self.0.inc(1)
    }
}

/// The tick of a bar for what begins.
pub fn begin(what: &str, ticks: usize) -> impl Fn() + Sync + use<> {
    Bar::new(what, ticks).into_tick()
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
