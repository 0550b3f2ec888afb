//! What keys do, in one table: the window acts by it, and the help shows it.

use eframe::egui::{Event, InputState, Key, Modifiers};

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Shows or hides the help.
    Help,
    /// Shows or hides what stands around the picture.
    Panels,
    /// Closes the window.
    Quit,
    /// Goes to the field for a file to open.
    Open,
    /// Saves the picture under the name in its field.
    SavePicture,
    /// Saves the blend under the name in its field.
    SavePaint,
    /// Turns the lamp on or off.
    Lamp,
    /// The next surroundings.
    Surroundings,
    /// The next object.
    Object,
    /// The object before.
    LastObject,
    /// Flakes on or off.
    Flakes,
    /// The next layout.
    Layout,
    /// The next channels.
    Channels,
    /// Extrapolation on or off.
    Extrapolate,
    /// Keeps the blend to stand beside others.
    Keep,
    /// The eye back.
    Home,
    /// Pictures without pause on or off.
    Run,
    /// Nearer by this factor.
    Zoom(f64),
    /// Turns by a drag of so many pixels, right and down.
    Orbit(f64, f64),
    /// Changes the exposure by so many stops.
    Expose(f64),
    /// Equal weights.
    Equal,
    /// One paint alone.
    Only(usize),
    /// Closes help and messages.
    Dismiss,
}

impl Action {
    /// Whether a key that is held does it again and again.
    fn repeats(self) -> bool {
        matches!(self, Self::Zoom(_) | Self::Orbit(..) | Self::Expose(_))
    }
}

impl Binding {
    /// Whether all of its keys do what something holds of.
    pub fn does(&self, holds: impl Fn(Action) -> bool) -> bool {
        self.keys.iter().all(|(_, _, action)| holds(*action))
    }
}

/// A line of the help, and the keys behind it.
pub struct Binding {
    /// Names of the keys.
    pub shown: &'static str,
    /// What they do.
    pub what: &'static str,
    keys: &'static [(Modifiers, Key, Action)],
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::CTRL;
/// Pixels of a drag that an arrow key stands for.
const STEP: f64 = 12.0;

const fn binding(
    shown: &'static str,
    what: &'static str,
    keys: &'static [(Modifiers, Key, Action)],
) -> Binding {
    Binding { shown, what, keys }
}

/// Every key that does something.
pub const BINDINGS: &[Binding] = &[
    binding(
        "F1  ?",
        "this help",
        &[
            (NONE, Key::F1, Action::Help),
            (NONE, Key::Questionmark, Action::Help),
            (SHIFT, Key::Questionmark, Action::Help),
        ],
    ),
    binding("H", "the picture alone, or with what stands around it", &[(NONE, Key::H, Action::Panels)]),
    binding("Esc", "close help and messages", &[(NONE, Key::Escape, Action::Dismiss)]),
    binding("L", "lamp on, off", &[(NONE, Key::L, Action::Lamp)]),
    binding("E", "next surroundings", &[(NONE, Key::E, Action::Surroundings)]),
    // Without Shift a key counts whether that is held or not: what is held comes first.
    binding(
        "O  Shift+O",
        "next object, the one before",
        &[(SHIFT, Key::O, Action::LastObject), (NONE, Key::O, Action::Object)],
    ),
    binding("F", "flakes, or the smooth part alone", &[(NONE, Key::F, Action::Flakes)]),
    binding("V", "single, split, side by side", &[(NONE, Key::V, Action::Layout)]),
    binding("C", "next channels", &[(NONE, Key::C, Action::Channels)]),
    binding("X", "extrapolation on, off", &[(NONE, Key::X, Action::Extrapolate)]),
    binding("K", "keep this blend beside others", &[(NONE, Key::K, Action::Keep)]),
    binding("0", "equal weights", &[(NONE, Key::Num0, Action::Equal)]),
    binding(
        "1 \u{2026} 8",
        "one paint alone",
        &[
            (NONE, Key::Num1, Action::Only(0)),
            (NONE, Key::Num2, Action::Only(1)),
            (NONE, Key::Num3, Action::Only(2)),
            (NONE, Key::Num4, Action::Only(3)),
            (NONE, Key::Num5, Action::Only(4)),
            (NONE, Key::Num6, Action::Only(5)),
            (NONE, Key::Num7, Action::Only(6)),
            (NONE, Key::Num8, Action::Only(7)),
        ],
    ),
    binding(
        "arrows",
        "turn the object",
        &[
            (NONE, Key::ArrowLeft, Action::Orbit(-STEP, 0.0)),
            (NONE, Key::ArrowRight, Action::Orbit(STEP, 0.0)),
            (NONE, Key::ArrowUp, Action::Orbit(0.0, -STEP)),
            (NONE, Key::ArrowDown, Action::Orbit(0.0, STEP)),
        ],
    ),
    binding(
        "+  -",
        "nearer, farther",
        &[
            (NONE, Key::Plus, Action::Zoom(1.25)),
            (SHIFT, Key::Plus, Action::Zoom(1.25)),
            (NONE, Key::Equals, Action::Zoom(1.25)),
            (NONE, Key::Minus, Action::Zoom(0.8)),
        ],
    ),
    binding(
        "[  ]",
        "darker, brighter by a quarter stop",
        &[(NONE, Key::OpenBracket, Action::Expose(-0.25)), (NONE, Key::CloseBracket, Action::Expose(0.25))],
    ),
    binding("Home", "the eye back", &[(NONE, Key::Home, Action::Home)]),
    binding("Space", "draw without pause, to time frames", &[(NONE, Key::Space, Action::Run)]),
    binding("Ctrl+O", "name a file to open", &[(CTRL, Key::O, Action::Open)]),
    binding("Ctrl+S", "save the picture", &[(CTRL, Key::S, Action::SavePicture)]),
    binding("Ctrl+B", "save the blended paint", &[(CTRL, Key::B, Action::SavePaint)]),
    binding("Ctrl+Q", "quit", &[(CTRL, Key::Q, Action::Quit)]),
];

/// What the mouse does in the picture, for the help.
pub const MOUSE: &[(&str, &str)] = &[
    ("drag", "turn the object"),
    ("Ctrl+drag, right drag", "move the lamp"),
    ("Shift+drag, middle drag", "move the object"),
    ("wheel", "nearer, farther, down to single flakes or dots"),
    ("double click", "the eye back"),
];

/// What was asked for since the last frame. While a text is being edited only keys held with Ctrl count.
pub fn actions(input: &mut InputState, is_editing: bool) -> Vec<Action> {
    let mut found = Vec::new();
    for (modifiers, key, action) in BINDINGS.iter().flat_map(|binding| binding.keys) {
        if (is_editing && !modifiers.ctrl) || modifiers.ctrl != input.modifiers.ctrl {
            continue;
        }
        let counts = |event: &&Event| match event {
            Event::Key { key: pressed_key, pressed: true, repeat, .. } => {
                pressed_key == key && (!repeat || action.repeats())
            }
            _ => false,
        };
        let presses = input.events.iter().filter(counts).count();
        let presses = presses.min(input.count_and_consume_key(*modifiers, *key));
        found.extend(std::iter::repeat_n(*action, presses));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let keys: Vec<_> = BINDINGS.iter().flat_map(|binding| binding.keys).collect();
        for (k, a) in keys.iter().enumerate() {
            assert!(keys[k + 1..].iter().all(|b| (a.0, a.1) != (b.0, b.1)), "{:?}", a.1);
        }
    }
}
