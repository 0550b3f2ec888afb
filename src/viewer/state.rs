//! What the window shows, without a window: weights, eye, lamp, surroundings, object, and which paints stand where.

use super::light::{Lamp, Panorama, Surroundings};
use super::orbit::Orbit;
use super::stage;
use super::weights;
use crate::error::Result;
use crate::mix::{BlendOptions, Channels};
use crate::scene::{Bodies, Scene, Shape, Up};
use glam::DVec2;
use std::path::PathBuf;

/// Longest side of a mesh, millimetres: files do not agree on units, and the eye sees some 60.
const MESH_MM: f64 = 60.0;

/// The painted object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Object {
    /// A cylinder with round ends.
    #[default]
    Capsule,
    /// A ball.
    Sphere,
    /// A flat panel.
    Panel,
    /// A car-like body.
    SpeedShape,
    /// Triangles from a file.
    Mesh,
    /// A capsule in each paint, and one in their blend that is moved among them.
    Demonstration,
}

impl Object {
    /// Every choice without a file.
    pub const BUILT_IN: [Self; 5] =
        [Self::Capsule, Self::Sphere, Self::Panel, Self::SpeedShape, Self::Demonstration];

    /// For people, and, of single objects, as [`Shape::named`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Capsule => "capsule",
            Self::Sphere => "sphere",
            Self::Panel => "panel",
            Self::SpeedShape => "speed-shape",
            Self::Mesh => "mesh",
            Self::Demonstration => "demonstration",
        }
    }

    /// Where the eye sees all of it.
    pub fn orbit(self) -> Orbit {
        match self {
            Self::Demonstration => Orbit::of(&stage::camera()),
            _ => Orbit::default(),
        }
    }
}

/// The choice after `now`, around.
fn after<T: Copy + PartialEq>(now: T, all: &[T]) -> T {
    let k = all.iter().position(|one| *one == now).map_or(0, |k| k + 1);
    all.get(k).or(all.first()).copied().unwrap_or(now)
}

/// A paint that can be looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The mix at the weights; of a single paint, that.
    Blend,
    /// One of the paints as it is.
    Paint(usize),
    /// What the composition panel makes.
    Recipe,
}

/// How two paints share the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// One paint.
    #[default]
    Single,
    /// One picture, the first paint left of a divider, the second right of it.
    Split,
    /// Two pictures.
    SideBySide,
}

impl Layout {
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::Single, Self::Split, Self::SideBySide];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Split => "split",
            Self::SideBySide => "side by side",
        }
    }

    /// The next one, around.
    pub fn next(self) -> Self {
        after(self, &Self::ALL)
    }
}

/// Everything that a user sets.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// One a paint, summing to 1.
    pub weights: Vec<f64>,
    /// Whether weights may leave [0, 1].
    pub extrapolates: bool,
    /// What of a blend goes, and how.
    pub blend: BlendOptions,
    /// The eye.
    pub orbit: Orbit,
    /// The lamp.
    pub lamp: Lamp,
    /// What lights the object from everywhere.
    pub surroundings: Surroundings,
    /// Surroundings from a file.
    pub panorama: Panorama,
    /// The object.
    pub object: Object,
    /// The mesh that was opened.
    pub mesh: Option<PathBuf>,
    /// Where the movable capsule of the demonstration stands, millimetres.
    pub movable: DVec2,
    /// Exposure, stops.
    pub exposure_stops: f64,
    /// Whether flakes sparkle.
    pub flakes: bool,
    /// Which flakes there are.
    pub seed: u32,
    /// How two paints share the picture.
    pub layout: Layout,
    /// Where the divider of a split stands, share of the width.
    pub divider: f32,
    /// The first paint and the second.
    pub shown: [Shown; 2],
}

impl Default for State {
    fn default() -> Self {
        Self {
            weights: vec![1.0],
            extrapolates: false,
            blend: BlendOptions::default(),
            orbit: Orbit::default(),
            lamp: Lamp::default(),
            surroundings: Surroundings::default(),
            panorama: Panorama::default(),
            object: Object::default(),
            mesh: None,
            movable: stage::START,
            exposure_stops: 0.0,
            flakes: true,
            seed: 1,
            layout: Layout::default(),
            divider: 0.5,
            shown: [Shown::Blend, Shown::Paint(0)],
        }
    }
}

