//! The usable cells of a table.
//!
//! Real tables are filled where the instrument could not reach: beyond the last measured polar angle a row repeats the row
//! before it, and small plateaus of one value stand where light or camera hid the sample. Both are recognized by their
//! bits, with no knowledge of the instrument, and left out. A table computed from a model holds equal neighbors too, which are
//! values: its user says that nothing was filled in.

use crate::brdf::{ClearCoat, LobeGeometry, TabulatedBrdf};
use crate::math::half_difference::HalfDifference;
use crate::math::hash::{pcg4d, unit};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// One usable cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Geometry under the coat, where lobes and chi live.
    pub geometry: LobeGeometry,
    /// Geometry outside, where the gloss lobe lives.
    pub outer: LobeGeometry,
    /// Address in the color table.
    pub angles: HalfDifference,
    /// What the coat lets pass, both ways.
    pub transmittance: f64,
    /// Share of the two spheres of directions, up to a factor: the product of both polar sines.
    pub solid_angle: f64,
    /// The table's value, 1/sr.
    pub color: DVec3,
}

impl Sample {
    /// Intensity, Rump et al. 2008, eq. 4; negative where the measurement is.
    pub fn intensity(&self) -> f64 {
        self.color.element_sum() / 3.0
    }

    /// Half-vector angle outside, radians.
    pub fn outer_theta_h(&self) -> f64 {
        self.outer.tan2_h.sqrt().atan()
    }
}

/// What became of the cells of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SampleCounts {
    /// Cells of the table.
    pub cells: usize,
    /// Cells left out because they repeat a neighbor to the bit.
    pub repeated: usize,
    /// Cells used (a table above a million usable cells is thinned at random to about that many).
    pub used: usize,
    /// Used cells that hold the clear coat's peak.
    pub gloss: usize,
    /// Used cells whose intensity is zero or negative: they enter eq. 7 as zero, and the color table as they are.
    pub not_positive: usize,
    /// Used cells with a negative channel: noise, or a color outside the gamut of Rec.709.
    pub negative_channel: usize,
}

/// Most samples kept.
const LIMIT: usize = 1_000_000;

/// Collects the usable cells of `table` under `coat`: all, or where it may be `filled` those that repeat no neighbor. `gloss`
/// in the counts is left at 0.
pub(super) fn collect(
    table: &TabulatedBrdf,
    coat: &ClearCoat,
    seed: u32,
    filled: bool,
) -> (Vec<Sample>, SampleCounts) {
    let [n, m] = table.resolution();
    let repeated = if filled { repeats(table) } else { vec![false; n * n * m] };
    let usable = repeated.iter().filter(|r| !**r).count();
    let keep = LIMIT as f32 / usable.max(1) as f32;
    let samples: Vec<Sample> = (0..n * n)
        .into_par_iter()
        .flat_map_iter(|row| {
            let repeated = &repeated[row * m..(row + 1) * m];
            (0..m).filter(move |k| !repeated[*k] && drawn(row * m + k, seed) < keep).map(move |k| {
                let (wi, wo) = table.directions(row / n, row % n, k);
                sample(wi, wo, coat, table.cell(row / n, row % n, k))
            })
        })
        .collect();
    let count = |test: fn(&Sample) -> bool| samples.iter().filter(|s| test(s)).count();
    let counts = SampleCounts {
        cells: repeated.len(),
        repeated: repeated.len() - usable,
        used: samples.len(),
        gloss: 0,
        not_positive: count(|s| s.intensity() <= 0.0),
        negative_channel: count(|s| s.color.min_element() < 0.0),
    };
    (samples, counts)
}

fn drawn(cell: usize, seed: u32) -> f32 {
    unit(pcg4d([cell as u32, (cell as u64 >> 32) as u32, seed, 0])[0])
}

fn sample(wi: DVec3, wo: DVec3, coat: &ClearCoat, color: DVec3) -> Sample {
    let (inner_i, inner_o) = (coat.inner(wi), coat.inner(wo));
    Sample {
        geometry: LobeGeometry::of(inner_i, inner_o),
        outer: LobeGeometry::of(wi, wo),
        angles: HalfDifference::of(inner_i, inner_o),
        transmittance: coat.transmittance(wi.z, wo.z),
        solid_angle: wi.truncate().length() * wo.truncate().length(),
        color,
    }
}

