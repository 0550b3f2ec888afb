//! The bright parts of surroundings as points of light, for maps of what paints scatter (`shaders/prefilter.wgsl`), and in
//! groups, for what flakes do.

use super::environment::Surroundings;
use super::lamp_groups::LampGroup;
use crate::color::luminance;
use crate::math::hash::unit;
use glam::{DVec3, Vec3};

/// Directions that say what light is usual, and candidates for points.
const DIRECTIONS: u32 = 4096;
const CANDIDATES: u32 = 1 << 15;
/// Light that is so many times the usual one is a lamp's. Errors of maps hardly hang on it: from 0 to 16, under six surroundings,
/// they change by a fifth.
const BRIGHT: f64 = 2.0;
/// Power below which there are no lamps: shares of it would be lost to rounding.
const FAINTEST: f32 = 1e-20;
/// Halvings of the bright parts, and the width below which there are none, radians: half the angle between a map's normals.
const HALVINGS: u32 = 8;
const NARROW: f32 = 0.035;

/// Light beyond a level.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LampPoints {
    /// Luminance up to which light is none of a lamp.
    pub level: f32,
    /// Integral of the luminance beyond it over all directions.
    pub power: f32,
    /// Some [`LampPoints::MOST`], of even power but where lamps are narrow.
    pub points: Vec<LampPoint>,
    /// All of them.
    pub groups: Vec<LampGroup>,
}

/// A part of a lamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LampPoint {
    /// Unit vector to its middle.
    pub direction: Vec3,
    /// Luminance beyond the level, the geometric mean: shares of the balance are sigmoids of its logarithm.
    pub luminance: f32,
    /// Radiance beyond the level times solid angle.
    pub light: Vec3,
}

/// A direction drawn by power, and what it stands for.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    direction: Vec3,
    /// Of radiance beyond the level.
    luminance: f64,
    light: DVec3,
    /// Luminance of `light`.
    power: f64,
}

impl LampPoints {
    /// Most points.
    pub const MOST: usize = 1 << HALVINGS;

    /// Of surroundings that are ready for rays; no points, and a level above all light, where there are no lamps.
    pub fn of(surroundings: &Surroundings) -> Self {
        let none = Self { level: f32::MAX, power: 0.0, points: Vec::new(), groups: Vec::new() };
        if !surroundings.has_lamps() {
            return none;
        }
        // Candidates come from soft boxes: what they are added to is no lamp, however bright.
        let gradient = surroundings.gradient.iter().map(|color| luminance(color.as_dvec3()));
        let level = gradient.fold(BRIGHT * usual(surroundings), f64::max);
        let mut candidates: Vec<_> =
            (0..CANDIDATES).filter_map(|k| candidate(surroundings, level, k)).collect();
        let power = candidates.iter().map(|c| c.power).sum::<f64>() as f32;
        if power < FAINTEST {
            return none;
        }
        let mut points = Vec::with_capacity(Self::MOST);
        halve(&mut candidates, HALVINGS, &mut points);
        let groups = LampGroup::all(points.clone());
        Self { level: level as f32, power, points, groups }
    }

    /// The share of light of this luminance that is not a lamp's.
    pub fn dim_share(&self, luminance: f32) -> f32 {
        if luminance <= self.level { 1.0 } else { self.level / luminance }
    }
}

impl LampPoint {
    /// Luminance of its light.
    pub fn power(&self) -> f64 {
        luminance(self.light.as_dvec3())
    }
}

/// Median of the luminance over all directions.
fn usual(surroundings: &Surroundings) -> f64 {
    // Vogel's spiral over the sphere.
    let seen = |k: u32| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(DIRECTIONS);
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(k)).sin_cos();
        let flat = (1.0 - z * z).sqrt();
        luminance(surroundings.radiance(DVec3::new(flat * cos, flat * sin, z).as_vec3()).as_dvec3())
    };
    let mut all: Vec<f64> = (0..DIRECTIONS).map(seen).collect();
    *all.select_nth_unstable_by(DIRECTIONS as usize / 2, f64::total_cmp).1
}

/// Point `k` of Fibonacci's lattice; none where it is dim.
fn candidate(surroundings: &Surroundings, level: f64, k: u32) -> Option<Candidate> {
    let point = [(k as f32 + 0.5) / CANDIDATES as f32, unit(k.wrapping_mul(2_654_435_769))];
    let direction = surroundings.sample(point);
    let radiance = surroundings.radiance(direction).as_dvec3();
    let all = luminance(radiance);
    let solid_angle = 1.0 / (f64::from(CANDIDATES) * f64::from(surroundings.density(direction)));
    let light = radiance * ((1.0 - level / all) * solid_angle);
    let lamp = Candidate { direction, luminance: all - level, light, power: luminance(light) };
    (all > level && lamp.power > 0.0 && light.is_finite()).then_some(lamp)
}

/// Halves of even power, across the widest axis (median cut: Debevec 2005), down to points.
fn halve(candidates: &mut [Candidate], halvings: u32, points: &mut Vec<LampPoint>) {
    let Some(first) = candidates.first() else { return };
    let bounds =
        |f: fn(Vec3, Vec3) -> Vec3| candidates.iter().fold(first.direction, |b, c| f(b, c.direction));
    let extent = bounds(Vec3::max) - bounds(Vec3::min);
    if halvings == 0 || extent.max_element() < NARROW {
        points.push(point(candidates));
        return;
    }
    let axis = extent.max_position();
    candidates.sort_by(|a, b| a.direction[axis].total_cmp(&b.direction[axis]));
    let half = 0.5 * candidates.iter().map(|c| c.power).sum::<f64>();
    let mut sum = 0.0;
    let middle = candidates
        .iter()
        .take_while(|c| {
            sum += c.power;
            sum <= half
        })
        .count();
    let (low, high) = candidates.split_at_mut(middle.clamp(1, candidates.len() - 1));
    halve(low, halvings - 1, points);
    halve(high, halvings - 1, points);
}