impl State {
    /// Legal exposures of the window, stops.
    pub const EXPOSURE: std::ops::RangeInclusive<f64> = -8.0..=8.0;

    /// What is kept when a document of `n` paints is opened: everything but what speaks of paints.
    pub fn opened(&mut self, n: usize) {
        self.weights = weights::equal(n);
        self.blend.source = 0;
        self.shown = [Shown::Blend, Shown::Paint(0)];
    }

    /// Legal weights.
    pub fn weight_range(&self) -> (f64, f64) {
        if self.extrapolates { weights::BEYOND } else { weights::INSIDE }
    }

    /// Sets one weight, see [`weights::set_weight`].
    pub fn set_weight(&mut self, k: usize, value: f64) {
        let range = self.weight_range();
        weights::set_weight(&mut self.weights, k, value, range);
    }

    /// Allows or forbids weights outside [0, 1]; those there come back.
    pub fn set_extrapolates(&mut self, extrapolates: bool) {
        self.extrapolates = extrapolates;
        let range = self.weight_range();
        weights::clamp(&mut self.weights, range);
    }

    /// Goes on to the next choice of channels.
    pub fn next_channels(&mut self) {
        self.blend.channels = after(self.blend.channels, &Channels::ALL);
    }

    /// The objects there are to choose from.
    pub fn all_objects(&self) -> Vec<Object> {
        Object::BUILT_IN.into_iter().chain(self.mesh.is_some().then_some(Object::Mesh)).collect()
    }

    /// Goes on to the next object.
    pub fn next_object(&mut self) {
        self.set_object(after(self.object, &self.all_objects()));
    }

    /// The surroundings there are to choose from.
    pub fn all_surroundings(&self) -> Vec<Surroundings> {
        let has_picture = !self.panorama.path.as_os_str().is_empty();
        Surroundings::BUILT_IN.into_iter().chain(has_picture.then_some(Surroundings::Picture)).collect()
    }

    /// Goes on to the next surroundings.
    pub fn next_surroundings(&mut self) {
        self.surroundings = after(self.surroundings, &self.all_surroundings());
    }

    /// Takes surroundings from a picture.
    ///
    /// # Errors
    /// Those of reading it; the surroundings then stay as they are.
    pub fn set_panorama(&mut self, path: PathBuf) -> Result<()> {
        let panorama = Panorama { path, ..Panorama::default() };
        Surroundings::Picture.environment(&self.lamp, &panorama).surroundings()?;
        self.panorama = panorama;
        self.surroundings = Surroundings::Picture;
        Ok(())
    }

    /// Takes a mesh for the object.
    ///
    /// # Errors
    /// Those of reading it; the object then stays as it is.
    pub fn set_mesh(&mut self, path: PathBuf) -> Result<()> {
        let next = Self { mesh: Some(path), object: Object::Mesh, ..self.clone() };
        Bodies::new(&next.scene([1, 1]))?;
        *self = next;
        self.home();
        Ok(())
    }

    /// The one object of the scene; of the demonstration any.
    fn shape(&self) -> Shape {
        match (self.object, &self.mesh) {
            (Object::Mesh, Some(path)) => {
                Shape::Mesh { path: path.clone(), length_mm: Some(MESH_MM), up: Up::Y }
            }
            // Every other name is a shape's.
            (object, _) => Shape::named(object.name()).unwrap_or_default(),
        }
    }

    /// Changes the object; the eye goes back to where it sees all of it.
    pub fn set_object(&mut self, object: Object) {
        if self.object != object {
            self.object = object;
            self.home();
        }
    }

    /// Takes the eye back.
    pub fn home(&mut self) {
        self.orbit = self.object.orbit();
    }

    /// The scene in a picture of `size` pixels, each at least 1.
    pub fn scene(&self, size: [usize; 2]) -> Scene {
        Scene {
            size,
            exposure_stops: self.exposure_stops,
            background: None,
            camera: self.orbit.camera(),
            shape: self.shape(),
            environment: self.surroundings.environment(&self.lamp, &self.panorama),
            lights: self.lamp.lights(),
            objects: self.objects(),
        }
    }

