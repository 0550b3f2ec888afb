//! From an image to how much of the paper each primary shall cover.
//!
//! The primaries add up as lights do where their dots lie side by side, so that linear red, green and blue are coverages, up
//! to a factor. Dots that never overlap share the paper: coverages add up to 1 at most, what is missing stays blank, and
//! white is a third of each. An image that asks for more is limited by one of two rules.

use crate::error::{Error, Result};
use rayon::prelude::*;

/// What happens to an image that asks for more ink than there is paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InkLimit {
    /// The whole image times one factor, so that its largest sum is 1: tones keep their proportions. An image that asks for
    /// less anywhere stays as it is.
    #[default]
    Scale,
    /// Every pixel with a sum above 1 divided by its own sum: the others stay as they are, bright ones keep their hue only.
    Clip,
}

/// Wished coverage of the three primaries in every pixel: each 0 to 1, together at most 1. Row-major, top row first.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    size: [usize; 2],
    tones: Vec<[f32; 3]>,
    factor: f64,
}

impl Separation {
    /// Separates an image of `size` (columns, rows) in linear Rec.709, 1 the brightest.
    ///
    /// # Errors
    /// No pixels, a number of them that does not fit, a value that is negative or not finite (its pixel named).
    pub fn new(size: [usize; 2], pixels: &[[f32; 3]], limit: InkLimit) -> Result<Self> {
        if pixels.is_empty() || pixels.len() != size[0].saturating_mul(size[1]) {
            let legal = format!("{} x {}, at least 1", size[0], size[1]);
            return Err(Error::invalid("image", "pixels", pixels.len(), legal));
        }
        let is_light = |c: &f32| c.is_finite() && *c >= 0.0;
        if let Some(k) = pixels.iter().position(|p| !p.iter().all(is_light)) {
            let place = format!("pixel ({}, {})", k % size[0], k / size[0]);
            return Err(Error::invalid(place, "linear RGB", format!("{:?}", pixels[k]), "0 or more"));
        }
        let largest = pixels.par_iter().map(sum).reduce(|| 0.0, f64::max);
        let factor = match limit {
            InkLimit::Scale => 1.0 / largest.max(1.0),
            InkLimit::Clip => 1.0,
        };
        let tone = |p: &[f32; 3]| {
            let factor = factor / (factor * sum(p)).max(1.0);
            p.map(|c| (f64::from(c) * factor) as f32)
        };
        Ok(Self { size, tones: pixels.par_iter().map(tone).collect(), factor })
    }

    /// Columns and rows of pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// What the whole image was multiplied by: 1, or less under [`InkLimit::Scale`].
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// Coverages of all pixels; rounded to f32, so that a full sum may miss 1 by some 1e-7.
    pub fn tones(&self) -> &[[f32; 3]] {
        &self.tones
    }

    /// Coverages of one pixel, which must be there.
    pub(super) fn tone(&self, column: usize, row: usize) -> [f64; 3] {
        self.tones[row * self.size[0] + column].map(f64::from)
    }
}

fn sum(pixel: &[f32; 3]) -> f64 {
    pixel.iter().map(|c| f64::from(*c)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// f32 rounds each coverage by up to 2^-25.
    const ROUNDING: f64 = 1e-7;

    #[test]
    fn scaling_keeps_proportions_and_clipping_what_fits() {
        let pixels = [[1.0, 1.0, 0.5], [0.25, 0.0, 0.125], [0.5, 0.5, 0.5]];
        let scaled = Separation::new([3, 1], &pixels, InkLimit::Scale).unwrap();
        assert_eq!(scaled.factor(), 0.4);
        assert_eq!(scaled.tones(), [[0.4, 0.4, 0.2], [0.1, 0.0, 0.05], [0.2, 0.2, 0.2]]);
        let clipped = Separation::new([3, 1], &pixels, InkLimit::Clip).unwrap();
        let third = 1.0 / 3.0;
        assert_eq!(clipped.tones(), [[0.4, 0.4, 0.2], [0.25, 0.0, 0.125], [third, third, third]]);
    }

    #[test]
    fn what_fits_stays_under_either_rule() {
        for limit in [InkLimit::Scale, InkLimit::Clip] {
            let pixels = [[0.3, 0.0, 0.0], [0.5, 0.25, 0.125]];
            let separation = Separation::new([1, 2], &pixels, limit).unwrap();
            assert_eq!((separation.tones(), separation.factor()), (&pixels[..], 1.0));
        }
    }

    #[test]
    fn light_that_cannot_be_is_refused() {
        for bad in [-0.1, f32::NAN, f32::INFINITY] {
            let pixels = [[0.0; 3], [0.0; 3], [0.0; 3], [0.0, bad, 0.0]];
            let message = Separation::new([2, 2], &pixels, InkLimit::Clip).unwrap_err().to_string();
            assert!(
                message.starts_with("pixel (1, 1): linear RGB") && message.ends_with("expected 0 or more")
            );
        }
        assert!(Separation::new([2, 2], &[[0.0; 3]; 3], InkLimit::Scale).is_err());
        assert!(Separation::new([0, 0], &[], InkLimit::Scale).is_err());
    }

    proptest! {
        #[test]
        fn inks_never_exceed_the_paper(
            pixels in prop::collection::vec(prop::array::uniform3(0.0f32..1e30), 1..20), scale: bool,
        ) {
            let limit = if scale { InkLimit::Scale } else { InkLimit::Clip };
            let separation = Separation::new([pixels.len(), 1], &pixels, limit).unwrap();
            for tone in separation.tones() {
                prop_assert!(tone.iter().all(|c| (0.0..=1.0).contains(c)), "{tone:?}");
                prop_assert!(sum(tone) <= 1.0 + ROUNDING, "{tone:?}");
            }
        }
    }
}
