//! The 2-D color table chi(theta_h, theta_i) that tints diffuse and lobes (Golla & Klein 2018, section 3.1).

use crate::error::{Error, Result};
use std::f64::consts::FRAC_PI_2;

/// Linear Rec.709 factors over `theta_h` (column) and `theta_i` (row), texel centers on the ends of [0, pi/2].
#[derive(Debug, Clone, PartialEq)]
pub struct ColorTable {
    size: [usize; 2],
    texels: Vec<[f32; 3]>,
    measured: Vec<bool>,
}

impl ColorTable {
    /// The usual size, columns (theta_h) x rows (theta_i).
    pub const DEFAULT_SIZE: [usize; 2] = [64, 64];
    /// Largest number of columns or rows.
    pub const MAX_SIDE: usize = 4096;
    /// Largest absolute value of a component: times the largest lobe it is far from the end of f32.
    pub const MAX_VALUE: f32 = 1e15;

    /// A table from its texels, row-major (`theta_i` outer), and whether each was measured or filled in.
    ///
    /// # Errors
    /// A side outside 2-4096, counts that do not fit, a component that is no number or beyond [`Self::MAX_VALUE`].
    pub fn new(size: [usize; 2], texels: Vec<[f32; 3]>, measured: Vec<bool>) -> Result<Self> {
        if size.iter().any(|n| !(2..=Self::MAX_SIDE).contains(n)) {
            return Err(Error::invalid("color table", "size", format!("{size:?}"), "sides of 2 to 4096"));
        }
        let n = size[0] * size[1];
        if texels.len() != n || measured.len() != n {
            let found = format!("{} texels, {} marks", texels.len(), measured.len());
            return Err(Error::invalid("color table", "length", found, format!("{n} of each")));
        }
        if let Some(k) = texels.iter().position(|t| !t.iter().all(|c| c.abs() <= Self::MAX_VALUE)) {
            let place = format!("color table: texel ({}, {})", k % size[0], k / size[0]);
            return Err(Error::invalid(place, "value", format!("{:?}", texels[k]), "numbers within +-1e15"));
        }
        Ok(Self { size, texels, measured })
    }

    /// The table that changes nothing: (1, 1, 1) everywhere.
    pub fn white() -> Self {
        Self { size: [2, 2], texels: vec![[1.0; 3]; 4], measured: vec![true; 4] }
    }

    /// Columns (theta_h) and rows (theta_i).
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// All texels, row-major.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Whether each texel rests on a measurement.
    pub fn measured(&self) -> &[bool] {
        &self.measured
    }

    /// Angles (theta_h, theta_i) at the center of texel (column, row), radians.
    pub fn angles(&self, column: usize, row: usize) -> (f64, f64) {
        let at = |k: usize, n: usize| FRAC_PI_2 * k as f64 / (n - 1) as f64;
        (at(column, self.size[0]), at(row, self.size[1]))
    }

    /// The four texels around (theta_h, theta_i), radians, with their bilinear weights; clamped to the table.
    pub fn taps(&self, theta_h: f32, theta_i: f32) -> [(usize, f32); 4] {
        let (h0, h1, fh) = bracket(theta_h, self.size[0]);
        let (i0, i1, fi) = bracket(theta_i, self.size[1]);
        let at = |h: usize, i: usize| i * self.size[0] + h;
        [
            (at(h0, i0), (1.0 - fh) * (1.0 - fi)),
            (at(h1, i0), fh * (1.0 - fi)),
            (at(h0, i1), (1.0 - fh) * fi),
            (at(h1, i1), fh * fi),
        ]
    }

    /// Bilinear look-up.
    pub fn sample(&self, theta_h: f32, theta_i: f32) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for (texel, weight) in self.taps(theta_h, theta_i) {
            for (s, c) in sum.iter_mut().zip(self.texels[texel]) {
                *s += weight * c;
            }
        }
        sum
    }
}

/// Neighbouring texels of an angle in [0, pi/2] on an axis of `n` texels, and the weight of the second.
fn bracket(theta: f32, n: usize) -> (usize, usize, f32) {
    let x = (theta * std::f32::consts::FRAC_2_PI * (n - 1) as f32).clamp(0.0, (n - 1) as f32);
    let low = (x as usize).min(n - 2);
    (low, low + 1, x - low as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texel_centres_return_their_value() {
        let size = [5, 4];
        let texels: Vec<_> = (0..20).map(|k| [k as f32, -1.0, 2.0]).collect();
        let table = ColorTable::new(size, texels, vec![true; 20]).unwrap();
        for row in 0..4 {
            for column in 0..5 {
                let (h, i) = table.angles(column, row);
                let c = table.sample(h as f32, i as f32);
                // f32 angles times 2/pi: a few units in the last place times the slope.
                assert!((c[0] - (row * 5 + column) as f32).abs() < 1e-5, "{c:?}");
            }
        }
        assert_eq!(table.sample(9.0, 9.0)[0], 19.0);
    }

    #[test]
    fn bad_tables_are_refused() {
        assert!(ColorTable::new([1, 4], vec![[0.0; 3]; 4], vec![true; 4]).is_err());
        assert!(ColorTable::new([2, 2], vec![[0.0; 3]; 3], vec![true; 4]).is_err());
        for bad in [f32::NAN, f32::INFINITY, -1e16] {
            assert!(ColorTable::new([2, 2], vec![[bad; 3]; 4], vec![true; 4]).is_err());
        }
    }
}
