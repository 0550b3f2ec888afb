//! The loop over pixels.

use super::cells::Random;
use super::disc::Disc;
use super::footprint::Footprint;
use super::lamp::Lamp;
use super::paint::RenderPaint;
use super::picture::Picture;
use super::shade::gloss_widening;
use super::surroundings::{Share, radiance};
use super::surroundings_flakes::{surroundings_sparkle, taps};
use super::truth::{FlakeTruth, Shine, flakes_mean};
use crate::error::{Error, Result};
use crate::scene::{Bodies, Hit, Incidence, Light, Scene, Surroundings, View};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// Rays a pixel, 1 to 4096.
    pub samples: usize,
    /// Directions a ray in which the base looks for the surroundings, 1 to 4096.
    pub directions: usize,
    /// Seed of flakes and sampling.
    pub seed: u32,
    /// Whether flakes sparkle; their mean belongs to the smooth part and stays.
    pub flakes: bool,
    /// Where the flakes' random numbers come from.
    pub random: Random,
}

impl Default for Options {
    fn default() -> Self {
        Self { samples: 8, directions: 48, seed: 1, flakes: true, random: Random::Hash }
    }
}

impl Options {
    pub(super) fn validate(&self) -> Result<()> {
        for (what, n) in [("samples", self.samples), ("directions", self.directions)] {
            if !(1..=4096).contains(&n) {
                return Err(Error::invalid("render", what, n, "1 to 4096"));
            }
        }
        self.random.validate()
    }
}

/// How often [`render()`] calls `tick`.
pub fn tick_count(scene: &Scene) -> usize {
    scene.size[1]
}

/// Renders every paint as a tile of the scene's size, left to right, or one picture of all paints where the scene lists objects
/// that wear them: linear Rec.709 radiance, not clamped, exposure not applied. The same bits on any number of threads. `tick`
/// is called once a row.
///
/// Objects hide each other, and keep the light of lamps from each other, by one ray to the middle of the lamp. Surroundings are
/// seen from everywhere as if there were no other objects.
///
/// # Errors
/// An illegal scene or option, no paints, an object that wears none of them, more pixels than [`Scene::MAX_PIXELS`], a paint
/// without statistics that the picture draws from.
pub fn render(
    scene: &Scene,
    paints: &[RenderPaint],
    options: &Options,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    let stage = check(scene, paints, options)?;
    let coatings: Vec<_> = paints.iter().map(|paint| Coating { paint, truth: None }).collect();
    Ok(stage.picture(&coatings, tick))
}

/// Renders as [`render()`] does, with what the flakes of each paint are in place of their statistics.
///
/// # Errors
/// As [`render()`]; another number of truths than of paints.
pub fn render_truth(
    scene: &Scene,
    paints: &[RenderPaint],
    truths: &[FlakeTruth<'_>],
    options: &Options,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    let stage = check(scene, paints, options)?;
    if truths.len() != paints.len() {
        let legal = format!("{}, one a paint", paints.len());
        return Err(Error::invalid("render", "number of flake truths", truths.len(), legal));
    }
    let coatings: Vec<_> =
        paints.iter().zip(truths).map(|(paint, truth)| Coating { paint, truth: Some(truth) }).collect();
    Ok(stage.picture(&coatings, tick))
}

/// The scene ready for rays, all that a picture needs checked.
///
/// # Errors
/// Those of [`render()`].
pub(crate) fn check<'a>(scene: &'a Scene, paints: &[RenderPaint], options: &'a Options) -> Result<Stage<'a>> {
    scene.validate()?;
    options.validate()?;
    let pixels = scene.size[0] * scene.size[1];
    let tiles = scene.tiles(paints).len();
    if paints.is_empty() || tiles.saturating_mul(pixels) > Scene::MAX_PIXELS {
        let legal = format!("1 to {}", Scene::MAX_PIXELS / pixels);
        return Err(Error::invalid("render", "number of paints", paints.len(), legal));
    }
    scene.check_paints(paints.len())?;
    let stage = Stage::new(scene, options)?;
    for (k, paint) in paints.iter().enumerate() {
        stage.check_cells(paint, (!scene.objects.is_empty()).then_some(k))?;
    }
    Ok(stage)
}

/// The points of a pixel through which its rays go, in pixels.
pub(super) fn sample_points(x: usize, y: usize, n: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..n).map(move |k| {
        let across = (k as f64 + 0.5) / n as f64;
        // The golden ratio's fractional part.
        let down = (k as f64 * 0.618_033_988_749_894_9 + 0.5).fract();
        [x as f64 + across, y as f64 + down]
    })
}