    /// The objects of the demonstration; none: one shape alone.
    fn objects(&self) -> Vec<crate::scene::Object> {
        match self.object {
            Object::Demonstration => stage::objects(self.weights.len(), self.movable),
            _ => Vec::new(),
        }
    }

    /// The paints that a picture needs, in the order in which objects name them, `shown` first.
    pub fn worn(&self, shown: Shown) -> Vec<Shown> {
        match self.object {
            Object::Demonstration => {
                [shown].into_iter().chain((0..self.weights.len()).map(Shown::Paint)).collect()
            }
            _ => vec![shown],
        }
    }

    /// Moves the capsule of the demonstration; weights go by its distances to the others.
    pub fn move_capsule(&mut self, to: DVec2) {
        self.movable = stage::within(to);
        self.weights = stage::weights(self.weights.len(), self.movable);
    }

    /// The second paint, if there is one to be seen.
    pub fn second(&self) -> Option<Shown> {
        (self.layout != Layout::Single).then_some(self.shown[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_makes_a_legal_scene() {
        let mut state = State::default();
        for object in Object::BUILT_IN {
            state.set_object(object);
            for surroundings in Surroundings::BUILT_IN {
                state.surroundings = surroundings;
                state.scene([7, 5]).validate().unwrap();
                if let Ok(shape) = Shape::named(object.name()) {
                    assert_eq!(state.scene([7, 5]).shape, shape);
                }
            }
        }
    }

    #[test]
    fn files_that_cannot_be_read_change_nothing() {
        let mut state = State::default();
        assert!(state.set_panorama("none.hdr".into()).is_err() && state.set_mesh("none.obj".into()).is_err());
        assert_eq!(state, State::default());
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenes");
        state.set_panorama(format!("{scenes}/studio.exr").into()).unwrap();
        state.set_mesh(format!("{scenes}/ring.obj").into()).unwrap();
        state.scene([7, 5]).validate().unwrap();
        assert_eq!((state.object, state.surroundings), (Object::Mesh, Surroundings::Picture));
        state.next_object();
        state.next_surroundings();
        assert_eq!((state.object, state.surroundings), (Object::Capsule, Surroundings::Studio));
    }

    #[test]
    fn a_moved_capsule_sets_the_weights() {
        let mut state =
            State { weights: weights::equal(3), object: Object::Demonstration, ..State::default() };
        state.move_capsule(DVec2::new(0.0, 46.0));
        assert!(state.weights[0] > 0.999, "at the first one: {:?}", state.weights);
        assert_eq!(state.worn(Shown::Blend).len(), 4);
        state.scene([8, 8]).check_paints(4).unwrap();
    }

    #[test]
    fn choices_come_round() {
        let mut state = State::default();
        for _ in Channels::ALL {
            state.next_channels();
        }
        for _ in Object::BUILT_IN {
            state.next_object();
        }
        for _ in Surroundings::BUILT_IN {
            state.next_surroundings();
        }
        assert_eq!(state, State::default());
        assert_eq!(Layout::ALL.iter().fold(Layout::Split, |l, _| l.next()), Layout::Split);
    }

    #[test]
    fn forbidding_extrapolation_brings_weights_back() {
        let mut state = State { weights: vec![0.5, 0.5], extrapolates: true, ..State::default() };
        state.set_weight(0, 1.5);
        assert_eq!(state.weights, [1.5, -0.5]);
        state.set_extrapolates(false);
        assert_eq!(state.weights, [1.0, 0.0]);
    }

    #[test]
    fn opening_keeps_what_does_not_speak_of_paints() {
        let mut state = State { shown: [Shown::Paint(2), Shown::Recipe], ..State::default() };
        state.lamp.is_on = false;
        state.blend.source = 2;
        state.opened(2);
        assert_eq!((state.weights.as_slice(), state.blend.source), (&[0.5, 0.5][..], 0));
        assert_eq!(state.shown, [Shown::Blend, Shown::Paint(0)]);
        assert!(!state.lamp.is_on);
    }
}
