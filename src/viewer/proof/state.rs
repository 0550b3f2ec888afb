//! What a user sets of a print, without a window.

use super::super::choices::{Layout, after};
use super::super::light::Lamp;
use super::super::orbit::Orbit;
use crate::color::{Illuminant, Spectrum};
use crate::error::Result;
use crate::proof::Method;
use crate::render::{Bands, InkModel, Look, Paper, lit_from_behind};
use crate::scene::{DirectionalLight, Light, PointLight, Scene, Shape};
use glam::{DVec2, DVec3};
use std::ops::RangeInclusive;

/// Light of the lamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LampLight {
    /// Daylight.
    #[default]
    D65,
    /// A bulb.
    A,
    /// The emission that was opened.
    Measured,
}

/// What a user sets.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Light of the lamps.
    pub light: LampLight,
    /// Name and spectrum of the emission that was opened.
    pub emission: Option<(String, Spectrum)>,
    /// Whether the eye takes the light's white for white.
    pub adapted: bool,
    /// How inks reflect: in the picture or its left part, and in the right one.
    pub models: [InkModel; 2],
    /// How two models share the picture.
    pub layout: Layout,
    /// Where a split picture is divided, share of the width.
    pub divider: f32,
    /// One of [`Shape::PRINTED`].
    pub shape: &'static str,
    /// Where the eye is.
    pub orbit: Orbit,
    /// Where it sees all of the print.
    home: Orbit,
    /// The lamp that is moved; its radius does not count.
    pub lamp: Lamp,
    /// Whether the other lamp, from the side, shines.
    pub side_lamp: bool,
    /// Share of light of the lamps behind; 0: there are none.
    pub back_light: f64,
    /// Whether paper lies beneath.
    pub has_paper: bool,
    /// Whether inks are as rough as their files say.
    pub own_roughness: bool,
    /// Roughness of all inks, if not.
    pub roughness: f64,
    /// How dots are placed.
    pub method: Method,
    /// Dots along a side of a pixel.
    pub cell: usize,
    /// Wavelengths at which light is added up.
    pub bands: Bands,
    /// Whether the exposure follows the picture, the first of two, as that of `carpaint proof` does.
    pub auto_exposure: bool,
    /// Exposure, stops; where it follows the picture, that of the last one.
    pub exposure_stops: f64,
}

impl Default for State {
    fn default() -> Self {
        let scene = Scene::proof(Shape::default());
        Self {
            light: LampLight::default(),
            emission: None,
            adapted: false,
            models: [InkModel::Goniochromatic, InkModel::Schlick],
            layout: Layout::default(),
            divider: 0.5,
            shape: Shape::PRINTED[0],
            orbit: Orbit::of(&scene.camera),
            home: Orbit::of(&scene.camera),
            lamp: lamp(&scene),
            side_lamp: true,
            back_light: 0.0,
            has_paper: true,
            own_roughness: true,
            roughness: 0.2,
            method: Method::default(),
            cell: 1,
            bands: Self::BANDS[0],
            auto_exposure: true,
            exposure_stops: scene.exposure_stops,
        }
    }
}

/// A lamp, or one in its place that does not shine.
fn dimmed(light: Light, is_on: bool) -> Light {
    match light {
        Light::Point(lamp) if !is_on => Light::Point(PointLight { irradiance: [0.0; 3], ..lamp }),
        light => light,
    }
}

/// Width over height of the narrowest picture in which the widest print is seen without a wider field.
const WIDEST: f64 = 1.1;

/// The lamp of a scene that is moved: its first one.
fn lamp(scene: &Scene) -> Lamp {
    match scene.lights.first() {
        Some(Light::Point(PointLight { position_mm: direction, irradiance, .. })) => {
            Lamp::of(&DirectionalLight {
                direction: *direction,
                irradiance: *irradiance,
                ..DirectionalLight::default()
            })
        }
        _ => Lamp::default(),
    }
}

