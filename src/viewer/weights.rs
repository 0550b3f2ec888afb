//! Weights as the hand sets them: one at a time, or all at once from a point in a polygon.

use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Weights of a mix in the window, without and with extrapolation.
pub const INSIDE: (f64, f64) = (0.0, 1.0);
/// See [`INSIDE`].
pub const BEYOND: (f64, f64) = (-1.0, 2.0);

/// Shares below this, of a sum of weights, are none.
const NOTHING: f64 = 1e-9;

/// The same weight for each of `n` paints.
pub fn equal(n: usize) -> Vec<f64> {
    vec![1.0 / n as f64; n]
}

/// All weight on paint `k` of `n`.
pub fn only(k: usize, n: usize) -> Vec<f64> {
    (0..n).map(|j| f64::from(u8::from(j == k))).collect()
}

/// Sets weight `k` to `value`, brought into the range; the others keep their proportions and share the rest, so that all sum to
/// 1. Others that sum to nothing, or that would leave the range, share it equally. A single weight stays 1.
pub fn set_weight(weights: &mut [f64], k: usize, value: f64, (low, high): (f64, f64)) {
    let others = weights.len().saturating_sub(1);
    if others == 0 {
        weights.fill(1.0);
        return;
    }
    let value = value.clamp(low, high);
    let rest = 1.0 - value;
    let sum: f64 = weights.iter().sum::<f64>() - weights[k];
    let scaled: Vec<f64> = weights.iter().map(|w| w * (rest / sum)).collect();
    let legal = (low - NOTHING)..=(high + NOTHING);
    let fits = sum.abs() > NOTHING && (0..scaled.len()).all(|j| j == k || legal.contains(&scaled[j]));
    for (j, weight) in weights.iter_mut().enumerate() {
        *weight = match fits {
            _ if j == k => value,
            true => scaled[j],
            false => rest / others as f64,
        };
    }
}

/// Weights into the range: what is cut off goes to the others in proportion to the room they have.
pub fn clamp(weights: &mut [f64], (low, high): (f64, f64)) {
    for weight in weights.iter_mut() {
        *weight = weight.clamp(low, high);
    }
    let missing = 1.0 - weights.iter().sum::<f64>();
    let room = |w: f64| if missing > 0.0 { high - w } else { w - low };
    let total: f64 = weights.iter().map(|w| room(*w)).sum();
    if total > NOTHING {
        for weight in weights.iter_mut() {
            *weight += missing * room(*weight) / total;
        }
    }
}

/// Corner `k` of the regular polygon of `n` on the unit circle, the first one on top; x right, y down.
pub fn corner(k: usize, n: usize) -> DVec2 {
    DVec2::from_angle(TAU * k as f64 / n as f64 - FRAC_PI_2)
}

/// Where weights lie in their polygon.
pub fn place(weights: &[f64]) -> DVec2 {
    weights.iter().enumerate().map(|(k, w)| *w * corner(k, weights.len())).sum()
}

/// Weights of the corners at a point: exact barycentric coordinates of a triangle, also outside it; in a polygon of more corners
/// mean value coordinates (Floater 2003), 0 or more, which are linear along the edges and give [`place`] back; a point outside
/// such a polygon counts as the nearest one of its rim.
pub fn at_place(point: DVec2, n: usize) -> Vec<f64> {
    if n == 3 { triangle(point) } else { mean_value(inside(point, n), n) }
}

fn triangle(point: DVec2) -> Vec<f64> {
    let [a, b, c] = [0, 1, 2].map(|k| corner(k, 3));
    let area = (b - a).perp_dot(c - a);
    let second = (point - a).perp_dot(c - a) / area;
    let third = (b - a).perp_dot(point - a) / area;
    vec![1.0 - second - third, second, third]
}

/// The nearest point of the polygon.
fn inside(point: DVec2, n: usize) -> DVec2 {
    let edges = || (0..n).map(|k| (corner(k, n), corner((k + 1) % n, n)));
    if edges().all(|(a, b)| (b - a).perp_dot(point - a) >= 0.0) {
        return point;
    }
    let nearest = |(a, b): (DVec2, DVec2)| {
        let along = (point - a).dot(b - a) / (b - a).length_squared();
        a.lerp(b, along.clamp(0.0, 1.0))
    };
    let by_distance = |a: &DVec2, b: &DVec2| point.distance(*a).total_cmp(&point.distance(*b));
    edges().map(nearest).min_by(by_distance).unwrap_or(point)
}

