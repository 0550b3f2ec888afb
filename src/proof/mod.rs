//! Soft proof of a print in three inks: what is printed where, and which tones that leaves.
//!
//! Pranovich et al. 2024, "Printing application": the levels of an image are replaced by dots of three primaries that never lie
//! on each other (dot off dot, their reference 2), and what is not printed stays paper. An image goes through [`Separation`]
//! (how much of each primary), [`Method`] (which dot has which, a [`Halftone`]) and, where dots are smaller than pixels,
//! [`Coverage`] (how much of a footprint each primary covers). The paper leaves the halftoning to the application; ours are
//! error diffusion and a blue-noise threshold. [`ToneErrors`] says how far the print is from what was wished.

mod blue_noise;
mod coverage;
mod error_diffusion;
mod halftone;
mod separation;
mod tone_errors;

pub use blue_noise::{ThresholdMask, blue_noise};
pub use coverage::Coverage;
pub use error_diffusion::error_diffusion;
pub use halftone::{Halftone, MAX_CELL, MAX_DOTS};
pub use separation::{InkLimit, Separation};
pub use tone_errors::ToneErrors;

use crate::error::Result;

/// How dots are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// [`error_diffusion`].
    #[default]
    ErrorDiffusion,
    /// [`blue_noise`].
    BlueNoise,
}

impl Method {
    /// The dots of a separation: every pixel becomes `cell` x `cell` of them, 1 to [`MAX_CELL`]. The same seed gives the same
    /// dots.
    ///
    /// # Errors
    /// A cell outside its range, more than [`MAX_DOTS`] dots.
    pub fn halftone(self, separation: &Separation, cell: usize, seed: u32) -> Result<Halftone> {
        match self {
            Self::ErrorDiffusion => error_diffusion(separation, cell, seed),
            Self::BlueNoise => blue_noise(separation, cell, seed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const METHODS: [Method; 2] = [Method::ErrorDiffusion, Method::BlueNoise];

    /// Power of a primary at up to 6 waves along 128 dots, relative to that of dots placed at random.
    fn low_power(print: &Halftone, primary: u8) -> f64 {
        let mean = print.mean_tone()[usize::from(primary) - 1];
        let dots: Vec<usize> = (0..128 * 128).filter(|k| print.dots()[*k] == primary).collect();
        let (mut sum, mut count) = (0.0, 0);
        for (u, v) in (0..=6).flat_map(|u| (-6..=6).map(move |v| (u, v))) {
            let is_half = u > 0 || v > 0;
            if is_half && u * u + v * v <= 36 {
                let angle = |k: &usize| {
                    TAU * (f64::from(u) * (k % 128) as f64 + f64::from(v) * (k / 128) as f64) / 128.0
                };
                let (re, im) =
                    dots.iter().map(angle).fold((0.0, 0.0), |(c, s), a| (c + a.cos(), s + a.sin()));
                sum += re * re + im * im;
                count += 1;
            }
        }
        sum / (f64::from(count) * 128.0 * 128.0 * mean * (1.0 - mean))
    }

    #[test]
    fn every_primary_is_spread_evenly() {
        for tone in [[0.2, 0.2, 0.2], [0.1, 0.5, 0.2], [0.05, 0.05, 0.05]] {
            let separation = Separation::new([128, 128], &vec![tone; 128 * 128], InkLimit::Scale).unwrap();
            for method in METHODS {
                let print = method.halftone(&separation, 1, 1).unwrap();
                let power = [1, 2, 3].map(|primary| low_power(&print, primary));
                // Random dots would have 1 within 0.13 (57 waves). Error diffusion reaches 0.03 and less; blue noise 0.06 for
                // green, and 0.13 for the differences of sets that red and blue are.
                let bars = if method == Method::BlueNoise { [0.2, 0.1, 0.2] } else { [0.06; 3] };
                println!("{tone:?} {method:?}: low-frequency power {power:.4?}");
                assert!((0..3).all(|c| power[c] < bars[c]), "{tone:?} {method:?}: {power:?}");
            }
        }
    }

    #[test]
    fn tones_along_gradients_are_reached_block_by_block() {
        let size = [256, 96];
        let tone = |k: usize| {
            let t = (k % 256) as f32 / 255.0;
            [[t, 0.0, 0.0], [t / 3.0; 3], [0.6 * t, 0.4 - 0.4 * t, 0.3 * t]][k / 256 / 32]
        };
        let pixels: Vec<[f32; 3]> = (0..256 * 96).map(tone).collect();
        let separation = Separation::new(size, &pixels, InkLimit::Scale).unwrap();
        for method in METHODS {
            let print = method.halftone(&separation, 1, 1).unwrap();
            let errors = ToneErrors::of(&separation, &print, 16).unwrap();
            // Of 256 dots, seven: what the 64 dots along the border of a block exchange with others. At random it would be
            // up to three or four times sqrt(64) dots, 0.1.
            assert!(errors.largest_of_blocks.iter().all(|e| *e < 7.5 / 256.0), "{method:?}: {errors:?}");
            // As along the border of the whole, in proportion.
            let total = [0, 1, 2].map(|c| (errors.reached[c] - errors.wished[c]).abs());
            assert!(total.iter().all(|e| *e < 0.002), "{method:?}: {errors:?}");
        }
    }

    #[test]
    fn cells_share_out_what_a_pixel_cannot_show() {
        let separation = Separation::new([40, 40], &[[0.3, 0.0, 0.0]; 1600], InkLimit::Scale).unwrap();
        for method in METHODS {
            let print = method.halftone(&separation, 3, 1).unwrap();
            assert_eq!(print.size(), [120, 120]);
            let mut counts = [0; 10];
            for (x, y) in (0..40).flat_map(|y| (0..40).map(move |x| (3 * x, 3 * y))) {
                counts[(9.0 * print.mean_tone_in(x..x + 3, y..y + 3)[0]).round() as usize] += 1;
            }
            println!("{method:?}: pixels by dots {counts:?}");
            // Mostly three of nine, as in the paper, otherwise two or four.
            assert!(
                counts[3] > counts[2].max(counts[4]) && counts[2] + counts[3] + counts[4] > 1500,
                "{counts:?}"
            );
            assert!((print.mean_tone()[0] - 0.3).abs() < 0.001);
        }
    }

    #[test]
    fn seeds_decide() {
        let separation = Separation::new([9, 9], &[[0.3, 0.2, 0.1]; 81], InkLimit::Scale).unwrap();
        for method in METHODS {
            let of_seed = |seed| method.halftone(&separation, 2, seed).unwrap();
            assert_eq!(of_seed(5), of_seed(5));
            assert_ne!(of_seed(5), of_seed(6));
            assert!(
                method.halftone(&separation, 0, 1).is_err() && method.halftone(&separation, 33, 1).is_err()
            );
        }
    }
}
