//! The offline reference: path tracing (Rump et al. 2008, section 6).
//!
//! What [`render()`](super::render()) leaves out for speed is in: objects light and hide each other, surroundings are hidden
//! by objects, and flakes at the first hit sparkle under all light, not under lamps only. Where light is looked for, samples of
//! the BRDF, of the bright parts of the surroundings and of the lamps' discs are combined with the balance heuristic. After
//! the first hit flakes count with their mean: a path has no footprint there.

mod directions;
mod numbers;
mod vertex;

use super::image::{Options, Seen, Stage, check, sample_points};
use super::paint::RenderPaint;
use super::picture::Picture;
use crate::error::{Error, Result};
use crate::scene::{Incidence, Scene};
use directions::Directions;
use glam::{DVec3, Vec3};
use numbers::Numbers;
use rayon::prelude::*;
use std::f64::consts::PI;
use vertex::{Bounce, Vertex};

/// A path-traced picture, and how noisy it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced {
    /// Linear Rec.709 radiance.
    pub picture: Picture,
    /// Root of the mean square of the pixels' standard errors, over the mean of the picture; 0 for one sample a pixel.
    pub standard_error: f64,
}

/// Most reflections of a path.
pub const MAX_BOUNCES: usize = 64;

/// Reflections after which a path may end by chance.
const SURE_BOUNCES: usize = 3;

/// Path-traces a scene as [`super::render()`] does, with up to `bounces` reflections, 1 to 64; `options.directions` has no
/// meaning here. The same bits on any number of threads. `tick` is called once a row.
///
/// # Errors
/// Those of [`super::render()`]; another number of reflections; flakes with slices left out.
pub fn trace(
    scene: &Scene,
    paints: &[RenderPaint],
    options: &Options,
    bounces: usize,
    tick: &(dyn Fn() + Sync),
) -> Result<Traced> {
    if !(1..=MAX_BOUNCES).contains(&bounces) {
        return Err(Error::invalid("path tracing", "reflections", bounces, "1 to 64"));
    }
    let stage = check(scene, paints, options)?;
    let is_whole =
        |paint: &RenderPaint| paint.flakes.as_ref().is_none_or(|f| !options.flakes || f.is_whole());
    if !paints.iter().all(is_whole) {
        return Err(Error::invalid(
            "path tracing",
            "slices",
            "some left out",
            "all: light comes from everywhere",
        ));
    }
    let dressed: Vec<_> = paints.iter().map(|paint| (paint, Directions::new(paint))).collect();
    let [width, height] = scene.size;
    let tiles = scene.tiles(&dressed);
    let size = [width * tiles.len(), height];
    let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
    let variances: Vec<f64> = pixels
        .par_chunks_mut(size[0])
        .enumerate()
        .map(|(y, row)| {
            let mut variance = 0.0;
            for (tile, dressed) in row.chunks_mut(width).zip(&tiles) {
                let tracer = Tracer { stage: &stage, paints: dressed, bounces };
                for (x, pixel) in tile.iter_mut().enumerate() {
                    let (mean, scatter) = tracer.pixel(x, y);
                    *pixel = mean.to_array();
                    variance += scatter;
                }
            }
            tick();
            variance
        })
        .collect();
    let mean = pixels.iter().map(|p| f64::from(Vec3::from(*p).element_sum()) / 3.0).sum::<f64>()
        / pixels.len() as f64;
    let error = (variances.iter().sum::<f64>() / pixels.len() as f64).sqrt();
    let standard_error = if mean > 0.0 { error / mean } else { 0.0 };
    Ok(Traced { picture: Picture { size, pixels }, standard_error })
}

/// A stage with the paints of one tile.
struct Tracer<'a> {
    stage: &'a Stage<'a>,
    paints: &'a [(&'a RenderPaint, Directions)],
    bounces: usize,
}

