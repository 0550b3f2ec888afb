//! Colors of AxF-like textures, and tables of which half is missing.

use crate::brdf::ColorTable;
use crate::color::{WHITE_XYZ, bradford, rgb_from_xyz};
use crate::error::Result;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Color spaces of textures; all linear, 2 degree observer, relative to the equal-energy white: a reflectance of 1 is (1, 1, 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ColorSpace {
    /// Primaries of Rec.709 adapted to the equal-energy white: what this program calls linear RGB, in which a reflectance of 1 is
    /// (1, 1, 1), too.
    #[default]
    #[serde(rename = "sRGB,E")]
    Srgb,
    /// CIE XYZ, brought to D65 by the Bradford transform.
    #[serde(rename = "XYZ")]
    Xyz,
}

impl ColorSpace {
    /// Linear Rec.709 of texels of this space.
    pub(super) fn convert(self, texels: &mut [[f32; 3]]) {
        if self == Self::Xyz {
            let adapt: DMat3 = bradford(DVec3::ONE, WHITE_XYZ);
            for texel in texels {
                *texel = rgb_from_xyz(adapt * DVec3::from(texel.map(f64::from))).as_vec3().to_array();
            }
        }
    }
}

/// The color table of texels, row by row. Where theta_F + theta_I is beyond 90 degrees and a texel is 0, the table ends there: it
/// gets the last color of its row, or of the row above, and is marked as not measured.
pub(super) fn table(size: [usize; 2], mut texels: Vec<[f32; 3]>) -> Result<ColorTable> {
    let [columns, rows] = size;
    let mut measured = vec![true; texels.len()];
    let angle = |k: usize, n: usize| FRAC_PI_2 * k as f64 / (n.max(2) - 1) as f64;
    for k in 0..texels.len() {
        let (column, row) = (k % columns, k / columns);
        // The angles on the diagonal itself are still there.
        let is_beyond = angle(column, columns) + angle(row, rows) > FRAC_PI_2 * (1.0 + 1e-9);
        if is_beyond && texels[k] == [0.0; 3] {
            measured[k] = false;
            texels[k] = if column > 0 { texels[k - 1] } else { texels[k.saturating_sub(columns)] };
        }
    }
    ColorTable::new(size, texels, measured)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_below_the_diagonal_is_filled_and_marked() {
        let at = |column: usize, row: usize| [1.0 + column as f32, row as f32, 0.5];
        let texels = (0..16).map(|k| if k % 4 + k / 4 > 3 { [0.0; 3] } else { at(k % 4, k / 4) }).collect();
        let table = table([4, 4], texels).unwrap();
        assert_eq!(table.texels()[3 * 4..], [at(0, 3); 4]);
        assert_eq!((table.texels()[7], table.measured()[7]), (at(2, 1), false));
        assert_eq!(table.measured().iter().filter(|m| !**m).count(), 6);
        // Black above the diagonal is a color.
        let black = super::table([2, 2], vec![[0.0; 3]; 4]).unwrap();
        assert_eq!(black.measured(), [true, true, true, false]);
    }

    #[test]
    fn the_white_of_equal_energy_is_white() {
        let mut texels = [[1.0; 3], [0.0; 3]];
        ColorSpace::Xyz.convert(&mut texels);
        // f32.
        assert!(texels[0].iter().all(|c| (c - 1.0).abs() < 1e-6) && texels[1] == [0.0; 3], "{texels:?}");
    }
}
