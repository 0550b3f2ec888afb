//! The form that paint designers judge paints by: a small car of nothing but body.
//!
//! Sections across the length are superellipses |y/w|^p + |z/h|^p = 1, whose half-width w and heights above and below the waist
//! follow a nose, a long hood, a cabin and a tail; the cabin leans inward, and a hollow runs along the side below the waist. So
//! gentle curves (hood, side), tight ones (nose, shoulders, sill) and concave ones (foot of the windshield, hollow) lie side by
//! side.

use crate::file::Triangles;
use std::f64::consts::{PI, TAU};

/// Sections between nose and tail, and points around each: some 32,000 triangles.
const SECTIONS: usize = 128;
const AROUND: usize = 128;
/// Exponent of the superellipses: 2 is an ellipse.
const SQUARENESS: f64 = 2.7;

/// The body of length 1, its nose towards +x, z up.
pub(super) fn triangles() -> Triangles {
    let section = |k: usize| (1.0 - (PI * k as f64 / SECTIONS as f64).cos()) / 2.0;
    let around = |k: usize| TAU * k as f64 / AROUND as f64;
    let ring = |k: usize| (0..AROUND).map(move |j| point(section(k), around(j)));
    let mut positions: Vec<[f32; 3]> = (1..SECTIONS).flat_map(ring).collect();
    let (nose, tail) = (positions.len() as u32, positions.len() as u32 + 1);
    positions.extend([point(0.0, 0.0), point(1.0, 0.0)]);
    let at = |k: usize, j: usize| (k * AROUND + j % AROUND) as u32;
    let last = SECTIONS - 2;
    let mut triangles = Vec::new();
    for j in 0..AROUND {
        triangles.push([nose, at(0, j), at(0, j + 1)]);
        triangles.push([tail, at(last, j + 1), at(last, j)]);
        for k in 0..last {
            triangles.push([at(k, j), at(k + 1, j), at(k + 1, j + 1)]);
            triangles.push([at(k, j), at(k + 1, j + 1), at(k, j + 1)]);
        }
    }
    Triangles { positions, triangles, ..Triangles::default() }
}

/// A point of the surface: `t` from nose (0) to tail (1), `angle` around from the left side (+y) over the top.
fn point(t: f64, angle: f64) -> [f32; 3] {
    // Nose and tail close like a superellipse, too.
    let end = (1.0 - (2.0 * t - 1.0).abs().powf(3.6)).max(0.0).sqrt();
    let cabin = step(0.32, 0.52, t) - step(0.60, 0.97, t);
    let width = 0.19 * end * (1.0 - 0.06 * step(0.45, 0.0, t));
    let above = end * (0.085 + 0.045 * step(0.0, 0.5, t) + 0.075 * cabin);
    let below = 0.09 * end;
    let (sin, cos) = angle.sin_cos();
    let radius = (cos.abs().powf(SQUARENESS) + sin.abs().powf(SQUARENESS)).powf(-1.0 / SQUARENESS);
    let height = below + (above - below) * step(-0.6, 0.6, sin);
    let lean = 1.0 - 0.3 * cabin * step(0.3, 1.0, sin * radius);
    // Of the side between the wheels.
    let hollow = 1.0 - 0.09 * step(0.12, 0.35, t) * step(0.95, 0.7, t) * bump((sin * radius + 0.2) / 0.2);
    let (y, z) = (width * radius * cos * lean * hollow, height * radius * sin);
    [0.5 - t, y, z].map(|c| c as f32)
}

/// 0 before `start`, 1 after `end`, with two smooth derivatives (Perlin 2002).
fn step(start: f64, end: f64, x: f64) -> f64 {
    let t = ((x - start) / (end - start)).clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// 1 at 0, falling smoothly to nothing.
fn bump(x: f64) -> f64 {
    (-x * x).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::collections::HashMap;

    #[test]
    fn the_body_is_closed_and_turned_outside() {
        let body = triangles();
        assert!((20_000..40_000).contains(&body.triangles.len()));
        let mut edges = HashMap::new();
        for [a, b, c] in &body.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|n| *n == 0), "every edge twice, once in each direction");
        let place = |k: &u32| DVec3::from(body.positions[*k as usize].map(f64::from));
        let volume: f64 =
            body.triangles.iter().map(|[a, b, c]| place(a).dot(place(b).cross(place(c))) / 6.0).sum();
        // A box of its size would hold 0.08.
        assert!((0.02..0.08).contains(&volume), "{volume}");
    }

    #[test]
    fn the_body_curves_both_ways() {
        // Along the side, below the waist: second differences of the half-width over the height change their sign.
        let y = |angle: f64| f64::from(point(0.5, angle)[1]);
        let bends: Vec<f64> =
            (-40..40).map(|k| f64::from(k) * 0.02).map(|a| y(a - 0.02) - 2.0 * y(a) + y(a + 0.02)).collect();
        assert!(bends.iter().any(|b| *b > 1e-5) && bends.iter().any(|b| *b < -1e-5));
    }
}
