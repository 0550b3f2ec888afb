//! Which paints of an arc are near enough to each other for boxes to travel between them.

use crate::error::{Error, Result};

/// For every paint the number of its group, four bits a paint; groups are numbered in the order in which u runs through
/// them, 0 first, without gaps. 0: all paints are in one group.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Groups(pub u32);

impl Groups {
    /// Bits of a paint.
    const BITS: usize = 4;
    /// More than any number of groups.
    pub(super) const MOST: usize = 1 << Self::BITS;

    /// From the group of every paint.
    pub(super) fn new(groups: impl IntoIterator<Item = usize>) -> Self {
        Self(groups.into_iter().enumerate().fold(0, |code, (k, g)| code | (g as u32) << (k * Self::BITS)))
    }

    /// Group of a paint.
    #[inline]
    pub fn of(self, paint: usize) -> usize {
        (self.0 >> (paint * Self::BITS)) as usize & 0xf
    }

    /// Whether all boxes travel.
    #[inline]
    pub fn is_one(self) -> bool {
        self.0 == 0
    }

    /// Number of groups among so many paints.
    pub fn count(self, paints: usize) -> usize {
        (0..paints).map(|k| self.of(k)).max().map_or(0, |g| g + 1)
    }

    /// # Errors
    /// Paints that are not in the mix, numbers with a gap.
    pub(super) fn validate(self, paints: usize) -> Result<()> {
        let count = self.count(paints);
        let gapless = (0..count).all(|g| (0..paints).any(|k| self.of(k) == g));
        if self.0.checked_shr((paints * Self::BITS) as u32).unwrap_or(0) != 0 || !gapless {
            let legal = format!("four bits for each of {paints} paints, numbered without gaps");
            return Err(Error::invalid("", "groups", format!("{:#x}", self.0), legal));
        }
        Ok(())
    }
}
