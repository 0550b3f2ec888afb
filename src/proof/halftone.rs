//! A print as dots, each blank or in one primary.
//!
//! The paper keeps it as an RGB texture of 0 and 1 without overlaps (Pranovich et al. 2024, Fig. 6). We keep the number of
//! the primary, so that two inks in one place cannot be said at all, and write and read that texture.

use crate::check::range;
use crate::error::{Error, Result};
use std::ops::Range;

/// Largest cell: dots along a side of a pixel.
pub const MAX_CELL: usize = 32;
/// Most dots of a print.
pub const MAX_DOTS: usize = 1 << 27;
/// Names of the channels of the texture, in the order of the primaries.
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// Dots of a print, row-major, top row first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Halftone {
    size: [usize; 2],
    dots: Vec<u8>,
}

impl Halftone {
    /// A print of `size` (columns, rows) dots: 0 blank, 1 to 3 the primary.
    ///
    /// # Errors
    /// No dots or more than [`MAX_DOTS`], a number of dots that does not fit, a dot above 3 (its place named).
    pub fn new(size: [usize; 2], dots: Vec<u8>) -> Result<Self> {
        check_dots(size, dots.len())?;
        if let Some(k) = dots.iter().position(|d| *d > 3) {
            let place = format!("dot ({}, {})", k % size[0], k / size[0]);
            return Err(Error::invalid(place, "primary", dots[k], "0 (blank) to 3"));
        }
        Ok(Self { size, dots })
    }

    /// A print from its texture, as [`Halftone::rgb`] makes it.
    ///
    /// # Errors
    /// No pixels or more than [`MAX_DOTS`], a number of pixels that does not fit, a value other than 0 and 255, overlapping
    /// inks (the pixel named).
    pub fn from_rgb(size: [usize; 2], pixels: &[[u8; 3]]) -> Result<Self> {
        check_dots(size, pixels.len())?;
        let dot = |(k, pixel)| {
            dot_of(pixel).map_err(|e| e.within(format!("pixel ({}, {})", k % size[0], k / size[0])))
        };
        Ok(Self { size, dots: pixels.iter().enumerate().map(dot).collect::<Result<_>>()? })
    }

    /// The texture of the paper: 255 in the channel of the primary of each dot, 0 elsewhere.
    pub fn rgb(&self) -> Vec<[u8; 3]> {
        let pixel = |dot: &u8| [1, 2, 3].map(|primary| if *dot == primary { 255 } else { 0 });
        self.dots.iter().map(pixel).collect()
    }

    /// Columns and rows of dots.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// All dots, row-major, top row first: 0 blank, 1 to 3 the primary.
    pub fn dots(&self) -> &[u8] {
        &self.dots
    }

    /// Share of all dots that each primary has.
    pub fn mean_tone(&self) -> [f64; 3] {
        self.mean_tone_in(0..self.size[0], 0..self.size[1])
    }

    /// Share of the dots of a rectangle that each primary has; what lies outside of the print does not count. 0 where no dots
    /// are left.
    pub fn mean_tone_in(&self, columns: Range<usize>, rows: Range<usize>) -> [f64; 3] {
        let within = |r: Range<usize>, n: usize| r.start.min(r.end).min(n)..r.end.min(n);
        let (columns, rows) = (within(columns, self.size[0]), within(rows, self.size[1]));
        let mut counts = [0u64; 4];
        for row in rows.clone() {
            for dot in &self.dots[row * self.size[0]..][columns.clone()] {
                counts[usize::from(*dot)] += 1;
            }
        }
        let all = (columns.len() * rows.len()).max(1) as f64;
        [1, 2, 3].map(|primary| counts[primary] as f64 / all)
    }
}

/// Columns and rows of dots of an image whose pixels become `cell` x `cell` dots.
pub(super) fn dots_of(size: [usize; 2], cell: usize) -> Result<[usize; 2]> {
    range("halftone", "cell", cell, 1..=MAX_CELL)?;
    let dots = size.map(|n| n.saturating_mul(cell));
    check_dots(dots, dots[0].saturating_mul(dots[1]))?;
    Ok(dots)
}

