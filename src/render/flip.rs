//! How different two pictures look when one flips between them.
//!
//! LDR-FLIP of Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images" (PACM CGIT 3(2)): colors as the eye
//! resolves them at a distance, their difference, and that of edges and points.

use super::picture::Picture;
use crate::color::xyz_from_rgb;
use crate::color::{WHITE_XYZ, lab_from_rgb, rgb_from_xyz};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Pixels a degree of the visual field: a screen of 3840 pixels on 0.7 m, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;

/// Contrast sensitivity of luminance, red-green and blue-yellow as sums of Gaussians: weights and widths (their Table 1).
const SENSITIVITY: [[[f64; 2]; 2]; 3] =
    [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
/// Exponents of color and feature differences, and where the color error is bent: their q_c, q_f, p_c, p_t.
const EXPONENTS: [f64; 2] = [0.7, 0.5];
const BEND: [f64; 2] = [0.4, 0.95];
/// Width of a feature, degrees.
const FEATURE: f64 = 0.082;

/// The mean of the error map, 0 to 1, of two pictures of one size whose light is clipped to [0, 1].
pub(super) fn flip(a: &Picture, b: &Picture) -> f64 {
    let [a, b] = [a, b].map(Opponent::of);
    let [seen_a, seen_b] = [&a, &b].map(Opponent::seen);
    let [features_a, features_b] = [&a, &b].map(Opponent::features);
    let most = hyab(hunt(DVec3::Y), hunt(DVec3::Z)).powf(EXPONENTS[0]);
    let error = |k: usize| {
        let color = bent(hyab(seen_a[k], seen_b[k]).powf(EXPONENTS[0]), most);
        let [edge, point] = [0, 1].map(|f| (features_a[k][f] - features_b[k][f]).abs());
        let feature = (edge.max(point) / 2f64.sqrt()).powf(EXPONENTS[1]);
        color.powf(1.0 - feature)
    };
    seen_a.iter().enumerate().map(|(k, _)| error(k)).sum::<f64>() / seen_a.len().max(1) as f64
}

/// Small differences fill most of the range.
fn bent(difference: f64, most: f64) -> f64 {
    let [knee, share] = BEND;
    if difference < knee * most {
        return difference * share / (knee * most);
    }
    share + (difference - knee * most) / (most - knee * most) * (1.0 - share)
}

/// Planes of luminance, red-green and blue-yellow of a picture: linear in light.
struct Opponent {
    size: [usize; 2],
    planes: [Vec<f64>; 3],
}

impl Opponent {
    fn of(picture: &Picture) -> Self {
        let pixel = |p: &[f32; 3]| {
            let rgb = DVec3::from(p.map(f64::from)).clamp(DVec3::ZERO, DVec3::ONE);
            let [x, y, z] = (xyz_from_rgb(rgb) / WHITE_XYZ).to_array();
            [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
        };
        let pixels: Vec<[f64; 3]> = picture.pixels.par_iter().map(pixel).collect();
        let planes = [0, 1, 2].map(|c| pixels.iter().map(|p| p[c]).collect());
        Self { size: picture.size, planes }
    }

    /// Colors as the eye resolves them: Lab, saturation fading with lightness (Hunt's effect).
    fn seen(&self) -> Vec<DVec3> {
        let widest = SENSITIVITY.iter().flatten().map(|[_, width]| *width).fold(0.0, f64::max);
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
        let filtered = [0, 1, 2].map(|c| {
            let parts = SENSITIVITY[c].map(|[weight, width]| {
                let fall = |k: i32| (-(PI * f64::from(k) / PIXELS_PER_DEGREE).powi(2) / width).exp();
                let taps: Vec<f64> = (-radius..=radius).map(fall).collect();
                let scale = weight * (PI / width).sqrt();
                let total = scale * taps.iter().sum::<f64>().powi(2);
                (taps, scale, total)
            });
            let whole: f64 = parts.iter().map(|part| part.2).sum();
            let mut sum = vec![0.0; self.planes[c].len()];
            for (taps, scale, _) in parts.iter().filter(|part| part.1 > 0.0) {
                let part = self.convolved(&self.planes[c], taps, taps);
                sum.iter_mut().zip(part).for_each(|(sum, value)| *sum += scale / whole * value);
            }
            sum
        });
        let color = |k: usize| {
            let y = (filtered[0][k] + 16.0) / 116.0;
            let xyz = DVec3::new(y + filtered[1][k] / 500.0, y, y - filtered[2][k] / 200.0) * WHITE_XYZ;
            hunt(rgb_from_xyz(xyz).clamp(DVec3::ZERO, DVec3::ONE))
        };
        (0..self.planes[0].len()).into_par_iter().map(color).collect()
    }

    /// Strengths of edges and of points about every pixel, in luminance of 0 to 1.
    fn features(&self) -> Vec<[f64; 2]> {
        let luminance: Vec<f64> = self.planes[0].iter().map(|y| (y + 16.0) / 116.0).collect();
        let deviation = 0.5 * FEATURE * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as i32;
        let taps = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (-radius..=radius)
                .map(|k| of(f64::from(k)) * (-0.5 * (f64::from(k) / deviation).powi(2)).exp())
                .collect()
        };
        let smooth = balanced(taps(&|_| 1.0));
        let strengths =
            [balanced(taps(&|x| -x)), balanced(taps(&|x| (x / deviation).powi(2) - 1.0))].map(|across| {
                let x = self.convolved(&luminance, &across, &smooth);
                let y = self.convolved(&luminance, &smooth, &across);
                x.iter().zip(y).map(|(x, y)| x.hypot(y)).collect::<Vec<_>>()
            });
        strengths[0].iter().zip(&strengths[1]).map(|(edge, point)| [*edge, *point]).collect()
    }

    /// A plane convolved with taps along x, then along y; beyond the rim the rim goes on.
    fn convolved(&self, plane: &[f64], along_x: &[f64], along_y: &[f64]) -> Vec<f64> {
        let [width, height] = self.size;
        let inside = |k: usize, tap: usize, taps: &[f64], end: usize| {
            (k + tap).saturating_sub(taps.len() / 2).min(end - 1)
        };
        let rows: Vec<f64> = (0..plane.len())
            .into_par_iter()
            .map(|k| {
                let (x, row) = (k % width, k - k % width);
                let taps = along_x.iter().enumerate();
                taps.map(|(t, weight)| weight * plane[row + inside(x, t, along_x, width)]).sum()
            })
            .collect();
        (0..plane.len())
            .into_par_iter()
            .map(|k| {
                let (x, y) = (k % width, k / width);
                let taps = along_y.iter().enumerate();
                taps.map(|(t, weight)| weight * rows[inside(y, t, along_y, height) * width + x]).sum()
            })
            .collect()
    }
}

/// Taps whose positive ones sum to 1 and whose negative ones to -1.
fn balanced(taps: Vec<f64>) -> Vec<f64> {
    let sum = |sign: f64| taps.iter().map(|t| (sign * t).max(0.0)).sum::<f64>().max(f64::MIN_POSITIVE);
    let (above, below) = (sum(1.0), sum(-1.0));
    taps.into_iter().map(|t| if t > 0.0 { t / above } else { t / below }).collect()
}

fn hunt(rgb: DVec3) -> DVec3 {
    let lab = lab_from_rgb(rgb);
    DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// City-block in lightness, Euclidean in color.
fn hyab(a: DVec3, b: DVec3) -> f64 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [56, 40];

    fn picture(light: impl Fn(usize, usize, usize) -> f64) -> Picture {
        let pixel = |k: usize| [0, 1, 2].map(|c| light(k % SIZE[0], k / SIZE[0], c) as f32);
        Picture { size: SIZE, pixels: (0..SIZE[0] * SIZE[1]).map(pixel).collect() }
    }

    #[test]
    fn means_are_those_of_the_authors_program() {
        // flip-evaluator 1.7, LDR, 67.02 pixels a degree, in f32.
        let code = |x: usize, y: usize, c: usize, shift: usize| {
            let encoded = ((x * 37 + y * 59 + c * 83 + shift * (x * y % 7) * 5) % 256) as f64 / 255.0;
            if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
        };
        let noise = [0, 1].map(|shift| picture(|x, y, c| code(x, y, c, shift)));
        // Their white point is ours to some 1e-4, and sums are f32.
        let found = flip(&noise[0], &noise[1]);
        assert!((found - 0.247_691).abs() < 1e-4, "{found}");
        let smooth = |x: usize, y: usize, c: usize| {
            let (x, y) = (x as f64, y as f64);
            [0.5 + 0.4 * (0.2 * x + 0.1 * y).sin(), 0.5 + 0.3 * (0.15 * y).cos(), 0.3 + 0.005 * x][c]
        };
        let patched = |x: usize, y: usize, c: usize| {
            let is_patch = (20..35).contains(&x) && (10..20).contains(&y);
            if is_patch { smooth(x, y, c) * 0.8 + 0.1 } else { smooth(x, y, c) }
        };
        let found = flip(&picture(smooth), &picture(patched));
        assert!((found - 0.017_469_8).abs() < 2e-5, "{found}");
    }

    #[test]
    fn ends_are_none_and_all() {
        let black = picture(|_, _, _| 0.0);
        assert_eq!(flip(&black, &black), 0.0);
        let [green, blue] = [1, 2].map(|own| picture(|_, _, c| f64::from(u8::from(c == own))));
        // The farthest pair of colors by definition; clamped filters of a flat picture round.
        assert!((flip(&green, &blue) - 1.0).abs() < 1e-9);
    }
}
