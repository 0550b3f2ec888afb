//! The bright parts of surroundings as few patches of light.

use super::lamp_points::LampPoint;
use glam::{DVec3, Vec3, swizzles::Vec3Swizzles};
use std::f64::consts::PI;

/// Neighbouring points of lamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LampGroup {
    /// Unit vector to their middle.
    pub direction: Vec3,
    /// Luminance beyond the level, the geometric mean.
    pub luminance: f32,
    /// Radiance beyond the level times solid angle.
    pub light: Vec3,
    /// Of a disc that is as large as the ellipse over which they are spread, themselves as large as they are.
    pub solid_angle: f32,
    /// How much oftener two of its points are the same one than in a disc that is evenly lit: not at all where points tile it, the sum of
    /// the squares of their shares of the light where they are small.
    pub alone: f32,
    /// Solid angle of one of them, as a share of all.
    pub own: f32,
}

/// Where points are.
#[derive(Debug, Clone, Copy)]
struct Spread {
    power: f64,
    /// Mean of the unit vectors, by power.
    middle: DVec3,
    /// Variances along the axes.
    variances: DVec3,
    /// Covariances of y and z, z and x, x and y.
    mixed: DVec3,
}

impl LampGroup {
    /// Most groups.
    pub const MOST: usize = 24;

    /// Groups of all points: those that are widest, and bright, are parted first.
    pub fn all(points: Vec<LampPoint>) -> Vec<Self> {
        let mut parts: Vec<_> = Some(points).filter(|points| !points.is_empty()).into_iter().collect();
        let mut costs: Vec<f64> = parts.iter().map(|part| cost(part)).collect();
        while parts.len() < Self::MOST {
            let Some(worst) = (0..parts.len()).max_by(|a, b| costs[*a].total_cmp(&costs[*b])) else { break };
            if costs[worst] <= 0.0 {
                break;
            }
            let other = parted(&mut parts[worst]);
            costs[worst] = cost(&parts[worst]);
            costs.push(cost(&other));
            parts.push(other);
        }
        parts.iter().map(|part| Self::of(part)).collect()
    }

    /// Of one point or more.
    fn of(points: &[LampPoint]) -> Self {
        let spread = Spread::of(points);
        let Spread { power, middle, .. } = spread;
        let mean = |of: &dyn Fn(&LampPoint) -> f64| points.iter().map(|p| p.power() / power * of(p)).sum();
        let own: f64 = mean(&|p| p.power() / f64::from(p.luminance));
        let solid_angle = spread.solid_angle() + own;
        let luminance: f64 = mean(&|p| f64::from(p.luminance).ln());
        let (same, own) = (mean(&|p| p.power() / power), own / solid_angle);
        let alone: f64 = if own < 1.0 { ((same - own) / (1.0 - own)).clamp(0.0, 1.0) } else { 1.0 };
        Self {
            direction: middle.normalize_or(points[0].direction.as_dvec3()).as_vec3(),
            luminance: luminance.exp() as f32,
            light: points.iter().map(|p| p.light.as_dvec3()).sum::<DVec3>().as_vec3(),
            solid_angle: solid_angle as f32,
            alone: alone as f32,
            own: own as f32,
        }
    }
}

/// How much is lost by one direction for all: nothing for a single point. Dim groups count as well where they are alone with a
/// paint, so that it grows with the root of the power.
fn cost(points: &[LampPoint]) -> f64 {
    if points.len() < 2 {
        return 0.0;
    }
    let spread = Spread::of(points);
    spread.power.sqrt() * spread.variances.element_sum()
}

/// Leaves what lies on one side of the middle, across the widest axis, and returns the rest; neither is empty. `points`: two or
/// more.
fn parted(points: &mut Vec<LampPoint>) -> Vec<LampPoint> {
    let Spread { middle, variances, .. } = Spread::of(points);
    let axis = variances.max_position();
    points.sort_by(|a, b| a.direction[axis].total_cmp(&b.direction[axis]));
    let low = points.partition_point(|p| f64::from(p.direction[axis]) < middle[axis]);
    points.split_off(low.clamp(1, points.len() - 1))
}

impl Spread {
    /// Of one point or more.
    fn of(points: &[LampPoint]) -> Self {
        let power = points.iter().map(LampPoint::power).sum();
        let mean = |of: &dyn Fn(DVec3) -> DVec3| {
            points.iter().map(|p| of(p.direction.as_dvec3()) * (p.power() / power)).sum::<DVec3>()
        };
        let middle = mean(&|d| d);
        let off = |d: DVec3| d - middle;
        Self {
            power,
            middle,
            variances: mean(&|d| off(d) * off(d)),
            mixed: mean(&|d| off(d).yzx() * off(d).zxy()),
        }
    }

