//! Scratches, dust and drops on the panel: places that differ from those around them in most pictures.
//!
//! A bright flake lights up in few pictures; what is wrong with the panel shows in all. Of a grid of cells over the sample, each
//! picture gives the logarithm of every cell's light over the median of the cells around it, and a cell whose mean over the pictures
//! is far from 0, by its standard error, in itself, and against the other cells (some hold more flakes than others, which all
//! pictures show, too), is a blemish. Smooth changes across the sample have the median in their
//! middle, and at the edges turn their sign with the direction of the light.

use super::{PairGeometry, Sheet};
use glam::DVec2;
use serde::Serialize;

/// Cells along the side of the sample.
const CELLS: usize = 14;
/// Differences beyond this are cut, so that no single picture decides.
const MOST: f64 = 0.5;
/// A blemish differs by so many standard errors, by so much, and by so many times what half of the cells differ by: five standard
/// deviations of normal ones.
const ERRORS: f64 = 6.0;
const LEAST: f64 = 0.08;
const TYPICAL: f64 = 7.4;
/// Pictures without which nothing is said.
const PICTURES: f64 = 20.0;

/// The grid of a picture.
pub(super) type Contrast = Vec<f32>;

/// Cells of the sample that are not like the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blemishes {
    /// Middles of the cells, millimetres.
    pub places_mm: Vec<[f64; 2]>,
    /// Half of a cell's side, millimetres.
    pub half_mm: f64,
}

/// Cells over a sample.
pub(super) struct Cells {
    sheet: Sheet,
}

impl Cells {
    pub fn new(sample_mm: [f64; 2]) -> Self {
        let side = sample_mm[0].min(sample_mm[1]) / CELLS as f64;
        // A rounding less, so that all cells lie on the sample.
        Self { sheet: Sheet::new(sample_mm, side * (1.0 - 1e-12)) }
    }

    /// Logarithm of every cell's light over the median of those around it; no number where a cell is not seen or dark.
    pub fn contrast(&self, pixels: &[[f32; 3]], size: [usize; 2], pair: &PairGeometry) -> Contrast {
        let [columns, rows] = self.sheet.size;
        let light: Vec<f32> = self
            .sheet
            .rectify(pixels, size, pair)
            .iter()
            .map(|rgb| rgb.iter().sum::<f32>())
            .map(|l| if l > 0.0 { l.ln() } else { f32::NAN })
            .collect();
        let around = |k: usize| {
            let (x, y) = ((k % columns) as i64, (k / columns) as i64);
            let mut values: Vec<f32> = (-1..=1)
                .flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
                .filter(|(a, b)| {
                    (*a, *b) != (x, y) && (0..columns as i64).contains(a) && (0..rows as i64).contains(b)
                })
                .map(|(a, b)| light[b as usize * columns + a as usize])
                .filter(|l| l.is_finite())
                .collect();
            values.sort_by(f32::total_cmp);
            let middle = values.len() / 2;
            values.get(middle).map_or(f32::NAN, |high| 0.5 * (high + values[values.len().div_ceil(2) - 1]))
        };
        (0..light.len()).map(|k| light[k] - around(k)).collect()
    }

    /// The cells that differ in most of the pictures.
    pub fn blemishes(&self, pictures: &[Contrast]) -> Blemishes {
        let cells = self.sheet.size[0] * self.sheet.size[1];
        let difference = |k: usize| {
            let values = pictures.iter().filter_map(|p| p.get(k)).filter(|v| v.is_finite());
            let (count, sum, squares) = values.fold((0.0, 0.0, 0.0), |(n, s, q), v| {
                let v = f64::from(*v).clamp(-MOST, MOST);
                (n + 1.0, s + v, q + v * v)
            });
            let mean = sum / count;
            let error = ((squares / count - mean * mean).max(0.0) / count).sqrt();
            // A cell that few pictures show is as all others.
            if count < PICTURES { [0.0; 2] } else { [mean.abs(), error] }
        };
        let found: Vec<[f64; 2]> = (0..cells).map(difference).collect();
        let mut means: Vec<f64> = found.iter().map(|[mean, _]| *mean).collect();
        means.sort_by(f64::total_cmp);
        let least = LEAST.max(TYPICAL * means.get(cells / 2).copied().unwrap_or(0.0));
        let differs = |k: &usize| found[*k][0] > least && found[*k][0] > ERRORS * found[*k][1];
        let place = |k: usize| {
            let [columns, _] = self.sheet.size;
            self.sheet.place_mm((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5).to_array()
        };
        Blemishes {
            places_mm: (0..cells).filter(differs).map(place).collect(),
            half_mm: 0.5 * self.sheet.texel_mm,
        }
    }
}

impl Blemishes {
    /// Whether a square about a place reaches into one.
    pub fn touch(&self, middle_mm: DVec2, half_side_mm: DVec2) -> bool {
        let reach = half_side_mm + self.half_mm;
        self.places_mm.iter().any(|place| (middle_mm - DVec2::from(*place)).abs().cmplt(reach).all())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{pcg4d, unit};

    #[test]
    fn what_differs_in_most_pictures_is_a_blemish_and_a_bright_flake_is_none() {
        let cells = Cells::new([14.0, 14.0]);
        let count = CELLS * CELLS;
        assert_eq!(cells.sheet.size, [CELLS; 2]);
        let picture = |n: u32| -> Contrast {
            let noise = |k: usize| 0.6 * (unit(pcg4d([n, k as u32, 1, 2])[0]) - 0.5);
            let mut values: Contrast = (0..count).map(noise).collect();
            values[5 * CELLS + 3] -= 0.2;
            if n.is_multiple_of(10) {
                values[9 * CELLS + 9] = 3.0;
            }
            values
        };
        let pictures: Vec<Contrast> = (0..200).map(picture).collect();
        let found = cells.blemishes(&pictures);
        assert_eq!(found.places_mm.len(), 1, "{found:?}");
        // The middle of column 3 and row 5 of cells of 1 mm about the origin.
        assert!((DVec2::from(found.places_mm[0]) - DVec2::new(-3.5, -1.5)).length() < 1e-9);
        assert!(found.touch(DVec2::new(-4.2, -1.5), DVec2::splat(0.3)));
        assert!(!found.touch(DVec2::new(-4.4, -1.5), DVec2::splat(0.3)));
        assert!(cells.blemishes(&pictures[..10]).places_mm.is_empty(), "too few to say");

        // Few flakes, and each cell with its own number of them.
        let sparse = |mut picture: Contrast| {
            let own = |k: usize| 0.25 * (unit(pcg4d([k as u32, 3, 5, 7])[0]) - 0.5);
            picture.iter_mut().enumerate().for_each(|(k, v)| *v += own(k));
            picture
        };
        let unlike: Vec<Contrast> = pictures.into_iter().map(sparse).collect();
        assert!(cells.blemishes(&unlike).places_mm.is_empty(), "{:?}", cells.blemishes(&unlike));
    }
}