fn check_dots(size: [usize; 2], found: usize) -> Result<()> {
    let expected = size[0].saturating_mul(size[1]);
    if !(1..=MAX_DOTS).contains(&expected) {
        let found = format!("{} x {}", size[0], size[1]);
        return Err(Error::invalid("halftone", "dots", found, format!("1 to {MAX_DOTS} in all")));
    }
    if found != expected {
        return Err(Error::invalid(
            "halftone",
            "dots",
            found,
            format!("{expected} ({} x {})", size[0], size[1]),
        ));
    }
    Ok(())
}

fn dot_of(pixel: &[u8; 3]) -> Result<u8> {
    let mut dot = 0;
    for (k, value) in pixel.iter().enumerate() {
        match value {
            0 => {}
            255 if dot == 0 => dot = k as u8 + 1,
            255 => {
                let found = format!("{} and {}", CHANNELS[usize::from(dot) - 1], CHANNELS[k]);
                return Err(Error::invalid("", "overlapping inks", found, "at most one ink in one place"));
            }
            other => return Err(Error::invalid(CHANNELS[k], "value", other, "0 or 255")),
        }
    }
    Ok(dot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_print_survives_the_way_through_its_texture() {
        let print = Halftone::new([3, 2], vec![0, 1, 2, 3, 3, 0]).unwrap();
        let texture = print.rgb();
        assert_eq!(texture[..4], [[0; 3], [255, 0, 0], [0, 255, 0], [0, 0, 255]]);
        assert_eq!(Halftone::from_rgb([3, 2], &texture).unwrap(), print);
    }

    #[test]
    fn tones_are_counted_in_all_and_in_rectangles() {
        let print = Halftone::new([3, 2], vec![0, 1, 2, 3, 3, 0]).unwrap();
        assert_eq!(print.mean_tone(), [1.0 / 6.0, 1.0 / 6.0, 2.0 / 6.0]);
        assert_eq!(print.mean_tone_in(1..3, 0..1), [0.5, 0.5, 0.0]);
        // Beyond the edge, turned around, empty.
        assert_eq!(print.mean_tone_in(2..9, 0..9), [0.0, 0.5, 0.0]);
        #[allow(clippy::reversed_empty_ranges)]
        let turned = 2..1;
        assert_eq!(print.mean_tone_in(turned, 0..2), [0.0; 3]);
        assert_eq!(print.mean_tone_in(7..9, 7..9), [0.0; 3]);
    }

    #[test]
    fn what_is_no_print_is_refused() {
        let refusal = |pixels: &[[u8; 3]]| Halftone::from_rgb([2, 1], pixels).unwrap_err().to_string();
        let overlap = refusal(&[[0; 3], [0, 255, 255]]);
        assert_eq!(
            overlap,
            "pixel (1, 0): overlapping inks: found green and blue, expected at most one ink in one place"
        );
        let level = refusal(&[[0, 0, 77], [0; 3]]);
        assert_eq!(level, "pixel (0, 0): blue: value: found 77, expected 0 or 255");
        assert!(refusal(&[[0; 3]]).contains("found 1, expected 2 (2 x 1)"));
        assert!(Halftone::new([1, 1], vec![4]).unwrap_err().to_string().contains("dot (0, 0)"));
        assert!(Halftone::new([0, 5], vec![]).is_err());
        assert!(Halftone::new([usize::MAX, 2], vec![]).is_err());
    }

    #[test]
    fn sizes_are_refused_before_they_cost_memory() {
        assert_eq!(dots_of([5, 7], 3).unwrap(), [15, 21]);
        assert!(dots_of([1 << 16, 1 << 11], 1).is_ok());
        for (size, cell) in [([1 << 16, 1 << 11], 2), ([usize::MAX, 1], 32), ([1, 1], 0), ([1, 1], 33)] {
            assert!(dots_of(size, cell).is_err(), "{size:?} {cell}");
        }
    }
}