    /// Of an ellipse of these variances, taken for no more than twice as long as wide: light that lies on a line is spread, too.
    fn solid_angle(&self) -> f64 {
        // Directions stray along two axes, whose variances have this sum and product.
        let (sum, v) = (self.variances.element_sum(), self.variances);
        let product = (v * v.yzx()).element_sum() - self.mixed.length_squared();
        let long = 0.5 * (sum + (sum * sum - 4.0 * product).max(0.0).sqrt());
        // A disc's radius squared is four times its variance along an axis.
        4.0 * PI * (long * (sum - long).max(0.25 * long)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(direction: Vec3, luminance: f32, light: f32) -> LampPoint {
        LampPoint { direction: direction.normalize(), luminance, light: Vec3::new(0.5, 1.0, 2.0) * light }
    }

    #[test]
    fn a_point_is_a_group_and_none_are_none() {
        assert!(LampGroup::all(Vec::new()).is_empty());
        let one = point(Vec3::new(1.0, 2.0, 2.0), 8.0, 0.1);
        let groups = LampGroup::all(vec![one]);
        let own = (one.power() / 8.0) as f32;
        assert_eq!(groups.len(), 1);
        let group = groups[0];
        assert!((group.direction - one.direction).length() < 1e-6 && group.light == one.light);
        // Rounding of unit vectors to f32 spreads a point by 1e-14.
        assert!((group.solid_angle / own - 1.0).abs() < 1e-5 && (group.luminance - 8.0).abs() < 1e-5);
        assert_eq!((group.alone, group.own), (1.0, 1.0));
        // Two at one place cannot be told apart, and end the parting.
        let same = LampGroup::all(vec![one; 2]);
        assert!(same.len() <= 2 && (same.iter().map(|g| g.light.y).sum::<f32>() - 0.2).abs() < 1e-6);
    }

    #[test]
    fn a_disc_of_points_is_as_large_as_it_is() {
        // Vogel's spiral over a disc of 0.2 radians, of points that fill it.
        let n = 250u16;
        let solid_angle = 0.2f32 * 0.2 * std::f32::consts::PI;
        let disc: Vec<_> = (0..n)
            .map(|k| {
                let radius = 0.2 * ((f32::from(k) + 0.5) / f32::from(n)).sqrt();
                let (sin, cos) = (f32::from(k) * 2.399_963).sin_cos();
                let direction = Vec3::new(radius * cos, radius * sin, 1.0);
                let light = solid_angle / f32::from(n);
                point(direction, (point(direction, 1.0, 1.0).power()) as f32, light)
            })
            .collect();
        let whole = LampGroup::of(&disc);
        // The sphere's curvature is a percent of it, the points themselves 0.4 percent.
        assert!((whole.solid_angle / solid_angle - 1.0).abs() < 0.03, "{whole:?}");
        assert!((whole.own * f32::from(n) - 1.0).abs() < 0.03);
        // Its points tile it; a tenth as large, at the same places, they do not.
        assert!(whole.alone * f32::from(n) < 0.03, "{whole:?}");
        let sparse: Vec<_> = disc.iter().map(|p| LampPoint { luminance: 10.0 * p.luminance, ..*p }).collect();
        assert!((LampGroup::of(&sparse).alone * f32::from(n) - 0.9).abs() < 0.03);
        let groups = LampGroup::all(disc);
        assert_eq!(groups.len(), LampGroup::MOST);
        let light = groups.iter().map(|g| g.light.y).sum::<f32>();
        assert!((light / whole.light.y - 1.0).abs() < 1e-5);
        // Together they are as large: of the same variances, an ellipse is by 4 pi / 12, a twentieth, larger than a rectangle.
        let parts = groups.iter().map(|g| g.solid_angle).sum::<f32>();
        assert!((parts / solid_angle - 1.05).abs() < 0.05, "{parts} {solid_angle}");
    }

    #[test]
    fn wide_groups_are_parted_before_bright_ones() {
        // A sun of many points, and a row of dim lamps far from it.
        let sun = (0..100u8).map(|k| point(Vec3::new(0.001 * f32::from(k), 0.0, 1.0), 1e4, 0.1));
        let row = (0..20u8).map(|k| point(Vec3::new(1.0, 0.1 * f32::from(k), 0.2), 3.0, 1e-3));
        let groups = LampGroup::all(sun.chain(row).collect());
        let of_row = groups.iter().filter(|g| g.direction.z < 0.5).count();
        assert!((8..=20).contains(&of_row), "{of_row} of {}", groups.len());
    }
}