fn mean_value(point: DVec2, n: usize) -> Vec<f64> {
    let spokes: Vec<DVec2> = (0..n).map(|k| corner(k, n) - point).collect();
    let lengths: Vec<f64> = spokes.iter().map(|s| s.length()).collect();
    if let Some(k) = lengths.iter().position(|l| *l < NOTHING) {
        return only(k, n);
    }
    // Half the angle between neighbouring spokes.
    let tangents: Vec<f64> = (0..n)
        .map(|k| {
            let (a, b) = (spokes[k], spokes[(k + 1) % n]);
            (a.perp_dot(b).atan2(a.dot(b)) / 2.0).tan()
        })
        .collect();
    // On an edge the angle is straight: the corners at its ends share the weight.
    if let Some(k) = tangents.iter().position(|t| t.abs() > 1.0 / NOTHING) {
        let next = (k + 1) % n;
        let share = lengths[k] / (lengths[k] + lengths[next]);
        return (0..n)
            .map(|j| {
                if j == k {
                    1.0 - share
                } else if j == next {
                    share
                } else {
                    0.0
                }
            })
            .collect();
    }
    let raw: Vec<f64> = (0..n).map(|k| (tangents[(k + n - 1) % n] + tangents[k]) / lengths[k]).collect();
    let sum: f64 = raw.iter().sum();
    raw.iter().map(|w| w / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sums_to_one(weights: &[f64]) -> bool {
        // A few roundings of numbers up to 2.
        (weights.iter().sum::<f64>() - 1.0).abs() < 1e-12
    }

    proptest! {
        #[test]
        fn set_weights_sum_to_one_and_stay_in_range(
            mut weights in prop::collection::vec(-1.0..2.0f64, 2..8), k in 0..8usize, value in -3.0..3.0f64,
        ) {
            clamp(&mut weights, BEYOND);
            let k = k % weights.len();
            set_weight(&mut weights, k, value, BEYOND);
            prop_assert!(sums_to_one(&weights), "{weights:?}");
            prop_assert_eq!(weights[k], value.clamp(-1.0, 2.0));
            prop_assert!(weights.iter().all(|w| (-1.0 - 1e-8..=2.0 + 1e-8).contains(w)), "{:?}", weights);
        }

        #[test]
        fn others_keep_their_proportions(
            mut weights in prop::collection::vec(0.01..1.0f64, 3..8), value in 0.0..0.99f64,
        ) {
            let before = weights.clone();
            set_weight(&mut weights, 0, value, INSIDE);
            let ratio = weights[1] / before[1];
            for (now, before) in weights.iter().zip(&before).skip(1) {
                prop_assert!((now / before / ratio - 1.0).abs() < 1e-12);
            }
        }

        #[test]
        fn clamped_weights_are_legal(mut weights in prop::collection::vec(-5.0..5.0f64, 2..8)) {
            for range in [INSIDE, BEYOND] {
                clamp(&mut weights, range);
                prop_assert!(sums_to_one(&weights), "{weights:?}");
                prop_assert!(weights.iter().all(|w| *w >= range.0 - 1e-12 && *w <= range.1 + 1e-12));
            }
        }

        #[test]
        fn a_point_of_the_polygon_comes_back(n in 3..9usize, shares in prop::collection::vec(0.0..1.0f64, 8)) {
            let sum: f64 = shares[..n].iter().sum();
            let shares: Vec<f64> = shares[..n].iter().map(|s| s / sum).collect();
            let point = place(&shares);
            let weights = at_place(point, n);
            prop_assert!(sums_to_one(&weights), "{weights:?}");
            prop_assert!(weights.iter().all(|w| *w > -1e-9), "{weights:?}");
            // The angle of a nearly straight corner keeps half the digits.
            prop_assert!(place(&weights).distance(point) < 1e-7, "{weights:?}");
        }

        #[test]
        fn a_triangle_extrapolates(x in -3.0..3.0f64, y in -3.0..3.0f64) {
            let weights = at_place(DVec2::new(x, y), 3);
            prop_assert!(sums_to_one(&weights));
            prop_assert!(place(&weights).distance(DVec2::new(x, y)) < 1e-13);
        }
    }

    #[test]
    fn corners_are_pure_and_edges_are_linear() {
        for n in 3..=8 {
            for k in 0..n {
                let next = (k + 1) % n;
                for share in [0.0, 0.25, 0.5] {
                    let weights = at_place(corner(k, n).lerp(corner(next, n), share), n);
                    for (j, weight) in weights.iter().enumerate() {
                        let expected = if j == k {
                            1.0 - share
                        } else if j == next {
                            share
                        } else {
                            0.0
                        };
                        // At the tangent of nearly a right angle.
                        assert!((weight - expected).abs() < 1e-7, "{n} {k} {share}: {weights:?}");
                    }
                }
            }
            let middle = at_place(DVec2::ZERO, n);
            assert!(middle.iter().all(|w| (w - 1.0 / n as f64).abs() < 1e-12), "{middle:?}");
        }
    }

    #[test]
    fn points_outside_a_polygon_count_as_its_rim() {
        let weights = at_place(corner(1, 5) * 3.0, 5);
        assert!((weights[1] - 1.0).abs() < 1e-12, "{weights:?}");
        let middle = 0.5 * (corner(0, 4) + corner(1, 4));
        let weights = at_place(middle * 2.0, 4);
        assert!((weights[0] - 0.5).abs() < 1e-9 && (weights[1] - 0.5).abs() < 1e-9, "{weights:?}");
    }

    #[test]
    fn nothing_to_share_is_shared_equally() {
        let mut weights = only(0, 3);
        set_weight(&mut weights, 0, 0.4, INSIDE);
        assert_eq!(weights, [0.4, 0.3, 0.3]);
        let mut weights = vec![1.0];
        set_weight(&mut weights, 0, 0.2, INSIDE);
        assert_eq!(weights, [1.0]);
        // In proportion the second would be at 1.1 * 3.
        let mut weights = vec![0.6, 1.2, -0.8];
        set_weight(&mut weights, 0, -0.1, BEYOND);
        assert_eq!(weights[0], -0.1);
        assert!((weights[1] - 0.55).abs() < 1e-12 && (weights[2] - 0.55).abs() < 1e-12, "{weights:?}");
    }
}
