//! The mean color of boxes in Lab, exactly.
//!
//! Lab is uniform in a box, so each companded value is a constant plus one or two independent uniform variables, and the
//! inverse companding function is a cubic on either side of a straight middle. Where a box stays on one side, with mean m
//! and variance v (the distribution is symmetric), E f^3 = m^3 + 3 m v. Where it crosses, the density of a sum of two
//! uniforms is linear between four knots, and Gauss' rule of three nodes is exact between these and the ends of the middle.

use super::Cluster;
use crate::color::{WHITE_XYZ, rgb_from_xyz};
use glam::DVec3;
use std::f64::consts::PI;

const DELTA: f64 = 6.0 / 29.0;
const ZERO: f64 = 4.0 / 29.0;
/// Slope of the inverse companding function on its straight part.
const SLOPE: f64 = 3.0 * DELTA * DELTA;

/// Mean of the colors drawn from the boxes with their probabilities, without any offset: linear Rec.709, 1/sr.
/// Corners may be inverted.
pub fn mean_of_boxes(clusters: &[Cluster]) -> DVec3 {
    clusters.iter().map(|cluster| cluster.probability * mean_of_box(cluster)).sum()
}

/// Mean color of one box, linear Rec.709, 1/sr.
fn mean_of_box(cluster: &Cluster) -> DVec3 {
    let half = |axis: usize| 0.5 * (f64::from(cluster.max[axis]) - f64::from(cluster.min[axis])).abs();
    let middle = |axis: usize| 0.5 * (f64::from(cluster.max[axis]) + f64::from(cluster.min[axis]));
    let (y, y_half) = (middle(0) / 116.0, half(0) / 116.0);
    let relative = DVec3::new(
        mean_expanded(y + middle(1) / 500.0, y_half, half(1) / 500.0),
        mean_expanded(y, y_half, 0.0),
        mean_expanded(y - middle(2) / 200.0, y_half, half(2) / 200.0),
    );
    rgb_from_xyz(relative * WHITE_XYZ) / PI
}

/// Expectation of the inverse companding function at `mean` + U(-a, a) + U(-b, b), arguments counted from its center 4/29.
fn mean_expanded(mean: f64, a: f64, b: f64) -> f64 {
    let joint = DELTA - ZERO;
    let reach = a + b;
    if mean.abs() - reach >= joint {
        let root = mean.abs() + ZERO;
        return (root * root * root + root * (a * a + b * b)).copysign(mean);
    }
    if mean.abs() + reach <= joint {
        return SLOPE * mean;
    }
    let expand = |f: f64| {
        let above = f.abs();
        let x = if above > joint { (above + ZERO).powi(3) } else { above * SLOPE };
        x.copysign(f)
    };
    let plateau = (a - b).abs();
    let density = |x: f64| {
        let d = (x - mean).abs();
        // Without a second variable there are no slopes; rounding may still leave d above the plateau.
        let flat = d <= plateau || a.min(b) == 0.0;
        if flat { 0.5 / a.max(b) } else { 0.25 * (reach - d).max(0.0) / (a * b) }
    };
    let mut knots = [mean - reach, mean - plateau, mean + plateau, mean + reach, -joint, joint];
    knots.sort_unstable_by(f64::total_cmp);
    knots
        .windows(2)
        .map(|ends| gauss(ends[0].max(mean - reach), ends[1].min(mean + reach), |x| density(x) * expand(x)))
        .sum()
}

