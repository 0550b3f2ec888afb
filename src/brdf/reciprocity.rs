//! How far a measurement is from `f(wi, wo) = f(wo, wi)`.
//!
//! The median over pairs of directions measured both ways of `|f - g| / ((|f| + |g|) / 2)`, f and g the means over the bands; 0 for
//! a reciprocal surface, up to 2. Pairs of which both values are 0 do not count.

use super::{SampleSet, TabulatedBrdf};
use glam::DVec3;
use std::collections::HashMap;

/// Cells of the angles in which two pairs of directions are the same, a turn: 0.1 degree.
const STEPS_A_TURN: f64 = 3600.0;

/// The measure over pairs of values, None without a pair that counts.
pub(super) fn median_difference(pairs: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let relative = |(f, g): (f64, f64)| (f - g).abs() / (0.5 * (f.abs() + g.abs()));
    let mut differences: Vec<f64> = pairs.map(relative).filter(|d| d.is_finite()).collect();
    if differences.is_empty() {
        return None;
    }
    let middle = differences.len() / 2;
    Some(*differences.select_nth_unstable_by(middle, f64::total_cmp).1)
}

impl TabulatedBrdf {
    /// Departure from reciprocity over all cells off the diagonal, see [`reciprocity`](crate::brdf::reciprocity); None if all are 0.
    pub fn reciprocity(&self) -> Option<f64> {
        let [n, m] = self.resolution();
        let pairs =
            (0..n * n * m).map(|cell| (cell / m / n, cell / m % n, cell % m)).filter(|(a, b, _)| a < b);
        let mean = |a: usize, b: usize, k: usize| self.cell(a, b, k).element_sum() / 3.0;
        median_difference(pairs.map(|(a, b, k)| (mean(a, b, k), mean(b, a, k))))
    }
}

impl SampleSet {
    /// Departure from reciprocity over the samples that are there both ways, to 0.1 degree, azimuths counted from the light and
    /// to either side; see [`reciprocity`](crate::brdf::reciprocity). None if there are none.
    pub fn reciprocity(&self) -> Option<f64> {
        let key = |wi: DVec3, wo: DVec3| {
            let step = |angle: f64| (angle / std::f64::consts::TAU * STEPS_A_TURN).round() as i32;
            let polar = |w: DVec3| step(w.truncate().length().atan2(w.z));
            let [a, b] = [wi.truncate(), wo.truncate()];
            // At the pole there is no azimuth.
            let azimuth =
                if polar(wi) == 0 || polar(wo) == 0 { 0 } else { step(a.perp_dot(b).abs().atan2(a.dot(b))) };
            (polar(wi), polar(wo), azimuth)
        };
        let mean = |k: usize| self.values(k).iter().sum::<f64>() / self.bands().len() as f64;
        let samples = || self.samples().iter().enumerate();
        let known: HashMap<_, usize> = samples().map(|(k, s)| (key(s.wi, s.wo), k)).collect();
        let pairs = samples().filter_map(|(k, s)| {
            let there = known.get(&key(s.wo, s.wi)).filter(|other| **other > k)?;
            let is_turned = key(s.wi, s.wo) != key(s.wo, s.wi);
            is_turned.then(|| (mean(k), mean(*there)))
        });
        median_difference(pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{Bands, BrdfSample};
    use crate::math::half_difference::spherical;

    #[test]
    fn a_reciprocal_table_has_none_and_a_lopsided_one_what_it_was_given() {
        let table = TabulatedBrdf::from_fn(6, 4, |wi, wo| DVec3::splat(1.0 + wi.z * wo.z)).unwrap();
        assert_eq!(table.reciprocity(), Some(0.0));
        // The larger angle of the eye is brighter by half: |1.5 - 1| / 1.25.
        let lopsided = |wi: DVec3, wo: DVec3| DVec3::splat(if wo.z < wi.z { 1.5 } else { 1.0 });
        let table = TabulatedBrdf::from_fn(6, 4, lopsided).unwrap();
        assert_eq!(table.reciprocity(), Some(0.4));
        assert_eq!(TabulatedBrdf::new(2, 2, vec![[0.0; 3]; 8]).unwrap().reciprocity(), None);
        // Samples of the table hold the same pairs; the halves of a tie in bands of equal value are exact.
        assert_eq!(SampleSet::from(&table).reciprocity(), Some(0.4));
    }

    #[test]
    fn turned_and_mirrored_pairs_are_found() {
        let mut set = SampleSet::new(Bands::Rgb).unwrap();
        let (near, far) = (0.3, 0.9);
        set.push(BrdfSample::new(spherical(near, 1.0), spherical(far, 1.7), 1.0), &[3.0; 3]).unwrap();
        assert_eq!(set.reciprocity(), None);
        set.push(BrdfSample::new(spherical(far, -2.0), spherical(near, -1.3), 1.0), &[1.0; 3]).unwrap();
        assert_eq!(set.reciprocity(), Some(1.0));
    }
}
