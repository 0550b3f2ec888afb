//! Surroundings given by an equirectangular picture: columns are longitudes, rows latitudes, the zenith on top.
//!
//! The middle column lies ahead of the default camera (+y), and to the right of it what is to the right (+x). Radiance is
//! bilinear between the middles of texels. Directions are chosen by luminance: a texel's share is the exact mean of the
//! bilinear radiance over its rectangle, times its solid angle, so that a single bright texel is found from its dark
//! neighbours, too. Rows, then columns, by inversion of their distribution functions: unlike an alias table that keeps
//! well-spread points well spread.

use crate::error::{Error, Result};
use glam::{DVec2, Vec2, Vec3};
use std::f64::consts::PI;

/// A panorama ready for rays, f32.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panorama {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Radiance, and the share of the texels from the row's first to this one in the row's power; row-major, top row first.
    pub texels: Vec<([f32; 3], f32)>,
    /// Share of the rows from the first to this one, and the height z of this row's lower end.
    pub rows: Vec<(f32, f32)>,
    /// Cosine and sine of the angle by which it is turned about z.
    pub turn: Vec2,
    /// Whether it shines at all.
    is_bright: bool,
}

impl Panorama {
    /// Most texels; larger pictures are halved.
    pub const MAX_TEXELS: usize = 1 << 22;
    /// How far below 0, as a share of the largest value, another may lie and count as 0: filters and lossy compression leave such
    /// values beside a sun, in files in use some 20 % of it.
    const RINGING: f32 = 0.5;
    /// Largest radiance.
    const MAX_RADIANCE: f32 = 1e30;

    /// A panorama of these pixels times `scale`, turned counterclockwise, seen from above, by `turn` radians.
    ///
    /// # Errors
    /// A value below 0 by more than half of the largest, or above 1e30 (its pixel named).
    pub fn new(size: [usize; 2], mut pixels: Vec<[f32; 3]>, scale: f32, turn: f64) -> Result<Self> {
        let lowest = -Self::RINGING * pixels.iter().flatten().copied().fold(0.0, f32::max);
        for (k, pixel) in pixels.iter_mut().enumerate() {
            let found = *pixel;
            *pixel = pixel.map(|c| c.max(0.0) * scale);
            if !found.iter().all(|c| *c >= lowest) || pixel.iter().any(|c| *c > Self::MAX_RADIANCE) {
                let place = format!("pixel ({}, {})", k % size[0], k / size[0]);
                let legal = "radiance from 0 to 1e30, times scale";
                return Err(Error::invalid(place, "value", format!("{found:?}"), legal));
            }
        }
        let (mut size, mut pixels) = (size, pixels);
        while size[0] * size[1] > Self::MAX_TEXELS {
            (size, pixels) = halved(size, &pixels);
        }
        let [width, height] = size;
        let weights = mean_luminance(size, &pixels);
        let edge = |row: usize| (PI * row as f64 / height as f64).cos();
        let mut texels = Vec::with_capacity(pixels.len());
        let mut powers = Vec::with_capacity(height);
        for (row, (weights, pixels)) in weights.chunks(width).zip(pixels.chunks(width)).enumerate() {
            let shares = cumulative(weights);
            texels.extend(pixels.iter().copied().zip(shares));
            powers.push(weights.iter().sum::<f64>() * (edge(row) - edge(row + 1)));
        }
        let is_bright = powers.iter().any(|power| *power > 0.0);
        let lower_ends = (1..=height).map(|row| edge(row) as f32);
        let rows = cumulative(&powers).into_iter().zip(lower_ends).collect();
        let turn = DVec2::from_angle(turn).as_vec2();
        Ok(Self { size, texels, rows, turn, is_bright })
    }

    /// Whether it shines at all.
    pub fn is_bright(&self) -> bool {
        self.is_bright
    }

