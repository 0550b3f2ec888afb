//! A Gaussian field over the plane: independent normal numbers on the knots of a square lattice, four of which are blended
//! at a place with bilinear weights scaled to unit length, so that the field has variance 1 everywhere.
//!
//! Twin of a shader: besides sums and products only a root and a quotient, which scale a value by all but 1e-7; what has
//! steps, the number of a knot's square, hangs on the place alone.

use super::floor::floor;
use super::hash::{pcg4d, unit};
use super::normal_f32::probit;
use glam::Vec2;

/// A map of the plane to places on a lattice: `p / (s sqrt(1 + c |p|^2))`, dense near the middle and ever wider outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnotMap {
    /// 1 / s.
    pub per_unit: f32,
    /// c, 0 or more.
    pub compression: f32,
}

impl KnotMap {
    /// Knots of a spacing s near the middle, and a compression c of 0 or more.
    pub fn new(spacing: f64, compression: f64) -> Self {
        Self { per_unit: (1.0 / spacing) as f32, compression: compression as f32 }
    }

    /// The place of a point, in units of the spacing.
    #[inline]
    pub fn place(&self, point: Vec2) -> Vec2 {
        point * (self.per_unit / (1.0 + self.compression * point.length_squared()).sqrt())
    }

    /// Area of places over that of the points they belong to.
    #[inline]
    pub fn stretch(&self, point: Vec2) -> f32 {
        let side = self.per_unit / (1.0 + self.compression * point.length_squared());
        side * side
    }
}

/// A lattice of unit spacing, turned and moved at random, and its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnotLattice {
    /// Cosine and sine of its turn.
    turn: Vec2,
    offset: Vec2,
    key: [u32; 2],
}

impl KnotLattice {
    /// The lattice that belongs to four random words.
    pub fn new(words: [u32; 4]) -> Self {
        let [x, y, angle, key] = words;
        // A square lattice has seen all its turns within an eighth of a circle to either side.
        let angle = (unit(angle) - 0.5) * std::f32::consts::FRAC_PI_2;
        Self { turn: turn(angle), offset: Vec2::new(unit(x), unit(y)), key: [key, x ^ y.rotate_left(16)] }
    }

    /// The field at a place, in units of the spacing.
    #[inline]
    pub fn value(&self, place: Vec2) -> f32 {
        let at = self.turn.rotate(place) + self.offset;
        let corner = Vec2::new(floor(at.x), floor(at.y));
        let [x, y] = [corner.x as i32 as u32, corner.y as i32 as u32];
        let weights = weights(at - corner);
        (0..4).fold(0.0, |sum, k| {
            let knot = [x.wrapping_add(k & 1), y.wrapping_add(k >> 1), self.key[0], self.key[1]];
            sum + weights[k as usize] * probit(unit(pcg4d(knot)[0]))
        })
    }
}

/// Weights of the four corners of the unit square, x before y: bilinear, scaled to a sum of squares of 1.
#[inline]
pub fn weights(place: Vec2) -> [f32; 4] {
    let (far, near) = (place, Vec2::ONE - place);
    let squares = near * near + far * far;
    let scale = 1.0 / (squares.x * squares.y).sqrt();
    [near.x * near.y, far.x * near.y, near.x * far.y, far.x * far.y].map(|w| w * scale)
}

/// Cosine and sine of an angle within an eighth of a circle, by Taylor's series: right to 3e-8.
fn turn(angle: f32) -> Vec2 {
    let square = angle * angle;
    let cosine = 1.0 - square * (0.5 - square * (1.0 / 24.0 - square * (1.0 / 720.0 - square / 40_320.0)));
    let sine = angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0)));
    Vec2::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_compressed_outwards() {
        let near = KnotMap::new(0.1, 9.0).place(Vec2::new(1e-4, -2e-4));
        assert!((near - Vec2::new(1e-3, -2e-3)).length() < 1e-8, "{near}");
        // 1 / (0.1 sqrt(1 + 9)).
        let far = KnotMap::new(0.1, 9.0).place(Vec2::new(0.6, 0.8));
        assert!((far - Vec2::new(0.6, 0.8) * 10f32.sqrt()).length() < 1e-6, "{far}");
    }

    #[test]
    fn the_stretch_is_the_area_of_a_small_square() {
        let map = KnotMap::new(0.1, 4.0);
        for point in [Vec2::ZERO, Vec2::new(0.2, -0.1), Vec2::new(-0.5, 0.7)] {
            let step = 0.01;
            let side =
                |axis: Vec2| (map.place(point + axis * step) - map.place(point - axis * step)) / (2.0 * step);
            let area = side(Vec2::X).perp_dot(side(Vec2::Y));
            // Central differences: a hundredth squared times curvatures of a few.
            assert!((area / map.stretch(point) - 1.0).abs() < 2e-3, "{point}: {area} {}", map.stretch(point));
        }
    }

    #[test]
    fn turns_keep_lengths_and_weights_are_unit() {
        for k in -50..=50 {
            let angle = k as f32 * 0.0157;
            let exact = Vec2::new(angle.cos(), angle.sin());
            // The first term left out: 0.785^9 / 9!, and two roundings.
            assert!((turn(angle) - exact).length() < 4.5e-7, "{angle}");
            let weights = weights(Vec2::new((k + 50) as f32 * 0.01, 0.3));
            assert!((weights.iter().map(|w| w * w).sum::<f32>() - 1.0).abs() < 4e-7);
        }
    }

    #[test]
    fn the_field_is_normal_and_forgets_within_two_spacings() {
        let n = 60_000u32;
        for (step, least, most) in [(0.0f32, 1.0, 1.0), (0.5, 0.7, 0.9), (1.0, 0.3, 0.5), (2.9, 0.0, 0.0)] {
            let (mut squares, mut products) = (0.0, 0.0);
            for k in 0..n {
                let lattice = KnotLattice::new(pcg4d([k, 1, 2, 3]));
                let (a, b) =
                    (lattice.value(Vec2::new(0.3, -0.2)), lattice.value(Vec2::new(0.3 + step, -0.2)));
                squares += f64::from(a * a);
                products += f64::from(a * b);
            }
            // The standard errors are 1.4 and 1 over the root of n: 0.006 and 0.004.
            let [variance, covariance] = [squares, products].map(|s| s / f64::from(n));
            assert!((variance - 1.0).abs() < 0.024, "{variance}");
            assert!(covariance > least - 0.024 && covariance < most + 0.024, "{step}: {covariance}");
        }
    }
}