/// All of them, in their middle.
fn point(candidates: &[Candidate]) -> LampPoint {
    let power = candidates.iter().map(|c| c.power).sum::<f64>();
    let mean = |of: fn(&Candidate) -> f64| candidates.iter().map(|c| c.power / power * of(c)).sum::<f64>();
    let middle = candidates.iter().map(|c| c.direction.as_dvec3() * (c.power / power)).sum::<DVec3>();
    LampPoint {
        direction: middle.normalize_or(candidates[0].direction.as_dvec3()).as_vec3(),
        luminance: mean(|c| c.luminance.ln()).exp() as f32,
        light: candidates.iter().map(|c| c.light).sum::<DVec3>().as_vec3(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Environment, Softbox};

    fn studio(softbox: Vec<Softbox>) -> Surroundings {
        studio_of([0.2; 3], softbox)
    }

    /// Gray from ground, horizon, zenith.
    fn studio_of(gradient: [f64; 3], softbox: Vec<Softbox>) -> Surroundings {
        let [ground, horizon, zenith] = gradient.map(|gray| [gray; 3]);
        Environment::Studio { ground, horizon, zenith, softbox }.surroundings().unwrap()
    }

    fn lamp(direction: [f64; 3], size_deg: [f64; 2], radiance: [f64; 3]) -> Softbox {
        Softbox { direction, size_deg, edge_deg: 0.5, radiance }
    }

    #[test]
    fn points_have_the_light_of_their_lamps() {
        let lamps = [
            lamp([1.0, 0.0, 0.0], [30.0, 20.0], [5.0, 6.0, 7.0]),
            lamp([0.0, 1.0, 0.3], [4.0, 4.0], [50.0, 40.0, 10.0]),
        ];
        let both = LampPoints::of(&studio(lamps.to_vec()));
        assert!((f64::from(both.level) - 0.4).abs() < 1e-6);
        for one in &lamps {
            let toward = DVec3::from(one.direction).normalize().as_vec3();
            let near = both.points.iter().filter(|p| p.direction.dot(toward) > 0.8);
            let light = near.map(|p| p.light.as_dvec3()).sum::<DVec3>();
            // The solid angle between planes through the axes; what is beyond the level.
            let [a, b] = one.size_deg.map(|size| (0.5 * size).to_radians().tan());
            let solid_angle = 4.0 * (a * b / (1.0 + a * a + b * b + a * a * b * b).sqrt()).asin();
            let all = DVec3::from(one.radiance) + 0.2;
            let expected = all * ((1.0 - 0.4 / luminance(all)) * solid_angle);
            // Points on a smooth edge of a lamp 8 edges wide: a percent.
            assert!((light / expected - 1.0).abs().max_element() < 0.01, "{light} {expected}");
        }
        let power = both.points.iter().map(|p| luminance(p.light.as_dvec3())).sum::<f64>();
        assert!((f64::from(both.power) / power - 1.0).abs() < 1e-5);
        assert!(both.points.len() <= LampPoints::MOST && both.points.len() > LampPoints::MOST / 2);
    }

    #[test]
    fn a_small_lamp_is_one_point_and_none_is_none() {
        let small = LampPoints::of(&studio(vec![lamp([0.3, -0.4, 0.5], [1.0, 1.0], [1e4; 3])]));
        let direction = DVec3::new(0.3, -0.4, 0.5).normalize().as_vec3();
        assert_eq!(small.points.len(), 1);
        assert!(small.points[0].direction.dot(direction) > 1.0 - 1e-6);
        // Half a degree of full light along either axis, and two edges of half a degree each: of f = 3 t^2 - 2 t^3, the integral of
        // f ln f is -0.19805.
        let expected = 1e4 * (-2.0 * 0.19805f32).exp();
        assert!((small.points[0].luminance / expected - 1.0).abs() < 0.01, "{}", small.points[0].luminance);
        assert!(LampPoints::of(&studio(Vec::new())).points.is_empty());
        // Dimmer than twice what is about it.
        let dim = LampPoints::of(&studio(vec![lamp([1.0, 0.0, 0.0], [20.0; 2], [0.1; 3])]));
        assert!(dim.points.is_empty() && dim.power == 0.0 && dim.level == f32::MAX);
        let faint = LampPoints::of(&studio_of([0.0; 3], vec![lamp([1.0, 0.0, 0.0], [20.0; 2], [1e-40; 3])]));
        assert!(faint.points.is_empty() && faint.level == f32::MAX);
    }

    /// A zenith ten times as bright as the horizon is no lamp, though it is more than twice the usual.
    #[test]
    fn gradients_are_no_lamps() {
        let one = |radiance| vec![lamp([1.0, 0.0, 0.0], [20.0; 2], [radiance; 3])];
        let bright = LampPoints::of(&studio_of([0.05, 0.1, 1.0], one(2.0)));
        assert!(bright.level >= 1.0 && !bright.points.is_empty());
        assert!(bright.points.iter().all(|point| point.direction.x > 0.9));
        assert_eq!(LampPoints::of(&studio_of([0.05, 0.1, 1.0], one(0.5))).level, f32::MAX);
    }
}