    /// Radiance from the unit vector `direction`.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [width, height] = self.size;
        let at = self.place(direction) - 0.5;
        let corner = at.floor();
        let weight = at - corner;
        let column = |step: i32| (corner.x as i32 + step).rem_euclid(width as i32) as usize;
        let row = |step: i32| (corner.y as i32 + step).clamp(0, height as i32 - 1) as usize;
        let texel = |x: i32, y: i32| Vec3::from(self.texels[row(y) * width + column(x)].0);
        let above = texel(0, 0).lerp(texel(1, 0), weight.x);
        let below = texel(0, 1).lerp(texel(1, 1), weight.x);
        above.lerp(below, weight.y)
    }

    /// A direction from two numbers in (0, 1), by luminance.
    pub fn sample(&self, [across, along]: [f32; 2]) -> Vec3 {
        let [width, _] = self.size;
        let (row, down) = inverted(&self.rows, |row| row.0, across);
        let texels = &self.texels[row * width..(row + 1) * width];
        let (column, right) = inverted(texels, |texel| texel.1, along);
        let upper = self.upper_end(row);
        let z = upper + (self.rows[row].1 - upper) * down;
        let longitude = std::f32::consts::TAU * ((column as f32 + right) / width as f32 - 0.5);
        let (sin, cos) = longitude.sin_cos();
        let level = (1.0 - z * z).max(0.0).sqrt();
        let flat = self.turn.rotate(Vec2::new(level * sin, level * cos));
        flat.extend(z)
    }

    /// Density of [`Panorama::sample`] at a unit vector, 1/sr.
    pub fn density(&self, direction: Vec3) -> f32 {
        let [width, height] = self.size;
        let at = self.place(direction);
        let row = (at.y as usize).min(height - 1);
        let column = (at.x as usize).min(width - 1);
        let texels = &self.texels[row * width..(row + 1) * width];
        let mass = share(&self.rows, |row| row.0, row) * share(texels, |texel| texel.1, column);
        let rise = self.upper_end(row) - self.rows[row].1;
        mass * width as f32 / (std::f32::consts::TAU * rise)
    }

    /// Height z of the upper end of a row.
    fn upper_end(&self, row: usize) -> f32 {
        if row > 0 { self.rows[row - 1].1 } else { 1.0 }
    }

    /// Where on the picture a direction is, in texels from its top left corner.
    fn place(&self, direction: Vec3) -> Vec2 {
        let flat = Vec2::new(self.turn.x, -self.turn.y).rotate(direction.truncate());
        let longitude = flat.x.atan2(flat.y);
        let colatitude = flat.length().atan2(direction.z);
        let [width, height] = self.size.map(|n| n as f32);
        Vec2::new(
            (longitude * std::f32::consts::FRAC_1_PI * 0.5 + 0.5) * width,
            colatitude * std::f32::consts::FRAC_1_PI * height,
        )
    }
}

/// Half the columns and rows, each the mean of two.
fn halved([width, height]: [usize; 2], pixels: &[[f32; 3]]) -> ([usize; 2], Vec<[f32; 3]>) {
    let size = [width.div_ceil(2), height.div_ceil(2)];
    let texel = |k: usize| {
        let (x, y) = (2 * (k % size[0]), 2 * (k / size[0]));
        let at = |x: usize, y: usize| Vec3::from(pixels[y.min(height - 1) * width + x.min(width - 1)]);
        ((at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) * 0.25).to_array()
    };
    (size, (0..size[0] * size[1]).map(texel).collect())
}

