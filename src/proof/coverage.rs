//! How much of a footprint each primary covers, where dots are smaller than pixels.
//!
//! Levels of means, each half as fine, by area ([`half_of`]), so that every level has the mean of the dots. A footprint is an
//! upright rectangle; its tone is the mean over it of a level whose texels are half its shorter side to that side, blended with the
//! same mean of the next level. Texels count as squares of one color, as dots are: level 0 is then the exact mean over the dots at
//! any magnification, and footprints that tile the print have its mean tone at every level, whatever the dots. Trilinear
//! interpolation between centers of texels has not: footprints of 1.5 dots would see some columns of dots more than others,
//! and a period of three dots with a wrong tone. Very long footprints take coarser levels than that: the cost of a mean is bounded.
//! Footprints that reach beyond an edge find its outermost texels again. They reach one texel far at most, up to rounding of
//! odd sides, so that this is the print mirrored, and edges count as often as the middle.

use super::halftone::Halftone;
use crate::btf::half_of;
use glam::DVec2;

/// Most texels along the longer side of a footprint, about: more cost more than their detail is worth.
const MAX_RATIO: f64 = 8.0;

/// Mean coverage of the primaries at all levels of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Level 0.
    dots: Halftone,
    /// From level 1 on, down to a single texel.
    means: Vec<Level>,
}

/// Means of a level, row-major.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    size: [usize; 2],
    texels: Vec<[f32; 3]>,
}

impl Coverage {
    /// All levels of a print; a byte a dot, and four for the means.
    pub fn new(dots: Halftone) -> Self {
        let mut coverage = Self { dots, means: Vec::new() };
        while coverage.size(coverage.levels() - 1) != [1, 1] {
            let last = coverage.levels() - 1;
            let (texels, size) = half_of(|k| coverage.texel(last, k), coverage.size(last));
            coverage.means.push(Level { size, texels });
        }
        coverage
    }

    /// Number of levels: 1 and the logarithm to base 2 of the longer side, rounded up.
    pub fn levels(&self) -> usize {
        1 + self.means.len()
    }

    /// The print, which is level 0.
    pub fn dots(&self) -> &Halftone {
        &self.dots
    }

    /// Columns and rows of a level, which must be there.
    pub fn size(&self, level: usize) -> [usize; 2] {
        if level == 0 { self.dots.size() } else { self.means[level - 1].size }
    }

    /// Coverage of each primary in a texel (its number, row-major) of a level; both must be there.
    pub fn texel(&self, level: usize, k: usize) -> [f32; 3] {
        match level {
            0 => {
                let dot = self.dots.dots()[k];
                [1, 2, 3].map(|primary| f32::from(u8::from(dot == primary)))
            }
            _ => self.means[level - 1].texels[k],
        }
    }

    /// Coverage of each primary over a rectangle about a place of the print, (0, 0) its upper left corner and (1, 1) its lower right
    /// one; places outside count as the nearest inside. `sides`: width and height, relative to the print's; a dot or less is within
    /// level 0.
    pub fn sample(&self, uv: DVec2, sides: DVec2) -> [f64; 3] {
        let [columns, rows] = self.size(0).map(|n| n as f64);
        let [width, height] = [sides.x * columns, sides.y * rows];
        let texel = width.min(height).max(width.max(height) / MAX_RATIO).max(1.0);
        let level = texel.log2().min((self.levels() - 1) as f64);
        let (fine, share) = (level as usize, level.fract());
        let near = self.mean(fine, uv, sides);
        if share == 0.0 {
            return near;
        }
        let far = self.mean(fine + 1, uv, sides);
        [0, 1, 2].map(|c| near[c] + share * (far[c] - near[c]))
    }

    /// Mean over a footprint of one level.
    fn mean(&self, level: usize, uv: DVec2, sides: DVec2) -> [f64; 3] {
        let size = self.size(level);
        let [columns, rows] = [0, 1].map(|k| Span::new(uv[k], sides[k], size[k]));
        let mut sum = [0.0; 3];
        let mut all = 0.0;
        for (y, height) in rows.texels() {
            for (x, width) in columns.texels() {
                let (area, texel) = (width * height, self.texel(level, y * size[0] + x));
                all += area;
                sum = [0, 1, 2].map(|c| sum[c] + area * f64::from(texel[c]));
            }
        }
        sum.map(|s| s / all)
    }
}

/// Part of a row or column of `n` texels.
struct Span {
    from: f64,
    to: f64,
    n: usize,
}

impl Span {
    /// About `center` and of `width`, both relative to the whole. Never wider than that, and never so narrow that it has no area.
    fn new(center: f64, width: f64, n: usize) -> Self {
        let half = 0.5 * (width * n as f64).max(1e-3).min(n as f64);
        // What is no number counts as 0.
        let center = if center > 0.0 { center.min(1.0) * n as f64 } else { 0.0 };
        Self { from: center - half, to: center + half, n }
    }

