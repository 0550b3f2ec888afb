//! The loop over pixels.

use super::cells::Random;
use super::footprint::Footprint;
use super::lamp::Lamp;
use super::needs::check_cells;
use super::paint::RenderPaint;
use super::picture::Picture;
use super::shade::gloss_widening;
use super::surroundings::{Share, radiance};
use crate::error::{Error, Result};
use crate::scene::{Light, Scene, Surroundings, View};
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

/// Renders every paint as a tile of the scene's size, left to right: linear Rec.709 radiance, not clamped, exposure not
/// applied. The same bits on any number of threads. `tick` is called once a row.
///
/// # Errors
/// An illegal scene or option, no paints, more pixels than [`Scene::MAX_PIXELS`], a paint without statistics that the picture
/// draws from.
pub fn render(
    scene: &Scene,
    paints: &[RenderPaint],
    options: &Options,
    tick: &(dyn Fn() + Sync),
) -> Result<Picture> {
    check(scene, paints, options)?;
    let [width, height] = scene.size;
    let stage = Stage::new(scene, options);
    let size = [width * paints.len(), height];
    let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
    pixels.par_chunks_mut(size[0]).enumerate().for_each(|(y, row)| {
        for (tile, paint) in row.chunks_mut(width).zip(paints) {
            for (x, pixel) in tile.iter_mut().enumerate() {
                *pixel = stage.pixel(paint, x, y).to_array();
            }
        }
        tick();
    });
    Ok(Picture { size, pixels })
}

/// # Errors
/// Those of [`render()`].
pub(crate) fn check(scene: &Scene, paints: &[RenderPaint], options: &Options) -> Result<()> {
    scene.validate()?;
    options.validate()?;
    let pixels = scene.size[0] * scene.size[1];
    if paints.is_empty() || paints.len().saturating_mul(pixels) > Scene::MAX_PIXELS {
        let legal = format!("1 to {}", Scene::MAX_PIXELS / pixels);
        return Err(Error::invalid("render", "number of paints", paints.len(), legal));
    }
    paints.iter().try_for_each(|paint| check_cells(scene, options, paint))
}

/// The points of a pixel through which its rays go, in pixels.
fn sample_points(x: usize, y: usize, n: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..n).map(move |k| {
        let across = (k as f64 + 0.5) / n as f64;
        // The golden ratio's fractional part.
        let down = (k as f64 * 0.618_033_988_749_894_9 + 0.5).fract();
        [x as f64 + across, y as f64 + down]
    })
}

/// What a ray meets. One at a time, on the stack.
#[allow(clippy::large_enum_variant)]
enum Seen {
    /// The painted side of the object.
    Paint(Patch),
    /// The inner side of a body and the back of a panel, which are not painted: black.
    Back,
    /// Nothing, in this direction.
    Surroundings(DVec3),
}

/// A patch of paint under a ray.
pub(super) struct Patch {
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
pub(super) struct Stage<'a> {
    scene: &'a Scene,
    options: &'a Options,
    view: View,
    surroundings: Surroundings,
    background: Option<Vec3>,
}

impl<'a> Stage<'a> {
    pub fn new(scene: &'a Scene, options: &'a Options) -> Self {
        Self {
            scene,
            options,
            view: scene.camera.view(scene.size),
            surroundings: scene.environment.surroundings(),
            background: scene.background.map(|b| DVec3::from(b).as_vec3()),
        }
    }

    /// Calls `visit` with every patch of paint that a row of pixels sees.
    pub fn patches_of_row(&self, y: usize, mut visit: impl FnMut(&Patch)) {
        for x in 0..self.scene.size[0] {
            for at in sample_points(x, y, self.options.samples) {
                if let Seen::Paint(patch) = self.seen(at) {
                    visit(&patch);
                }
            }
        }
    }

    /// The lamps as a patch sees them.
    pub fn lamps(&self, patch: &Patch) -> impl Iterator<Item = Lamp> {
        let point = patch.footprint.point;
        self.scene.lights.iter().map(move |light: &Light| Lamp::new(light.at(point)))
    }

    /// Mean over the samples of a pixel (box filter), at the points of Fibonacci's lattice.
    fn pixel(&self, paint: &RenderPaint, x: usize, y: usize) -> Vec3 {
        let n = self.options.samples;
        let mut sum = Vec3::ZERO;
        for (k, at) in sample_points(x, y, n).enumerate() {
            sum += self.sample(paint, at, Share { sample: k as u32, samples: n as u32 });
        }
        sum / n as f32
    }

    /// What a ray meets.
    fn seen(&self, at: [f64; 2]) -> Seen {
        let direction = self.view.direction(at[0], at[1]);
        let Some(hit) = self.scene.shape.intersect(self.view.origin, direction) else {
            return Seen::Surroundings(direction);
        };
        if direction.dot(hit.normal) >= 0.0 {
            return Seen::Back;
        }
        let side = 1.0 / (self.options.samples as f64).sqrt();
        let source = (self.options.seed, self.options.random);
        let footprint = Footprint::new(&self.scene.shape, &self.view, &hit, at, side, source);
        // The surroundings are looked for in the camera's frame, whose directions vary smoothly over the object; flakes turn
        // with the surface.
        let to_world = self.view.frame(hit.normal);
        let wo = (to_world.transpose() * -direction).as_vec3();
        let to_surface = self.scene.shape.frame(hit.chart, hit.normal).transpose();
        let seen_from = (to_surface * -direction).as_vec3();
        Seen::Paint(Patch { footprint, to_world, wo, to_surface, seen_from })
    }

    /// Radiance along one ray.
    fn sample(&self, paint: &RenderPaint, at: [f64; 2], share: Share) -> Vec3 {
        let patch = match self.seen(at) {
            Seen::Paint(patch) => patch,
            Seen::Surroundings(direction) => {
                return self.background.unwrap_or_else(|| self.surroundings.radiance(direction.as_vec3()));
            }
            Seen::Back => return Vec3::ZERO,
        };
        let Patch { footprint, to_world, wo, to_surface, seen_from } = &patch;
        let flakes =
            paint.flakes.as_ref().filter(|_| self.options.flakes).map(|f| f.draws(&footprint.surface));
        let spread = footprint.mirrored_sides.map(|s| s.length() as f32);
        let widening = gloss_widening(0.0, spread);
        let directions = self.options.directions as u32;
        let around =
            radiance(paint, &self.surroundings, &to_world.as_mat3(), *wo, widening, directions, share);
        self.lamps(&patch).fold(around, |sum, lamp| {
            sum + lamp.radiance(paint, flakes.as_ref(), footprint, to_surface, *seen_from)
        })
    }
}
