//! The mirrored flash in a picture, told from a bright flake (Rump et al. 2008, section 5.1.1).
//!
//! From the brightest pixel on, the pixels next to it that are at least a share as bright are filled. What fills a small area is a
//! sparkle: the next bright pixel is tried, until an area is as large as a mirrored flash must be.

use super::HighlightCheck;
use glam::DVec2;

/// A highlight ends where light has fallen to this share of its brightest pixel.
const TOLERANCE: f32 = 0.25;
/// Bright pixels that are tried.
const TRIES: usize = 200;

/// Share of the area of a mirrored flash that has to be found, and beyond how many times that it is a broad one.
const AREA: [f64; 2] = [0.2, 4.0];

/// What is found of a flash that should be seen mirrored.
#[derive(Debug, Clone, PartialEq)]
pub enum Mirrored {
    /// Nothing as large as it.
    Absent,
    /// Something broader than any mirrored flash: the gloss of a rough surface, or the paint's own glow. It has no place.
    Broad,
    /// A highlight.
    At(Highlight),
}

/// Seeks the highlight of a flash whose mirror image covers `area_px` in a row-major picture.
pub fn find_mirrored(pixels: &[[f32; 3]], size: [usize; 2], area_px: f64) -> Mirrored {
    let light: Vec<f32> = pixels.iter().map(|p| p.iter().sum()).collect();
    let least = (AREA[0] * area_px).ceil().max(4.0) as usize;
    match find_highlight(&light, size, least) {
        None => Mirrored::Absent,
        Some(found) if found.area_px as f64 > (AREA[1] * area_px).max(16.0) => Mirrored::Broad,
        Some(found) => Mirrored::At(found),
    }
}

/// Highlights that are farther from where the calibration puts them than they reach.
pub fn misplaced(checks: &[HighlightCheck]) -> Vec<&HighlightCheck> {
    let is_off = |check: &&HighlightCheck| check.distance_px.is_some_and(|d| d > check.radius_px);
    checks.iter().filter(is_off).collect()
}

/// A highlight found in a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Highlight {
    /// Its middle, pixels from the top left corner of the picture.
    pub center_px: DVec2,
    /// How many pixels it fills.
    pub area_px: usize,
    /// These pixels, row-major indices, ascending.
    pub pixels: Vec<u32>,
}

/// Finds the highlight of at least `least_px` pixels in a row-major picture of `size`; pixels that are not finite are no light.
/// Where there is none, that may be the paint's own glow, which fills much of the picture.
pub fn find_highlight(luminance: &[f32], size: [usize; 2], least_px: usize) -> Option<Highlight> {
    let light = |k: usize| luminance.get(k).copied().filter(|l| l.is_finite() && *l > 0.0);
    let mut bright: Vec<usize> = (0..size[0] * size[1]).filter(|k| light(*k).is_some()).collect();
    let brighter = |a: &usize, b: &usize| luminance[*b].total_cmp(&luminance[*a]).then(a.cmp(b));
    let mut seen = vec![false; size[0] * size[1]];
    for _ in 0..TRIES {
        let first = bright.iter().copied().min_by(brighter)?;
        let filled =
            fill(first, size, |k| light(k).is_some_and(|l| l >= TOLERANCE * luminance[first]), &mut seen);
        if filled.len() >= least_px {
            return Some(Highlight::of(filled, size));
        }
        bright.retain(|k| !seen[*k]);
    }
    None
}

/// Pixels joined to `first` by their sides, through pixels that are `inside` and not yet `seen`.
fn fill(first: usize, size: [usize; 2], inside: impl Fn(usize) -> bool, seen: &mut [bool]) -> Vec<u32> {
    let mut filled = Vec::new();
    let mut open = vec![first];
    seen[first] = true;
    while let Some(k) = open.pop() {
        filled.push(k as u32);
        let (x, y) = (k % size[0], k / size[0]);
        let neighbors = [
            (x > 0).then(|| k - 1),
            (x + 1 < size[0]).then(|| k + 1),
            (y > 0).then(|| k - size[0]),
            (y + 1 < size[1]).then(|| k + size[0]),
        ];
        for next in neighbors.into_iter().flatten() {
            if !seen[next] && inside(next) {
                seen[next] = true;
                open.push(next);
            }
        }
    }
    filled
}

impl Highlight {
    fn of(mut pixels: Vec<u32>, size: [usize; 2]) -> Self {
        pixels.sort_unstable();
        let place =
            |k: &u32| DVec2::new((*k as usize % size[0]) as f64 + 0.5, (*k as usize / size[0]) as f64 + 0.5);
        let center_px = pixels.iter().map(place).sum::<DVec2>() / pixels.len() as f64;
        Self { center_px, area_px: pixels.len(), pixels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dark picture with rectangles of light: columns, rows, light.
    fn picture(rectangles: &[([usize; 2], [usize; 2], f32)]) -> Vec<f32> {
        let mut light = vec![0.1; 40 * 30];
        for (columns, rows, value) in rectangles {
            for y in rows[0]..rows[1] {
                for x in columns[0]..columns[1] {
                    light[y * 40 + x] = *value;
                }
            }
        }
        light
    }

    #[test]
    fn a_sparkle_is_no_highlight() {
        let highlight = ([10, 18], [5, 11], 5.0);
        let sparkles = [([30, 32], [20, 22], 50.0), ([3, 4], [3, 4], 9.0), ([35, 37], [2, 3], 30.0)];
        let all = [highlight, sparkles[0], sparkles[1], sparkles[2]];
        let found = find_highlight(&picture(&all), [40, 30], 12).unwrap();
        assert_eq!((found.center_px, found.area_px), (DVec2::new(14.0, 8.0), 48));
        let glow = find_highlight(&picture(&sparkles), [40, 30], 12).unwrap();
        assert_eq!(glow.area_px, 1200 - 4 - 1 - 2, "what is left is the whole picture");
        assert_eq!(find_highlight(&picture(&all), [40, 30], 1200), None);
    }

    #[test]
    fn what_is_no_number_is_no_light() {
        let mut light = picture(&[([10, 18], [5, 11], 5.0)]);
        light[0] = f32::NAN;
        light[1] = f32::INFINITY;
        assert_eq!(find_highlight(&light, [40, 30], 12).unwrap().area_px, 48);
        assert_eq!(find_highlight(&[f32::NAN; 1200], [40, 30], 1), None);
        assert_eq!(find_highlight(&[], [0, 0], 1), None);
    }
}
