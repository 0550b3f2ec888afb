//! The random numbers of a path.

use crate::math::hash::{pcg4d, unit};

/// Uniform numbers in (0, 1), one after the other, that hang on pixel, sample and seed alone.
#[derive(Debug, Clone)]
pub(super) struct Numbers {
    key: [u32; 4],
    words: [u32; 4],
    used: usize,
}

impl Numbers {
    /// The numbers of a sample: column, row, number.
    pub fn new([x, y, sample]: [u32; 3], seed: u32) -> Self {
        // Apart from the numbers of the flakes, which are keyed by the seed itself.
        Self { key: pcg4d([x, y, sample, seed ^ 0x5bd1_e995]), words: [0; 4], used: 4 }
    }

    /// The next number.
    pub fn next(&mut self) -> f32 {
        if self.used == 4 {
            self.words = pcg4d(self.key);
            self.key[0] = self.key[0].wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        unit(self.words[self.used - 1])
    }
}