/// A paint, and what its flakes are if not their statistics.
#[derive(Debug, Clone, Copy)]
struct Coating<'a> {
    paint: &'a RenderPaint,
    truth: Option<&'a FlakeTruth<'a>>,
}

/// What a ray meets. One at a time, on the stack.
#[allow(clippy::large_enum_variant)]
pub(super) enum Seen {
    /// The painted side of the object.
    Paint(Patch),
    /// The inner side of a body and the back of a panel, which are not painted: black.
    Back,
    /// Nothing, in this direction.
    Surroundings(DVec3),
}

/// A patch of paint under a ray.
pub(super) struct Patch {
    /// The middle of it.
    pub hit: Hit,
    /// Number of the paint.
    pub paint: usize,
    /// Where it is, and what it mirrors.
    pub footprint: Footprint,
    /// Columns are the axes of the camera's frame, turned to the surface.
    pub to_world: DMat3,
    /// Towards the eye, in that frame.
    pub wo: Vec3,
    /// Rows are the axes of the frame that is fixed to the surface.
    pub to_surface: DMat3,
    /// Towards the eye, in that frame.
    pub seen_from: Vec3,
}

/// A scene ready for rays.
pub(crate) struct Stage<'a> {
    pub scene: &'a Scene,
    pub options: &'a Options,
    pub view: View,
    pub bodies: Bodies,
    pub surroundings: Surroundings,
    background: Option<Vec3>,
}

impl<'a> Stage<'a> {
    /// # Errors
    /// A file of the scene that cannot be read.
    pub fn new(scene: &'a Scene, options: &'a Options) -> Result<Self> {
        Ok(Self::with(scene, options, Bodies::new(scene)?, scene.environment.surroundings()?))
    }

    /// A scene whose objects and surroundings are ready.
    pub fn with(scene: &'a Scene, options: &'a Options, bodies: Bodies, surroundings: Surroundings) -> Self {
        let view = scene.camera.view(scene.size);
        let background = scene.background.map(|b| DVec3::from(b).as_vec3());
        Self { scene, options, view, bodies, surroundings, background }
    }

    /// Calls `visit` with every patch of paint that a row of pixels sees.
    pub(super) fn patches_of_row(&self, y: usize, mut visit: impl FnMut(&Patch)) {
        for x in 0..self.scene.size[0] {
            for at in sample_points(x, y, self.options.samples) {
                if let Seen::Paint(patch) = self.seen(at) {
                    visit(&patch);
                }
            }
        }
    }

    /// The lamps that a patch sees.
    pub(super) fn lamps(&self, patch: &Patch) -> impl Iterator<Item = Lamp> {
        self.incidences(patch).map(Lamp::new)
    }

    pub(super) fn incidences(&self, patch: &Patch) -> impl Iterator<Item = Incidence> {
        let seen = self.scene.lights.iter().map(|light: &Light| light.at(patch.footprint.point));
        seen.filter(|lamp| !self.bodies.is_shaded(&patch.hit, lamp))
    }