impl State {
    /// Legal shares of light from behind.
    pub const BACK_LIGHT: RangeInclusive<f64> = 0.0..=1.0;
    /// Legal roughness: smoother ones sparkle at single pixels.
    pub const ROUGHNESS: RangeInclusive<f64> = 0.02..=1.0;
    /// Cells to choose from.
    pub const CELLS: [usize; 8] = [1, 2, 3, 4, 6, 8, 16, 32];
    /// Wavelengths to choose from.
    pub const BANDS: [Bands; 5] = [
        Bands::Wavelengths(crate::color::BANDS),
        Bands::Wavelengths(21),
        Bands::Wavelengths(16),
        Bands::Wavelengths(8),
        Bands::Xyz,
    ];

    /// The lights to choose from.
    pub fn all_lights(&self) -> Vec<LampLight> {
        let measured = self.emission.is_some().then_some(LampLight::Measured);
        [LampLight::D65, LampLight::A].into_iter().chain(measured).collect()
    }

    /// Takes an emission for the light of the lamps.
    pub fn set_emission(&mut self, name: String, spectrum: Spectrum) {
        (self.emission, self.light) = (Some((name, spectrum)), LampLight::Measured);
    }

    /// Goes on to the next shape, or back.
    pub fn next_shape(&mut self, is_back: bool) {
        let mut all = Shape::PRINTED;
        if is_back {
            all.reverse();
        }
        self.shape = after(self.shape, &all);
    }

    /// Takes the eye back to where it sees all of the print.
    pub fn home(&mut self) {
        self.orbit = self.home;
    }

    /// Pictures are of these proportions from now on, width over height: narrow ones are seen through a wider field, so that nothing
    /// is cut off. An eye that was moved stays.
    pub fn fit(&mut self, proportions: f64) {
        let mut home = Orbit::of(&Scene::proof(Shape::default()).camera);
        if proportions < WIDEST {
            home.zoom(proportions / WIDEST, DVec2::ZERO);
        }
        if self.orbit == self.home {
            self.orbit = home;
        }
        self.home = home;
    }

    /// The exposure that is asked for, stops; none: it follows the picture.
    pub fn stops(&self) -> Option<f64> {
        (!self.auto_exposure).then_some(self.exposure_stops)
    }

    /// Takes note of the exposure of a picture, which it follows unless a user has set it since.
    pub fn exposed(&mut self, stops: f64) {
        if self.auto_exposure {
            self.exposure_stops = stops;
        }
    }

    /// The models that are shown, from left to right.
    pub fn shown_models(&self) -> &[InkModel] {
        &self.models[..if self.layout == Layout::Single { 1 } else { 2 }]
    }

    /// How inks are seen that reflect in this way. Three numbers are only known for the goniochromatic model: others are seen at all
    /// wavelengths instead.
    pub fn look(&self, model: InkModel) -> Look {
        let light = match (self.light, &self.emission) {
            (LampLight::Measured, Some((_, spectrum))) => spectrum.clone(),
            (LampLight::A, _) => Illuminant::A.spectrum(),
            _ => Illuminant::D65.spectrum(),
        };
        let bands = match (self.bands, model) {
            (Bands::Xyz, InkModel::Goniochromatic) | (Bands::Wavelengths(_), _) => self.bands,
            (Bands::Xyz, _) => Self::BANDS[0],
        };
        Look { light, adapted: self.adapted, model, bands }
    }

    /// What lies beneath.
    pub fn paper(&self) -> Paper {
        if self.has_paper { Paper::BLACK } else { Paper::NONE }
    }

    /// The scene in a picture of `size` pixels, printed with an image of these proportions; its exposure is 0.
    ///
    /// # Errors
    /// A shape that there is not.
    pub fn scene(&self, size: [usize; 2], proportions: f64) -> Result<Scene> {
        let proof = Scene::proof(Shape::printed(self.shape, proportions)?);
        // Lamps that are off stay: without any nothing would be rendered.
        let mut lights = proof.lights.clone().into_iter();
        let moved = lights.next().map(|light| dimmed(self.moved(light), self.lamp.is_on));
        let lights = moved.into_iter().chain(lights.map(|light| dimmed(light, self.side_lamp))).collect();
        let scene = Scene { size, lights, camera: self.orbit.camera(), exposure_stops: 0.0, ..proof };
        Ok(if self.back_light > 0.0 { lit_from_behind(scene, self.back_light) } else { scene })
    }

