//! What the window shows, without a window: weights, eye, lamp, surroundings, object, and which paints stand where.

use super::beside::mesh;
use super::choices::after;
pub use super::choices::{Layout, Object, Shown};
use super::light::{Lamp, Panorama, Surroundings};
use super::orbit::Orbit;
use super::stage;
use super::staged::Staged;
use super::weights;
use crate::error::Result;
use crate::mix::{BlendOptions, Channels};
use crate::scene::{Environment, Light, Scene, Shape};
use glam::DVec2;
use std::path::PathBuf;

/// Everything that a user sets.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// One a paint, summing to 1; none: no document is open.
    pub weights: Vec<f64>,
    /// Whether weights may leave [0, 1].
    pub extrapolates: bool,
    /// What of a blend goes, and how.
    pub blend: BlendOptions,
    /// Weights and what goes of a blend that stays beside the one being made.
    pub kept: Option<(Vec<f64>, BlendOptions)>,
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
    /// The scene that was opened.
    pub staged: Option<Staged>,
    /// Its lamps beside the one that the window moves, and whether they shine.
    pub others: Vec<Light>,
    /// See `others`.
    pub others_shine: bool,
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
            weights: Vec::new(),
            extrapolates: false,
            blend: BlendOptions::default(),
            kept: None,
            orbit: Orbit::default(),
            lamp: Lamp::default(),
            surroundings: Surroundings::default(),
            panorama: Panorama::default(),
            object: Object::default(),
            mesh: None,
            staged: None,
            others: Vec::new(),
            others_shine: true,
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
    ///
    /// # Errors
    /// The objects on show wear more paints; another object is shown instead.
    pub fn opened(&mut self, n: usize) -> Result<()> {
        self.weights = weights::equal(n);
        self.blend.source = 0;
        self.kept = None;
        self.shown = [Shown::Blend, Shown::Paint(0)];
        let fits = self.worn(Shown::Blend).map(drop);
        if fits.is_err() {
            self.set_object(Object::default());
        }
        fits
    }

    /// Keeps the blend as it is now, to stand beside others.
    pub fn keep(&mut self) {
        self.kept = Some((self.weights.clone(), self.blend));
        self.shown[1] = Shown::Kept;
        if self.layout == Layout::Single {
            self.layout = Layout::Split;
        }
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
        let opened = [(self.mesh.is_some(), Object::Mesh), (self.staged.is_some(), Object::Scene)];
        let opened = opened.into_iter().filter_map(|(is_there, object)| is_there.then_some(object));
        Object::BUILT_IN.into_iter().chain(opened).collect()
    }

    /// Goes on to the next object.
    pub fn next_object(&mut self) {
        self.set_object(after(self.object, &self.all_objects()));
    }

    /// Goes back to the object before.
    pub fn last_object(&mut self) {
        let mut all = self.all_objects();
        all.reverse();
        self.set_object(after(self.object, &all));
    }

    /// The surroundings there are to choose from.
    pub fn all_surroundings(&self) -> Vec<Surroundings> {
        let has_picture = !self.panorama.path.as_os_str().is_empty();
        let opened = [(has_picture, Surroundings::Picture), (self.staged.is_some(), Surroundings::Scene)];
        let opened = opened.into_iter().filter_map(|(is_there, one)| is_there.then_some(one));
        Surroundings::BUILT_IN.into_iter().chain(opened).collect()
    }

    /// Goes on to the next surroundings.
    pub fn next_surroundings(&mut self) {
        self.surroundings = after(self.surroundings, &self.all_surroundings());
    }

    /// Takes surroundings from a picture that can be read.
    pub fn set_panorama(&mut self, path: PathBuf) {
        self.panorama = Panorama { path, ..Panorama::default() };
        self.surroundings = Surroundings::Picture;
    }

    /// Takes a mesh that can be read for the object.
    pub fn set_mesh(&mut self, path: PathBuf) {
        (self.mesh, self.object) = (Some(path), Object::Mesh);
        self.home();
    }

    /// Shows a scene that can be read: objects, eye, lamps, surroundings and exposure.
    ///
    /// # Errors
    /// Objects that wear more paints than there are; all then stays as it is.
    pub fn set_scene(&mut self, staged: Staged) -> Result<()> {
        staged.worn(self.shown[0], self.paints())?;
        let (lamp, others) = staged.lamps();
        self.lamp = lamp.as_ref().map_or(Lamp { is_on: false, ..self.lamp }, Lamp::of);
        (self.others, self.others_shine) = (others, true);
        let (darkest, brightest) = (*Self::EXPOSURE.start(), *Self::EXPOSURE.end());
        self.exposure_stops = staged.scene.exposure_stops.clamp(darkest, brightest);
        (self.surroundings, self.object) = (Surroundings::Scene, Object::Scene);
        self.staged = Some(staged);
        self.home();
        Ok(())
    }

    /// Paints of the document; 0: none is open.
    fn paints(&self) -> usize {
        self.weights.len()
    }

    /// The one object of the scene; of several any.
    fn shape(&self) -> Shape {
        match (self.object, &self.mesh, &self.staged) {
            (Object::Mesh, Some(path), _) => mesh(path),
            (Object::Scene, _, Some(staged)) => staged.scene.shape.clone(),
            // Every other name is a shape's.
            (object, ..) => Shape::named(object.name()).unwrap_or_default(),
        }
    }

    /// Changes the object; the eye goes back to where it sees all of it.
    pub fn set_object(&mut self, object: Object) {
        if self.object != object {
            self.object = object;
            self.home();
        }
    }

    /// Takes the eye back to where it sees all of the object.
    pub fn home(&mut self) {
        self.orbit = match (self.object, &self.staged) {
            (Object::Demonstration, _) => Orbit::of(&stage::camera()),
            (Object::Scene, Some(staged)) => Orbit::of(&staged.scene.camera),
            _ => Orbit::default(),
        };
    }

    /// The scene in a picture of `size` pixels, each at least 1.
    pub fn scene(&self, size: [usize; 2]) -> Scene {
        let file = self.staged.as_ref().map(|staged| &staged.scene);
        let environment = self.environment();
        let background = file.filter(|_| self.surroundings == Surroundings::Scene);
        Scene {
            size,
            exposure_stops: self.exposure_stops,
            background: background.and_then(|scene| scene.background),
            camera: self.orbit.camera(),
            shape: self.shape(),
            environment,
            lights: self.lights(),
            objects: self.objects(),
        }
    }

    fn environment(&self) -> Environment {
        let file = self.staged.as_ref().map(|staged| &staged.scene.environment);
        self.surroundings.environment(&self.lamp, &self.panorama, file)
    }

    fn lights(&self) -> Vec<Light> {
        let mut lights = self.lamp.lights();
        if self.others_shine {
            lights.extend(&self.others);
        }
        // The lamp that moves comes first, and is one more where a scene has as many as there may be.
        lights.truncate(Scene::MAX_LIGHTS);
        lights
    }

    /// The objects of the demonstration or of an opened scene; none: one shape alone.
    fn objects(&self) -> Vec<crate::scene::Object> {
        match (self.object, &self.staged) {
            (Object::Demonstration, _) => stage::objects(self.weights.len(), self.movable),
            (Object::Scene, Some(staged)) => staged.scene.objects.clone(),
            _ => Vec::new(),
        }
    }

    /// The paints that a picture needs, in the order in which objects name them.
    ///
    /// # Errors
    /// An object that wears a paint that there is not.
    pub fn worn(&self, shown: Shown) -> Result<Vec<Shown>> {
        match (self.object, &self.staged) {
            (Object::Demonstration, _) => {
                Ok([shown].into_iter().chain((0..self.paints()).map(Shown::Paint)).collect())
            }
            (Object::Scene, Some(staged)) => staged.worn(shown, self.paints()),
            _ => Ok(vec![shown]),
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
    fn opened_files_are_choices_like_others() {
        let mut state = State::default();
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenes");
        state.set_panorama(format!("{scenes}/studio.exr").into());
        state.set_mesh(format!("{scenes}/ring.obj").into());
        state.scene([7, 5]).validate().unwrap();
        assert_eq!((state.object, state.surroundings), (Object::Mesh, Surroundings::Picture));
        state.next_object();
        state.next_surroundings();
        assert_eq!((state.object, state.surroundings), (Object::Capsule, Surroundings::Studio));
        state.last_object();
        assert_eq!(state.object, Object::Mesh);
    }

    #[test]
    fn a_scene_is_shown_as_its_file_says() {
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenes");
        for file in std::fs::read_dir(scenes).unwrap() {
            let file = file.unwrap().path();
            if file.extension().is_none_or(|e| e != "toml") {
                continue;
            }
            let mut state = State { weights: weights::equal(4), ..State::default() };
            let staged = Staged::read(&file).unwrap();
            let own = staged.scene.clone();
            state.set_scene(staged).unwrap();
            let shown = state.scene(own.size);
            let name = file.display();
            assert_eq!((&shown.shape, &shown.objects), (&own.shape, &own.objects), "{name}");
            assert_eq!((&shown.environment, shown.background), (&own.environment, own.background), "{name}");
            assert_eq!(shown.exposure_stops, own.exposure_stops, "{name}");
            assert_eq!(shown.lights.len(), own.lights.len(), "{name}");
            // Sines of arc tangents at some hundred millimetres.
            let eyes = [&shown, &own].map(|s| glam::DVec3::from(s.camera.position_mm));
            assert!(eyes[0].distance(eyes[1]) < 1e-9, "{name}: {eyes:?}");
            shown.check_paints(state.worn(Shown::Blend).unwrap().len()).unwrap();
            // Chosen anew, surroundings and objects are those of the window.
            state.surroundings = Surroundings::Studio;
            state.set_object(Object::Sphere);
            assert!(state.scene([4, 4]).objects.is_empty() && state.scene([4, 4]).background.is_none());
        }
    }

    #[test]
    fn a_scene_that_wears_more_paints_than_there_are_is_not_shown() {
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/scenes/demo.toml");
        let staged = Staged::read(demo.as_ref()).unwrap();
        let mut state = State { weights: weights::equal(2), ..State::default() };
        let before = state.clone();
        assert!(state.set_scene(staged.clone()).is_err() && state == before);
        state.opened(3).unwrap();
        state.set_scene(staged).unwrap();
        assert!(state.opened(2).is_err(), "fewer paints");
        assert_eq!(state.object, Object::Capsule);
    }

    #[test]
    fn a_moved_capsule_sets_the_weights() {
        let mut state =
            State { weights: weights::equal(3), object: Object::Demonstration, ..State::default() };
        state.move_capsule(DVec2::new(0.0, 46.0));
        assert!(state.weights[0] > 0.999, "at the first one: {:?}", state.weights);
        assert_eq!(state.worn(Shown::Blend).unwrap().len(), 4);
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
    fn a_kept_blend_stands_beside_the_one_being_made() {
        let mut state = State { weights: vec![0.5, 0.5], ..State::default() };
        state.keep();
        state.set_weight(0, 1.0);
        assert_eq!((state.layout, state.second()), (Layout::Split, Some(Shown::Kept)));
        assert_eq!(state.kept, Some((vec![0.5, 0.5], BlendOptions::default())));
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
        state.opened(2).unwrap();
        assert_eq!((state.weights.as_slice(), state.blend.source), (&[0.5, 0.5][..], 0));
        assert_eq!(state.shown, [Shown::Blend, Shown::Paint(0)]);
        assert!(!state.lamp.is_on);
    }
}
