//! How far the tones of a print are from those that were wished.

use super::halftone::Halftone;
use super::separation::Separation;
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;

/// Wished and reached tones: shares of the paper that the three primaries cover.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToneErrors {
    /// Mean wished tone of each primary.
    pub wished: [f64; 3],
    /// Mean reached tone of each primary.
    pub reached: [f64; 3],
    /// Side of the blocks, pixels of the image; those at the right and lower edge may be smaller.
    pub block: usize,
    /// Largest difference of reached and wished tone over all blocks, of each primary.
    pub largest_of_blocks: [f64; 3],
}

impl ToneErrors {
    /// Compares a print with the separation it was made from, over the whole and over blocks of `block` x `block` pixels.
    ///
    /// # Errors
    /// A print whose size is no multiple of the image's, the same in both directions; a block of no pixels.
    pub fn of(separation: &Separation, halftone: &Halftone, block: usize) -> Result<Self> {
        let (pixels, dots) = (separation.size(), halftone.size());
        let cell = dots[0] / pixels[0];
        if dots != pixels.map(|n| n * cell) {
            let legal = format!("a multiple of {} x {}", pixels[0], pixels[1]);
            return Err(Error::invalid("print", "size", format!("{} x {}", dots[0], dots[1]), legal));
        }
        if block == 0 {
            return Err(Error::invalid("tone errors", "block", 0, "1 or more"));
        }
        let blocks = pixels.map(|n| n.div_ceil(block));
        let differences: Vec<[f64; 3]> = (0..blocks[0] * blocks[1])
            .into_par_iter()
            .map(|k| {
                let from = [k % blocks[0] * block, k / blocks[0] * block];
                let to = [0, 1].map(|k| (from[k] + block).min(pixels[k]));
                let reached =
                    halftone.mean_tone_in(from[0] * cell..to[0] * cell, from[1] * cell..to[1] * cell);
                let wished = mean_tone(separation, from, to);
                [0, 1, 2].map(|c| (reached[c] - wished[c]).abs())
            })
            .collect();
        Ok(Self {
            wished: mean_tone(separation, [0, 0], pixels),
            reached: halftone.mean_tone(),
            block,
            largest_of_blocks: [0, 1, 2].map(|c| differences.iter().map(|d| d[c]).fold(0.0, f64::max)),
        })
    }
}

/// Mean of the pixels from one corner up to another.
fn mean_tone(separation: &Separation, from: [usize; 2], to: [usize; 2]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for row in from[1]..to[1] {
        for column in from[0]..to[0] {
            let tone = separation.tone(column, row);
            sum = [0, 1, 2].map(|c| sum[c] + tone[c]);
        }
    }
    sum.map(|s| s / ((to[0] - from[0]) * (to[1] - from[1])) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proof::InkLimit;

    #[test]
    fn differences_are_those_of_whole_and_blocks() {
        let separation = Separation::new([3, 1], &[[0.5, 0.0, 0.25]; 3], InkLimit::Scale).unwrap();
        // Cells of 2 x 2: red in half of the first pixel, green all over the last one.
        let print = Halftone::new([6, 2], vec![1, 0, 0, 0, 2, 2, 0, 1, 0, 0, 2, 2]).unwrap();
        let errors = ToneErrors::of(&separation, &print, 2).unwrap();
        let sixth = 1.0 / 6.0;
        let expected = ToneErrors {
            wished: [0.5, 0.0, 0.25],
            reached: [sixth, 2.0 * sixth, 0.0],
            block: 2,
            largest_of_blocks: [0.5, 1.0, 0.25],
        };
        assert_eq!(errors, expected);
        assert!(ToneErrors::of(&separation, &print, 0).is_err());
        let other = Halftone::new([6, 1], vec![0; 6]).unwrap();
        assert!(
            ToneErrors::of(&separation, &other, 1).unwrap_err().to_string().contains("multiple of 3 x 1")
        );
    }
}