impl Tracer<'_> {
    /// Mean over the samples of a pixel, and the square of its standard error, mean of the channels.
    fn pixel(&self, x: usize, y: usize) -> (Vec3, f64) {
        let n = self.stage.options.samples;
        let (mut sum, mut squares) = (DVec3::ZERO, 0.0);
        for (k, at) in sample_points(x, y, n).enumerate() {
            let mut numbers = Numbers::new([x as u32, y as u32, k as u32], self.stage.options.seed);
            let radiance = self.path(at, &mut numbers).as_dvec3();
            sum += radiance;
            squares += (radiance.element_sum() / 3.0).powi(2);
        }
        let mean = sum / n as f64;
        let variance = (squares / n as f64 - (mean.element_sum() / 3.0).powi(2)).max(0.0);
        (mean.as_vec3(), if n > 1 { variance / (n - 1) as f64 } else { 0.0 })
    }

    /// Radiance along the path that begins at a point of the picture.
    fn path(&self, at: [f64; 2], numbers: &mut Numbers) -> Vec3 {
        let patch = match self.stage.seen(at) {
            Seen::Paint(patch) => patch,
            Seen::Surroundings(direction) => return self.stage.seen_beyond(direction),
            Seen::Back => return Vec3::ZERO,
        };
        let (paint, directions) = &self.paints[patch.paint];
        let mut vertex = Vertex::first(&patch, paint, directions, self.stage.options.flakes);
        let (mut sum, mut throughput) = (Vec3::ZERO, Vec3::ONE);
        for bounce in 1..=self.bounces {
            sum += throughput * self.looked_for(&vertex, numbers);
            let Some(way) = vertex.scatter(numbers) else { break };
            throughput *= way.weight;
            let hit = self.stage.bodies.intersect(vertex.origin(), way.direction);
            let distance = hit.map_or(f64::INFINITY, |hit| hit.distance);
            sum += throughput * self.found(&vertex, &way, distance);
            let Some(hit) = hit.filter(|hit| way.direction.dot(hit.normal) < 0.0) else { break };
            if bounce >= SURE_BOUNCES {
                let survival = throughput.max_element().clamp(0.05, 1.0);
                if numbers.next() >= survival {
                    break;
                }
                throughput /= survival;
            }
            let (paint, directions) = &self.paints[self.stage.bodies.paint(hit.object)];
            vertex = Vertex::later(&self.stage.bodies, &hit, way.direction, paint, directions);
        }
        sum
    }

    /// Light from the lamps and the bright parts of the surroundings, looked for there.
    fn looked_for(&self, vertex: &Vertex<'_>, numbers: &mut Numbers) -> Vec3 {
        let surroundings = &self.stage.surroundings;
        let mut sum = Vec3::ZERO;
        if surroundings.has_lamps() {
            let direction = surroundings.sample([numbers.next(), numbers.next()]);
            let density = surroundings.density(direction);
            let seen = || surroundings.radiance(direction);
            // Of unit length in f64: rays begin so near the surface that f32's would meet it.
            sum += self.weighed(vertex, direction.as_dvec3().normalize(), f64::INFINITY, density, seen);
        }
        for light in &self.stage.scene.lights {
            let lamp = light.at(vertex.point);
            let direction = within_disc(&lamp, [numbers.next(), numbers.next()]);
            let density = (1.0 / solid_angle(&lamp)) as f32;
            sum += self.weighed(vertex, direction, lamp.distance, density, || disc_radiance(&lamp));
        }
        sum
    }

    /// What light from a direction that was drawn with this density adds, weighed against drawing it from the BRDF.
    fn weighed(
        &self,
        vertex: &Vertex<'_>,
        direction: DVec3,
        distance: f64,
        density: f32,
        radiance: impl FnOnce() -> Vec3,
    ) -> Vec3 {
        let wi = vertex.local(direction);
        if wi.z <= 0.0 || density <= 0.0 {
            return Vec3::ZERO;
        }
        let hit = self.stage.bodies.intersect(vertex.origin(), direction);
        if hit.is_some_and(|hit| hit.distance < distance) {
            return Vec3::ZERO;
        }
        vertex.reflected(wi) * radiance() * (wi.z / (density + vertex.density(wi)))
    }

    /// Light that a direction drawn from the BRDF happened to meet before `distance`.
    fn found(&self, vertex: &Vertex<'_>, way: &Bounce, distance: f64) -> Vec3 {
        let weight = |other: f32| way.density.map_or(1.0, |own| own / (own + other));
        let mut sum = Vec3::ZERO;
        if distance == f64::INFINITY {
            let direction = way.direction.as_vec3();
            let surroundings = &self.stage.surroundings;
            sum += surroundings.radiance(direction) * weight(surroundings.density(direction));
        }
        for light in &self.stage.scene.lights {
            let lamp = light.at(vertex.point);
            let angle = lamp.direction.cross(way.direction).length().atan2(lamp.direction.dot(way.direction));
            if angle < lamp.angular_radius && distance >= lamp.distance {
                sum += disc_radiance(&lamp) * weight((1.0 / solid_angle(&lamp)) as f32);
            }
        }
        sum
    }
}

/// Solid angle of a lamp's disc, sr: 2 pi (1 - cos r) without cancellation.
fn solid_angle(lamp: &Incidence) -> f64 {
    4.0 * PI * (0.5 * lamp.angular_radius).sin().powi(2)
}

/// Radiance of a lamp's disc: E / (pi sin^2 r).
fn disc_radiance(lamp: &Incidence) -> Vec3 {
    (lamp.irradiance / (PI * lamp.angular_radius.sin().powi(2))).as_vec3()
}

/// A direction within a lamp's disc, uniform in solid angle, for two numbers in (0, 1).
fn within_disc(lamp: &Incidence, [share, turn]: [f32; 2]) -> DVec3 {
    let fall = f64::from(share) * 2.0 * (0.5 * lamp.angular_radius).sin().powi(2);
    let sine = (fall * (2.0 - fall)).sqrt();
    let (sin, cos) = (2.0 * PI * f64::from(turn)).sin_cos();
    let (right, up) = lamp.direction.any_orthonormal_pair();
    right * (sine * cos) + up * (sine * sin) + lamp.direction * (1.0 - fall)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_fill_the_disc() {
        for radius in [0.0044f64, 0.5, 1.5] {
            let lamp = Incidence {
                direction: DVec3::new(0.48, -0.6, 0.64),
                irradiance: DVec3::ONE,
                angular_radius: radius,
                distance: f64::INFINITY,
            };
            let n = 20_000u32;
            let mut numbers = Numbers::new([1, 2, 3], 4);
            let mut irradiance = 0.0;
            for _ in 0..n {
                let direction = within_disc(&lamp, [numbers.next(), numbers.next()]);
                let cosine = direction.dot(lamp.direction);
                assert!((direction.length() - 1.0).abs() < 1e-12 && cosine >= radius.cos() - 1e-12);
                irradiance += cosine * f64::from(disc_radiance(&lamp).x) * solid_angle(&lamp) / f64::from(n);
            }
            // The cosine spreads by up to 0.3 of its mean: five standard errors of n draws; f32 radiance.
            assert!((irradiance - 1.0).abs() < 0.011, "{radius}: {irradiance}");
        }
    }
}