    /// Texels and how much of each is covered; beyond an edge the print is mirrored.
    fn texels(&self) -> impl Iterator<Item = (usize, f64)> {
        let n = self.n as isize;
        (self.from.floor() as isize..self.to.ceil() as isize).map(move |k| {
            let covered = self.to.min((k + 1) as f64) - self.from.max(k as f64);
            let mirrored = if k < 0 { -1 - k } else { k.min(2 * n - 1 - k) };
            (mirrored.clamp(0, n - 1) as usize, covered)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proof::{InkLimit, Method, Separation};
    use glam::DVec3;

    /// A print with tones that vary, of sides that are odd on most levels.
    fn print(method: Method) -> Halftone {
        let tone = |k: usize| {
            let (x, y) = ((k % 300) as f32 / 300.0, (k / 300) as f32 / 217.0);
            [0.6 * x * x, 0.3 * y, 0.05 + 0.05 * (x - y).abs()]
        };
        let pixels: Vec<[f32; 3]> = (0..300 * 217).map(tone).collect();
        method.halftone(&Separation::new([300, 217], &pixels, InkLimit::Scale).unwrap(), 1, 1).unwrap()
    }

    /// Mean of footprints of `side` at the middles of `count` columns and rows.
    fn mean(coverage: &Coverage, count: [usize; 2], side: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (x, y) in (0..count[1]).flat_map(|y| (0..count[0]).map(move |x| (x, y))) {
            let uv = (DVec2::new(x as f64, y as f64) + 0.5) / DVec2::new(count[0] as f64, count[1] as f64);
            let tone = square(coverage, uv, side);
            sum = [0, 1, 2].map(|c| sum[c] + tone[c]);
        }
        sum.map(|s| s / (count[0] * count[1]) as f64)
    }

    /// A square footprint, its side in dots.
    fn square(coverage: &Coverage, uv: DVec2, side: f64) -> [f64; 3] {
        let [columns, rows] = coverage.size(0).map(|n| n as f64);
        coverage.sample(uv, DVec2::new(side / columns, side / rows))
    }

    fn largest_relative(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|c| (a[c] / b[c] - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn every_level_has_the_mean_of_the_dots() {
        let print = print(Method::ErrorDiffusion);
        let (tone, coverage) = (print.mean_tone(), Coverage::new(print));
        assert_eq!((coverage.levels(), coverage.size(9)), (10, [1, 1]));
        for level in 0..coverage.levels() {
            let [columns, rows] = coverage.size(level);
            let mut sum = [0.0; 3];
            for texel in (0..columns * rows).map(|k| coverage.texel(level, k)) {
                sum = [0, 1, 2].map(|c| sum[c] + f64::from(texel[c]));
            }
            // Up to nine roundings to f32.
            assert!(largest_relative(sum.map(|s| s / (columns * rows) as f64), tone) < 1e-6, "level {level}");
        }
    }

    #[test]
    fn one_ink_all_over_is_one_at_any_place_and_side() {
        let coverage = Coverage::new(Halftone::new([13, 7], vec![2; 91]).unwrap());
        for side in [0.0, 0.3, 1.0, 1.7, 4.0, 5.5, 100.0] {
            for uv in [DVec2::ZERO, DVec2::ONE, DVec2::splat(0.5), DVec2::new(0.31, 0.97)] {
                let tone = square(&coverage, uv, side);
                assert!(
                    (tone[1] - 1.0).abs() < 1e-6 && tone[0] == 0.0 && tone[2] == 0.0,
                    "{uv} {side}: {tone:?}"
                );
            }
        }
    }

    #[test]
    fn level_0_is_the_exact_mean_over_dots() {
        let coverage = Coverage::new(Halftone::new([3, 1], vec![1, 0, 2]).unwrap());
        let at = |x: f64, side| square(&coverage, DVec2::new(x / 3.0, 0.5), side);
        assert_eq!(at(0.5, 1.0), [1.0, 0.0, 0.0]);
        assert_eq!(at(0.5, 0.0), [1.0, 0.0, 0.0]);
        let near =
            |a: [f64; 3], b: [f64; 3]| assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-12), "{a:?} {b:?}");
        near(at(1.0, 0.5), [0.5, 0.0, 0.0]);
        near(at(2.25, 1.0), [0.0, 0.75, 0.0]);
        // Beyond the edge the last dot once more.
        near(at(3.0, 1.0), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn footprints_keep_the_mean_tone() {
        for method in [Method::ErrorDiffusion, Method::BlueNoise] {
            let print = print(method);
            let (tone, coverage) = (print.mean_tone(), Coverage::new(print));
            let (mut beside, mut dense, mut side) = (0.0f64, 0.0f64, 1.0);
            while side <= 64.0 {
                let counts = |per_side: f64| [300.0, 217.0].map(|n| (per_side * n / side).round() as usize);
                beside = beside.max(largest_relative(mean(&coverage, counts(1.0), side), tone));
                if side > 4.0 {
                    dense = dense.max(largest_relative(mean(&coverage, counts(4.0), side), tone));
                }
                side *= 1.09;
            }
            println!("{method:?}: side by side {beside:.2e}, four times as dense {dense:.2e}");
            // What is asked for. Side by side they overlap, or leave gaps, of up to half a side at 64 dots.
            assert!(beside < 0.005 && dense < 0.001, "{method:?}: {beside} {dense}");
        }
    }

    #[test]
    fn footprints_that_tile_a_print_have_its_mean_tone() {
        // Stripes of a period that trilinear interpolation takes for others.
        let stripes = Halftone::new([192, 192], (0..192 * 192).map(|k| [1, 0, 3][k % 3]).collect()).unwrap();
        let (tone, coverage) = (stripes.mean_tone(), Coverage::new(stripes));
        for count in [192, 128, 100, 77, 64, 50, 33, 20, 7, 3] {
            let reached = mean(&coverage, [count; 2], 192.0 / count as f64);
            // Roundings to f32.
            assert!((0..3).all(|c| (reached[c] - tone[c]).abs() < 1e-6), "{count}: {reached:?}");
        }
    }

    /// Also where they are long and thin, as on a sheet seen at a slant: the finer side is not blurred.
    #[test]
    fn long_footprints_tile_a_print_and_keep_what_runs_along_them() {
        let print = print(Method::BlueNoise);
        let (tone, coverage) = (print.mean_tone(), Coverage::new(print));
        for [columns, rows] in [[300, 31], [300, 20], [60, 217], [25, 217], [5, 217]] {
            let sides = DVec2::new(1.0 / columns as f64, 1.0 / rows as f64);
            let mut sum = DVec3::ZERO;
            for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
                sum +=
                    DVec3::from(coverage.sample(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * sides, sides));
            }
            // Odd sides: texels of coarser levels are not quite those of the dots.
            let reached = (sum / (columns * rows) as f64).to_array();
            assert!(largest_relative(reached, tone) < 0.005, "{columns} x {rows}: {reached:?} {tone:?}");
        }
        let stripes = Halftone::new([64, 64], (0..64 * 64).map(|k| (k % 2) as u8).collect()).unwrap();
        let coverage = Coverage::new(stripes);
        let along = coverage.sample(DVec2::new(33.5 / 64.0, 0.5), DVec2::new(1.0, 8.0) / 64.0);
        let across = coverage.sample(DVec2::new(0.5, 0.5), DVec2::new(8.0, 1.0) / 64.0);
        assert!((along[0] - 1.0).abs() < 1e-12 && (across[0] - 0.5).abs() < 1e-12, "{along:?} {across:?}");
    }

    #[test]
    fn edges_count_as_often_as_the_middle() {
        // Ink along the edges alone.
        let is_edge = |k: usize| [k % 64, k / 64].iter().any(|x| [0, 63].contains(x));
        let frame = Halftone::new([64, 64], (0..64 * 64).map(|k| u8::from(is_edge(k))).collect()).unwrap();
        let coverage = Coverage::new(frame);
        for side in [1.5, 3.0, 6.0, 12.0, 24.0, 48.0] {
            let tone = mean(&coverage, [256; 2], side);
            // Sums of f32 means of up to 4,096 dots, which are exact here.
            assert!((tone[0] - 252.0 / 4096.0).abs() < 1e-9, "{side}: {tone:?}");
        }
    }

    #[test]
    fn levels_go_over_into_each_other() {
        let coverage = Coverage::new(print(Method::BlueNoise));
        for side in [1.0, 2.0, 4.0, 8.0, 64.0, 256.0, 512.0f64] {
            let uv = DVec2::new(0.433, 0.71);
            let (below, above) =
                (square(&coverage, uv, side * (1.0 - 1e-9)), square(&coverage, uv, side * (1.0 + 1e-9)));
            assert!((0..3).all(|c| (below[c] - above[c]).abs() < 1e-6), "{side}: {below:?} {above:?}");
        }
    }

    #[test]
    fn no_footprint_is_out_of_range() {
        let coverage = Coverage::new(Halftone::new([5, 1], vec![1, 2, 3, 0, 1]).unwrap());
        for x in [f64::NAN, f64::INFINITY, -1e300, -1.0, 0.0, 1.0, 2.0] {
            for side in [f64::NAN, f64::INFINITY, -3.0, 0.0, 1e-300, 3.0, 1e300] {
                let tone = coverage.sample(DVec2::new(x, 0.5), DVec2::new(side, 0.3 * x));
                assert!(tone.iter().all(|c| (0.0..=1.0 + 1e-12).contains(c)), "{x} {side}: {tone:?}");
            }
        }
    }
}
