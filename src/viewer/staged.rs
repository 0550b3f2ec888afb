//! A scene from a file, as the window shows it: its objects wear what is open.

use super::document::stem;
use super::orbit::Orbit;
use super::state::Shown;
use crate::error::{Error, Result};
use crate::scene::{Bodies, Camera, DirectionalLight, Light, Scene};
use glam::DVec3;
use std::path::Path;

/// A scene from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Staged {
    /// For people, that of the file.
    pub name: String,
    /// As it was read.
    pub scene: Scene,
}

impl Staged {
    /// Reads a scene and the files that it names.
    ///
    /// # Errors
    /// As [`Scene::read`]; those of reading its meshes and its surroundings.
    pub fn read(file: &Path) -> Result<Self> {
        let scene = Scene::read(file)?;
        Bodies::new(&scene).map_err(|e| e.in_file(file))?;
        scene.environment.surroundings().map_err(|e| e.in_file(file))?;
        Ok(Self { name: stem(file), scene })
    }

    /// The lamp that the window can move: the first one from afar; and the others.
    pub fn lamps(&self) -> (Option<DirectionalLight>, Vec<Light>) {
        let mut others = self.scene.lights.clone();
        let first = others.iter().position(|light| matches!(light, Light::Directional(_)));
        match first.map(|k| others.remove(k)) {
            Some(Light::Directional(light)) => (Some(light), others),
            _ => (None, others),
        }
    }

    /// The paints that its objects wear, in the order in which they name them, where `n` are open: what is `shown`, if all wear
    /// the same number, or stand for themselves; else number k the k-th paint, and the number after the last what is shown.
    ///
    /// # Errors
    /// An object that wears none of these.
    pub fn worn(&self, shown: Shown, n: usize) -> Result<Vec<Shown>> {
        let objects = &self.scene.objects;
        let most = objects.iter().map(|object| object.paint).max().unwrap_or(0);
        if n == 0 || objects.iter().all(|object| object.paint == most) {
            return Ok(vec![shown; most + 1]);
        }
        self.scene.check_paints(n + 1).map_err(|e| e.within(&self.name))?;
        Ok((0..=most).map(|k| if k < n { Shown::Paint(k) } else { shown }).collect())
    }

    /// What of its camera the window cannot show: the eye of the window is upright, and its field of view has limits.
    ///
    /// # Errors
    /// What it shows instead.
    pub fn check_camera(&self) -> Result<()> {
        let (own, shown) = (&self.scene.camera, Orbit::of(&self.scene.camera).camera());
        let place = |what: &str| format!("{}: camera: {what}", self.name);
        if own.vertical_fov_deg != shown.vertical_fov_deg {
            let legal = format!("0.01 to 75 in the window: shown with {}", shown.vertical_fov_deg);
            return Err(Error::unsupported(
                place("field of view"),
                "vertical_fov_deg",
                own.vertical_fov_deg,
                legal,
            ));
        }
        // The axes of a pixel, unit vectors: roundings of arc tangents.
        if right(own).distance(right(&shown)) > 1e-6
            || eye(own).distance(eye(&shown)) > 1e-6 * eye(own).length()
        {
            let legal = "z upright, short of straight down: shown upright";
            return Err(Error::unsupported(place("upright"), "up", format!("{:?}", own.up), legal));
        }
        Ok(())
    }
}

fn eye(camera: &Camera) -> DVec3 {
    DVec3::from(camera.position_mm) - DVec3::from(camera.target_mm)
}

fn right(camera: &Camera) -> DVec3 {
    DVec3::from(camera.up).cross(eye(camera)).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Object;

    fn staged(paints: &[usize]) -> Staged {
        let object = |paint: &usize| Object { paint: *paint, ..Object::default() };
        let scene = Scene { objects: paints.iter().map(object).collect(), ..Scene::default() };
        Staged { name: "test".to_owned(), scene }
    }

    #[test]
    fn objects_wear_the_paints_that_are_open_and_the_one_on_show() {
        use Shown::{Blend, Paint};
        for (paints, n, expected) in [
            (&[][..], 3, vec![Blend]),
            (&[0, 0], 3, vec![Blend]),
            (&[1], 3, vec![Blend, Blend]),
            (&[0, 1, 2, 3, 3], 3, vec![Paint(0), Paint(1), Paint(2), Blend]),
            (&[0, 1], 1, vec![Paint(0), Blend]),
            (&[0, 4], 0, vec![Blend; 5]),
        ] {
            assert_eq!(staged(paints).worn(Blend, n).unwrap(), expected, "{paints:?} of {n}");
        }
        let message = staged(&[0, 3]).worn(Blend, 2).unwrap_err().to_string();
        assert!(message.contains("object 1") && message.contains("found 3, expected 0 to 2"), "{message}");
    }

    #[test]
    fn cameras_that_the_window_cannot_turn_are_named() {
        let with = |camera| Staged { scene: Scene { camera, ..Scene::default() }, ..staged(&[]) };
        let usual = Camera::default();
        with(usual).check_camera().unwrap();
        for (camera, word) in [
            (Camera { up: [1.0, 0.0, 1.0], ..usual }, "upright"),
            (Camera { position_mm: [0.0, -0.01, 200.0], ..usual }, "upright"),
            (Camera { vertical_fov_deg: 120.0, ..usual }, "75"),
        ] {
            let message = with(camera).check_camera().unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        // Straight up along z in any length.
        with(Camera { up: [0.0, 0.0, 5.0], ..usual }).check_camera().unwrap();
    }

    #[test]
    fn the_first_far_lamp_is_the_one_that_moves() {
        let far = DirectionalLight { direction: [1.0, 0.0, 1.0], ..DirectionalLight::default() };
        let point = Light::Point(crate::scene::PointLight {
            position_mm: [0.0, 0.0, 90.0],
            irradiance: [1.0; 3],
            radius_mm: 3.0,
        });
        let mut staged = staged(&[]);
        staged.scene.lights = vec![point, far.into(), Light::default()];
        assert_eq!(staged.lamps(), (Some(far), vec![point, Light::default()]));
        staged.scene.lights = vec![point];
        assert_eq!(staged.lamps(), (None, vec![point]));
    }
}
