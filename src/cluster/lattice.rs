//! Signed Lab on an integer lattice, where sums are exact and do not depend on the order of the texels.

use super::moments::Point;
use crate::color::lab_planes_f32;
use crate::error::{Error, Result};

const STEPS: f32 = ((1u32 << Point::BITS) - 1) as f32;

/// 2^23: numbers from here to twice this are the integers.
const INTEGERS: f32 = (1u32 << 23) as f32;

/// Largest magnitude of a texel, 1/sr; half floats end at 65,504.
const LARGEST: f32 = 1e12;

/// The root cube of a slice: it starts at the smallest L, a, b and its edge is the largest range of the three.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cube {
    origin: [f32; 3],
    edge: f32,
}

/// Lab of `pi f` of every texel, one plane an axis (L, a, b).
///
/// # Errors
/// A component that is not a number within +-1e12; its texel is named.
pub(super) fn lab_planes(texels: &[[f32; 3]]) -> Result<[Vec<f32>; 3]> {
    // One test for all texels is a vector loop; the culprit is looked for afterwards.
    let legal = |t: &[f32; 3]| (t[0].abs() <= LARGEST) & (t[1].abs() <= LARGEST) & (t[2].abs() <= LARGEST);
    if !texels.iter().fold(true, |all, t| all & legal(t)) {
        let k = texels.iter().position(|t| !legal(t)).unwrap_or_default();
        let found = format!("{:?}", texels[k]);
        return Err(Error::invalid(format!("texel {k}"), "value", found, "numbers within +-1e12"));
    }
    Ok(lab_planes_f32(texels, std::f32::consts::PI))
}

/// Smallest and largest number of a plane; it is not empty.
fn range(plane: &[f32]) -> [f32; 2] {
    // Eight pairs at a time: the order of comparisons does not matter, but a compiler must assume that it does.
    let (chunks, rest) = plane.as_chunks::<8>();
    let [mut low, mut high] = [[plane[0]; 8]; 2];
    for chunk in chunks {
        low = std::array::from_fn(|k| low[k].min(chunk[k]));
        high = std::array::from_fn(|k| high[k].max(chunk[k]));
    }
    let all = || low.iter().chain(&high).chain(rest).copied();
    [all().fold(plane[0], f32::min), all().fold(plane[0], f32::max)]
}

impl Cube {
    /// The smallest cube around all colors.
    pub(super) fn around(planes: &[Vec<f32>; 3]) -> Self {
        let ranges = [0, 1, 2].map(|axis| range(&planes[axis]));
        let edge = ranges.iter().fold(0.0, |edge: f32, r| edge.max(r[1] - r[0]));
        Self { origin: ranges.map(|r| r[0]), edge }
    }

    /// The lattice points of all colors, coordinates below 2^20.
    pub(super) fn points(&self, [l, a, b]: &[Vec<f32>; 3]) -> Vec<Point> {
        let scale = if self.edge > 0.0 { STEPS / self.edge } else { 0.0 };
        let coordinate = |axis: usize, x: &f32| {
            let steps = (x - self.origin[axis]) * scale;
            let steps = if steps < STEPS { steps } else { STEPS };
            // The sum is rounded to an integer, which its lowest bits hold: cheaper than a conversion.
            (steps + INTEGERS).to_bits() - INTEGERS.to_bits()
        };
        let colors = l.iter().zip(a).zip(b);
        colors.map(|((l, a), b)| Point::new([coordinate(0, l), coordinate(1, a), coordinate(2, b)])).collect()
    }

    /// The Lab component at a coordinate, which may lie between lattice points.
    pub(super) fn lab(&self, axis: usize, coordinate: f64) -> f64 {
        f64::from(self.origin[axis]) + coordinate * f64::from(self.edge) / f64::from(STEPS)
    }
}
