//! The program in a window, watched.

use super::display::{Display, Screenshot};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use x11rb::protocol::xproto::Window;

/// How long anything may take: a software adapter on a busy machine compiles its shaders when they are first used.
const PATIENCE: Duration = Duration::from_secs(300);
/// Between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// `carpaint view` under way.
pub struct Program<'a> {
    child: Child,
    display: &'a Display,
    places: PathBuf,
    window: Window,
}

impl<'a> Program<'a> {
    /// Starts the program in `folder` and waits until it shows a picture.
    pub fn start(display: &'a Display, folder: &Path, arguments: &[&str]) -> Self {
        let places = folder.join("places.json");
        let child = command(folder)
            .env("DISPLAY", &display.name)
            .arg("--places")
            .arg(&places)
            .args(arguments)
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        let mut program = Self { child, display, places, window: 0 };
        program.look_for_window();
        program.wait("a frame", |program| program.all()["events"].is_u64());
        program
    }

    /// Waits for the window that is there now, and gives it the keyboard.
    pub fn look_for_window(&mut self) {
        self.wait("a window", |program| {
            program.window = program.display.window().unwrap_or_default();
            program.window != 0
        });
        self.display.focus(self.window);
    }

    /// Makes the window narrow, so that all panels are there, and a picture that is soon drawn between them; the mouse rests on the
    /// picture, where it brings no hint up.
    pub fn narrow(&mut self) {
        self.resize([900, 800]);
        self.wait("a narrow window", |p| p.all()["picture"].is_array() && p.place("picture")[2] == 604.0);
        self.point([450.0, 400.0]);
    }

    /// Makes the window small, with nothing in it but the picture, and waits for that: on a software adapter pixels take their time.
    pub fn alone(&mut self, size: [u32; 2]) {
        self.key(u32::from(b'h'), false);
        self.resize(size);
        let edges = [0.0, 0.0, f64::from(size[0]), f64::from(size[1])];
        self.wait("the picture alone", |p| p.all()["picture"].is_array() && p.place("picture") == edges);
    }

    /// What is on the screen; kept under a name.
    pub fn seen(&self, name: &str) -> Screenshot {
        let shot = self.display.screenshot();
        shot.save(name);
        shot
    }

    /// Waits until something holds.
    pub fn wait(&mut self, what: &str, mut holds: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        loop {
            assert!(self.is_alive(), "the program ended while waiting for {what}");
            if holds(self) {
                return;
            }
            if start.elapsed() > PATIENCE {
                self.display.screenshot().save("what came too late");
                panic!("no {what} within {PATIENCE:?}: {}", self.all());
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// Waits until all is loaded and drawn, and what is on the screen stays; a screenshot of it.
    pub fn settled(&mut self, name: &str) -> Screenshot {
        let mut last = self.display.screenshot();
        self.wait("settled picture", |program| {
            let all = program.all();
            if all["is settled"] != true || all["is busy"] != false {
                return false;
            }
            let now = program.display.screenshot();
            // A window that has just been opened is black at first, panels and all.
            let is_black = now.pixels.iter().all(|pixel| *pixel == [0; 3]);
            std::mem::replace(&mut last, now) == last && !is_black
        });
        last.save(name);
        last
    }

    pub fn is_alive(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// What the window says of itself; null before its first frame.
    pub fn all(&self) -> Value {
        let text = std::fs::read_to_string(&self.places).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// A number that the window says.
    pub fn number(&self, name: &str, k: usize) -> f64 {
        self.all()[name][k].as_f64().unwrap_or(f64::NAN)
    }

    /// Where a control stands: left, top, right, bottom.
    pub fn place(&self, name: &str) -> [f64; 4] {
        let all = self.all();
        let rect = all[name].as_array().unwrap_or_else(|| panic!("no {name} in {all}"));
        std::array::from_fn(|k| rect[k].as_f64().unwrap())
    }

    /// Where a control's middle is.
    pub fn middle(&self, name: &str) -> [f64; 2] {
        let [left, top, right, bottom] = self.place(name);
        [0.5 * (left + right), 0.5 * (top + bottom)]
    }

    /// Drags with a button from one point to another, in steps that a hand would make.
    pub fn drag(&mut self, button: u8, from: [f64; 2], to: [f64; 2]) {
        // A mouse that is there already would not move.
        self.display.point([from[0] + 3.0, from[1]]);
        self.see("events", |display| display.point(from));
        self.see("events", |display| display.button(button, true));
        for share in [0.5, 1.0] {
            self.see("events", |display| display.point([0, 1].map(|c| from[c] + share * (to[c] - from[c]))));
        }
        self.see("events", |display| display.button(button, false));
    }

    /// Moves the mouse there: where it rests, hints appear.
    pub fn point(&mut self, at: [f64; 2]) {
        self.see("events", |display| display.point(at));
    }

    /// Turns the wheel by notches, away from the user if `is_away`.
    pub fn wheel(&mut self, notches: usize, is_away: bool) {
        for _ in 0..notches {
            let button = if is_away { 4 } else { 5 };
            self.see("events", |display| {
                display.button(button, true);
                display.button(button, false);
            });
        }
    }

    /// Types a key, with Ctrl if wanted.
    pub fn key(&mut self, symbol: u32, with_ctrl: bool) {
        // A window that was taken away and put back has lost the keyboard.
        self.display.focus(self.window);
        if with_ctrl {
            self.display.key(CONTROL, true);
        }
        self.see("keys", |display| display.key(symbol, true));
        self.see("keys", |display| display.key(symbol, false));
        if with_ctrl {
            self.display.key(CONTROL, false);
        }
    }

    /// Types a key with Shift.
    pub fn shifted_key(&mut self, symbol: u32) {
        self.display.key(SHIFT, true);
        self.key(symbol, false);
        self.display.key(SHIFT, false);
    }

    /// Does something with mouse or keyboard, and waits until the window has taken note and shows what came of it.
    fn see(&mut self, kind: &str, act: impl FnOnce(&Display)) {
        let events = |program: &Self| program.all()[kind].as_u64();
        let before = events(self);
        act(self.display);
        self.wait("event seen", |program| events(program) > before);
    }

    pub fn resize(&mut self, size: [u32; 2]) {
        self.display.resize(self.window, size);
    }

    pub fn show(&mut self, is_shown: bool) {
        self.display.show(self.window, is_shown);
    }

    /// Quits by the keyboard.
    pub fn quit(mut self) -> ExitStatus {
        let start = Instant::now();
        self.display.focus(self.window);
        self.display.key(CONTROL, true);
        self.display.key(u32::from(b'q'), true);
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(start.elapsed() < PATIENCE, "it does not end");
            std::thread::sleep(PAUSE);
        }
    }
}

impl Drop for Program<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub const CONTROL: u32 = 0xffe3;
const SHIFT: u32 = 0xffe1;
pub const ESCAPE: u32 = 0xff1b;
pub const F1: u32 = 0xffbe;
pub const HOME: u32 = 0xff50;

/// The program, without the display of whoever runs the test.
pub fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carpaint"));
    command
        .current_dir(folder)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env_remove("DISPLAY");
    command.env("XDG_RUNTIME_DIR", folder).arg("view");
    command
}
