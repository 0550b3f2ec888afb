//! A virtual screen, and hands that type and move a mouse on it.

use carpaint::render::Picture;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConfigureWindowAux, ConnectionExt, ImageFormat, InputFocus,
    KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, MapState, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Columns and rows of the screen.
pub const SCREEN: [u16; 2] = [1280, 800];

/// An X server without a monitor, and a connection to it.
pub struct Display {
    server: Child,
    /// As `DISPLAY` wants it.
    pub name: String,
    connection: RustConnection,
    root: Window,
}

/// Colors of a screenshot, row-major.
#[derive(Clone, PartialEq)]
pub struct Screenshot {
    pub size: [usize; 2],
    pub pixels: Vec<[u8; 3]>,
}

impl Display {
    /// Starts a server on a free display; none where Xvfb is not installed.
    pub fn start() -> Option<Self> {
        let screen = format!("{}x{}x24", SCREEN[0], SCREEN[1]);
        let mut server = Command::new("Xvfb")
            // Without repeating keys: on a busy machine a press may last.
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-r"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        let (connection, screen) = RustConnection::connect(Some(&name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Some(Self { server, name, connection, root })
    }

    /// What is on the screen.
    pub fn screenshot(&self) -> Screenshot {
        let [width, height] = SCREEN;
        let image = self
            .connection
            .get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, u32::MAX)
            .unwrap()
            .reply()
            .unwrap();
        // 24 bits in four bytes, blue first.
        let pixels = image.data.chunks_exact(4).map(|p| [p[2], p[1], p[0]]).collect();
        Screenshot { size: SCREEN.map(usize::from), pixels }
    }

    fn input(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.connection.xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, self.root, x, y, 0).unwrap();
        self.connection.sync();
    }

    /// Moves the mouse there.
    pub fn point(&self, at: [f64; 2]) {
        self.input(MOTION_NOTIFY_EVENT, 0, at.map(|c| c.round() as i16));
    }

    /// Presses or releases a mouse button: 1 left, 2 middle, 3 right, 4 and 5 the wheel.
    pub fn button(&self, number: u8, is_down: bool) {
        self.input(if is_down { BUTTON_PRESS_EVENT } else { BUTTON_RELEASE_EVENT }, number, [0, 0]);
    }

    /// Presses or releases the key of a symbol.
    pub fn key(&self, symbol: u32, is_down: bool) {
        self.input(if is_down { KEY_PRESS_EVENT } else { KEY_RELEASE_EVENT }, self.code(symbol), [0, 0]);
    }

    /// The key that bears a symbol, without shift.
    fn code(&self, symbol: u32) -> u8 {
        let (first, last) = (self.connection.setup().min_keycode, self.connection.setup().max_keycode);
        let map = self.connection.get_keyboard_mapping(first, last - first + 1).unwrap().reply().unwrap();
        let rows = map.keysyms.chunks(usize::from(map.keysyms_per_keycode));
        first + rows.into_iter().position(|row| row[0] == symbol).unwrap() as u8
    }

    /// The program's window, once it is there.
    pub fn window(&self) -> Option<Window> {
        let tree = self.connection.query_tree(self.root).unwrap().reply().unwrap();
        tree.children.into_iter().rev().find(|window| {
            let attributes = self.connection.get_window_attributes(*window).unwrap().reply();
            let size = self.connection.get_geometry(*window).unwrap().reply();
            attributes.is_ok_and(|a| a.map_state == MapState::VIEWABLE) && size.is_ok_and(|s| s.width > 10)
        })
    }

    /// Gives the keyboard to a window: there is no window manager to do it.
    pub fn focus(&self, window: Window) {
        self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap();
        self.connection.sync();
    }

    /// Gives a window another size.
    pub fn resize(&self, window: Window, [width, height]: [u32; 2]) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).unwrap();
        self.connection.sync();
    }

    /// Takes a window from the screen, or puts it back.
    pub fn show(&self, window: Window, is_shown: bool) {
        if is_shown {
            self.connection.map_window(window).unwrap();
        } else {
            self.connection.unmap_window(window).unwrap();
        }
        self.connection.sync();
    }
}

/// Waits until the server has done all that it was asked for.
trait Sync {
    fn sync(&self);
}

impl Sync for RustConnection {
    fn sync(&self) {
        self.get_input_focus().unwrap().reply().unwrap();
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // Asked to end it takes its socket away, which a killed one would leave.
        let _ = Command::new("kill").arg(self.server.id().to_string()).status();
        let _ = self.server.wait();
    }
}

impl Screenshot {
    /// The part within a rectangle: left, top, right, bottom.
    pub fn part(&self, [left, top, right, bottom]: [f64; 4]) -> Self {
        let clamp = |value: f64, most: usize| (value.round().max(0.0) as usize).min(most);
        let (x, y) = (clamp(left, self.size[0]), clamp(top, self.size[1]));
        let (end, foot) = (clamp(right, self.size[0]), clamp(bottom, self.size[1]));
        let rows = (y..foot).flat_map(|row| &self.pixels[row * self.size[0] + x..row * self.size[0] + end]);
        Self { size: [end - x, foot - y], pixels: rows.copied().collect() }
    }

    /// Share of pixels of which a channel differs by more than `step` of 255.
    pub fn changed(&self, other: &Self, step: u8) -> f64 {
        assert_eq!(self.size, other.size);
        let differs = |(a, b): &(&[u8; 3], &[u8; 3])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > step);
        self.pixels.iter().zip(&other.pixels).filter(differs).count() as f64 / self.pixels.len().max(1) as f64
    }

    /// Mean of each channel, 0 to 255.
    pub fn color(&self) -> [f64; 3] {
        let sum = |k: usize| self.pixels.iter().map(|pixel| f64::from(pixel[k])).sum::<f64>();
        [0, 1, 2].map(|k| sum(k) / self.pixels.len().max(1) as f64)
    }

    /// Mean of all channels, 0 to 255.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.pixels.iter().flatten().map(|c| f64::from(*c)).sum();
        sum / (3 * self.pixels.len().max(1)) as f64
    }

    /// Keeps it for people to look at, beside what cargo builds.
    pub fn save(&self, name: &str) {
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("viewer-screenshots");
        std::fs::create_dir_all(&folder).unwrap();
        carpaint::file::write_png(&folder.join(format!("{name}.png")), self.size, &self.pixels).unwrap();
        // Readable by the crate's own reader, too.
        assert_eq!(Picture::read(&folder.join(format!("{name}.png"))).unwrap().size, self.size);
    }
}