    /// A lamp as far away as it is, where the lamp of the window stands, as bright as that.
    fn moved(&self, light: Light) -> Light {
        let Light::Point(lamp) = light else { return light };
        let distance = DVec3::from(lamp.position_mm).length();
        Light::Point(PointLight {
            position_mm: (self.lamp.direction() * distance).to_array(),
            irradiance: self.lamp.irradiance.map(|c| c * self.lamp.stops.exp2()),
            ..lamp
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_first_it_shows_what_the_program_writes() {
        let scene = State::default().scene([640, 480], 1.5).unwrap();
        let own = Scene::proof(Shape::printed("sheet", 1.5).unwrap());
        assert_eq!((&scene.shape, scene.size), (&own.shape, own.size));
        let positions = |scene: &Scene| -> Vec<DVec3> {
            let position = |light: &Light| match light {
                Light::Point(lamp) => DVec3::from(lamp.position_mm),
                _ => panic!("a lamp that is none of the proof's"),
            };
            scene.lights.iter().map(position).chain([DVec3::from(scene.camera.position_mm)]).collect()
        };
        // Sines of arc tangents at some hundred millimetres.
        assert!(positions(&scene).iter().zip(positions(&own)).all(|(a, b)| a.distance(b) < 1e-9));
    }

    #[test]
    fn every_choice_makes_a_legal_scene() {
        let mut state = State::default();
        for proportions in [1e-3, 1.0, 1e3] {
            for _ in Shape::PRINTED {
                state.next_shape(false);
                for (is_on, side_lamp, back_light, shining) in [
                    (false, false, 1.0, 0),
                    (true, false, 0.0, 1),
                    (false, true, 0.1, 2),
                    (true, true, 1.0, 4),
                ] {
                    (state.lamp.is_on, state.side_lamp, state.back_light) = (is_on, side_lamp, back_light);
                    let scene = state.scene([7, 5], proportions).unwrap();
                    scene.validate().unwrap();
                    let shines = |light: &&Light| light.at(DVec3::ZERO).irradiance != DVec3::ZERO;
                    assert_eq!(scene.lights.iter().filter(shines).count(), shining);
                }
            }
        }
        assert_eq!(state.shape, Shape::PRINTED[0]);
        state.next_shape(true);
        assert_eq!(state.shape, "capsule");
    }

    #[test]
    fn narrow_pictures_show_all_of_the_print_unless_the_eye_was_moved() {
        let mut state = State::default();
        let wide = state.orbit;
        state.fit(1.2);
        assert_eq!(state.orbit, wide);
        state.fit(0.5);
        // The edges of a panel, as wide as a print gets.
        let width = 0.5 * state.orbit.field_mm();
        assert!(width > 60.0, "{width}");
        state.orbit.orbit(DVec2::new(20.0, 0.0));
        let moved = state.orbit;
        state.fit(1.2);
        assert_eq!(state.orbit, moved);
        state.home();
        assert_eq!(state.orbit, wide);
    }

    #[test]
    fn three_numbers_are_for_our_model_alone() {
        let state = State { bands: Bands::Xyz, ..State::default() };
        assert_eq!(state.look(InkModel::Goniochromatic).bands, Bands::Xyz);
        assert_eq!(state.look(InkModel::Schlick).bands, Bands::Wavelengths(41));
    }

    #[test]
    fn an_emission_that_is_opened_lights_the_print() {
        let mut state = State::default();
        assert_eq!(state.all_lights().len(), 2);
        state.set_emission("led".to_owned(), Spectrum::constant(2.0));
        assert_eq!(state.look(InkModel::Exact).light, Spectrum::constant(2.0));
        state.light = LampLight::A;
        assert_eq!(state.look(InkModel::Exact).light, Illuminant::A.spectrum());
        assert_eq!(state.all_lights().len(), 3, "it can be chosen again");
    }
}