/// Gauss' rule of three nodes on `[from, to]`, exact for polynomials of degree 5; 0 for an empty interval.
fn gauss(from: f64, to: f64, value: impl Fn(f64) -> f64) -> f64 {
    if to <= from {
        return 0.0;
    }
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    // The roots of the Legendre polynomial of degree 3: 0 and +-sqrt(3/5).
    let x = half * 0.774_596_669_241_483_4;
    half * (5.0 * (value(middle - x) + value(middle + x)) + 8.0 * value(middle)) / 9.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The inverse companding function integrated twice: odd, its constants chosen so that it is smooth at the joint.
    fn integrated_twice(f: f64) -> f64 {
        let (g, joint) = (f.abs(), DELTA - ZERO);
        let slope = SLOPE;
        let value = if g <= joint {
            slope * g.powi(3) / 6.0
        } else {
            let c = slope * joint * joint / 2.0 - DELTA.powi(4) / 4.0;
            let d = slope * joint.powi(3) / 6.0 - DELTA.powi(5) / 20.0 - c * joint;
            (g + ZERO).powi(5) / 20.0 + c * g + d
        };
        value.copysign(f)
    }

    proptest! {
        #[test]
        fn the_mean_is_a_second_difference(mean in -2.0..2.0f64, a in 0.02..1.0f64, b in 0.02..1.0f64) {
            let h = integrated_twice;
            let exact = (h(mean + a + b) - h(mean + a - b) - h(mean - a + b) + h(mean - a - b)) / (4.0 * a * b);
            // Values up to 4^5/20 cancel, over at least 4 (0.02)^2: 50 eps / 0.0016.
            prop_assert!((mean_expanded(mean, a, b) - exact).abs() < 1e-11, "{} {exact}", mean_expanded(mean, a, b));
        }

        #[test]
        fn the_mean_is_odd_and_does_not_care_which_is_which(mean in -1.0..1.0f64, a in 0.0..0.5f64, b in 0.0..0.5f64) {
            let value = mean_expanded(mean, a, b);
            // Seven intervals of three nodes, summed in another order.
            prop_assert!((mean_expanded(-mean, a, b) + value).abs() < 1e-14);
            prop_assert!((mean_expanded(mean, b, a) - value).abs() < 1e-14);
        }
    }

    #[test]
    fn boxes_without_chroma_have_a_mean_wherever_they_cross_the_joint() {
        for k in 0..20_000 {
            // Widths of every kind, and those that end a few roundings behind the joint.
            let mean = f64::from(k / 10) * 1.7e-4 - 0.17;
            let a = match k % 10 {
                0 => 1e-3 + f64::from(k % 97) * 7.3e-4,
                ulps => ((DELTA - ZERO) - mean).abs() * (1.0 + f64::from(ulps) * f64::EPSILON),
            };
            let h = |f: f64| (integrated_twice(f + 1e-5) - integrated_twice(f - 1e-5)) / 2e-5;
            let exact = (h(mean + a) - h(mean - a)) / (2.0 * a);
            for value in [mean_expanded(mean, a, 0.0), mean_expanded(mean, 0.0, a)] {
                // Central differences of step 1e-5: off by 1e-10 / 6 of the slope (below 1) and by rounding, over the width.
                assert!((value - exact).abs() < 1e-10 / a.min(1.0), "{mean} {a}: {value} {exact}");
            }
        }
    }

    #[test]
    fn thin_boxes_are_points_or_lines() {
        for mean in [-3.0, -0.069, -0.01, 0.0, 0.03, 0.0689, 0.069, 0.5, 70.0] {
            let point = {
                let g = f64::abs(mean);
                let x = if g > DELTA - ZERO { (g + ZERO).powi(3) } else { g * SLOPE };
                x.copysign(mean)
            };
            for tiny in [0.0, 1e-300, 1e-12] {
                // The slope of the function is 3 * 70^2 at most.
                assert!(
                    (mean_expanded(mean, tiny, 0.0) - point).abs()
                        <= 2e-8 * tiny.max(1e-20) + 1e-12 * point.abs()
                );
                let line = mean_expanded(mean, 0.1, 0.0);
                assert!(
                    (mean_expanded(mean, 0.1, tiny) - line).abs() <= 1e-10 * (1.0 + line.abs()),
                    "{mean} {tiny}"
                );
            }
        }
    }
}