/// Which cells repeat a neighbor to the bit, and so were filled in. A table of which more than half would go is no filled
/// measurement but a function with plateaus (a matte one, say), and nothing is left out.
fn repeats(table: &TabulatedBrdf) -> Vec<bool> {
    let [n, m] = table.resolution();
    let values = table.values();
    let at = |a: usize, b: usize, k: usize| values[(a * n + b) * m + k];
    let reach_in = reach(n, |a| (0..n).all(|b| (0..m).all(|k| at(a, b, k) == at(a - 1, b, k))));
    let reach_out = reach(n, |b| (0..n).all(|a| (0..m).all(|k| at(a, b, k) == at(a, b - 1, k))));
    let marks: Vec<bool> = (0..n * n * m)
        .into_par_iter()
        .map(|cell| {
            let (a, b, k) = (cell / m / n, cell / m % n, cell % m);
            if a >= reach_in || b >= reach_out {
                return true;
            }
            let value = at(a, b, k);
            // A clipped black is a value, not a filling.
            value != [0.0; 3]
                && ((b > 0 && at(a, b - 1, k) == value)
                    || (b + 1 < reach_out && at(a, b + 1, k) == value)
                    || (k > 0 && at(a, b, k - 1) == value)
                    || (k + 1 < m && at(a, b, k + 1) == value))
        })
        .collect();
    let share = marks.iter().filter(|r| **r).count();
    if 2 * share > marks.len() { vec![false; marks.len()] } else { marks }
}

/// Number of rows before the run of repeated rows at the far end of an axis of `n`.
fn reach(n: usize, repeats: impl Fn(usize) -> bool) -> usize {
    (1..n).rev().find(|k| !repeats(*k)).map_or(1, |k| k + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavy(wi: DVec3, wo: DVec3) -> DVec3 {
        DVec3::new(wi.z + 2.0 * wo.z, wi.dot(wo), 0.5 + wi.x * wo.x)
    }

    #[test]
    fn repeated_rows_at_the_ends_are_left_out() {
        let table = TabulatedBrdf::from_fn(10, 12, wavy).unwrap();
        let mut values = table.values().to_vec();
        let row = |a: usize, b: usize| (a * 10 + b) * 12;
        for a in 0..10 {
            for b in 8..10 {
                values.copy_within(row(a, 7)..row(a, 8), row(a, b));
            }
        }
        for a in 7..10 {
            values.copy_within(row(6, 0)..row(7, 0), row(a, 0));
        }
        let filled = TabulatedBrdf::new(10, 12, values).unwrap();
        let (samples, counts) = collect(&filled, &ClearCoat::NONE, 0, true);
        assert_eq!(counts.used, 7 * 8 * 12);
        assert_eq!(samples.len(), counts.used);
        assert_eq!(counts.repeated, 1200 - counts.used);
        assert_eq!(collect(&filled, &ClearCoat::NONE, 0, false).1.used, 1200);
    }

    #[test]
    fn a_plateau_is_left_out_and_a_matte_table_is_not() {
        let table = TabulatedBrdf::from_fn(10, 12, wavy).unwrap();
        let mut values = table.values().to_vec();
        for b in 2..5 {
            for k in 3..6 {
                values[(4 * 10 + b) * 12 + k] = [0.7; 3];
            }
        }
        let filled = TabulatedBrdf::new(10, 12, values).unwrap();
        assert_eq!(collect(&filled, &ClearCoat::NONE, 0, true).1.repeated, 9);
        let matte = TabulatedBrdf::from_fn(10, 12, |_, _| DVec3::splat(0.2)).unwrap();
        assert_eq!(collect(&matte, &ClearCoat::NONE, 0, true).1.repeated, 0);
    }

    #[test]
    fn negative_values_are_counted() {
        let table = TabulatedBrdf::from_fn(6, 6, |wi, wo| {
            if wi.z > 0.9 { DVec3::splat(-wo.z) } else { DVec3::new(-0.1, wi.z, wo.z) }
        })
        .unwrap();
        let (samples, counts) = collect(&table, &ClearCoat::NONE, 0, true);
        assert_eq!(counts.negative_channel, samples.len());
        assert!(counts.not_positive > 0 && counts.not_positive < samples.len());
    }
}
