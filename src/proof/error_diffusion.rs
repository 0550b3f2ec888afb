//! Dots by error diffusion: what one dot cannot show, its neighbors make up for.
//!
//! Floyd & Steinberg 1976 for vectors: the tone (blank and three primaries, adding up to 1) plus the error handed on takes the
//! nearest of the four pure dots, which for such vectors is the largest component, and the rest goes to the dots still to
//! come, 7/16 ahead, 3/16, 5/16 and 1/16 in the next row. Rows alternate in direction; at either side the neighbors that are
//! there take the whole error.
//!
//! Two departures from the plain method, which prints lines and arcs of dots where tones are light, and nothing at all in the
//! first rows:
//! * Noise on the decision alone (Ulichney 1987) breaks lines and, as the error carries on, costs no tone. It is narrow
//!   enough that an ink with neither a tone nor an error to make up for never wins: it would have to beat a share of 1/3.
//! * Rows above the print, of its first row's tones, are done first and left out: the first row to be printed finds the errors
//!   that any other finds. What the last row hands on is lost. Both are below some 1.2 dots a column, and cancel on average.

use super::halftone::{Halftone, dots_of};
use super::separation::Separation;
use crate::error::Result;
use crate::math::hash::{pcg4d, unit};

/// Half width of the noise on the decision.
const NOISE: f64 = 0.125;
/// Rows above the print; a tone of 1/1000 takes so many to print its first dots.
const ROWS_ABOVE: usize = 32;
/// Neighbors that take the error: columns ahead, rows down, share.
const NEIGHBORS: [(isize, usize, f64); 4] = [(1, 0, 7.0), (-1, 1, 3.0), (0, 1, 5.0), (1, 1, 1.0)];

/// Shares of blank and three primaries.
type Shares = [f64; 4];

/// The dots of a separation, every pixel `cell` x `cell` of them. A dot depends on all above and before it.
///
/// A pixel is not rounded on its own: what its dots cannot show goes to the next ones, what others could not show comes in. A
/// level of 0.3 in cells of 3 x 3 (the paper's example) is three dots of nine, sometimes two or four, and 2.7 on average.
///
/// # Errors
/// A cell outside 1 to 32, more than [`MAX_DOTS`](super::MAX_DOTS) dots.
pub fn error_diffusion(separation: &Separation, cell: usize, seed: u32) -> Result<Halftone> {
    let size = dots_of(separation.size(), cell)?;
    let mut dots = vec![0u8; size[0] * size[1]];
    let mut errors = [vec![[0.0; 4]; size[0]], vec![[0.0; 4]; size[0]]];
    for y in 0..ROWS_ABOVE + size[1] {
        let printed = y.saturating_sub(ROWS_ABOVE);
        let row = &mut dots[printed * size[0]..][..size[0]];
        let ahead = if y % 2 == 0 { 1 } else { -1 };
        for step in 0..size[0] {
            let x = if ahead == 1 { step } else { size[0] - 1 - step };
            let [r, g, b] = separation.tone(x / cell, printed / cell);
            let tone = [(1.0 - r - g - b).max(0.0), r, g, b];
            let mut rest = add(tone, 1.0, errors[0][x]);
            let dot = decide(rest, [x, y], seed);
            // Rows above the print are overwritten by its first one.
            row[x] = dot as u8;
            rest[dot] -= 1.0;
            hand_on(&mut errors, rest, x, ahead);
        }
        errors.swap(0, 1);
        errors[1].fill([0.0; 4]);
    }
    Halftone::new(size, dots)
}

/// The largest share, noise included; the first where some are equal.
fn decide(shares: Shares, at: [usize; 2], seed: u32) -> usize {
    let noise =
        pcg4d([at[0] as u32, at[1] as u32, seed, 0]).map(|bits| NOISE * (2.0 * f64::from(unit(bits)) - 1.0));
    let noisy = add(shares, 1.0, noise);
    (1..4).fold(0, |best, k| if noisy[k] > noisy[best] { k } else { best })
}

/// Spreads the error of dot `x` over those neighbors that are there.
fn hand_on(errors: &mut [Vec<Shares>; 2], rest: Shares, x: usize, ahead: isize) {
    let columns = errors[0].len();
    let there = NEIGHBORS.map(|(dx, row, share)| {
        let column = x.checked_add_signed(dx * ahead).filter(|c| *c < columns);
        column.map(|c| (c, row, share))
    });
    let all: f64 = there.iter().flatten().map(|(_, _, share)| share).sum();
    for (column, row, share) in there.into_iter().flatten() {
        errors[row][column] = add(errors[row][column], share / all, rest);
    }
}

fn add(a: Shares, factor: f64, b: Shares) -> Shares {
    [0, 1, 2, 3].map(|k| a[k] + factor * b[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proof::InkLimit;

    fn flat(size: [usize; 2], tone: [f32; 3]) -> Separation {
        Separation::new(size, &vec![tone; size[0] * size[1]], InkLimit::Scale).unwrap()
    }

    #[test]
    fn errors_stay_bounded_and_absent_inks_absent() {
        let third = 1.0 / 3.0;
        for tone in [[0.3; 3], [third; 3], [0.01, 0.02, 0.005], [0.5, 0.48, 0.0], [0.0, 1.0, 0.0], [0.0; 3]] {
            let print = error_diffusion(&flat([96, 96], tone), 1, 1).unwrap();
            for rows in [12, 48, 96] {
                let reached = print.mean_tone_in(0..96, 0..rows);
                for c in 0..3 {
                    // Half a dot a column; errors in and out, below 1.2 a column, are of either sign.
                    let missing = (reached[c] - f64::from(tone[c])).abs() * rows as f64;
                    assert!(missing < 0.5, "{tone:?}: {missing} dots a column after {rows} rows");
                    assert!(tone[c] > 0.0 || reached[c] == 0.0, "{tone:?}");
                }
            }
        }
    }

    #[test]
    fn light_tones_begin_and_end_as_they_go_on() {
        let (tone, seeds) = ([0.01, 0.02, 0.005], 20);
        let ink = |rows: std::ops::Range<usize>| -> f64 {
            let one = |seed| {
                error_diffusion(&flat([96, 96], tone), 1, seed).unwrap().mean_tone_in(0..96, rows.clone())
            };
            (0..seeds).map(|seed| one(seed).iter().sum::<f64>()).sum::<f64>() / f64::from(seeds)
        };
        // The last row has 67 dots in 20 prints: less than three times the square root of that.
        for rows in [0..5, 91..96, 95..96] {
            let share = ink(rows.clone()) / 0.035;
            assert!((share - 1.0).abs() < 0.35, "rows {rows:?}: {share}");
        }
    }
}