    fn picture(&self, coatings: &[Coating<'_>], tick: &(dyn Fn() + Sync)) -> Picture {
        let [width, height] = self.scene.size;
        let tiles = self.scene.tiles(coatings);
        let size = [width * tiles.len(), height];
        let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
        pixels.par_chunks_mut(size[0]).enumerate().for_each(|(y, row)| {
            for (tile, coatings) in row.chunks_mut(width).zip(&tiles) {
                for (x, pixel) in tile.iter_mut().enumerate() {
                    *pixel = self.pixel(coatings, x, y).to_array();
                }
            }
            tick();
        });
        Picture { size, pixels }
    }

    /// All pairs of directions, to light and eye, at which a patch draws from its flakes; some may be below the horizon.
    pub(super) fn flake_directions(&self, patch: &Patch) -> impl Iterator<Item = [Vec3; 2]> {
        let wo = patch.seen_from;
        let discs = self.lamps(patch).map(|lamp| lamp.disc(&patch.to_surface));
        let lit = discs.flat_map(Disc::directions).map(move |wi| [wi, wo]);
        let around = taps(&self.surroundings, patch.to_world.as_mat3(), patch.wo);
        lit.chain(around.map(|tap| [tap.wi, patch.wo]))
    }

    /// Mean over the samples of a pixel (box filter), at the points of Fibonacci's lattice.
    fn pixel(&self, coatings: &[Coating<'_>], x: usize, y: usize) -> Vec3 {
        let n = self.options.samples;
        let mut sum = Vec3::ZERO;
        for (k, at) in sample_points(x, y, n).enumerate() {
            let place = [(x * n + k) as u32, y as u32];
            sum += self.sample(coatings, at, place, Share { sample: k as u32, samples: n as u32 });
        }
        sum / n as f32
    }

    /// What is seen where a ray meets nothing.
    pub(super) fn seen_beyond(&self, direction: DVec3) -> Vec3 {
        self.background.unwrap_or_else(|| self.surroundings.radiance(direction.as_vec3()))
    }

    /// What a ray meets.
    pub(super) fn seen(&self, at: [f64; 2]) -> Seen {
        let direction = self.view.direction(at[0], at[1]);
        let Some(hit) = self.bodies.intersect(self.view.origin, direction) else {
            return Seen::Surroundings(direction);
        };
        if direction.dot(hit.normal) >= 0.0 {
            return Seen::Back;
        }
        let side = 1.0 / (self.options.samples as f64).sqrt();
        let source = (self.options.seed, self.options.random);
        let footprint = Footprint::new(&self.bodies, &self.view, &hit, at, side, source);
        // The surroundings are looked for in the camera's frame, whose directions vary smoothly over the object; flakes turn
        // with the surface.
        let to_world = self.view.frame(hit.normal);
        let wo = (to_world.transpose() * -direction).as_vec3();
        let to_surface = self.bodies.frame(&hit).transpose();
        let seen_from = (to_surface * -direction).as_vec3();
        let paint = self.bodies.paint(hit.object);
        Seen::Paint(Patch { hit, paint, footprint, to_world, wo, to_surface, seen_from })
    }

    /// Radiance along one ray, the sample of a pixel at `place`.
    fn sample(&self, coatings: &[Coating<'_>], at: [f64; 2], place: [u32; 2], share: Share) -> Vec3 {
        let patch = match self.seen(at) {
            Seen::Paint(patch) => patch,
            Seen::Surroundings(direction) => return self.seen_beyond(direction),
            Seen::Back => return Vec3::ZERO,
        };
        let Coating { paint, truth } = coatings[patch.paint];
        let Patch { footprint, to_world, wo, to_surface, seen_from, .. } = &patch;
        let statistics = paint.flakes.as_ref().filter(|_| self.options.flakes && truth.is_none());
        let flakes = statistics.map(|f| f.draws(&footprint.surface));
        let spread = footprint.mirrored_sides.map(|s| s.length() as f32);
        let widening = gloss_widening(0.0, spread);
        let directions = self.options.directions as u32;
        let frames = [&to_world.as_mat3(), &to_surface.as_mat3()];
        let mut around = radiance(paint, &self.surroundings, frames[0], *wo, widening, directions, share);
        if let Some(flakes) = &flakes {
            around += surroundings_sparkle(paint, flakes, &self.surroundings, frames, *wo);
        }
        let sum = self.lamps(&patch).fold(around, |sum, lamp| {
            sum + lamp.radiance(paint, flakes.as_ref(), footprint, to_surface, *seen_from)
        });
        sum + truth.map_or(Vec3::ZERO, |truth| {
            let shines: Vec<_> = self.incidences(&patch).map(|lamp| Shine::new(&lamp, to_surface)).collect();
            let mean = flakes_mean(paint, &shines, *seen_from);
            let sparkle =
                self.options.flakes.then(|| truth.radiance(&footprint.surface, *seen_from, &shines, place));
            mean + sparkle.unwrap_or_default()
        })
    }
}
