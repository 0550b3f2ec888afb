//! Boxes and bands in few bits, as they lie on a GPU; the CPU draws from the same.
//!
//! A corner is off by no more than half a step, and a step is 2^-14 of the power of two above the largest component of its box: up to
//! 0.004 Lab units in a box of L* 64 to 128, less in darker ones.

use crate::cluster::{Ramp, SliceStatistics, mean_of_boxes};
use glam::DVec3;

/// Bits of a component, its sign among them.
const BITS: u32 = 15;
const MOST: f32 = 16383.0;
/// Biased exponent of the smallest step, 2^-40.
const SMALLEST: i32 = 87;
/// Steps are powers of two, so many of them.
const STEPS: i32 = 64;
/// Of a ramp: bits of its middle; mantissa of its slope, and the biased exponent where its codes begin.
const MIDDLE: u32 = 14;
const MANTISSA: u32 = 13;
const LEAST_SLOPE: u32 = 126;

/// Smallest and largest corner of a box as three words: an axis each, fifteen bits a corner, and two bits of the exponent of the
/// step that all share.
pub fn pack_box(min: [f32; 3], max: [f32; 3]) -> [u32; 3] {
    let largest = min.iter().chain(&max).fold(0.0f32, |most, x| most.max(x.abs()));
    // A hair more, so that no component rounds up past the most.
    let exponent = ((largest * 1.0001).to_bits() >> 23) as i32 - 13 - SMALLEST;
    let exponent = exponent.clamp(0, STEPS - 1) as u32;
    let per_step = f32::from_bits((254 - SMALLEST as u32 - exponent) << 23);
    let steps =
        |x: f32| ((x * per_step).round_ties_even().clamp(-MOST, MOST) as i32 as u32) & ((1 << BITS) - 1);
    [0, 1, 2].map(|axis| {
        steps(min[axis]) | steps(max[axis]) << BITS | ((exponent >> (2 * axis)) & 3) << (2 * BITS)
    })
}

/// The corners that [`pack_box`] keeps.
pub fn unpack_box(words: [u32; 3]) -> [[f32; 3]; 2] {
    let exponent = words.iter().rev().fold(0, |e, word| e << 2 | word >> (2 * BITS));
    let step = f32::from_bits((exponent + SMALLEST as u32) << 23);
    let corner = |left: u32| words.map(|word| ((word << left) as i32 >> 17) as f32 * step);
    [corner(17), corner(2)]
}

/// A band as one word: its slope, 1 to 2^30, within 2^-14 of itself in the upper 18 bits, its middle within 2^-15 below. 0: no band.
pub fn pack_ramp(ramp: Ramp) -> u32 {
    if ramp.slope <= 0.0 {
        return 0;
    }
    let code =
        ((ramp.slope.to_bits() + (1 << (22 - MANTISSA))) >> (23 - MANTISSA)) - (LEAST_SLOPE << MANTISSA);
    let ends = (1 << MIDDLE) as f32;
    code << MIDDLE | (ramp.middle * ends).round_ties_even().min(ends - 1.0) as u32
}

/// The band that [`pack_ramp`] keeps.
pub fn unpack_ramp(word: u32) -> Ramp {
    if word == 0 {
        return Ramp::default();
    }
    Ramp {
        slope: f32::from_bits(((word >> MIDDLE) + (LEAST_SLOPE << MANTISSA)) << (23 - MANTISSA)),
        middle: (word & ((1 << MIDDLE) - 1)) as f32 / (1 << MIDDLE) as f32,
    }
}

/// The statistics with the boxes that are kept; the offset takes up what rounding adds to their mean.
pub(super) fn rounded(statistics: &SliceStatistics) -> SliceStatistics {
    let mut rounded = statistics.clone();
    for cluster in &mut rounded.clusters {
        [cluster.min, cluster.max] = unpack_box(pack_box(cluster.min, cluster.max));
    }
    let gain = DVec3::from(statistics.gain.map(f64::from));
    let more = gain * (mean_of_boxes(&rounded.clusters) - mean_of_boxes(&statistics.clusters));
    rounded.offset = (DVec3::from(statistics.offset.map(f64::from)) - more).as_vec3().to_array();
    rounded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{pcg4d, unit};

    #[test]
    fn corners_are_kept_within_half_a_step() {
        for k in 0..20_000u32 {
            let [size, a, b, c] = pcg4d([k, 1, 2, 3]).map(unit);
            let [d, e, f, _] = pcg4d([k, 4, 5, 6]).map(unit);
            // From far below what can be seen to the largest legal corner.
            let size = 1e-8 * 1e17f32.powf(size);
            let corner = |v: [f32; 3]| v.map(|x| size * (2.0 * x - 1.0));
            let (min, max) = (corner([a, b, c]), corner([d, e, f]));
            let largest = min.iter().chain(&max).fold(0.0f32, |most, x| most.max(x.abs()));
            // The power of two above, 1.0001 times the largest at least.
            let step = (1.0001 * largest).log2().floor().exp2() / 8192.0;
            let [low, high] = unpack_box(pack_box(min, max));
            for (exact, kept) in min.iter().chain(&max).zip(low.iter().chain(&high)) {
                assert!((exact - kept).abs() <= 0.5001 * step.max(2f32.powi(-40)), "{exact} {kept} {step}");
            }
            assert_eq!(unpack_box(pack_box(low, high)), [low, high], "what is kept is kept again");
        }
        assert_eq!(unpack_box(pack_box([0.0; 3], [0.0; 3])), [[0.0; 3]; 2]);
    }

    #[test]
    fn bands_are_kept() {
        for k in 0..10_000u32 {
            let [slope, middle, ..] = pcg4d([k, 1, 2, 3]).map(unit);
            let ramp = Ramp { slope: 1e8f32.powf(slope), middle };
            let kept = unpack_ramp(pack_ramp(ramp));
            assert!((kept.slope / ramp.slope - 1.0).abs() <= 2f32.powi(-14), "{ramp:?} {kept:?}");
            // The end itself is cut by a step.
            assert!((kept.middle - ramp.middle).abs() <= 2f32.powi(-14), "{ramp:?} {kept:?}");
        }
        assert_eq!(unpack_ramp(pack_ramp(Ramp::default())), Ramp::default());
        let usual = Ramp { slope: 2.5, middle: 0.5 };
        assert_eq!(unpack_ramp(pack_ramp(usual)), usual);
    }

    #[test]
    fn the_mean_stays() {
        let cluster = |k: u32| {
            let [a, b, c, d] = pcg4d([k, 7, 8, 9]).map(unit);
            let low = [130.0 * a - 20.0, 20.0 * b, 20.0 * c];
            crate::cluster::Cluster { probability: 0.02, min: low, max: low.map(|x| x + 4.0 * d) }
        };
        let gain = [1.5, 1.0, 0.5];
        let exact =
            SliceStatistics { gain, ..SliceStatistics::new((0..50).map(cluster).collect(), [0.0; 3]) };
        let kept = rounded(&exact);
        // Without the offset: fifty errors of 1e-4 and less of a color.
        assert!((exact.box_mean() - kept.box_mean()).length() > 1e-7);
        // The rounding of an offset near 1e-5.
        assert!((exact.mean_rgb() - kept.mean_rgb()).length() < 1e-11);
    }
}