/// Mean over each texel of the luminance that is bilinear between the middles of texels: an eighth of either neighbour.
fn mean_luminance([width, height]: [usize; 2], pixels: &[[f32; 3]]) -> Vec<f64> {
    let luminance = |p: &[f32; 3]| {
        let [r, g, b] = p.map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let plain: Vec<f64> = pixels.iter().map(luminance).collect();
    let across = |k: usize| {
        let (row, x) = (k / width * width, k % width);
        0.75 * plain[k] + 0.125 * (plain[row + (x + 1) % width] + plain[row + (x + width - 1) % width])
    };
    let rows: Vec<f64> = (0..plain.len()).map(across).collect();
    let down = |k: usize| {
        let above = if k >= width { k - width } else { k };
        let below = if k + width < rows.len() { k + width } else { k };
        0.75 * rows[k] + 0.125 * (rows[above] + rows[below])
    };
    debug_assert_eq!(pixels.len(), width * height);
    (0..rows.len()).map(down).collect()
}

/// Shares of the first weights in all, up to each; all 1 where there is no weight.
fn cumulative(weights: &[f64]) -> Vec<f32> {
    let total: f64 = weights.iter().sum();
    let upto = weights.iter().scan(0.0, |sum, weight| {
        *sum += weight;
        // The last is the total, to the bit: the sums are the same.
        Some(if total > 0.0 { (*sum / total) as f32 } else { 1.0 })
    });
    upto.collect()
}

/// The part of a distribution in which `x` in (0, 1) lies, and where in it, 0 to 1.
fn inverted<T>(parts: &[T], upto: impl Fn(&T) -> f32, x: f32) -> (usize, f32) {
    let part = parts.partition_point(|part| upto(part) <= x).min(parts.len() - 1);
    let before = if part > 0 { upto(&parts[part - 1]) } else { 0.0 };
    (part, ((x - before) / (upto(&parts[part]) - before)).clamp(0.0, 1.0))
}

/// Share of part `k` of a distribution.
fn share<T>(parts: &[T], upto: impl Fn(&T) -> f32, k: usize) -> f32 {
    upto(&parts[k]) - if k > 0 { upto(&parts[k - 1]) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::half_difference::spherical;
    use crate::math::hash::{pcg4d, unit};
    use glam::DVec3;

    /// Dark, with a gradient and one texel a hundred thousand times as bright, turned.
    fn panorama() -> Panorama {
        let texel = |k: usize| match k {
            200 => [1e5, 9e4, 8e4],
            _ => [0.1 + (k / 32) as f32, 0.5, (k % 32) as f32 / 32.0],
        };
        Panorama::new([32, 16], (0..32 * 16).map(texel).collect(), 0.5, 0.7).unwrap()
    }

    /// Points of a grid over the sphere, each with its solid angle 4 pi / n^2.
    fn sphere(n: usize) -> impl Iterator<Item = Vec3> {
        let middle = move |k: usize| (k as f64 + 0.5) / n as f64;
        (0..n * n)
            .map(move |k| spherical((1.0 - 2.0 * middle(k / n)).acos(), 2.0 * PI * middle(k % n)).as_vec3())
    }

    #[test]
    fn the_density_integrates_to_one() {
        let panorama = panorama();
        let n = 1000;
        let mean = sphere(n).map(|d| f64::from(panorama.density(d))).sum::<f64>() / (n * n) as f64;
        // The density is constant over texels, of whose area the rule of 1000^2 points misses up to 2 parts in 1000 / 16.
        assert!((mean * 4.0 * PI - 1.0).abs() < 0.03, "{mean}");
    }

    #[test]
    fn samples_have_the_density_stated() {
        let panorama = panorama();
        let n = 1024;
        let at = |k: usize| (k as f32 + 0.5) / n as f32;
        let mut light = DVec3::ZERO;
        for k in 0..n * n {
            let direction = panorama.sample([at(k % n), at(k / n)]);
            assert!((direction.length() - 1.0).abs() < 1e-6);
            let density = f64::from(panorama.density(direction));
            light += panorama.radiance(direction).as_dvec3() / density / (n * n) as f64;
        }
        let n = 2000;
        let exact =
            sphere(n).map(|d| panorama.radiance(d).as_dvec3()).sum::<DVec3>() * 4.0 * PI / (n * n) as f64;
        // Four million points see the bright texel's tent, a thousandth of the sphere, to a tenth of a percent; a million samples
        // that fall on it in proportion see it better.
        assert!((light / exact - 1.0).abs().max_element() < 3e-3, "{light} {exact}");
    }

    #[test]
    fn a_place_is_found_where_it_was_put() {
        // Ahead, to the right, behind, to the left, above, below; each a color of its own.
        let pixel = |k: usize| {
            let (x, y) = (k % 64, k / 64);
            match (x, y) {
                (_, 0..=2) => [9.0, 0.0, 0.0],
                (_, 29..) => [0.0, 9.0, 0.0],
                _ => [1.0 + ((x + 8) / 16 % 4) as f32; 3],
            }
        };
        let pixels: Vec<_> = (0..64 * 32).map(pixel).collect();
        let seen = |turn: f64, direction: Vec3| {
            Panorama::new([64, 32], pixels.clone(), 1.0, turn).unwrap().radiance(direction).x
        };
        assert_eq!([Vec3::NEG_Y, Vec3::NEG_X, Vec3::Y, Vec3::X].map(|d| seen(0.0, d)), [1.0, 2.0, 3.0, 4.0]);
        // Turned by a quarter, counterclockwise: what was ahead is to the left.
        assert_eq!([Vec3::NEG_X, Vec3::Y].map(|d| seen(PI / 2.0, d)), [3.0, 4.0]);
        assert_eq!([Vec3::Z, Vec3::NEG_Z].map(|d| seen(1.0, d)), [9.0, 0.0]);
    }

    #[test]
    fn large_pictures_are_halved_and_keep_their_light() {
        let size = [4096, 2048];
        let texel = |k: usize| [unit(pcg4d([k as u32, 1, 2, 3])[0]), 0.0, 1.0];
        let panorama = Panorama::new(size, (0..size[0] * size[1]).map(texel).collect(), 1.0, 0.0).unwrap();
        assert_eq!(panorama.size, [2048, 1024]);
        let mean = panorama.texels.iter().map(|t| f64::from(t.0[0])).sum::<f64>() / (2048.0 * 1024.0);
        // Eight million uniform numbers: one standard error is 1e-4.
        assert!((mean - 0.5).abs() < 4e-4, "{mean}");
    }

    #[test]
    fn hostile_pictures_are_refused_and_a_black_one_is_not() {
        let refused = |pixel: [f32; 3], scale: f32| {
            let pixels = vec![[0.0; 3], [0.0; 3], pixel, [0.0; 3]];
            Panorama::new([2, 2], pixels, scale, 0.0).unwrap_err().to_string()
        };
        assert!(refused([0.0, -1.0, 0.0], 1.0).contains("pixel (0, 1)"));
        assert!(refused([0.0, f32::NAN, 0.0], 1.0).contains("NaN"));
        assert!(refused([1e29, 0.0, 0.0], 100.0).contains("1e30"));
        let ringing = Panorama::new([2, 1], vec![[1.0; 3], [-0.04; 3]], 1.0, 0.0).unwrap();
        assert_eq!(ringing.texels[1].0, [0.0; 3]);
        let black = Panorama::new([2, 2], vec![[0.0; 3]; 4], 1.0, 0.0).unwrap();
        assert!(!black.is_bright() && black.radiance(Vec3::X) == Vec3::ZERO);
        // Rows and columns without light in a picture with some.
        let one = Panorama::new([4, 8], (0..32).map(|k| [f32::from(k == 17) * 1e20; 3]).collect(), 1.0, 0.0)
            .unwrap();
        for k in 0..1000u32 {
            let [a, b, ..] = pcg4d([k, 7, 8, 9]).map(unit);
            let direction = one.sample([a, b]);
            assert!(one.density(direction) > 0.0 && direction.is_finite());
        }
    }
}
